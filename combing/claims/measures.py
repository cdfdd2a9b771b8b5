"""Quantities that claims are decided by: exponents, ratios and shares, with intervals at 95 %."""

from collections.abc import Callable

import numpy as np
import pandas as pd
from scipy import stats

from combing.claims.claim import Finding

LEVEL = 0.95
PERFECT = 0.999  # correlation from which on Fisher's z tells nothing more
Measure = Callable[[pd.DataFrame], Finding | None]


def exponent(curves: pd.DataFrame) -> Finding | None:
    """Return b of f_max ~ value^b by least squares in logarithms, with Student's interval."""
    used = curves[(curves["f_max"] > 0) & (curves["value"] > 0)]
    if used["value"].nunique() < 3:
        return None
    fit = stats.linregress(np.log(used["value"]), np.log(used["f_max"]))
    half = stats.t.ppf((1 + LEVEL) / 2, len(used) - 2) * fit.stderr
    return Finding(float(fit.slope), float(fit.slope - half), float(fit.slope + half))


def ratio_of_ends(curves: pd.DataFrame, quantity: str = "f_max") -> Finding | None:
    """Return f_max at the largest value over that at the smallest, by Welch's interval of logs."""
    ends = (curves["value"].max(), curves["value"].min())
    one, other = (np.log(curves.loc[curves["value"] == end, quantity]) for end in ends)
    if ends[0] == ends[1]:
        return None
    apart = float(one.mean() - other.mean())
    if min(len(one), len(other)) < 2:
        return Finding(float(np.exp(apart)), np.nan, np.nan)
    interval = stats.ttest_ind(one, other, equal_var=False).confidence_interval(LEVEL)
    low, high = np.exp([interval.low, interval.high])
    return Finding(float(np.exp(apart)), float(low), float(high))


def ratio_of_fullness(curves: pd.DataFrame) -> Finding | None:
    """Return `ratio_of_ends` of w/f_max, the mean force over the highest: the curve's shape."""
    return ratio_of_ends(curves.assign(fullness=curves["w"] / curves["f_max"]), "fullness")


def mean(column: str) -> Measure:
    """Measure the mean of `column` over the curves that have it, with Student's interval."""

    def measure(curves: pd.DataFrame) -> Finding | None:
        values = curves[column].dropna() if column in curves else pd.Series(dtype=float)
        if values.empty:
            return None
        middle = float(np.mean(values))
        if len(values) < 2:
            return Finding(middle, np.nan, np.nan)
        half = stats.t.ppf((1 + LEVEL) / 2, len(values) - 1) * stats.sem(values)
        return Finding(middle, float(middle - half), float(middle + half))

    return measure


def mean_correlation(column: str) -> Measure:
    """Measure the mean of correlations in `column`: by Fisher's z, so that it stays below 1."""

    def measure(curves: pd.DataFrame) -> Finding | None:
        if column not in curves:
            return None
        z = np.arctanh(curves[column].clip(-PERFECT, PERFECT))
        found = mean(column)(curves.assign(**{column: z}))
        if found is None:
            return None
        return Finding(*(float(np.tanh(z)) for z in (found.value, found.low, found.high)))

    return measure


def rank_correlation(one: str, other: str) -> Measure:
    """Measure Spearman's correlation of two columns over the curves, with Fisher's interval."""

    def measure(curves: pd.DataFrame) -> Finding | None:
        used = curves[[one, other]].dropna() if {one, other} <= set(curves) else curves[:0]
        if len(used) < 5:
            return None
        rho = float(stats.spearmanr(used[one], used[other]).statistic)
        # Fieller, Hartley & Pearson, Biometrika 44, 470 (1957); ranks in perfect order say of rho
        # that it is nearer to 1 than half a step of it.
        n = len(used)
        most = 1 - 6 / (n * (n**2 - 1))
        half = stats.norm.ppf((1 + LEVEL) / 2) * np.sqrt(1.06 / (n - 3))
        low, high = np.tanh(np.arctanh(np.clip(rho, -most, most)) + np.array([-half, half]))
        low, high = min(low, rho), max(high, rho)
        return Finding(rho, float(low), float(high))

    return measure


def share(column: str, chosen: Callable[[pd.Series], pd.Series]) -> Measure:
    """Measure the share of curves with at least one of `column`, where `chosen` picks the values.

    The interval is Clopper and Pearson's.
    """

    def measure(curves: pd.DataFrame) -> Finding | None:
        if column not in curves:
            return None
        rows = curves[chosen(curves["value"])].dropna(subset=[column])
        if rows.empty:
            return None
        found = stats.binomtest(int((rows[column] > 0).sum()), len(rows))
        interval = found.proportion_ci(LEVEL)
        return Finding(float(found.statistic), float(interval.low), float(interval.high))

    return measure
