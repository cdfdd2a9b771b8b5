"""Why a march became unstable: where, by which effect, and what to change."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from sim.errors import Unstable

if TYPE_CHECKING:
    from sim.explicit import Explicit


def unstable(march: Explicit) -> Unstable:
    """Return the error that says what went wrong in the step just taken."""
    state = march.state
    speed = np.linalg.norm(state.rows("V0 V1 V2"), axis=0)
    worst = int(np.argmax(np.where(np.isfinite(speed), speed, np.inf)))
    rod = int(np.searchsorted(state.first, worst, side="right") - 1)
    element = worst - state.first[rod]
    return Unstable(
        f"unstable at t = {march.time:.6g} s: node {element} of rod {rod} moves at "
        f"{speed[worst]:.3g} m/s, a good part of an element per step of {march.dt:.3g} s; "
        "lower `safety`, the tine's speed or the contact stiffness",
        march.time, rod, element,
    )  # fmt: skip
