"""Pictures as cameras store them -> pixels, upright, with what is to be looked at."""

from imaging.photo.read import Photo, bands, read_photo, shrunk

__all__ = ["Photo", "bands", "read_photo", "shrunk"]
