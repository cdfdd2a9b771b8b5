"""One check of a march against every way of going wrong."""

from __future__ import annotations

import math
from typing import NamedTuple

from sim.diagnosis import NO_NUMBER, unstable
from sim.errors import Unstable
from sim.guards.passing import bent_through, deep_pairs, newcomer, passing_through, tight_bends
from sim.guards.winding import wound_up
from sim.kernels import march as kernel
from sim.march.marching import Marching

STRAINED = 0.2  # most that an element may be strained within a step; stable marches stay far below
MOVED = 0.25  # of the smallest radius: most that what touches may move within a step


class Cause(NamedTuple):
    """Why a march must not go on like this, and whether shorter steps may help."""

    error: Unstable
    by_step: bool


def resolved(march: Marching) -> tuple[float, float, float]:
    """Return what a time step resolves: the square of a rate of strain [1/s^2] and of a speed
    [m^2/s^2], infinite where nothing can touch; and that of a speed which keeps both on any
    element, since its ends part at twice their speed at most: one look at speeds is then enough.
    """
    radius = min(rod.radius for rod in march.scene.rods)
    effects = march.effects
    touches = any(each is not None for each in (effects.contact, effects.tines, effects.planes))
    fastest = MOVED * radius / march.step if touches else math.inf
    strained = STRAINED / march.step
    shortest = 1 / march.state.row("INV_LENGTH").max()
    return strained**2, fastest**2, min(fastest, strained * shortest / 2) ** 2


def check(march: Marching, status: int) -> Cause | None:
    """Return what is wrong with a march that the kernel has stopped for this reason, if anything.

    Strands that pass through each other, or themselves where they are bent, count when they were
    apart at the last look.
    """
    if status == kernel.UNSTABLE:
        error = unstable(march)
        return Cause(error, by_step=error.mode != NO_NUMBER)
    if status == kernel.WOUND:
        return Cause(wound_up(march), by_step=True)
    if status == kernel.DEEP:
        before, march.deep = march.deep, deep_pairs(march)
        pair = newcomer(march.deep, before)
        return None if pair is None else Cause(passing_through(march, *pair), by_step=False)
    if status == kernel.STALE:
        before, march.tight = march.tight, tight_bends(march)
        pair = newcomer(march.tight, before)
        return None if pair is None else Cause(bent_through(march, *pair), by_step=False)
    return None
