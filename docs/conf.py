"""Settings of the pages: `sphinx-build -W docs site`; needs the ``docs`` extra."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1]))

from combing import __version__

project = "combing"
author = "The combing developers"
release = version = __version__
extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.autosummary", "numpydoc"]
myst_heading_anchors = 3
numpydoc_show_class_members = False
autodoc_typehints = "none"  # the numpydoc sections say types, shapes and units
autosummary_generate = True
autosummary_imported_members = True
html_theme = "furo"
html_title = f"combing {release}"
exclude_patterns = ["_build"]
