"""Contact and friction between elements of rods; the contact integral is in `sim.kernels.overlap`.

The pairs in play are pressed a batch at a time: gathered into rows of a small work space, where the
compiler vectorises the integral, and scattered to the nodes, in the same order at every step.
"""

import math
from typing import NamedTuple

import numpy as np

from sim.kernels.compiled import formula, kernel
from sim.kernels.layout import *  # noqa: F403
from sim.kernels.neighbours import keep_in_play
from sim.kernels.overlap import *  # noqa: F403
from sim.kernels.vectors import along, at, cross, dot, minus, push, spin, to_body

GIVES_WAY = 0.3  # mean overlap over contact distance, 0.31 where that is half, and more beyond


class Contact(NamedTuple):
    """Contact between elements of rods: line stiffness k [N/m^2] and the neighbour list.

    Candidates for element a are ``partner[start[a]:start[a + 1]]``, those in play come first, up to
    ``stop[a]``; `play` (3,) is how far nodes may move until that is found out anew [m], the number
    of steps since, and how many pairs gave way in the last step. `slip` holds the tangential
    displacement [m] of each pair, one row without friction. `rod` and `arc` tell which rod an
    element is on and where. `batch` (3, BATCH) and `work` (WORK,): element, partner and number of
    the pairs that are pressed together, and their columns (`sim.kernels.overlap`).
    """

    stiffness: float
    skin: float
    rod: np.ndarray
    arc: np.ndarray
    self_gap: float
    start: np.ndarray
    partner: np.ndarray
    slip: np.ndarray
    stop: np.ndarray
    play: np.ndarray
    batch: np.ndarray
    work: np.ndarray


class Friction(NamedTuple):
    """Coulomb friction with an elastic slip: its coefficients.

    `forward` resists a strand's surface that slides from its root to its tip over the other body,
    `backward` the other way.
    """

    forward: float
    backward: float


@kernel
def wedges(buf, n):
    """Fill the unit tangents and the normals of the planes that bisect each node's angle."""
    for i in range(n):
        t0 = buf[X0 + i + 1] - buf[X0 + i]
        t1 = buf[X1 + i + 1] - buf[X1 + i]
        t2 = buf[X2 + i + 1] - buf[X2 + i]
        scale = 1.0 / math.sqrt(t0 * t0 + t1 * t1 + t2 * t2 + 1e-300)
        buf[T0 + i], buf[T1 + i], buf[T2 + i] = t0 * scale, t1 * scale, t2 * scale
    for i in range(1, n):
        left, right = buf[PREVIOUS + i], buf[NEXT + i]
        buf[B0 + i] = left * buf[T0 + i - 1] + right * buf[T0 + i]
        buf[B1 + i] = left * buf[T1 + i - 1] + right * buf[T1 + i]
        buf[B2 + i] = left * buf[T2 + i - 1] + right * buf[T2 + i]


@formula
def contact_interval(buf, a, b, reach):
    """Return the interval of s on element a that element b owns and that may touch it."""
    p0, p1 = at(buf, X0, X1, X2, a), at(buf, X0, X1, X2, a + 1)
    q0, q1 = at(buf, X0, X1, X2, b), at(buf, X0, X1, X2, b + 1)
    n0, n1 = at(buf, B0, B1, B2, b), at(buf, B0, B1, B2, b + 1)
    h0, h1 = buf[OVERHANG + b], buf[OVERHANG + b + 1]
    return interval(minus(p0, q0), minus(p1, p0), minus(q1, q0), n0, n1, h0, h1, reach)


@kernel
def contact_forces(buf, n, dt, contact, friction):
    """Add the contact forces, and friction if given, of all pairs in the neighbour list."""
    wedges(buf, n)
    keep_in_play(buf, n, contact)
    contact.play[2] = 0.0
    count = 0
    for a in range(n):
        first, last = contact.start[a], contact.stop[a]
        while first < last:
            some = min(last - first, BATCH - count)
            gather(buf, contact, count, a, first, some)
            first += some
            count += some
            if count == BATCH:
                press_batch(contact.work, count)
                scatter(buf, count, dt, contact, friction)
                count = 0
    # Whole vectors only, so that a pair's rounding does not depend on its place in the batch; the
    # columns beyond the last pair are left over from earlier ones.
    press_batch(contact.work, (count + LANES - 1) // LANES * LANES)
    scatter(buf, count, dt, contact, friction)


@formula
def natural(i):
    """Return the index i, which the compiler then knows not to count from the end of an array."""
    return i & 0x7FFFFFFF


@formula
def gather(buf, contact, count, a, first, some):
    """Put what the contact of element a with some of its partners depends on into columns."""
    work, p0, radius = contact.work, at(buf, X0, X1, X2, a), buf[RADIUS + a]
    dp, line = minus(at(buf, X0, X1, X2, a + 1), p0), contact.stiffness * buf[LENGTH + a]
    for j in range(some):
        m, b = natural(count + j), natural(contact.partner[first + j])
        q0 = at(buf, X0, X1, X2, b)
        contact.batch[0, m], contact.batch[1, m], contact.batch[2, m] = a, b, first + j
        work[OFF0 + m], work[OFF1 + m], work[OFF2 + m] = minus(p0, q0)
        work[DA0 + m], work[DA1 + m], work[DA2 + m] = dp
        work[DB0 + m], work[DB1 + m], work[DB2 + m] = minus(at(buf, X0, X1, X2, b + 1), q0)
        work[LOW0 + m], work[LOW1 + m], work[LOW2 + m] = at(buf, B0, B1, B2, b)
        work[TOP0 + m], work[TOP1 + m], work[TOP2 + m] = at(buf, B0, B1, B2, b + 1)
        work[BELOW + m], work[ABOVE + m] = buf[OVERHANG + b], buf[OVERHANG + b + 1]
        work[REACH + m], work[LINE + m] = radius + buf[RADIUS + b], line


@formula
def scatter(buf, count, dt, contact, friction):
    """Add the forces of all columns to the four nodes of each pair, and their friction."""
    batch, work = contact.batch, contact.work
    for m in range(count):
        # A quick test for `sim.kernels.passing`: straight strands half the contact distance apart.
        if work[TOTAL + m] > GIVES_WAY * work[REACH + m] * work[SPRING + m]:
            contact.play[2] += 1.0
        a, b = natural(batch[0, m]), natural(batch[1, m])
        force = at(work, PUSH0, PUSH1, PUSH2, m)
        by_s, by_t = at(work, BY_S0, BY_S1, BY_S2, m), at(work, BY_T0, BY_T1, BY_T2, m)
        push(buf, F0, F1, F2, a, minus(force, by_s), 1.0)
        push(buf, F0, F1, F2, a + 1, by_s, 1.0)
        push(buf, F0, F1, F2, b, minus(force, by_t), -1.0)
        push(buf, F0, F1, F2, b + 1, by_t, -1.0)
        if friction is not None:
            slip, total = contact.slip[batch[2, m]], work[TOTAL + m]
            if total > 0.0:
                s, t = work[SUM_S + m] / total, work[SUM_T + m] / total
                rub(buf, a, b, s, t, total, work[SPRING + m], dt, friction, slip)
            else:
                slip[0] = slip[1] = slip[2] = 0.0


@kernel
def rub(buf, a, b, s, t, normal, spring, dt, friction, slip):
    """Add the friction between element a at s and element b at t to nodes and couples.

    Both act at one point in space, between the two centrelines, so that neither momentum nor
    angular momentum is made.
    """
    dp = minus(at(buf, X0, X1, X2, a + 1), at(buf, X0, X1, X2, a))
    dq = minus(at(buf, X0, X1, X2, b + 1), at(buf, X0, X1, X2, b))
    x = along(at(buf, X0, X1, X2, a), s, dp)
    y = along(at(buf, X0, X1, X2, b), t, dq)
    to_b = minus(y, x)
    share = buf[RADIUS + a] / (buf[RADIUS + a] + buf[RADIUS + b])
    arm_a = (share * to_b[0], share * to_b[1], share * to_b[2])
    arm_b = along(arm_a, -1.0, to_b)
    velocity = minus(surface_velocity(buf, a, s, arm_a), surface_velocity(buf, b, t, arm_b))
    f = rubbing_force(velocity, to_b, dp, normal, spring, dt, friction, slip)
    push(buf, F0, F1, F2, a, f, 1.0 - s)
    push(buf, F0, F1, F2, a + 1, f, s)
    push(buf, F0, F1, F2, b, f, t - 1.0)
    push(buf, F0, F1, F2, b + 1, f, -t)
    push(buf, C0, C1, C2, a, to_body(buf, a, cross(arm_a, f)), 1.0)
    push(buf, C0, C1, C2, b, to_body(buf, b, cross(arm_b, f)), -1.0)


@kernel
def surface_velocity(buf, a, s, arm):
    """Return the velocity of the point that sits at s on element a, `arm` off its centreline."""
    v0, v1 = at(buf, V0, V1, V2, a), at(buf, V0, V1, V2, a + 1)
    return along(along(v0, s, minus(v1, v0)), 1.0, cross(spin(buf, a), arm))


@kernel
def rubbing_force(velocity, normal_direction, tangent, normal, spring, dt, friction, slip):
    """Return the friction force [N] on the first body and update the elastic slip [m].

    A spring of stiffness `spring` [N/m] follows the relative motion in the contact plane until it
    pulls with mu N, then drags along (Cundall & Strack, Geotechnique 29, 47 (1979)): true sticking
    at rest, and a slope that the time step resolves as well as the normal contact, where a
    velocity-regularised law at these loads would need a slip speed above the tine's. There is no
    dashpot beside the spring: at velocities half a step old it feeds the fast turning of elements.
    """
    inverse = 1.0 / (dot(normal_direction, normal_direction) + 1e-300)
    v = along(velocity, -dot(velocity, normal_direction) * inverse, normal_direction)
    old = (slip[0], slip[1], slip[2])
    u = along(along(old, -dot(old, normal_direction) * inverse, normal_direction), dt, v)
    rootward = dot(u, tangent) < 0.0
    limit = normal * (friction.backward if rootward else friction.forward)
    pull = spring * math.sqrt(dot(u, u))
    if pull > limit:
        shrink = limit / pull
        u = (u[0] * shrink, u[1] * shrink, u[2] * shrink)
    slip[0], slip[1], slip[2] = u
    return -spring * u[0], -spring * u[1], -spring * u[2]
