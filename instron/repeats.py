"""Repeats of one experiment: mean, scatter, band, and what a mean curve must not be asked."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd
from scipy.special import stdtrit

from instron.errors import Unscalable
from instron.events import events
from instron.scaling.average import profile
from instron.scaling.scale import work
from instron.scaling.strokes import name_of
from instron.summary import summary

PART = 200  # resamples at a time: 16 MB for eight repeats of 501 points


@dataclass(frozen=True)
class Repeats:
    """Repeats on one grid of x in [0, 1].

    Attributes
    ----------
    grid
        ``x``, ``mean``, ``sd`` (over specimens), ``low``, ``high`` (simultaneous band of the mean).
    curves
        One row per repeat: f on the grid.
    table
        One row per repeat: ``specimen`` and what ``summary`` gives of it.
    summary
        Per column of the table: ``mean``, ``sd``, ``low``, ``high`` (Student interval of the mean).
    representative
        Number of the repeat nearest to all others (the medoid).
    registered
        The grid of the landmark-registered mean, or None.
    unregistered_because
        Why there is no registered mean, or "".
    level
        Confidence level of the band and the intervals.
    used
        Which of the curves given these are.
    left_out
        Names of curves whose combing did not end: they are no repeats.
    """

    grid: pd.DataFrame
    curves: np.ndarray
    table: pd.DataFrame
    summary: pd.DataFrame
    representative: int
    registered: pd.DataFrame | None
    unregistered_because: str
    level: float
    used: list[int]
    left_out: list[str]


def repeats(
    curves: Sequence[pd.DataFrame],
    *,
    points: int = 501,
    level: float = 0.95,
    resamples: int = 4000,
    rng: np.random.Generator | int | None = 0,
) -> Repeats:
    """Combine the scaled curves of repeats, each scaled by its own D.

    The maximum of the mean curve is not the mean of the maxima: where peaks differ in place, the
    mean flattens them. f_max, work and peak count are therefore given per repeat.

    Parameters
    ----------
    curves
        From ``scale``.
    points
        Points of the common grid over x in [0, 1].
    level
        Confidence level.
    resamples
        Bootstrap resamples over specimens.
    rng
        Seed or generator of the bootstrap.

    Raises
    ------
    Unscalable
        For fewer than two curves whose combing ended.
    """
    used = [k for k, curve in enumerate(curves) if curve.attrs.get("ended", True)]
    left_out = [name_of(curve) for curve in curves if not curve.attrs.get("ended", True)]
    curves = [curves[k] for k in used]
    if len(curves) < 2:
        aborted = f" in which combing ended (not in {', '.join(left_out)})" if left_out else ""
        raise Unscalable(f"repeats need at least 2 curves, got {len(curves)}{aborted}")
    x = np.linspace(0, 1, points)
    values = np.array([on_grid(curve, x) for curve in curves])
    found = [_turning_points(curve) for curve in curves]
    table = pd.DataFrame([_row(c, e) for c, e in zip(curves, found, strict=True)])
    grid = _statistics(x, values, level, resamples, np.random.default_rng(rng))
    registered, reason = _register(x, values, found, level, resamples, rng)
    distance = np.sqrt(((values[:, None] - values[None]) ** 2).mean(axis=2))
    return Repeats(
        grid=grid,
        curves=values,
        table=table,
        summary=_summary(table, level),
        representative=int(np.argmin(distance.sum(axis=1))),
        registered=registered,
        unregistered_because=reason,
        level=level,
        used=used,
        left_out=left_out,
    )


def on_grid(curve: pd.DataFrame, x: np.ndarray) -> np.ndarray:
    """Return f at ``x``, averaged over the curve's own length, or a step of the grid if longer.

    So the result depends neither on the sampling rate nor on which instrument it was.
    """
    table = curve[["x", "f"]].dropna()
    own = curve.attrs.get("average_over", 0.0) / curve.attrs.get("D", 1.0)
    source = profile(table["x"].to_numpy(), table["f"].to_numpy())
    return source.mean(np.asarray(x, dtype=float), max(own, float(x[1] - x[0])))


def simultaneous_band(
    values: np.ndarray, level: float, resamples: int, rng: np.random.Generator
) -> tuple[np.ndarray, np.ndarray]:
    """Return a band around the mean that covers the whole true mean curve at once.

    The width in units of the standard error se is the ``level`` quantile of the largest
    ``|mean| / se`` over x in a bootstrap over specimens, the wider of two. Independent signs on
    the residual curves (Rademacher multiplier-t; Telschow & Schwartzman, J. Stat. Plan. Inference
    216, 70, 2022) assume nothing but symmetry, yet four specimens have only eight patterns of
    signs. Normal draws from the residuals' covariance have no such limit. Drawing specimens with
    replacement instead is far too narrow for few of them. A tenth of the largest se is added to
    se in quadrature, so that stretches where the repeats hardly differ (before and after combing)
    do not decide the width.

    Parameters
    ----------
    values
        One curve per row.

    Returns
    -------
    low, high
        Bounds at every point.
    """
    mean = values.mean(axis=0)
    residuals = values - mean
    n = len(values)
    variance = (residuals**2).sum(axis=0) / (n - 1)
    least = 0.01 * float(variance.max())
    draws = (_by_signs, _by_normals)
    width = max(float(np.quantile(draw(residuals, least, resamples, rng), level)) for draw in draws)
    half = width * np.sqrt((variance + least) / n)
    return mean - half, mean + half


def _by_signs(
    residuals: np.ndarray, least: float, resamples: int, rng: np.random.Generator
) -> np.ndarray:
    """Return the largest ``|mean| / se`` of curves whose residuals got random signs."""
    n = len(residuals)
    moved = rng.choice([-1.0, 1.0], (resamples, n)) @ residuals / n
    spread = np.clip(((residuals**2).sum(axis=0) - n * moved**2) / (n - 1), 0, None) + least
    return _largest(moved, spread, n)


def _by_normals(
    residuals: np.ndarray, least: float, resamples: int, rng: np.random.Generator
) -> np.ndarray:
    """Return the largest ``|mean| / se`` of n normal curves of the residuals' covariance."""
    n = len(residuals)
    found = []
    for first in range(0, resamples, PART):
        weights = rng.standard_normal((min(PART, resamples - first), n, n))
        drawn = weights @ residuals / np.sqrt(n - 1)
        found.append(_largest(drawn.mean(axis=1), drawn.var(axis=1, ddof=1) + least, n))
    return np.concatenate(found)


def _largest(mean: np.ndarray, variance: np.ndarray, n: int) -> np.ndarray:
    return (np.abs(mean) / np.sqrt(np.where(variance > 0, variance, np.inf) / n)).max(axis=1)


def _statistics(
    x: np.ndarray, values: np.ndarray, level: float, resamples: int, rng: np.random.Generator
) -> pd.DataFrame:
    low, high = simultaneous_band(values, level, resamples, rng)
    return pd.DataFrame({"x": x, "mean": values.mean(axis=0), "sd": values.std(axis=0, ddof=1),
                         "low": low, "high": high})  # fmt: skip


def _turning_points(curve: pd.DataFrame) -> pd.DataFrame:
    found = events(curve)
    return found[found["kind"] != "plateau"].reset_index(drop=True)


def _row(curve: pd.DataFrame, found: pd.DataFrame) -> dict[str, object]:
    name: dict[str, object] = {"specimen": str(curve.attrs.get("specimen", ""))}
    if "average_over" in curve.attrs:
        return {**name, **summary(curve)}
    inside = curve[(curve["x"] >= 0) & (curve["x"] <= 1)]
    top = int(np.argmax(inside["f"].to_numpy()))
    W, w = work(curve)
    return name | {
        "f_max": float(inside["f"].iloc[top]),
        "x_max": float(inside["x"].iloc[top]),
        "w": w,
        "W": W,
        "D": float(curve.attrs.get("D", np.nan)),
        "peaks": len(found),
    }


def _summary(table: pd.DataFrame, level: float) -> pd.DataFrame:
    numbers = table.drop(columns="specimen")
    n = len(numbers)
    mean, sd = numbers.mean(), numbers.std(ddof=1)
    half = sd / np.sqrt(n) * stdtrit(n - 1, (1 + level) / 2)
    return pd.DataFrame({"mean": mean, "sd": sd, "low": mean - half, "high": mean + half})


def _register(
    x: np.ndarray,
    values: np.ndarray,
    found: list[pd.DataFrame],
    level: float,
    resamples: int,
    rng: np.random.Generator | int | None,
) -> tuple[pd.DataFrame | None, str]:
    """Return the mean after moving every peak to its mean place, or the reason there is none."""
    counts = [len(peaks) for peaks in found]
    if len(set(counts)) > 1:
        return None, f"the repeats have {', '.join(map(str, counts))} peaks: nothing to match"
    if counts[0] == 0:
        return None, "no repeat has a peak"
    marks = np.array([peaks["x"].to_numpy() for peaks in found])
    target = np.concatenate([[0], marks.mean(axis=0), [1]])
    moved = [
        np.interp(np.interp(x, target, np.concatenate([[0], own, [1]])), x, f)
        for own, f in zip(marks, values, strict=True)
    ]
    generator = np.random.default_rng(rng)
    return _statistics(x, np.array(moved), level, resamples, generator), ""
