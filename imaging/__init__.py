"""Photographs of coloured strands: crossings, N-body interactions, helix centreline, link density.

Functions bear the names of the rooms they live in (``imaging.segment`` is the function), so they
are imported here, once, after their modules.
"""

from imaging.errors import Unmeasurable
from imaging.photo import Photo, read_photo
from imaging.segment import Segmentation, segment

__all__ = ["Photo", "Segmentation", "Unmeasurable", "read_photo", "segment"]
