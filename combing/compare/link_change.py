"""Delta lambda / lambda_0: over s at several places of the tine, and its jump there over x."""

from collections.abc import Sequence

import numpy as np
import pandas as pd

import sim
from combing.study import LinkSet, combed
from combing.unlinking import combing_ends, link_change, link_history

COLUMNS = ["source", "curve", "d", "x", "s", "change", "sd"]


def changes(
    chosen: LinkSet,
    before: pd.DataFrame | None,
    seen: Sequence[pd.DataFrame],
    positions: Sequence[float],
    run: sim.Run | None,
) -> pd.DataFrame:
    """Put the change of link density in photographs and in the simulation into one table.

    Parameters
    ----------
    chosen : LinkSet
        From the study.
    before : DataFrame or None
        `measure_link` of the photograph before the tine, for lambda_0; else the first of `seen`.
    seen : sequence of DataFrame
        `measure_link` of the others.
    positions : sequence of float
        Where the tine is in them, d [m].
    run : sim.Run or None
        The simulation.

    Returns
    -------
    DataFrame
        Columns set, source (experiment, simulation), curve (profile, jump), d [m],
        x = d/D (by the study's D, else the simulation's; NaN where neither is known), s [m] of a
        profile, change, sd. A jump is that of `imaging.jump_across`.
    """
    D = combed(chosen) or (combing_ends(run) if run is not None else np.nan)
    parts = _photographed(seen[0] if before is None else before, seen, positions, D)
    if run is not None:
        parts += _simulated(run, positions)
    return pd.concat(parts, ignore_index=True).assign(set=chosen.name)


def _photographed(
    first: pd.DataFrame, seen: Sequence[pd.DataFrame], positions: Sequence[float], D: float
) -> list[pd.DataFrame]:
    lambda_0 = first.attrs["first"]
    rest, parts = lambda_0[0], []
    for d, one in zip(positions, seen, strict=True):
        profile = {"s": one["s"], "change": one["link"] / rest - 1, "sd": one["sd"] / abs(rest)}
        parts.append(_rows("experiment", "profile", d, d / D, **profile))
        found = one.attrs["jump"](lambda_0)
        if np.isfinite(found["jump"]):
            jump = {"change": found["jump"], "sd": found["jump_sd"]}
            parts.append(_rows("experiment", "jump", d, d / D, s=[np.nan], **jump))
    return parts


def _simulated(run: sim.Run, positions: Sequence[float]) -> list[pd.DataFrame]:
    profiles, history = link_change(run, positions), link_history(run, shots=None)
    profiles = profiles.assign(source="simulation", curve="profile", sd=0.0)
    jumps = history.assign(source="simulation", curve="jump", sd=0.0, s=np.nan)
    return [profiles[COLUMNS], jumps.rename(columns={"jump": "change"})[COLUMNS]]


def _rows(source: str, curve: str, d: float, x: float, **columns: object) -> pd.DataFrame:
    table = pd.DataFrame(columns).assign(source=source, curve=curve, d=d, x=x)
    return table[COLUMNS]
