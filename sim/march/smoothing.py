"""What makes a smooth centreline, the one that contact acts on, of the nodes of rods."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from sim.march.state import State

MORE = 1.2  # by trial: `benchmarks/sim_crossing.py` keeps its place, at 1 it drifts by 0.07 mm
MOST = 0.25


def fill(state: State) -> None:
    """Fill what makes a smooth centreline of the nodes (`sim.kernels.curve`).

    Where a rod is so bent at rest that the curve would be farther than MOST radii from a chord, it
    is as far and no more: the squared distance of two such curves is no parabola, of chords it is.
    """
    length, left = state.row("LENGTH"), np.roll(state.row("LENGTH"), 1)
    inner = state.row("PREVIOUS") * state.row("NEXT")
    kink = 2 * np.minimum(left, length) / np.maximum(left + length, 1e-300)
    state.row("KINK")[:] = inner * kink * _resolved(state)
    bend = np.maximum(state.row("BEND"), np.roll(state.row("BEND"), -1))
    firm = state.row("SHEAR") * length**2
    shear = np.divide(bend, firm, out=np.zeros_like(bend), where=firm > 0)
    square, linear, rest = 4 + 10 * shear, (9 + 10 * shear) / 4, (7 + 15 * shear) / 128
    sharp = (np.sqrt(linear**2 + 4 * square * rest) - linear) / (2 * square)
    even = np.minimum(kink, np.roll(kink, -1)) ** 4
    state.row("SHARP")[:] = 16 * MORE * sharp * even * inner * np.roll(inner, -1)


def _resolved(state: State) -> np.ndarray:
    """Return MOST radii over how far a rod at rest is off its chords, at most 1, for all nodes."""
    span = 0.5 * (state.row("LENGTH") + np.roll(state.row("LENGTH"), 1))
    off = np.linalg.norm(state.rows("K0 K1"), axis=0) * span**2 / 8
    most = MOST * state.row("RADIUS")
    return np.divide(most, off, out=np.ones_like(off), where=off > most)
