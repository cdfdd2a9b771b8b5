"""What comes after the first jam: single runs that part, and what an ensemble says instead."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
import pandas as pd

from combing.accuracy.measurement import Measurement, Problem
from combing.accuracy.study import IMPERFECTION, Teeth

PEAKS = ["run", "first", "first_place", "later", "later_place", "f_max"]
CLOSE, FAR = 0.9, 1.1  # of the places of first jams: before the one and after the other


class Parting(NamedTuple):
    """How far runs that should agree are apart: RMS over mean f, before and after the release."""

    before: float
    after: float


def curves(teeth: Teeth, results: Mapping[Problem, Measurement]) -> pd.DataFrame:
    """Return columns run, d [m], f of every longer combing."""
    tables = [
        pd.DataFrame({"run": name, "d": results[problem].d, "f": results[problem].f})
        for name, problem in teeth.runs.items()
        if results[problem].d is not None
    ]
    return pd.concat(tables, ignore_index=True)


def on_grid(table: pd.DataFrame, runs: list[str]) -> tuple[np.ndarray, np.ndarray]:
    """Return places d (n,) [m] that all runs reach, and f (runs, n)."""
    parts = [table[table["run"] == run] for run in runs]
    shortest = min(parts, key=lambda part: part["d"].max())
    d = shortest["d"].to_numpy()
    return d, np.array([np.interp(d, part["d"], part["f"]) for part in parts])


def parting(teeth: Teeth, results: Mapping[Problem, Measurement]) -> Parting:
    """Return how far the same combing on other meshes and at other speeds parts."""
    names = list(teeth.meshes)
    d, f = on_grid(curves(teeth, results), names)
    jams = [place for name in names if (place := results[teeth.meshes[name]].place) is not None]
    if not jams:
        return Parting(np.nan, np.nan)
    return Parting(_apart(f[:, d < CLOSE * min(jams)]), _apart(f[:, d > FAR * max(jams)]))


def _apart(f: np.ndarray) -> float:
    return float(np.sqrt(np.mean((f[1:] - f[0]) ** 2)) / f[0].mean()) if f.size else np.nan


def ensemble(teeth: Teeth, results: Mapping[Problem, Measurement]) -> pd.DataFrame:
    """Return columns d [m], mean, sd, low, high of f over the perturbed runs."""
    d, f = on_grid(curves(teeth, results), list(teeth.ensemble))
    return pd.DataFrame(
        {
            "d": d,
            "mean": f.mean(axis=0),
            "sd": f.std(axis=0, ddof=1),
            "low": f.min(axis=0),
            "high": f.max(axis=0),
        }
    )


def peaks(teeth: Teeth, results: Mapping[Problem, Measurement]) -> pd.DataFrame:
    """Return columns run, first, first_place, later, later_place, f_max of every longer combing.

    `first` is the first jam, `later` the highest force from a tenth of its place behind it on.
    """
    table = curves(teeth, results)
    rows = []
    for name in table["run"].unique():
        part, one = table[table["run"] == name], results[teeth.runs[name]]
        behind = part[part["d"] > FAR * (one.place or 0.0)]
        later = behind.loc[behind["f"].idxmax()]
        rows.append((name, one.quantity, one.place, later["f"], later["d"], part["f"].max()))
    return pd.DataFrame(rows, columns=PEAKS)


def about() -> list[str]:
    """Return what stands above the ensemble's table."""
    return [
        f"f over d [m] of runs with random curvature, sd {IMPERFECTION:g} of the helix's",
        "f is averaged over the sixth of a pitch before d; low and high are the extremes",
    ]
