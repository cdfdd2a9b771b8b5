"""Two strands wound round each other: axis, radius, phase, link density."""

from imaging.helix.measurement import HelixMeasurement
from imaging.helix.photograph import helices, helix
from imaging.helix.sequence import first_link, helix_sequence, jump_across, link_before, link_jump

__all__ = [
    "HelixMeasurement",
    "first_link",
    "helices",
    "helix",
    "helix_sequence",
    "jump_across",
    "link_before",
    "link_jump",
]
