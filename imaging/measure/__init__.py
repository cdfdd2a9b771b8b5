"""Everything that is told of one photograph, in one call."""

from imaging.measure.measured import BESIDE, Measured, corrections_for, measure, strands_of

__all__ = ["BESIDE", "Measured", "corrections_for", "measure", "strands_of"]
