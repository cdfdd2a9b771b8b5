"""Two strands wound round each other: axis, radius, phase, link density."""

from imaging.helix.measurement import HelixMeasurement
from imaging.helix.photograph import helices, helix
from imaging.helix.sequence import helix_sequence, link_jump

__all__ = ["HelixMeasurement", "helices", "helix", "helix_sequence", "link_jump"]
