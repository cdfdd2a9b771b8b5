"""How far two scaled curves are apart: an experiment and a simulation are the same table.

No single number will do. What each sees and is blind to:

============== ======================================= =========================================
metric         sees                                    blind to
============== ======================================= =========================================
f_max_error    the highest force, with sign            everything else
work_error     the area, with sign                     where the work is done; errors that cancel
nrmse          pointwise differences                   a small shift of sharp peaks looks like a
                                                       missing peak
event_score    the number, place and height of jams    the force between them
iso18571       corridor, phase, size and slope         the physical units; needs two full curves
============== ======================================= =========================================

A mean absolute error is left out on purpose: it prefers a curve without any jam to the true curve
shifted by 3 %.
"""

from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas as pd
from scipy.integrate import trapezoid
from scipy.optimize import linear_sum_assignment

import instron
from combing.errors import UserError

POINTS = 1001


def compare_curves(
    reference: pd.DataFrame, curve: pd.DataFrame, *, iso: bool = False
) -> dict[str, float]:
    """Return all metrics of ``curve`` against ``reference``.

    Parameters
    ----------
    reference, curve
        Scaled curves, columns ``x`` and ``f``; compared over x in [0, 1].
    iso
        Include ISO/TS 18571; its package compiles itself anew in every process (about 10 s).

    Returns
    -------
    dict
        ``f_max_error`` and ``work_error`` (signed, relative to the reference), ``nrmse``
        (relative to the reference's range), ``event_score`` in [0, 1], and with ``iso``
        ``iso18571`` with its parts ``iso_corridor``, ``iso_phase``, ``iso_magnitude``,
        ``iso_slope``.

    Raises
    ------
    UserError
        When a curve is empty, not finite, or the reference has no force.
    """
    x = np.linspace(0, 1, POINTS)
    a, b = _values(reference, x, "reference"), _values(curve, x, "curve")
    if np.ptp(a) == 0:
        raise UserError("the reference curve is constant: nothing to compare with")
    found = {
        "f_max_error": _peak(curve) / _peak(reference) - 1,
        "work_error": float(trapezoid(b, x) / trapezoid(a, x) - 1),
        "nrmse": float(np.sqrt(np.mean((b - a) ** 2)) / np.ptp(a)),
        "event_score": event_score(instron.events(reference), instron.events(curve)),
    }
    return found | (iso18571(a, b) if iso else {})


def event_score(reference: pd.DataFrame, events: pd.DataFrame, *, reach: float = 0.1) -> float:
    """Return how well the jams and peaks of two curves match, from 0 (none) to 1 (all).

    Two peaks at distance dx and of heights f1, f2 are alike by
    ``max(0, 1 - dx / reach) * min(f1, f2) / max(f1, f2)``. The pairing with the largest sum is
    taken (Hungarian algorithm), and the score is ``2 sum / (n1 + n2)``, so that a missing and a
    false peak cost the same. Two curves without peaks agree: 1.

    Parameters
    ----------
    reference, events
        Tables of ``instron.events``; plateaus are left out.
    reach
        Distance in x at which two peaks have nothing in common.
    """
    one, two = (_peaks(table) for table in (reference, events))
    if not len(one) or not len(two):
        return float(len(one) == len(two))
    apart = np.abs(one[:, None, 0] - two[None, :, 0])
    low = np.minimum(one[:, None, 1], two[None, :, 1])
    high = np.maximum(one[:, None, 1], two[None, :, 1])
    alike = np.clip(1 - apart / reach, 0, None) * np.clip(low / high, 0, None)
    pairs = linear_sum_assignment(alike, maximize=True)
    return float(2 * alike[pairs].sum() / (len(one) + len(two)))


def iso18571(reference: np.ndarray, curve: np.ndarray) -> dict[str, float]:
    """Return the rating of ISO/TS 18571 and its parts, each from 0 to 1 (excellent above 0.94).

    The standard is written for time signals; here x takes the place of time. Its phase score
    allows shifts up to 20 % of the record.

    Parameters
    ----------
    reference, curve
        f on the same even grid, at least 100 points.

    Raises
    ------
    UserError
        When the package objective-rating-metrics is not installed.
    """
    try:
        from objective_rating_metrics.rating import ISO18571
    except ImportError:
        raise UserError(
            "ISO 18571 needs the package objective-rating-metrics: pip install"
            " objective-rating-metrics"
        ) from None
    step = np.arange(len(reference)) * 1e-4
    rating = ISO18571(np.column_stack([step, reference]), np.column_stack([step, curve]))
    parts: Mapping[str, Any] = {
        "iso18571": rating.overall_rating,
        "iso_corridor": rating.corridor_rating,
        "iso_phase": rating.phase_rating,
        "iso_magnitude": rating.magnitude_rating,
        "iso_slope": rating.slope_rating,
    }
    return {name: float(part(ndigits=-1)) for name, part in parts.items()}


def _values(curve: pd.DataFrame, x: np.ndarray, name: str) -> np.ndarray:
    table = curve[["x", "f"]].dropna()
    table.attrs = dict(curve.attrs)
    if len(table) < 5 or not np.isfinite(table.to_numpy()).all():
        raise UserError(f"the {name} has {len(table)} usable points; at least 5 are needed")
    return instron.on_grid(table, x)


def _peak(curve: pd.DataFrame) -> float:
    """Return f_max of a scaled curve; of a bare table the highest value."""
    if "f_max" in curve.attrs:
        return float(curve.attrs["f_max"])
    inside = curve.loc[(curve["x"] >= 0) & (curve["x"] <= 1), "f"]
    return float(inside.max())


def _peaks(table: pd.DataFrame) -> np.ndarray:
    return table.loc[table["kind"] != "plateau", ["x", "f"]].to_numpy(dtype=float)
