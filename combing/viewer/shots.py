"""What the page shows of a run, packed: places, colours and curves at every snapshot shown."""

from __future__ import annotations

import base64
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd

import instron
import sim
from combing.figures.style import STRANDS
from combing.runs import scaled, tine_at
from combing.unlinking import first_link, tine_place
from sim.topology import common_arclength

LIMIT = 7_000_000  # bytes of packed runs on one page; the page itself takes 0.6 MB
PLACES = 160  # along a pair, of its link density
POINTS = 1500  # of a force curve, many times what its panel resolves
NODE = 5 * 2 * 4 / 3  # bytes of a node: three coordinates and two colours, 16 bits each, as base64
WIDEST = 32767


@dataclass(frozen=True)
class Shown:
    """A run as the page has it.

    Attributes
    ----------
    data : dict
        Plain values and base64, as `page.js` reads them.
    every : int
        Every how many snapshots are shown.
    """

    data: dict[str, Any]
    every: int


def shown(run: sim.Run, *, limit: float = LIMIT) -> Shown:
    """Gather what the page shows of a run.

    Parameters
    ----------
    run : sim.Run
    limit : float
        Bytes that it may take; of a longer run every second snapshot is shown, or fewer.
    """
    snapshots, nodes = len(run.times), run.data.sizes["node"]
    every = max(1, int(np.ceil(snapshots * nodes * NODE / limit)))
    # The last one is always shown.
    chosen = np.arange(snapshots - 1, -1, -every)[::-1]
    pair = _Pair(run) if len(run.scene.rods) == 2 and run.scene.tines else None
    data = {
        "title": run.data.attrs["title"],
        "strands": np.bincount(np.asarray(run.data["rod"])).tolist(),
        "radius": np.asarray(run.data["radius"]).tolist(),
        "time": run.times[chosen].tolist(),
        "displacement": run.displacements[chosen].tolist(),
        "position": _packed(np.asarray(run.data["position"])[chosen]),
        "bend": _packed(np.stack([_strain(run, i) for i in chosen])),
        "tine": _tine(run),
        "inks": STRANDS,
    }
    if pair is not None:
        data |= pair.curves(chosen)
    return Shown(data, every)


def _packed(values: np.ndarray) -> dict[str, Any]:
    """Return values as 16-bit steps over their range, NaN as the lowest: value = low + step k."""
    low, high = float(np.nanmin(values)), float(np.nanmax(values))
    step = (high - low) / (2 * WIDEST - 1) or 1.0
    filled = np.where(np.isfinite(values), np.rint((values - low) / step) - WIDEST + 1, -WIDEST)
    content = base64.b64encode(filled.astype("<i2").tobytes()).decode()
    return {"low": low, "step": step, "steps": content}


def _strain(run: sim.Run, snapshot: int) -> np.ndarray:
    """Return the strain of bending, radius times curvature, at every node of a snapshot."""
    return np.concatenate(
        [
            radius * _curvature(strand)
            for radius, strand in zip(
                np.asarray(run.data["radius"]), run.strands(snapshot), strict=True
            )
        ]
    )


def _curvature(strand: np.ndarray) -> np.ndarray:
    """Return the angle at every node over the mean length beside it [1/m], (n,); 0 at the ends."""
    chords = np.diff(strand, axis=0)
    lengths = np.linalg.norm(chords, axis=1)
    tangents = chords / lengths[:, None]
    half_sine = np.linalg.norm(np.diff(tangents, axis=0), axis=1) / 2
    angle = 2 * np.arcsin(np.minimum(half_sine, 1.0))
    return np.concatenate([[0.0], 2 * angle / (lengths[1:] + lengths[:-1]), [0.0]])


def _tine(run: sim.Run) -> dict[str, Any] | None:
    tines = run.scene.tines
    if not tines:
        return None
    start, axis = tine_at(run, 0.0)
    return {
        "position": start.tolist(),
        "way": (tine_at(run, 1.0)[0] - start).tolist(),
        "axis": axis.tolist(),
        "radius": tines[0].radius,
        "length": tines[0].length,
    }


class _Pair:
    """Force and link density of a pair that a tine combs."""

    def __init__(self, run: sim.Run) -> None:
        self.run, self.rest, self.curve = run, first_link(run), scaled(run)

    def curves(self, chosen: np.ndarray) -> dict[str, Any]:
        D, averaged = float(self.curve.attrs["D"]), instron.averaged(self.curve)
        averaged = averaged.iloc[:: -(-len(averaged) // POINTS)]
        sides = [self._link(int(i)) for i in chosen]
        return {
            "D": D,
            "force": {"d": averaged["d"].tolist(), "F": averaged["F"].tolist()},
            "rest": self.rest,
            "length": [side["length"] for side in sides],
            "place": [side["place"] for side in sides],
            "links": _packed(np.stack([side["links"] for side in sides])),
            "link": _packed(np.stack([side["link"] for side in sides])),
        }

    def _link(self, snapshot: int) -> dict[str, Any]:
        """Link density over that at rest: along the pair, and at every node."""
        first, second = self.run.strands(snapshot)
        found = sim.link_density(first, second, resolution=abs(1 / self.rest))
        turns, length = found.attrs["total_link"], found.attrs["length"]
        d = float(self.run.displacements[snapshot])
        on_nodes = np.concatenate(common_arclength(first, second, abs(turns)))
        along = np.linspace(0, length, PLACES)
        return {
            "length": length,
            "place": tine_place(self.run, d, first, second, turns),
            "links": _at(along, found) / self.rest,
            "link": _at(on_nodes, found) / self.rest,
        }


def _at(places: np.ndarray, found: pd.DataFrame) -> np.ndarray:
    return np.interp(places, found["s"], found["link"])
