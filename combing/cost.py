"""Cost of combing with strokes that begin q pitches from the free end: pain against time.

C(q) = gamma f_max(q) + (1 - gamma) q0/q, q0 = 25: the highest force, and the
number of strokes.
"""

import numpy as np
import pandas as pd

Q0 = 25.0
GAMMAS = (0.0, 0.25, 0.5, 0.75, 1.0)
RESAMPLES = 2000


def cost(q: np.ndarray, f_max: np.ndarray, gamma: float, q0: float = Q0) -> np.ndarray:
    """Return C(q).

    Parameters
    ----------
    q : ndarray
        Pitches between the tine and the free end.
    f_max : ndarray
        Highest scaled force of a stroke.
    gamma : float
        Weight of the force, from 0 (time alone) to 1 (pain alone).
    q0 : float
        Pitches in all.
    """
    return gamma * f_max + (1 - gamma) * q0 / q


def cost_table(
    q: np.ndarray, f_max: np.ndarray, *, level: float = 0.95, rng: int = 0
) -> pd.DataFrame:
    """Return cost and optimum over curves, with intervals.

    Parameters
    ----------
    q, f_max : ndarray
        One entry a curve; several curves may share a q.
    level : float
        Of the intervals, from a bootstrap over the curves of each q. With one curve a q there are
        none (NaN).
    rng : int
        Seed of the bootstrap.

    Returns
    -------
    DataFrame
        Columns gamma, q, cost, low, high, and the optimum best, best_low, best_high of each gamma.
    """
    places = np.unique(q)
    groups = [f_max[q == place] for place in places]
    mean = np.array([group.mean() for group in groups])
    drawn = _resampled(groups, np.random.default_rng(rng))
    tail = 100 * (1 - level) / 2
    tables = []
    for gamma in GAMMAS:
        each = cost(places, drawn, gamma)
        low, high = np.percentile(each, [tail, 100 - tail], axis=0)
        best = np.percentile(
            places[each.argmin(axis=1)], [tail, 100 - tail], method="nearest"
        ) if np.isfinite(each).all() else (np.nan, np.nan)  # fmt: skip
        own = cost(places, mean, gamma)
        tables.append(
            pd.DataFrame({"gamma": gamma, "q": places, "cost": own, "low": low, "high": high})
            .assign(best=places[own.argmin()], best_low=best[0], best_high=best[1])
        )  # fmt: skip
    return pd.concat(tables, ignore_index=True)


def _resampled(groups: list[np.ndarray], rng: np.random.Generator) -> np.ndarray:
    """Return (resamples, places) means of f_max; NaN where a place has one curve."""
    columns = [
        rng.choice(group, (RESAMPLES, len(group))).mean(axis=1)
        if len(group) > 1
        else np.full(RESAMPLES, np.nan)
        for group in groups
    ]
    return np.column_stack(columns)
