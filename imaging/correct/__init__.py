"""What a hand says of a photograph, applied to its measurement: corrections are data."""

from imaging.correct.correct import Hand, Outcome, correct, put_on_top
from imaging.correct.foreign import read_corrections
from imaging.correct.schema import SUFFIX, Corrections, Photograph, beside, told_besides, written

__all__ = [
    "SUFFIX",
    "Corrections",
    "Hand",
    "Outcome",
    "Photograph",
    "beside",
    "correct",
    "put_on_top",
    "read_corrections",
    "told_besides",
    "written",
]
