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
        Columns set, source (experiment, simulation), curve (profile, behind, jump), d [m],
        x = d/D (by the study's D, else the simulation's; NaN where neither is known), s [m] of a
        profile, change, sd. A jump is that of lambda across the tine over lambda_0; behind, two
        ends of the stretch behind the tine with its mean.
    """
    D = combed(chosen) or (combing_ends(run) if run is not None else np.nan)
    parts = _photographed(seen[0] if before is None else before, seen, positions, D)
    if run is not None:
        parts += _simulated(run, positions)
    return pd.concat(parts, ignore_index=True).assign(set=chosen.name)


def _photographed(
    first: pd.DataFrame, seen: Sequence[pd.DataFrame], positions: Sequence[float], D: float
) -> list[pd.DataFrame]:
    rest = float(first["link"].mean())
    parts = []
    for d, one in zip(positions, seen, strict=True):
        profile = {"s": one["s"], "change": one["link"] / rest - 1, "sd": one["sd"] / abs(rest)}
        parts.append(_rows("experiment", "profile", d, d / D, **profile))
        sides = one.attrs.get("sides", {})
        if sides and np.isfinite(sides["jump"]):
            jump = (sides["ahead"] - sides["behind"]) / abs(rest)
            sd = float(np.hypot(sides["ahead_sd"], sides["behind_sd"])) / abs(rest)
            parts.append(_rows("experiment", "jump", d, d / D, s=[np.nan], change=jump, sd=sd))
            mean, sd = sides["behind"] / abs(rest) - 1, sides["behind_sd"] / abs(rest)
            ends = [0.0, sides["tine"]]
            parts.append(_rows("experiment", "behind", d, d / D, s=ends, change=mean, sd=sd))
    return parts


def _simulated(run: sim.Run, positions: Sequence[float]) -> list[pd.DataFrame]:
    profiles, history = link_change(run, positions), link_history(run, shots=None)
    profiles = profiles.assign(source="simulation", curve="profile", sd=0.0)
    jumps = history.assign(source="simulation", curve="jump", sd=0.0, s=np.nan)
    return [profiles[COLUMNS], jumps.rename(columns={"jump": "change"})[COLUMNS]]


def _rows(source: str, curve: str, d: float, x: float, **columns: object) -> pd.DataFrame:
    table = pd.DataFrame(columns).assign(source=source, curve=curve, d=d, x=x)
    return table[COLUMNS]
