"""The one operator behind f_max, D, noise and events: F averaged over a length along d."""

from dataclasses import dataclass

import numpy as np
import pandas as pd

FINE = 16  # places to a length at which an averaged curve is tabulated


@dataclass(frozen=True)
class Profile:
    """F over d with d growing, and its integral: what is averaged.

    Attributes
    ----------
    d
        Places [m], each once.
    area
        Integral of F up to there [J].
    """

    d: np.ndarray
    area: np.ndarray

    def mean(self, at: np.ndarray, length: float) -> np.ndarray:
        """Return F averaged over ``length`` [m] around each place, less beyond the ends."""
        low = np.clip(at - length / 2, self.d[0], self.d[-1])
        high = np.clip(at + length / 2, self.d[0], self.d[-1])
        gained = np.interp(high, self.d, self.area) - np.interp(low, self.d, self.area)
        return gained / (high - low)

    def places(self, length: float, last: float = np.inf) -> np.ndarray:
        """Return even places, ``FINE`` to a length, that have a whole length around them.

        Where the record is too short for one, that is its middle.
        """
        first, last = self.d[0] + length / 2, min(last, self.d[-1] - length / 2)
        if last <= first:
            return np.array([(self.d[0] + self.d[-1]) / 2])
        return np.linspace(first, last, int(np.ceil(FINE * (last - first) / length)) + 1)


def profile(d: np.ndarray, F: np.ndarray) -> Profile:
    """Return the profile of rows in any order; rows at the same place count by their mean."""
    place, row = np.unique(d, return_inverse=True)
    if len(place) < len(d):
        F = np.bincount(row, weights=F) / np.bincount(row)
    else:
        F = F[np.argsort(d, kind="stable")]
    return Profile(place, np.concatenate([[0], np.cumsum(np.diff(place) * (F[1:] + F[:-1]) / 2)]))


def averaged(curve: pd.DataFrame) -> pd.DataFrame:
    """Return a scaled curve averaged over its own length, at even places up to x = 1.

    Parameters
    ----------
    curve
        From ``scale``, whose attribute ``average_over`` [m] is the length.

    Returns
    -------
    DataFrame
        Columns ``x``, ``f``, ``d`` [m], ``F`` [N], sixteen rows to a length; the attributes of the
        curve.
    """
    facts = curve.attrs
    source = profile(curve["d"].to_numpy(), curve["F"].to_numpy())
    d = source.places(facts["average_over"], facts["D"])
    F = source.mean(d, facts["average_over"])
    table = pd.DataFrame({"x": d / facts["D"], "f": F * facts["l0"] ** 2 / facts["B"]})
    table["d"], table["F"] = d, F
    table.attrs = dict(facts)
    return table
