"""Where a march lost count of turns: an element half a turn away from the one before."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from sim.energy import directors
from sim.errors import Unstable
from sim.march.marching import Marching


def wound_up(march: Marching) -> Unstable:
    """Return the error that says which element has turned by half a turn against the one before."""
    state = march.state
    frames = directors(state, slice(0, state.n))
    turns = Rotation.from_matrix(frames[1:] @ frames[:-1].transpose(0, 2, 1)).as_rotvec()
    angles = np.linalg.norm(turns, axis=1) * (state.row("INV_VORONOI")[1:] > 0)
    worst = int(np.argmax(angles)) + 1
    rod, element = state.place(worst)
    twisted = abs(turns[worst - 1, 2]) > 0.7 * angles[worst - 1]
    how, mode = ("twists", "twist") if twisted else ("bends", "bending")
    return Unstable(
        f"half a turn at t = {march.time:.6g} s: at node {element}, rod {rod} {how} by "
        f"{np.degrees(angles[worst - 1]):.0f} degrees from one element to the next, and beyond 180 "
        "a turn would be lost unseen; give the rod more elements or turn it less",
        march.time, rod, element, "elasticity", mode,
    )  # fmt: skip
