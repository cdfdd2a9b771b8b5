"""How a march whose scene ends at rest comes there: by Newton's method, or by itself."""

from __future__ import annotations

import logging
import math

import numpy as np

from sim import rest
from sim.march import checkpoint
from sim.march.marching import Marching
from sim.march.softness import obstacle, soften
from sim.scene import Scene
from sim.statics.newton import settle

CALM = 0.003  # of `rest.pace`: fastest march that Newton's method is tried on
FAR = 0.02  # of the longest rod: more would be another branch than the march is on
EVERY = 10  # windows between two tries
FINE = 1e-6  # of a node's weight: what Newton's method reaches at no cost
log = logging.getLogger("sim")


def come_to_rest(march: Marching, window: int) -> str | None:
    """Bring a march to rest if it is near; return how it came there, None if it has not.

    Strands that touch are tried every so many windows as soon as they are slow; others at once.
    """
    if march.time < _busy(march.scene):
        return None
    if march.soft == 1.0 and rest.at_rest(march, march.scene.rest_tolerance):
        return f"the march, t = {march.time:.4g} s"
    if obstacle(march.scene) is not None:
        return None
    if march.contact is None:
        return _finish(march) if window == 0 else None
    slow = rest.speed(march) <= CALM * rest.pace(march)
    return _finish(march) if window > 0 and window % EVERY == 0 and slow else None


def _busy(scene: Scene) -> float:
    """Return until when tines, ends and loads do what the scene prescribes [s]."""
    ends = [end for rod in scene.rods for end in (rod.root, rod.tip)]
    moved = [end.motion for end in ends if end.motion]
    courses = [motion.start + (motion.duration or math.inf) for motion in moved]
    loads = [end.load.ramp for end in ends if end.load]
    return max([0.0, *courses, *loads, *(tine.duration for tine in scene.tines)])


def _finish(march: Marching) -> str | None:
    """Settle by Newton's method, or leave the march as it was."""
    mark = checkpoint.mark(march)
    far = np.inf if march.contact is None else FAR * rest.longest(march)
    by, march.soft = march.soft, 1.0
    soften(march.state, 1 / by)
    found = settle(march, min(march.scene.rest_tolerance, FINE), far, by)
    if found.converged:
        return f"Newton's method from t = {march.time:.4g} s, {found.steps} steps"
    checkpoint.thaw(march, mark)
    march.soft = by
    soften(march.state, by)
    log.info(
        "not at rest yet at t = %.4g s: %d steps of Newton's method led to a net force of "
        "%.2g node weights on rod %d", march.time, found.steps, found.residual, found.rod,
    )  # fmt: skip
    return None
