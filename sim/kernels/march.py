"""The explicit march: position Verlet over whatever effects the scene has.

An absent effect is ``None``; the compiler prunes its branch, so it costs nothing.
"""

from typing import NamedTuple

import numpy as np

from sim.kernels.compiled import kernel
from sim.kernels.contact import Contact, Friction
from sim.kernels.ends import Driven, Held, Pulled, drive, pull, react, weigh_holders
from sim.kernels.layout import *  # noqa: F403
from sim.kernels.ledger import Ledger, kick_and_book, touch_and_book
from sim.kernels.neighbours import moved_far
from sim.kernels.plane import Planes, plane_forces
from sim.kernels.rod import (
    bend_and_twist,
    clear_loads,
    drift,
    drift_twice,
    kick,
    stretch_and_shear,
)
from sim.kernels.tine import Tines
from sim.kernels.touch import touching_loads
from sim.kernels.vectors import at, dot, minus

DONE, STALE, UNSTABLE, WOUND, DEEP = 0, 1, 2, 3, 4


class Gravity(NamedTuple):
    """Acceleration [m/s^2]."""

    x: float
    y: float
    z: float


class Effects(NamedTuple):
    """All effects of a scene, None where it has not got one.

    `keep` is the fraction of all velocities that drag lets survive a step, `viscous` the
    Kelvin-Voigt time [s]. Friction on tines has coefficients of its own, every plane has one (m,).
    """

    keep: float | None = None
    viscous: float | None = None
    gravity: Gravity | None = None
    contact: Contact | None = None
    friction: Friction | None = None
    tines: Tines | None = None
    tine_friction: Friction | None = None
    planes: Planes | None = None
    plane_friction: np.ndarray | None = None
    driven: Driven | None = None
    pulled: Pulled | None = None
    ledger: Ledger | None = None
    held: Held | None = None


@kernel
def weigh(buf, n, gravity):
    """Add the weight of every node."""
    for i in range(n):
        buf[F0 + i] += buf[MASS + i] * gravity.x
        buf[F1 + i] += buf[MASS + i] * gravity.y
        buf[F2 + i] += buf[MASS + i] * gravity.z


@kernel
def body_loads(buf, n, time, dt, viscous, gravity, pulled):
    """Fill the internal forces and couples, add weight and end loads.

    Returns how many vertices are about to turn by more than half a turn.
    """
    clear_loads(buf, n)
    stretch_and_shear(buf, n, viscous)
    wound = bend_and_twist(buf, n, viscous)
    if gravity is not None:
        weigh(buf, n, gravity)
    if pulled is not None:
        pull(buf, pulled, time, dt)
    return wound


@kernel
def touch(buf, n, time, dt, contact, friction, tines, tine_friction, ledger):
    """Add everything that touches, and book what friction does if there is a ledger."""
    if ledger is not None:
        touch_and_book(buf, n, time, dt, contact, friction, tines, tine_friction, ledger)
    else:
        touching_loads(buf, n, time, dt, contact, friction, tines, tine_friction)


@kernel
def bear(buf, n, dt, planes, plane_friction, ledger):
    """Add the contact with planes, if there are any; the ledger's friction comes before."""
    if planes is not None:
        plane_forces(buf, n, dt, planes, plane_friction, ledger)


@kernel
def speed_up(buf, n, dt, keep, viscous, ledger):
    """Kick, and book the losses if there is a ledger."""
    if ledger is not None:
        kick_and_book(buf, n, dt, keep, viscous, ledger)
    else:
        kick(buf, n, dt, keep)


@kernel
def lead(buf, driven, time):
    """Set the velocities of the ends with a prescribed motion, if there are any."""
    if driven is not None:
        drive(buf, driven, time)


@kernel
def record(buf, driven, held, dt):
    """Add up the reactions of held ends that are asked for or that work, if there are any."""
    if held is not None:
        weigh_holders(buf, held)
    if driven is not None:
        react(buf, driven, dt)


@kernel
def is_stale(buf, n, contact):
    """Tell whether the neighbour list may miss a contact."""
    if contact is not None:
        return moved_far(buf, n, 0.5 * contact.skin)
    return False


@kernel
def gives_way(contact):
    """Tell whether in the last step some contact had all but given way."""
    if contact is not None:
        return contact.play[2] > 0.0
    return False


@kernel
def faster(buf, n, limit):
    """Count the nodes whose squared speed is not below `limit`; a NaN counts."""
    count = 0
    for i in range(n):
        v = at(buf, V0, V1, V2, i)
        count += 0 if dot(v, v) < limit else 1
    return count


@kernel
def too_fast(buf, n, limits):
    """Count the elements strained too fast and the nodes that are too fast; a NaN counts.

    Two elements of different rods are told apart by their ghosts, whose inverse length is zero.
    """
    strained, moved, harmless = limits
    if faster(buf, n, harmless) == 0:
        return 0
    count = 0
    for i in range(n):
        v, inverse = at(buf, V0, V1, V2, i), buf[INV_LENGTH + i]
        step = minus(at(buf, V0, V1, V2, i + 1), v)
        slow = dot(step, step) * inverse * inverse < strained and dot(v, v) < moved
        count += 0 if slow else 1
    return count


@kernel
def verdict(buf, n, limits, wound, contact):
    """Return why the march must stop after this step, DONE if it need not."""
    if too_fast(buf, n, limits) > 0:
        return UNSTABLE
    if wound > 0:
        return WOUND
    return DEEP if gives_way(contact) else DONE


@kernel
def drift_on(buf, n, dt, driven, middle):
    """Drift from the middle of a step to that of the next; driven ends change course between."""
    if driven is not None:
        drift(buf, n, 0.5 * dt)
        drive(buf, driven, middle)
        drift(buf, n, 0.5 * dt)
    else:
        drift_twice(buf, n, 0.5 * dt)


@kernel
def march(buf, n, time, dt, steps, limits, effects):
    """Take up to `steps` steps from `time`; return how many were taken and why it stopped.

    STALE: the neighbour list must be rebuilt before the next step. UNSTABLE: after the step counted
    last, the square of an element's rate of strain or of a node's speed is not below `limits`
    [1/s^2], [m^2/s^2]; the third of these is the square of a speed below which all nodes keep both.
    WOUND: in that step an element turned by nearly half a turn against its neighbour. DEEP: in that
    step strands were half the contact distance apart, or nearly.
    """
    (
        keep, viscous, gravity, contact, friction, tines, tine_friction, planes, plane_friction,
        driven, pulled, ledger, held,
    ) = effects  # fmt: skip
    middle, step = time + 0.5 * dt, 0
    lead(buf, driven, middle)
    drift(buf, n, 0.5 * dt)
    while not is_stale(buf, n, contact):
        wound = body_loads(buf, n, middle, dt, viscous, gravity, pulled)
        touch(buf, n, middle, dt, contact, friction, tines, tine_friction, ledger)
        bear(buf, n, dt, planes, plane_friction, ledger)
        record(buf, driven, held, dt)
        speed_up(buf, n, dt, keep, viscous, ledger)
        lead(buf, driven, middle)  # drag has slowed them too
        step += 1
        status = verdict(buf, n, limits, wound, contact)
        if step == steps or status != DONE:
            drift(buf, n, 0.5 * dt)
            return step, status
        middle = time + (step + 0.5) * dt
        drift_on(buf, n, dt, driven, middle)
    drift(buf, n, -0.5 * dt)
    return step, STALE
