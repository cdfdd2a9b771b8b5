"""F over x of the lab, and of the model at the best point with a band, from the emulated runs."""

from collections.abc import Sequence

import numpy as np
import pandas as pd

import instron
from combing.fit.emulator import process
from combing.fit.plan import FitPlan, from_unit
from combing.fit.posterior import LEVEL, Posterior

GRID = np.linspace(0, 1, 101)
DRAWS = 400


def fitted_curve(
    plan: FitPlan,
    lab: Sequence[pd.DataFrame],
    unit: np.ndarray,
    runs: Sequence[Sequence[pd.DataFrame]],
    found: Posterior,
) -> pd.DataFrame:
    """Return F over x of the lab and of the model.

    F over the rigidity is emulated at every x by one Gaussian process, whose scale of variation is
    common to all. The band holds one more specimen: friction and factor drawn from the posterior,
    and what one run, drawn of all, is off the emulator.

    Parameters
    ----------
    plan : FitPlan
    lab : sequence of DataFrame
        Scaled logs.
    unit : (n, 2) array
        Points of the runs in the unit square.
    runs : sequence of sequences of DataFrame
        Scaled curves of the members of each point.
    found : Posterior

    Returns
    -------
    DataFrame
        x; lab, lab_sd; best, low, high [N]. The sd of one log is NaN.
    """
    f = [np.array([_over_own_rigidity(one) for one in some]) for some in runs]
    means = np.array([some.mean(axis=0) for some in f])
    counts = np.array([len(some) for some in f])
    noise = np.concatenate([some - some.mean(axis=0) for some in f])
    size = float(means.std())
    variance = float(np.mean(noise**2) * counts.sum() / max(1, (counts - 1).sum()))
    emulated = process(unit, means / size, variance / size**2 / counts)
    off = np.concatenate(
        [some - size * at for some, at in zip(f, emulated.predict(unit), strict=True)]
    )
    rng = np.random.default_rng(0)
    at = found.draws(DRAWS, rng)
    drawn = size * emulated.predict(at) + off[rng.integers(len(off), size=DRAWS)]
    rig = instron.load_rig(plan.rig)
    newtons = rig.rigidity * from_unit(at, plan.friction, plan.factor)[:, 1]
    ends = np.quantile(drawn * newtons[:, None], [(1 - LEVEL) / 2, (1 + LEVEL) / 2], axis=0)
    best = size * emulated.predict(found.unit_of(*found.best)[None])[0]
    own = np.array([curve.attrs["B"] * _over_own_rigidity(curve) for curve in lab])
    return pd.DataFrame(
        {
            "x": GRID,
            "lab": own.mean(axis=0),
            "lab_sd": own.std(axis=0, ddof=1) if len(own) > 1 else np.full(len(GRID), np.nan),
            "best": best * rig.rigidity * found.best[1],
            "low": ends[0],
            "high": ends[1],
        }
    )


def _over_own_rigidity(curve: pd.DataFrame) -> np.ndarray:
    """Return F/B over x [1/m^2]."""
    return instron.on_grid(curve, GRID) / curve.attrs["l0"] ** 2
