"""One check of a march against every way of going wrong."""

from __future__ import annotations

from sim.diagnosis import unstable
from sim.errors import Unstable
from sim.guards.passing import bent_through, deep_pairs, newcomer, passing_through, tight_bends
from sim.guards.winding import wound_up
from sim.kernels import march as kernel
from sim.marching import Marching

SPEED_LIMIT = 0.2  # of an element's length per step; the stable march stays far below


def fastest(march: Marching) -> float:
    """Return the speed beyond which the time step resolves no motion [m/s]."""
    lengths = march.state.row("LENGTH")
    return SPEED_LIMIT * float(lengths[lengths > 0].min()) / march.dt


def start(march: Marching) -> None:
    """Take note of what is in each other from the start: strands may be, and are pushed apart."""
    march.deep, march.tight = deep_pairs(march), tight_bends(march)


def check(march: Marching, status: int) -> Unstable | None:
    """Return what is wrong with a march that the kernel has stopped for this reason, if anything.

    Strands that pass through each other, or themselves where they are bent, count when they were
    apart at the last look.
    """
    if status == kernel.UNSTABLE:
        return unstable(march)
    if status == kernel.WOUND:
        return wound_up(march)
    if status == kernel.DEEP:
        before, march.deep = march.deep, deep_pairs(march)
        pair = newcomer(march.deep, before)
        return None if pair is None else passing_through(march, *pair)
    if status == kernel.STALE:
        before, march.tight = march.tight, tight_bends(march)
        pair = newcomer(march.tight, before)
        return None if pair is None else bent_through(march, *pair)
    return None
