"""Quantities that claims are decided by: exponents, ratios and shares, with intervals at 95 %."""

from collections.abc import Callable

import numpy as np
import pandas as pd
from scipy import stats

from combing.claims.claim import Finding

LEVEL = 0.95
Measure = Callable[[pd.DataFrame], Finding | None]


def exponent(curves: pd.DataFrame) -> Finding | None:
    """Return b of f_max ~ value^b by least squares in logarithms, with Student's interval."""
    used = curves[(curves["f_max"] > 0) & (curves["value"] > 0)]
    if used["value"].nunique() < 3:
        return None
    fit = stats.linregress(np.log(used["value"]), np.log(used["f_max"]))
    half = stats.t.ppf((1 + LEVEL) / 2, len(used) - 2) * fit.stderr
    return Finding(float(fit.slope), float(fit.slope - half), float(fit.slope + half))


def ratio_of_ends(curves: pd.DataFrame) -> Finding | None:
    """Return f_max at the largest value over that at the smallest, by Welch's interval of logs."""
    ends = (curves["value"].max(), curves["value"].min())
    one, other = (np.log(curves.loc[curves["value"] == end, "f_max"]) for end in ends)
    if ends[0] == ends[1]:
        return None
    apart = float(one.mean() - other.mean())
    if min(len(one), len(other)) < 2:
        return Finding(float(np.exp(apart)), np.nan, np.nan)
    interval = stats.ttest_ind(one, other, equal_var=False).confidence_interval(LEVEL)
    low, high = np.exp([interval.low, interval.high])
    return Finding(float(np.exp(apart)), float(low), float(high))


def share(column: str, chosen: Callable[[pd.Series], pd.Series]) -> Measure:
    """Measure the share of curves with at least one of `column`, where `chosen` picks the values.

    The interval is Clopper and Pearson's.
    """

    def measure(curves: pd.DataFrame) -> Finding | None:
        rows = curves[chosen(curves["value"])]
        if rows.empty:
            return None
        found = stats.binomtest(int((rows[column] > 0).sum()), len(rows))
        interval = found.proportion_ci(LEVEL)
        return Finding(float(found.statistic), float(interval.low), float(interval.high))

    return measure
