"""How far a scene is from rest: forces out of balance and speeds, each over a scale of its own."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from sim.march.marching import Marching

Array = NDArray[np.float64]


def scale(march: Marching) -> Array:
    """Return what forces on nodes are measured by [N], (n,): weight, or the largest inner force."""
    gravity, state = march.effects.gravity, march.state
    if gravity is not None and any(gravity):
        return np.maximum(state.row("MASS"), 1e-300) * float(np.linalg.norm(gravity))
    inner = np.linalg.norm(state.rows("N0 N1 N2"), axis=0).max()
    bending = np.abs(state.rows("L0 L1 L2")[:, state.row("INV_VORONOI") > 0]).max(initial=0.0)
    return np.full(state.n, max(inner, bending / longest(march), 1e-300))


def longest(march: Marching) -> float:
    """Return the length of the longest rod [m]."""
    state, rods = march.state, range(len(march.state.first))
    return max(float(state.row("LENGTH")[state.nodes(rod)].sum()) for rod in rods)


def imbalance(march: Marching) -> Array:
    """Return the net force on every node in the last step, without drag, over `scale`, (n,).

    The net couple on an element, over its length, is one on its first node. Held nodes have none.
    """
    state = march.state
    inner = state.rows("N0 N1 N2")
    force = state.rows("F0 F1 F2") + inner - np.roll(inner, 1, axis=1)
    couple = state.rows("C0 C1 C2") + state.rows("E0 E1 E2") + state.rows("R0 R1 R2")
    couple += np.roll(state.rows("L0 L1 L2"), -1, axis=1)
    force[:, state.row("INV_MASS") == 0] = 0.0
    if march.effects.driven is not None:
        for node, slide in zip(march.effects.driven.node, march.effects.driven.slide, strict=True):
            force[:, node] = (slide @ force[:, node]) * slide
    found = np.maximum(
        np.linalg.norm(force, axis=0), np.linalg.norm(couple, axis=0) * state.row("INV_LENGTH")
    )
    return found / scale(march)


def speed(march: Marching) -> float:
    """Return the largest speed of a node [m/s]."""
    return float(np.linalg.norm(march.state.rows("V0 V1 V2"), axis=0).max())


def pace(march: Marching) -> float:
    """Return what speeds are measured by [m/s]: sqrt(g L) of the longest rod.

    A pendulum of length L that swings by a part of L has that part of g and of this speed. Without
    gravity g is that of a rod under the largest inner force.
    """
    state, rods = march.state, range(len(march.state.first))
    gravity = march.effects.gravity
    if gravity is not None and any(gravity):
        return float(np.sqrt(np.linalg.norm(gravity) * longest(march)))
    mass = min(float(state.row("MASS")[state.nodes(rod)].sum()) for rod in rods)
    return float(np.sqrt(scale(march).max() / mass * longest(march)))


def at_rest(march: Marching, tolerance: float) -> bool:
    """Tell whether forces out of balance and speeds are below this part of their scales.

    Never before the first step: no forces are known then.
    """
    if march.steps == 0 or speed(march) > tolerance * pace(march):
        return False
    return float(imbalance(march).max()) <= tolerance


def worst(march: Marching) -> int:
    """Return the rod with the node that is most out of balance."""
    return march.state.place(int(np.argmax(imbalance(march))))[0]
