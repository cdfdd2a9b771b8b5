"""The explicit march: position Verlet over whatever effects the scene has.

An absent effect is ``None``; the compiler prunes its branch, so it costs nothing.
"""

from typing import NamedTuple

from sim.kernels.compiled import kernel
from sim.kernels.contact import contact_forces
from sim.kernels.layout import *  # noqa: F403
from sim.kernels.neighbours import moved_far
from sim.kernels.rod import (
    bend_and_twist,
    clear_loads,
    drift,
    kick_elements,
    kick_nodes,
    stretch_and_shear,
)
from sim.kernels.tine import place, tine_forces

DONE, STALE, UNSTABLE = 0, 1, 2


class Gravity(NamedTuple):
    """Acceleration [m/s^2]."""

    x: float
    y: float
    z: float


@kernel
def weigh(buf, n, gravity):
    """Add the weight of every node."""
    for i in range(n):
        buf[F0 + i] += buf[MASS + i] * gravity.x
        buf[F1 + i] += buf[MASS + i] * gravity.y
        buf[F2 + i] += buf[MASS + i] * gravity.z


@kernel
def loads(buf, n, dt, viscous, gravity, contact, friction, tines):
    """Fill all forces and couples at the present positions."""
    clear_loads(buf, n)
    stretch_and_shear(buf, n, viscous)
    bend_and_twist(buf, n, viscous)
    if gravity is not None:
        weigh(buf, n, gravity)
    if contact is not None:
        contact_forces(buf, n, dt, contact, friction)
    if tines is not None:
        tine_forces(buf, n, dt, tines, friction)


@kernel
def kick(buf, n, dt, keep):
    """Change velocities by the forces; drag lets the fraction `keep` of them survive."""
    if keep is not None:
        kick_nodes(buf, n, dt, keep)
        kick_elements(buf, n, dt, keep)
    else:
        kick_nodes(buf, n, dt, 1.0)
        kick_elements(buf, n, dt, 1.0)


@kernel
def too_fast(buf, n, limit):
    """Count the nodes whose squared speed is not below `limit`; a NaN counts."""
    count = 0
    for i in range(n):
        v0, v1, v2 = buf[V0 + i], buf[V1 + i], buf[V2 + i]
        count += 0 if v0 * v0 + v1 * v1 + v2 * v2 < limit else 1
    return count


@kernel
def march(buf, n, time, dt, steps, limit, keep, viscous, gravity, contact, friction, tines):
    """Take up to `steps` steps from `time`; return how many were taken and why it stopped.

    STALE: the neighbour list must be rebuilt before the next step. UNSTABLE: after the step counted
    last, a node's squared speed is above `limit` or not a number.
    """
    half = 0.5 * dt
    for step in range(steps):
        drift(buf, n, half)
        if contact is not None:  # noqa: SIM102  (nested, so that the compiler prunes it)
            if moved_far(buf, n, 0.5 * contact.skin):
                drift(buf, n, -half)
                return step, STALE
        if tines is not None:
            place(tines, time + (step + 0.5) * dt)
        loads(buf, n, dt, viscous, gravity, contact, friction, tines)
        kick(buf, n, dt, keep)
        drift(buf, n, half)
        if too_fast(buf, n, limit) > 0:
            return step + 1, UNSTABLE
    return steps, DONE
