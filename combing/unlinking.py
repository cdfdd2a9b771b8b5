"""How link flows while a tine combs a pair: its density over s, and on both sides of the tine."""

from collections.abc import Sequence
from functools import partial

import numpy as np
import pandas as pd

import imaging
import instron
import sim
from combing.errors import UserError
from combing.runs import scaled, tine_at
from sim.topology import box_average, common_arclength

SHOTS = 32  # snapshots that a history looks at


def link_change(
    run: sim.Run, positions: Sequence[float], *, resolution: float | None = None
) -> pd.DataFrame:
    """Return (lambda(s) - lambda_0) / lambda_0 of a run at several places of the tine.

    Parameters
    ----------
    run : sim.Run
        Combing of a pair.
    positions : sequence of float
        Tine displacements d [m]; the nearest snapshots are taken.
    resolution : float, optional
        Length over which lambda is averaged [m]; by default one pitch, over which the phase
        of the pair drops out.

    Returns
    -------
    DataFrame
        ``d`` [m] of the snapshot, ``x`` = d/D, ``s`` [m] along the centreline of the pair,
        ``link`` [1/m], ``change``. ``attrs``: ``lambda_0`` [1/m], the link density before
        combing (`imaging.link_before`), with its sign; ``D`` [m].

    Raises
    ------
    UserError
        If the run is not of a pair that a tine combs.
    """
    before = first_link(run)
    width = resolution or abs(1 / before)
    D = combing_ends(run)
    tables = []
    for d in positions:
        snapshot = nearest_snapshot(run, d)
        found = sim.link_density(*run.strands(snapshot)[:2], resolution=width)
        d = float(run.displacements[snapshot])
        tables.append(pd.DataFrame({"d": d, "x": d / D, "s": found["s"], "link": found["link"]}))
    table = pd.concat(tables, ignore_index=True)
    table["change"] = table["link"] / before - 1
    table.attrs = {"lambda_0": before, "D": D}
    return table


def link_history(run: sim.Run, *, shots: int | None = SHOTS) -> pd.DataFrame:
    """Return the link on both sides of the tine over its way.

    Parameters
    ----------
    run : sim.Run
        Combing of a pair.
    shots : int, optional
        Snapshots to look at, evenly over the run; None for all.

    Returns
    -------
    DataFrame
        A row a snapshot up to the end of combing: ``d`` [m], ``x`` = d/D, ``tine``, its place along
        the pair's centreline [m]; ``behind``, ``ahead`` [1/m] and ``jump``, on the root's and the
        tip's side, as `imaging.jump_across` gives them; ``stays``, mean link density from the root
        to the tine [1/m]; ``turns``, link of the pair;
        ``excess``, turns by which lambda exceeds lambda_0 ahead, and ``extent``, over which [m];
        ``near``, lambda within two pitches ahead [1/m]; ``force`` [N], averaged as in
        `instron.scale`. Link counts positive in the sense of the pair. ``attrs`` as `link_change`.

    Raises
    ------
    UserError
        If the run is not of a pair that a tine combs.
    """
    before, curve = first_link(run), scaled(run)
    D, averaged = float(curve.attrs["D"]), instron.averaged(curve)
    last = np.flatnonzero(run.displacements <= D)
    chosen = last if shots is None else last[:: max(1, len(last) // shots)]
    rows = [_sides(run, int(snapshot), before) for snapshot in chosen]
    table = pd.DataFrame(rows)
    table.insert(1, "x", table["d"] / D)
    table["force"] = np.interp(table["d"], averaged["d"], averaged["F"])
    table.attrs = {"lambda_0": before, "D": D}
    return table


def link_facts(history: pd.DataFrame, jams: Sequence[float]) -> dict[str, float]:
    """Return what claims about link are decided by.

    Parameters
    ----------
    history : DataFrame
        From `link_history`.
    jams : sequence of float
        Where the tine jams, x = d/D.

    Returns
    -------
    dict
        ``force_and_excess``, Spearman's correlation of force and excess; ``most_excess`` [turns];
        ``below_jams``, share of the stroke on which lambda near the tine is lower than at the
        jams; ``jump``, ``jump_growth``, ``jump_change``, ``behind``: as the claims say
        (`combing.claims`), over lambda_0; ``expelled``, share of the link. NaN where the history
        does not reach there.
    """
    first, x = abs(history.attrs["lambda_0"]), history["x"]

    def over(column: str, low: float, high: float) -> float:
        return float(history.loc[(x >= low) & (x <= high), column].mean())

    moving = history[x > 0.02]
    at_jams = np.interp(jams, moving["x"], moving["near"]) if len(moving) else np.empty(0)
    lower = [float((moving["near"] < there).mean()) for there in at_jams]
    late, turns = over("jump", 0.5, 0.7), history["turns"].iloc[[0, -1]].to_numpy()
    return {
        "force_and_excess": float(moving["force"].corr(moving["excess"], method="spearman")),
        "most_excess": float(history["excess"].max()),
        "below_jams": float(np.mean(lower)) if lower else np.nan,
        "jump": over("jump", 0.2, 0.9),
        "jump_growth": late - over("jump", 0.15, 0.25),
        "jump_change": over("jump", 0.75, 0.95) / late - 1,
        "behind": over("stays", 0.3, 0.9) / first,
        "expelled": float(1 - turns[1] / turns[0]),
    }


def combing_ends(run: sim.Run) -> float:
    """D, the displacement at which combing ends [m], by the rules of `instron.scale`."""
    return float(scaled(run).attrs["D"])


def nearest_snapshot(run: sim.Run, d: float) -> int:
    """Return the last snapshot among those nearest to tine displacement `d` [m]."""
    apart = np.abs(run.displacements - d)
    return int(np.flatnonzero(apart == apart.min())[-1])


def first_link(run: sim.Run) -> float:
    """Return the link density of a pair before it is combed [1/m], by `imaging.link_before`.

    Raises
    ------
    UserError
        If the run is not of a pair that a tine combs.
    """
    strands = run.strands(0)
    if len(strands) != 2 or not run.scene.tines:
        what = f"{len(strands)} strands and {len(run.scene.tines)} tines"
        raise UserError(
            f"{run.data.attrs['title']}: {what}; link flows in a pair that a tine combs"
        )
    found = sim.link_density(*strands)
    return imaging.link_before(partial(_mean_link, found), found.attrs["length"])[0]


def _mean_link(density: pd.DataFrame, start: float, end: float) -> tuple[float, float]:
    """Mean of a link density of even steps between two arclengths; exact, hence an sd of 0."""
    s, link = density["s"].to_numpy(), density["link"].to_numpy()
    edges = np.append(s - s[0], s[-1] + s[0])
    turns = np.append(0.0, np.cumsum(link * np.diff(edges)))
    return float(np.diff(np.interp([start, end], edges, turns))[0]) / (end - start), 0.0


def _sides(run: sim.Run, snapshot: int, before: float) -> dict[str, float]:
    """Link behind and ahead of the tine in a snapshot."""
    first, second = run.strands(snapshot)
    rest, sense = abs(before), float(np.sign(before))
    found = sim.link_density(first, second)
    d, turns = float(run.displacements[snapshot]), float(found.attrs["total_link"])
    tine, length = tine_place(run, d, first, second, turns), float(found.attrs["length"])
    jump = imaging.jump_across(partial(_mean_link, found), tine, length, (before, 0.0))
    s, link = found["s"].to_numpy(), found["link"].to_numpy() * sense
    step, ahead, near = s[1] - s[0], s > tine, (s > tine) & (s < tine + 2 / rest)
    over = box_average(s, link, 1 / rest)[ahead] - rest
    return {
        "d": d,
        **{one: jump[one] for one in ("tine", "behind", "ahead", "jump")},
        "stays": _mean(link[~ahead]),
        "turns": turns * sense,
        "excess": float(np.sum(over[over > 0]) * step),
        "near": _mean(link[near]),
        "extent": float(np.sum(over > 0) * step),
    }


def _mean(values: np.ndarray) -> float:
    return float(values.mean()) if len(values) else np.nan


def tine_place(
    run: sim.Run, d: float, first: np.ndarray, second: np.ndarray, turns: float
) -> float:
    """Return where the tine is along the pair's centreline [m]: where each strand meets it first.

    A kink that whirls about the tine's axis comes near it again further on.

    Parameters
    ----------
    run : sim.Run
    d : float
        Displacement of the tine [m].
    first, second : (n, 3) arrays
        Strands at that displacement [m].
    turns : float
        Their link.
    """
    place, axis = tine_at(run, d)
    places = []
    touching = 1.5 * (run.scene.tines[0].radius + run.scene.rods[0].radius)
    along = common_arclength(first, second, abs(turns))
    for strand, s in zip((first, second), along, strict=True):
        apart = np.linalg.norm(np.cross(strand - place, axis), axis=1)
        close = np.flatnonzero(apart < max(touching, 1.05 * apart.min()))
        end = close[0] + int(np.argmax(np.append(np.diff(close), 2) > 1))
        places.append(s[close[0] : end + 1][np.argmin(apart[close[0] : end + 1])])
    return float(np.mean(places))
