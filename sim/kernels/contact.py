"""Contact of a segment with a polyline as an integral along the segment.

The potential between strand A and strand B is a line integral over A,

    U = integral 1/2 k (reach - d(s))_+^2 ds,      d(s) = distance from x_A(s) to polyline B,

so the force varies continuously as one strand slides along another, whatever their angle and
whether they are parallel, and no closest-point problem between two segments is solved. Space
around B is divided among its elements by the planes that bisect the angle at each node; every
point of A then has one owner, so nothing counts twice. On the plane the distances to the two
elements are equal, hence U has no jump.
"""

import math
from typing import NamedTuple

import numpy as np

from sim.kernels.compiled import formula, kernel
from sim.kernels.layout import *  # noqa: F403
from sim.kernels.vectors import along, at, cross, dot, minus, push, spin, to_body

# Gauss-Legendre nodes and weights on [0, 1]: exact to degree 5, for a smooth integrand.
GAUSS = (
    (0.5 - math.sqrt(0.15), 5.0 / 18.0),
    (0.5, 8.0 / 18.0),
    (0.5 + math.sqrt(0.15), 5.0 / 18.0),
)


class Contact(NamedTuple):
    """Contact between elements of rods: line stiffness k [N/m^2] and the neighbour list.

    Candidates for element a are ``partner[start[a]:start[a + 1]]``; `slip` holds the tangential
    displacement [m] of each pair. `rod` and `arc` tell which rod an element is on and where.
    """

    stiffness: float
    skin: float
    rod: np.ndarray
    arc: np.ndarray
    self_gap: float
    start: np.ndarray
    partner: np.ndarray
    slip: np.ndarray


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
def clip(low, high, at_0, at_1):
    """Return the part of [low, high] where the linear function from at_0 to at_1 is positive."""
    if at_0 < 0.0 and at_1 < 0.0:
        return 1.0, 0.0
    if at_0 < 0.0:
        low = max(low, at_0 / (at_0 - at_1))
    elif at_1 < 0.0:
        high = min(high, at_0 / (at_0 - at_1))
    return low, high


@formula
def near_line(low, high, w0, w1, u, reach):
    """Return the part of [low, high] where the point w0 + s (w1 - w0) is within reach of line u."""
    inverse = 1.0 / (dot(u, u) + 1e-300)
    a = along(w0, -dot(w0, u) * inverse, u)
    b = along(w1, -dot(w1, u) * inverse, u)
    c = minus(b, a)
    square, middle, offset = dot(c, c), dot(a, c), dot(a, a) - reach * reach
    root = middle * middle - square * offset
    if root <= 0.0:
        # No crossing of the cylinder's surface: parallel inside it, or outside all along.
        if offset < 0.0:
            return low, high
        return 1.0, 0.0
    root = math.sqrt(root)
    if square <= 1e-16 * dot(u, u):
        if offset < 0.0:
            return low, high
        return 1.0, 0.0
    return max(low, (-middle - root) / square), min(high, (root - middle) / square)


@formula
def press(p0, p1, q0, q1, low, high, reach, line):
    """Integrate the contact of segment p over [low, high] with segment q.

    Parameters: ends of both segments [m], interval of s on p, reach [m], and line = k l0 [N/m].
    Returns the force on p [N], its first moments over s and t (the positions on p and q), the sum
    of the force's magnitudes and that sum weighted by s and by t.
    """
    dp, u = minus(p1, p0), minus(q1, q0)
    inverse = 1.0 / (dot(u, u) + 1e-300)
    force = first_s = first_t = (0.0, 0.0, 0.0)
    total = sum_s = sum_t = 0.0
    for node, weight in GAUSS:
        s = low + (high - low) * node
        x = along(p0, s, dp)
        w = minus(x, q0)
        t = min(max(dot(w, u) * inverse, 0.0), 1.0)
        gap = along(w, -t, u)
        distance = math.sqrt(dot(gap, gap))
        if distance < reach:
            size = line * (high - low) * weight * (reach - distance)
            unit = size / max(distance, 1e-300)
            force = along(force, unit, gap)
            first_s = along(first_s, unit * s, gap)
            first_t = along(first_t, unit * t, gap)
            total += size
            sum_s += size * s
            sum_t += size * t
    return force, first_s, first_t, total, sum_s, sum_t


@formula
def contact_interval(buf, a, b, reach):
    """Return the interval of s on element a that element b owns and that may touch it."""
    p0, p1 = at(buf, X0, X1, X2, a), at(buf, X0, X1, X2, a + 1)
    q0, q1 = at(buf, X0, X1, X2, b), at(buf, X0, X1, X2, b + 1)
    w0, w1 = minus(p0, q0), minus(p1, q0)
    n0, n1 = at(buf, B0, B1, B2, b), at(buf, B0, B1, B2, b + 1)
    h0, h1 = buf[OVERHANG + b], buf[OVERHANG + b + 1]
    low, high = clip(0.0, 1.0, dot(w0, n0) + h0, dot(w1, n0) + h0)
    if low < high:
        low, high = clip(low, high, h1 - dot(minus(p0, q1), n1), h1 - dot(minus(p1, q1), n1))
    if low < high:
        low, high = near_line(low, high, w0, w1, minus(q1, q0), reach)
    return low, high


@kernel
def contact_forces(buf, n, dt, contact, friction):
    """Add the contact forces, and friction if given, of all pairs in the neighbour list."""
    wedges(buf, n)
    for a in range(n):
        for k in range(contact.start[a], contact.start[a + 1]):
            b = contact.partner[k]
            reach = buf[RADIUS + a] + buf[RADIUS + b]
            low, high = contact_interval(buf, a, b, reach)
            if low < high:
                touch(buf, a, b, low, high, reach, dt, contact, friction, k)
            elif friction is not None:
                contact.slip[k, 0] = contact.slip[k, 1] = contact.slip[k, 2] = 0.0


@formula
def touch(buf, a, b, low, high, reach, dt, contact, friction, k):
    """Add the forces of one pair to its four nodes."""
    p0, p1 = at(buf, X0, X1, X2, a), at(buf, X0, X1, X2, a + 1)
    q0, q1 = at(buf, X0, X1, X2, b), at(buf, X0, X1, X2, b + 1)
    line = contact.stiffness * buf[LENGTH + a]
    force, first_s, first_t, total, sum_s, sum_t = press(p0, p1, q0, q1, low, high, reach, line)
    push(buf, F0, F1, F2, a, minus(force, first_s), 1.0)
    push(buf, F0, F1, F2, a + 1, first_s, 1.0)
    push(buf, F0, F1, F2, b, minus(force, first_t), -1.0)
    push(buf, F0, F1, F2, b + 1, first_t, -1.0)
    if friction is not None:
        if total > 0.0:
            s, t = sum_s / total, sum_t / total
            rub(buf, a, b, s, t, total, line * (high - low), dt, friction, contact.slip[k])
        else:
            contact.slip[k, 0] = contact.slip[k, 1] = contact.slip[k, 2] = 0.0


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
