"""Everything that is told of one photograph, in one call."""

from imaging.measure.measured import Measured, measure

__all__ = ["Measured", "measure"]
