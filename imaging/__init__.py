"""Photographs of coloured strands: crossings, N-body interactions, helix centreline, link density.

The pieces are imported when first asked for, so that ``import imaging`` costs nothing.
"""

import importlib
from typing import Any

_HOME = {
    "Unmeasurable": "imaging.errors",
    "Photo": "imaging.photo",
    "read_photo": "imaging.photo",
    "Segmentation": "imaging.segment",
    "segment": "imaging.segment",
}
__all__ = list(_HOME)


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module 'imaging' has no attribute {name!r}")
    return getattr(importlib.import_module(_HOME[name]), name)
