"""Contact and friction between elements of rods; the contact integral is in `sim.kernels.overlap`.

Where strands lie side by side, the pairs that touch come in runs: (a, b), (a + 1, b + 1) and so on.
A run is pressed at once, its columns in a small work space, in loops that the compiler vectorises,
and then added to the nodes. All sums are in the order of the list's pairs, one after another,
however these are put together to runs.
"""

import math
from typing import NamedTuple

import numpy as np

from sim.kernels.compiled import formula, kernel
from sim.kernels.layout import *  # noqa: F403
from sim.kernels.neighbours import keep_in_play
from sim.kernels.overlap import *  # noqa: F403
from sim.kernels.runs import *  # noqa: F403
from sim.kernels.vectors import along, at, cross, dot, minus, push, put, spin, to_body

GIVES_WAY = 0.3  # mean overlap over contact distance, 0.31 where that is half, and more beyond

# Columns of a run: forces at the starts and ends of a and b (of its end with a minus sign), the sum
# of the force's magnitudes and that sum weighted by s and by t, the spring constant of the whole
# interval, couples on a and b, and the slip.
AT_A0, AT_A1, AT_A2, BY_S0, BY_S1, BY_S2 = (STRIDE * row for row in range(6))
AT_B0, AT_B1, AT_B2, BY_T0, BY_T1, BY_T2 = (STRIDE * row for row in range(6, 12))
TOTAL, SUM_S, SUM_T, SPRING = (STRIDE * row for row in range(12, 16))
TURN_A0, TURN_A1, TURN_A2, TURN_B0, TURN_B1, TURN_B2 = (STRIDE * row for row in range(16, 22))
SLIP0, SLIP1, SLIP2 = (STRIDE * row for row in range(22, 25))
WORK = STRIDE * 25


class Contact(NamedTuple):
    """Contact between elements of rods: line stiffness k [N/m^2] and the neighbour list.

    `pairs` (2, m) are the elements a < b that may touch, sorted by rods, by b - a and by a;
    `listed` (4, m + 1) are their runs, `runs` (4, m + 1) those of the pairs in play
    (`sim.kernels.runs`). `play` (3,): for how many steps nodes may move on until these are sieved
    anew, how many steps ago that was, and how many pairs gave way in the last step. `slip` (3, m)
    holds the tangential displacement [m] of each pair, nothing without friction. `rod` and `arc`
    tell which rod an element is on and where. `work` (WORK,): columns of a run.
    """

    stiffness: float
    skin: float
    rod: np.ndarray
    arc: np.ndarray
    self_gap: float
    pairs: np.ndarray
    slip: np.ndarray
    listed: np.ndarray
    runs: np.ndarray
    play: np.ndarray
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
    keep_in_play(buf, n, dt, contact)
    contact.play[2] = 0.0
    run = 0
    while contact.runs[LENGTH_OF, run] > 0:
        contact.play[2] += press_run(buf, contact, run)
        if friction is not None:
            rub_run(buf, dt, contact, friction, run)
        scatter_run(buf, contact, run)
        if friction is not None:
            scatter_couples(buf, contact, run)
        run += 1


@kernel
def press_run(buf, contact, run):
    """Integrate the contact of a run's pairs and fill their columns.

    Returns how many of them give way (`sim.kernels.passing`). Whole vectors only, so that a pair's
    rounding does not depend on its place in the run; nobody uses the columns beyond the last pair.
    """
    a, b, _, length = bounds(contact.runs, run)
    work, yielding = contact.work, 0
    for k in range(whole(length)):
        i, j = a + k, b + k
        p0, q0 = at(buf, X0, X1, X2, i), at(buf, X0, X1, X2, j)
        w, dp = minus(p0, q0), minus(at(buf, X0, X1, X2, i + 1), p0)
        u = minus(at(buf, X0, X1, X2, j + 1), q0)
        n0, n1 = at(buf, B0, B1, B2, j), at(buf, B0, B1, B2, j + 1)
        reach, line = buf[RADIUS + i] + buf[RADIUS + j], contact.stiffness * buf[LENGTH + i]
        low, high = interval(w, dp, u, n0, n1, buf[OVERHANG + j], buf[OVERHANG + j + 1], reach)
        touches = low < high
        low, high = low if touches else 0.0, high if touches else 0.0
        force, by_s, by_t, total, sum_s, sum_t = press(
            w, along(w, 1.0, dp), (0.0, 0.0, 0.0), u, low, high, reach, line
        )
        put(work, AT_A0, AT_A1, AT_A2, k, minus(force, by_s))
        put(work, BY_S0, BY_S1, BY_S2, k, by_s)
        put(work, AT_B0, AT_B1, AT_B2, k, minus(by_t, force))
        put(work, BY_T0, BY_T1, BY_T2, k, by_t)
        spring = line * (high - low)
        put(work, TOTAL, SUM_S, SUM_T, k, (total, sum_s, sum_t))
        work[SPRING + k] = spring
        yielding += 1 if k < length and total > GIVES_WAY * reach * spring else 0
    return yielding


@kernel
def scatter_run(buf, contact, run):
    """Add the forces in the columns of a run to the four nodes of each pair.

    A node is the end of one pair and the start of the next: its sums are in the order of the pairs
    if the ends of all of them come first.
    """
    a, b, _, length = bounds(contact.runs, run)
    add_run(buf, F0, F1, F2, a + 1, contact.work, BY_S0, BY_S1, BY_S2, length, 1.0)
    add_run(buf, F0, F1, F2, b + 1, contact.work, BY_T0, BY_T1, BY_T2, length, -1.0)
    add_run(buf, F0, F1, F2, a, contact.work, AT_A0, AT_A1, AT_A2, length, 1.0)
    add_run(buf, F0, F1, F2, b, contact.work, AT_B0, AT_B1, AT_B2, length, 1.0)


@kernel
def scatter_couples(buf, contact, run):
    """Add the couples in the columns of a run to both elements of each pair."""
    a, b, _, length = bounds(contact.runs, run)
    add_run(buf, C0, C1, C2, a, contact.work, TURN_A0, TURN_A1, TURN_A2, length, 1.0)
    add_run(buf, C0, C1, C2, b, contact.work, TURN_B0, TURN_B1, TURN_B2, length, 1.0)


@formula
def add_run(buf, into0, into1, into2, i, work, row0, row1, row2, length, sign):
    """Add the columns of three rows, times `sign`, to what is stored from index i on."""
    i = natural(i)
    for k in range(whole(length)):
        f0, f1, f2 = at(work, row0, row1, row2, k)
        own = k < length
        buf[into0 + (i + k)] += sign * f0 if own else 0.0
        buf[into1 + (i + k)] += sign * f1 if own else 0.0
        buf[into2 + (i + k)] += sign * f2 if own else 0.0


@kernel
def rub_run(buf, dt, contact, friction, run):
    """Add the friction of a run's pairs to their columns, where they touch."""
    a, b, number, length = bounds(contact.runs, run)
    work = contact.work
    copy_slip(contact.slip, number, work, length)
    for k in range(whole(length)):
        total, sum_s, sum_t = at(work, TOTAL, SUM_S, SUM_T, k)
        touches = total > 0.0
        inverse = 1.0 / (total if touches else 1.0)
        s, t, old = sum_s * inverse, sum_t * inverse, at(work, SLIP0, SLIP1, SLIP2, k)
        f, slip, turn_a, turn_b = rub(
            buf, a + k, b + k, s, t, total, work[SPRING + k], dt, friction, old
        )
        push(work, AT_A0, AT_A1, AT_A2, k, f, 1.0 - s)
        push(work, BY_S0, BY_S1, BY_S2, k, f, s)
        push(work, AT_B0, AT_B1, AT_B2, k, f, t - 1.0)
        push(work, BY_T0, BY_T1, BY_T2, k, f, t)
        put(work, TURN_A0, TURN_A1, TURN_A2, k, turn_a)
        put(work, TURN_B0, TURN_B1, TURN_B2, k, turn_b)
        slip = slip if touches else (0.0, 0.0, 0.0)
        put(work, SLIP0, SLIP1, SLIP2, k, slip)
    keep_slip(work, contact.slip, number, length)


@kernel
def copy_slip(slip, number, work, length):
    """Copy the slip of a run's pairs to their columns."""
    for axis in range(3):
        row = slip[axis]
        for k in range(length):
            work[SLIP0 + axis * STRIDE + k] = row[number + k]


@kernel
def keep_slip(work, slip, number, length):
    """Copy the slip in the columns of a run back."""
    for axis in range(3):
        row = slip[axis]
        for k in range(length):
            row[number + k] = work[SLIP0 + axis * STRIDE + k]


@formula
def rub(buf, a, b, s, t, normal, spring, dt, friction, slip):
    """Return the friction of element a at s on element b at t: force, slip and couples on both.

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
    f, slip = dragged(velocity, to_b, dp, normal, spring, dt, friction, slip)
    turn_a, turn_b = to_body(buf, a, cross(arm_a, f)), to_body(buf, b, cross(f, arm_b))
    return f, slip, turn_a, turn_b


@formula
def surface_velocity(buf, a, s, arm):
    """Return the velocity of the point that sits at s on element a, `arm` off its centreline."""
    v0, v1 = at(buf, V0, V1, V2, a), at(buf, V0, V1, V2, a + 1)
    return along(along(v0, s, minus(v1, v0)), 1.0, cross(spin(buf, a), arm))


@formula
def dragged(velocity, normal_direction, tangent, normal, spring, dt, friction, slip):
    """Return the friction force [N] on the first body and the elastic slip [m] after this step.

    A spring of stiffness `spring` [N/m] follows the relative motion in the contact plane until it
    pulls with mu N, then drags along (Cundall & Strack, Geotechnique 29, 47 (1979)): true sticking
    at rest, and a slope that the time step resolves as well as the normal contact, where a
    velocity-regularised law at these loads would need a slip speed above the tine's. There is no
    dashpot beside the spring: at velocities half a step old it feeds the fast turning of elements.
    """
    inverse = 1.0 / (dot(normal_direction, normal_direction) + 1e-300)
    v = along(velocity, -dot(velocity, normal_direction) * inverse, normal_direction)
    u = along(along(slip, -dot(slip, normal_direction) * inverse, normal_direction), dt, v)
    rootward = dot(u, tangent) < 0.0
    limit = normal * (friction.backward if rootward else friction.forward)
    pull = spring * math.sqrt(dot(u, u))
    shrink = limit / pull if pull > limit else 1.0
    u = (u[0] * shrink, u[1] * shrink, u[2] * shrink)
    return (-spring * u[0], -spring * u[1], -spring * u[2]), u


@kernel
def rubbing_force(velocity, normal_direction, tangent, normal, spring, dt, friction, slip):
    """Return the friction force [N] on the first body and update the elastic slip [m]."""
    old = (slip[0], slip[1], slip[2])
    f, u = dragged(velocity, normal_direction, tangent, normal, spring, dt, friction, old)
    slip[0], slip[1], slip[2] = u
    return f
