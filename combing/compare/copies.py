"""The same specimen, photograph or simulation under two names: it would count twice."""

from collections.abc import Hashable, Sequence
from itertools import combinations

import numpy as np
import pandas as pd

from combing.errors import UserError

HALF = 0.51  # of the last digit: by which a file rounded once more differs from the first


def refuse_copied_logs(name: str, curves: Sequence[pd.DataFrame]) -> None:
    """Raise UserError where two force logs of a set, scaled, hold the same readings.

    Compared is what was read, not the bytes: a copy in other units, with other line endings or
    rounded to fewer digits is a copy. Two repeats never agree to half a digit in every row.
    """
    for one, other in combinations(curves, 2):
        if len(one) == len(other) and all(
            _same(one[column].to_numpy(float), other[column].to_numpy(float))
            for column in ("d", "F")
        ):
            raise UserError(_twice(name, _place(one), _place(other), "readings"))


def refuse_copies(name: str, what: str, contents: Sequence[tuple[str, Hashable]]) -> None:
    """Raise UserError where two of (name, content) pairs have the same content."""
    seen: dict[Hashable, str] = {}
    for label, content in contents:
        if content in seen:
            raise UserError(_twice(name, seen[content], label, what))
        seen[content] = label


def _twice(name: str, one: str, other: str, what: str) -> str:
    return f"{name}: {one} and {other} hold the same {what} and would count twice; name one of them"


def _place(log: pd.DataFrame) -> str:
    return f"{log.attrs.get('source', 'a log')} ({log.attrs.get('specimen', '')})"


def _same(one: np.ndarray, other: np.ndarray) -> bool:
    return bool(np.all(np.abs(one - other) <= HALF * max(_digit(one), _digit(other))))


def _digit(values: np.ndarray) -> float:
    """Return the smallest step between readings: the last digit of the file."""
    largest = float(np.abs(values).max(initial=0.0))
    steps = np.diff(np.unique(values))
    steps = steps[steps > 1e-9 * largest]  # less is rounding of the conversion of units
    return max(float(steps.min()) if len(steps) else 0.0, 1e-9 * largest)
