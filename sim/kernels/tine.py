"""Rigid cylinders that are driven through the rods: their motion, contact and measured load."""

import math
from typing import NamedTuple

import numpy as np

from sim.kernels.compiled import formula, kernel
from sim.kernels.contact import rubbing_force, surface_velocity
from sim.kernels.curve import bulge_velocity, load_skewness, skewness
from sim.kernels.ends import smooth
from sim.kernels.layout import *  # noqa: F403
from sim.kernels.overlap import GAUSS, arc
from sim.kernels.vectors import along, at, cross, dot, minus, point, push, to_body

SAMPLES = 4  # of an element, where contact with a tine is looked for


class Tines(NamedTuple):
    """All tines of a scene.

    `geometry` (m, 8): start of the axis' midpoint [m], unit axis, half length and radius [m].
    `motion` (m, 10): unit direction, insertion time [s], travel [m], speed [m/s] and its ramp [s]
    on the way there, dwell [s], speed and ramp on the way back. `now` (m, 7): travel [m], speed
    [m/s], radius [m], midpoint [m], rate of the radius [m/s]; filled every step. `load` (m, 3):
    sum over steps of the force on the tine [N]. `work` (1,): done by all tines so far [J].
    `slip` (m, n, 3): see friction. `viscous`: Kelvin-Voigt time of the contact [s], or None.
    """

    stiffness: float
    geometry: np.ndarray
    motion: np.ndarray
    now: np.ndarray
    load: np.ndarray
    work: np.ndarray
    slip: np.ndarray
    viscous: float | None


@kernel
def moved(t, travel, speed, ramp):
    """Return how far [m] and how fast [m/s] after time t: an even start, steady, an even stop."""
    steady = travel / speed
    if t <= 0.0:
        return 0.0, 0.0
    if t < ramp:
        return 0.5 * speed * t * t / ramp, speed * t / ramp
    if t < steady:
        return speed * (t - 0.5 * ramp), speed
    left = steady + ramp - t
    if left <= 0.0:
        return travel, 0.0
    return travel - 0.5 * speed * left * left / ramp, speed * left / ramp


@kernel
def travelled(time, motion):
    """Return a tine's travel [m] and speed [m/s]: at rest, there, dwelling, and perhaps back."""
    travel, speed, ramp, dwell = motion[4], motion[5], motion[6], motion[7]
    if travel <= 0.0:
        return 0.0, 0.0
    t = time - motion[3]
    back = t - (travel / speed + ramp + dwell)
    if back > 0.0 and motion[8] > 0.0:
        distance, velocity = moved(back, travel, motion[8], motion[9])
        return travel - distance, -velocity
    return moved(t, travel, speed, ramp)


@kernel
def place(tines, time):
    """Move every tine to where it is at `time`; while being inserted its radius grows smoothly."""
    for m in range(tines.geometry.shape[0]):
        g, motion, now = tines.geometry[m], tines.motion[m], tines.now[m]
        now[0], now[1] = travelled(time, motion)
        now[2], now[6] = g[7], 0.0
        if time < motion[3]:
            grown = time / motion[3]
            now[2] = g[7] * smooth(grown)
            now[6] = g[7] * 6.0 * grown * (1.0 - grown) / motion[3]
        for axis in range(3):
            now[3 + axis] = g[axis] + now[0] * motion[axis]


@kernel
def tine_forces(buf, n, dt, tines, friction):
    """Add the contact of every element with every tine and sum the reaction on the tine."""
    for m in range(tines.geometry.shape[0]):
        g, now = tines.geometry[m], tines.now[m]
        middle, axis = (now[3], now[4], now[5]), (g[3], g[4], g[5])
        before = tine_power(tines, m)
        for a in range(n):
            if passes_near(buf, a, middle, axis, now[2]):
                one_tine(buf, a, m, dt, tines, friction)
            elif friction is not None:
                tines.slip[m, a, 0] = tines.slip[m, a, 1] = tines.slip[m, a, 2] = 0.0
        tines.work[0] += dt * (tine_power(tines, m) - before)


@kernel
def tine_power(tines, m):
    """Return the power of a tine's steady motion against all the load summed so far [W]."""
    return -tines.now[m, 1] * dot(point(tines.load, m), point(tines.motion, m))


@formula
def passes_near(buf, a, middle, axis, radius):
    """Tell whether a sphere around the centreline of element a meets the cylinder."""
    start, h = minus(at(buf, X0, X1, X2, a), middle), at(buf, H0, H1, H2, a)
    chord = minus(at(buf, X0, X1, X2, a + 1), at(buf, X0, X1, X2, a))
    w = along(start, 0.5, chord)
    across = along(w, -dot(w, axis), axis)
    half = 0.5 * math.sqrt(dot(chord, chord)) + math.sqrt(dot(h, h))
    bound = buf[RADIUS + a] + radius + half
    return buf[LENGTH + a] > 0.0 and dot(across, across) < bound * bound


@formula
def tine_gap(s, w0, dp, bow, skew, u, inverse):
    """Return the vector to a centreline at s from the next place on an axis, and where that is."""
    w = along(arc(w0, s, dp, bow), s * (1.0 - s) * (1.0 - 2.0 * s), skew)
    t = dot(w, u) * inverse
    t = 0.0 if t < 0.0 else (1.0 if t > 1.0 else t)
    return along(w, -t, u), t


@formula
def excess(s, w0, dp, bow, skew, u, reach):
    """Return the squared distance of a centreline at s from an axis less reach^2, and half its
    derivative.
    """
    gap, _ = tine_gap(s, w0, dp, bow, skew, u, 1.0 / dot(u, u))
    slope = along(along(dp, 1.0 - 2.0 * s, bow), 1.0 - 6.0 * s * (1.0 - s), skew)
    return dot(gap, gap) - reach * reach, dot(gap, slope)


@kernel
def border(inside, outside, w0, dp, bow, skew, u, reach):
    """Return where touching ends between a place that touches and one that does not.

    Newton's method, kept between the two by bisection.
    """
    s = 0.5 * (inside + outside)
    for _ in range(60):
        value, slope = excess(s, w0, dp, bow, skew, u, reach)
        inside, outside = (s, outside) if value < 0.0 else (inside, s)
        new = s - 0.5 * value / slope if slope != 0.0 else s
        if not min(inside, outside) < new < max(inside, outside):
            new = 0.5 * (inside + outside)
        if abs(new - s) < 1e-14:
            break
        s = new
    return new


@kernel
def nearest(low, high, w0, dp, bow, skew, u):
    """Return the place of [low, high] that is nearest to an axis, by bisection of the slope."""
    for _ in range(30):
        s = 0.5 * (low + high)
        _, slope = excess(s, w0, dp, bow, skew, u, 0.0)
        low, high = (low, s) if slope > 0.0 else (s, high)
    return s


@kernel
def tine_interval(w0, dp, bow, skew, u, reach):
    """Return the part of a centreline that touches the cylinder with axis u, as [low, high].

    From the first to the last of SAMPLES + 1 places that touch, and to the borders beyond them.
    """
    first, last, near, least = 2.0, -1.0, 0.0, np.inf
    for k in range(SAMPLES + 1):
        value, _ = excess(k / SAMPLES, w0, dp, bow, skew, u, reach)
        if value < 0.0:
            first, last = min(first, k / SAMPLES), k / SAMPLES
        near, least = (k / SAMPLES, value) if value < least else (near, least)
    if last < 0.0:
        low, high = max(near - 1.0 / SAMPLES, 0.0), min(near + 1.0 / SAMPLES, 1.0)
        first = last = nearest(low, high, w0, dp, bow, skew, u)
        if excess(first, w0, dp, bow, skew, u, reach)[0] >= 0.0:
            return 0.0, 0.0
    else:
        low, high = max(first - 1.0 / SAMPLES, 0.0), min(last + 1.0 / SAMPLES, 1.0)
    if excess(low, w0, dp, bow, skew, u, reach)[0] >= 0.0:
        low = border(first, low, w0, dp, bow, skew, u, reach)
    if excess(high, w0, dp, bow, skew, u, reach)[0] >= 0.0:
        high = border(last, high, w0, dp, bow, skew, u, reach)
    return low, high


@formula
def facing_tine(buf, a, m, tines):
    """Return start of element a seen from that of tine m, chord, bulge, skew, axis, and reach."""
    g, now = tines.geometry[m], tines.now[m]
    axis, half = (g[3], g[4], g[5]), g[6]
    p0, q0 = at(buf, X0, X1, X2, a), along((now[3], now[4], now[5]), -half, axis)
    return (
        minus(p0, q0),
        minus(at(buf, X0, X1, X2, a + 1), p0),
        at(buf, H0, H1, H2, a),
        skewness(buf, a),
        (2.0 * half * axis[0], 2.0 * half * axis[1], 2.0 * half * axis[2]),
        buf[RADIUS + a] + now[2],
    )


@kernel
def energy_of(buf, a, m, tines):
    """Return the energy stored in the contact of element a with tine m [J]."""
    w0, dp, bow, skew, u, reach = facing_tine(buf, a, m, tines)
    low, high = tine_interval(w0, dp, bow, skew, u, reach)
    line, total = tines.stiffness * buf[LENGTH + a] * (high - low), 0.0
    for node, weight in GAUSS:
        s = low + (high - low) * node
        gap, _ = tine_gap(s, w0, dp, bow, skew, u, 1.0 / dot(u, u))
        deep = max(reach - math.sqrt(dot(gap, gap)), 0.0)
        total += 0.5 * line * weight * deep * deep
    return total


@kernel
def one_tine(buf, a, m, dt, tines, friction):
    """Add the contact of element a with tine m."""
    w0, dp, bow, skew, u, reach = facing_tine(buf, a, m, tines)
    low, high = tine_interval(w0, dp, bow, skew, u, reach)
    if low >= high:
        if friction is not None:
            tines.slip[m, a, 0] = tines.slip[m, a, 1] = tines.slip[m, a, 2] = 0.0
        return
    force, total, s, t = press_tine(
        buf, a, m, w0, dp, bow, skew, u, low, high, reach, tines, tines.viscous
    )
    tines.work[0] += dt * total * tines.now[m, 6]  # a growing tine pushes along the normal
    if friction is not None and total > 0.0:
        spring = tines.stiffness * buf[LENGTH + a] * (high - low)
        f = rub_tine(buf, a, m, s / total, t / total, total, spring, dt, tines, friction)
        force = along(force, 1.0, f)
    for k in range(3):
        tines.load[m, k] -= force[k]


@kernel
def press_tine(buf, a, m, w0, dp, bow, skew, u, low, high, reach, tines, viscous):
    """Add the contact of element a with a tine over [low, high] to the nodes and the bulge.

    Returns the force [N], the sum of its magnitudes and that sum weighted by s and by t, the places
    on the element and on the axis. Where it is damped, k (overlap + T d(overlap)/dt) nowhere pulls.
    """
    length, inverse = tines.stiffness * buf[LENGTH + a] * (high - low), 1.0 / dot(u, u)
    force = first = (0.0, 0.0, 0.0)
    total = sum_s = sum_t = 0.0
    for node, weight in GAUSS:
        s = low + (high - low) * node
        gap, t = tine_gap(s, w0, dp, bow, skew, u, inverse)
        distance = math.sqrt(dot(gap, gap)) + 1e-300
        deep = max(reach - distance, 0.0)
        if viscous is not None:
            rate = tines.now[m, 6] - dot(seen_from(tines, m, buf, a, s), gap) / distance
            deep = max(deep + viscous * rate, 0.0) if deep > 0.0 else 0.0
        size = length * weight * deep
        part = (size / distance * gap[0], size / distance * gap[1], size / distance * gap[2])
        push(buf, F0, F1, F2, a, part, 1.0 - s)
        push(buf, F0, F1, F2, a + 1, part, s)
        push(buf, P0, P1, P2, a, part, s * (1.0 - s))
        first = along(first, s * (1.0 - s) * (1.0 - 2.0 * s), part)
        force, total = along(force, 1.0, part), total + size
        sum_s, sum_t = sum_s + size * s, sum_t + size * t
    load_skewness(buf, a, first)
    return force, total, sum_s, sum_t


@kernel
def seen_from(tines, m, buf, a, s):
    """Return the velocity of the centreline at s on element a less that of tine m [m/s]."""
    now, motion = tines.now[m], tines.motion[m]
    v0, v1 = at(buf, V0, V1, V2, a), at(buf, V0, V1, V2, a + 1)
    v = arc(v0, s, minus(v1, v0), bulge_velocity(buf, a))
    return along(v, -now[1], (motion[0], motion[1], motion[2]))


@kernel
def rub_tine(buf, a, m, s, t, normal, spring, dt, tines, friction):
    """Add the friction of element a on tine m and return the force on the element [N]."""
    g, now, motion = tines.geometry[m], tines.now[m], tines.motion[m]
    dp = minus(at(buf, X0, X1, X2, a + 1), at(buf, X0, X1, X2, a))
    x = along(at(buf, X0, X1, X2, a), s, dp)
    on_axis = along((now[3], now[4], now[5]), (2.0 * t - 1.0) * g[6], (g[3], g[4], g[5]))
    to_tine = minus(on_axis, x)
    share = buf[RADIUS + a] / (buf[RADIUS + a] + now[2])
    arm = (share * to_tine[0], share * to_tine[1], share * to_tine[2])
    drive = (now[1] * motion[0], now[1] * motion[1], now[1] * motion[2])
    velocity = minus(surface_velocity(buf, a, s, arm), drive)
    f = rubbing_force(velocity, to_tine, dp, normal, spring, dt, friction, tines.slip[m, a])
    push(buf, F0, F1, F2, a, f, 1.0 - s)
    push(buf, F0, F1, F2, a + 1, f, s)
    push(buf, C0, C1, C2, a, to_body(buf, a, cross(arm, f)), 1.0)
    return f
