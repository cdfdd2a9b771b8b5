"""A page over a photograph and its measurement, to correct it by hand."""

from imaging.edit.page import Place, edit_page

__all__ = ["Place", "edit_page"]
