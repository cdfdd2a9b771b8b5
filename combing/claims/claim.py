"""What a claim is, and when it holds."""

from collections.abc import Callable
from dataclasses import dataclass
from enum import StrEnum

import pandas as pd


class Verdict(StrEnum):
    """What a study says of a claim."""

    HOLDS = "holds"
    FAILS = "does not hold"
    OPEN = "cannot tell"
    DEFINITION = "holds by definition"


@dataclass(frozen=True)
class Finding:
    """A quantity with its interval at 95 %; NaN bounds where there are too few curves."""

    value: float
    low: float
    high: float


@dataclass(frozen=True)
class Claim:
    """A claim of the paper.

    Attributes
    ----------
    sentence : str
        The claim in our words.
    where : str
        Where the paper makes it.
    over : str
        Parameter of the sets that decide it.
    quantity : str
        What is measured.
    measure : callable
        Takes the curves of one source (columns value, f_max, jams, plateaus, D (m)), one row each;
        returns a Finding, or None where the set does not reach far enough.
    above, below : float
        The claim holds where the whole interval lies between them, and does not where all of it
        lies outside; else one cannot tell.
    by_definition : bool
        Whether it follows from how the quantity is defined, whatever is measured.
    """

    sentence: str
    where: str
    over: str
    quantity: str
    measure: Callable[[pd.DataFrame], Finding | None]
    above: float = float("-inf")
    below: float = float("inf")
    by_definition: bool = False

    @property
    def threshold(self) -> str:
        """Threshold in words."""
        if self.below == float("inf"):
            return f"above {self.above:g}"
        if self.above == float("-inf"):
            return f"below {self.below:g}"
        return f"from {self.above:g} to {self.below:g}"

    def verdict(self, found: Finding | None) -> Verdict:
        """Say whether the claim holds."""
        if self.by_definition:
            return Verdict.DEFINITION
        if found is None or not (found.low <= found.high):
            return Verdict.OPEN
        if self.above < found.low and found.high < self.below:
            return Verdict.HOLDS
        if found.high <= self.above or self.below <= found.low:
            return Verdict.FAILS
        return Verdict.OPEN
