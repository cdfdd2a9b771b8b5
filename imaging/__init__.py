"""Photographs of coloured strands: crossings, N-body interactions, helix centreline, link density.

Functions bear the names of the rooms they live in (``imaging.segment`` is the function), so they
are imported here, once, after their modules.
"""

from imaging.correct import Corrections, read_corrections
from imaging.count import crossing_matrix, crossings, densities, events, interactions, unresolved
from imaging.errors import Unmeasurable
from imaging.helix import (
    HelixMeasurement,
    first_link,
    helix,
    helix_sequence,
    jump_across,
    link_before,
    link_jump,
)
from imaging.measure import Measured, measure, strands_of
from imaging.photo import Photo, read_photo
from imaging.segment import Segmentation, segment
from imaging.trace import Strand, trace

__all__ = [
    "Corrections",
    "HelixMeasurement",
    "Measured",
    "Photo",
    "Segmentation",
    "Strand",
    "Unmeasurable",
    "crossing_matrix",
    "crossings",
    "densities",
    "events",
    "first_link",
    "helix",
    "helix_sequence",
    "interactions",
    "jump_across",
    "link_before",
    "link_jump",
    "measure",
    "read_corrections",
    "read_photo",
    "segment",
    "strands_of",
    "trace",
    "unresolved",
]
