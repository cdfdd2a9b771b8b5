"""Cost of combing with strokes that begin q pitches from the free end: pain against time.

C(q) = gamma f_max(q) + (1 - gamma) q0/q, q0 = 25: the highest force, and the
number of strokes.
"""

import numpy as np
import pandas as pd
from scipy import stats

Q0 = 25.0
GAMMAS = (0.0, 0.25, 0.5, 0.75, 1.0)
DRAWS = 2000


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
        Of the intervals: Student's, of the mean over the curves of each q. With one curve a q
        there are none (NaN).
    rng : int
        Seed of the draws of those means that the optimum's interval is made of.

    Returns
    -------
    DataFrame
        Columns gamma, q, cost, low, high, and the optimum best, best_low, best_high of each gamma.
    """
    places = np.unique(q)
    groups = [f_max[q == place] for place in places]
    mean = np.array([group.mean() for group in groups])
    error, freedom = _errors(groups)
    half = stats.t.ppf((1 + level) / 2, freedom) * error
    drawn = mean + error * np.random.default_rng(rng).standard_t(freedom, (DRAWS, len(places)))
    tail = 100 * (1 - level) / 2
    tables = []
    for gamma in GAMMAS:
        each = cost(places, drawn, gamma)
        best = np.percentile(
            places[each.argmin(axis=1)], [tail, 100 - tail], method="nearest"
        ) if np.isfinite(each).all() else (np.nan, np.nan)  # fmt: skip
        own = cost(places, mean, gamma)
        low, high = own - gamma * half, own + gamma * half
        tables.append(
            pd.DataFrame({"gamma": gamma, "q": places, "cost": own, "low": low, "high": high})
            .assign(best=places[own.argmin()], best_low=best[0], best_high=best[1])
        )  # fmt: skip
    return pd.concat(tables, ignore_index=True)


def _errors(groups: list[np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
    """Return standard errors of the means, NaN of one curve alone, and their degrees of freedom."""
    count = np.array([len(group) for group in groups])
    spread = [group.std(ddof=1) if len(group) > 1 else np.nan for group in groups]
    return np.array(spread) / np.sqrt(count), np.maximum(count - 1, 1)


def cost_of_strokes(curves: pd.DataFrame) -> pd.DataFrame:
    """Return `cost_table` of every set over q and source, with columns set and source.

    Parameters
    ----------
    curves : DataFrame
        One row a curve: set, over, source, value, f_max. Sets over anything else are left out.
    """
    strokes = curves[curves["over"] == "q"]
    tables = [
        cost_table(own["value"].to_numpy(float), own["f_max"].to_numpy(float)).assign(
            set=str(name), source=str(source)
        )
        for (name, source), own in strokes.groupby(["set", "source"], sort=False)
    ]
    return pd.concat(tables, ignore_index=True) if tables else pd.DataFrame()
