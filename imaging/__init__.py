"""Photographs of coloured strands: crossings, N-body interactions, helix centreline, link density.

Functions bear the names of the rooms they live in (``imaging.segment`` is the function), so they
are imported here, once, after their modules.
"""

from imaging.crossings import crossings
from imaging.errors import Unmeasurable
from imaging.helix import helix
from imaging.helix_measurement import HelixMeasurement
from imaging.helix_sequence import helix_sequence, link_jump
from imaging.interactions import densities, events, interactions
from imaging.photo import Photo, read_photo
from imaging.segment import Segmentation, segment
from imaging.trace import Strand, trace
from imaging.unresolved import unresolved

__all__ = [
    "HelixMeasurement",
    "Photo",
    "Segmentation",
    "Strand",
    "Unmeasurable",
    "crossings",
    "densities",
    "events",
    "helix",
    "helix_sequence",
    "interactions",
    "link_jump",
    "read_photo",
    "segment",
    "trace",
    "unresolved",
]
