"""Rods that are marched softer than they are, because Newton's method finishes them as they are.

What a march costs on its way to rest is set by waves of stretch and shear, which carry hardly any
load there. With their rigidities lowered, as far as loads strain rods by less than `STRAIN`, they
allow longer steps; bending, inertia and contact, which make the motion, stay as they are.
"""

from __future__ import annotations

import numpy as np

from sim.march.state import State
from sim.scene import Scene

LEAST, STRAIN = 0.01, 1e-3
ROWS = ("SHEAR", "STRETCH")


def obstacle(scene: Scene) -> str | None:
    """Return why Newton's method cannot find the rest of a scene, if it cannot."""
    if scene.friction is not None or scene.tines or scene.planes:
        return "friction, tines and planes"
    for number, rod in enumerate(scene.rods):
        if rod.root.hold != "clamped" or rod.root.motion or rod.root.slides:
            return f"rods.{number}.root, which is not clamped in one place"
        if rod.tip.hold != "free" or (rod.tip.load and rod.tip.load.through):
            return f"rods.{number}.tip, which is held or pulled along a line"
    return None


def softness(scene: Scene, state: State) -> float:
    """Return what the rigidities of stretch and shear may be multiplied by on the way to rest."""
    if scene.until != "rest" or scene.contact is None or obstacle(scene) is not None:
        return 1.0
    weight = float(np.linalg.norm(scene.gravity or 0.0))
    strains = []
    for number, rod in enumerate(scene.rods):
        at = state.nodes(number)
        load = 0.0 if rod.tip.load is None else float(np.linalg.norm(rod.tip.load.force))
        load += weight * float(state.row("MASS")[at].sum())
        strains.append(load / float(state.row("SHEAR")[at][:-1].min()))
    return float(np.clip(max(strains) / STRAIN, LEAST, 1.0))


def soften(state: State, by: float) -> None:
    """Multiply the rigidities of stretch and shear, and slow down waves of twist.

    These hardly move, and would limit the step next: their inertia goes as 1/sqrt(by).
    """
    for name in ROWS:
        state.row(name)[:] *= by
    state.row("INV_J3")[:] *= by**0.5
    turns = state.row("INV_J3") > 0
    state.row("J_RATIO")[turns] = state.row("INV_J1")[turns] / state.row("INV_J3")[turns] - 1
