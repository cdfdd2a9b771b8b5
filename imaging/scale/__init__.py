"""From pixels to metres: a stated scale, a ruler, a marker, a board, or a known filament."""

from imaging.scale.calibration import calibrate
from imaging.scale.marker import find_marker, from_marker, without_markers
from imaging.scale.request import FORMS, METRES, Request, parse_scale
from imaging.scale.scale import Scale, from_filament, from_ruler, stated

__all__ = [
    "FORMS",
    "METRES",
    "Request",
    "Scale",
    "calibrate",
    "find_marker",
    "from_filament",
    "from_marker",
    "from_ruler",
    "parse_scale",
    "stated",
    "without_markers",
]
