"""Rigid cylinders that are driven through the rods: their motion, contact and measured load."""

import math
from typing import NamedTuple

import numpy as np

from sim.kernels.compiled import formula, kernel
from sim.kernels.contact import clip, near_line, press, rubbing_force, surface_velocity
from sim.kernels.ends import smooth
from sim.kernels.layout import *  # noqa: F403
from sim.kernels.overlap import GAUSS
from sim.kernels.vectors import along, at, cross, dot, minus, point, push, to_body


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
        middle, axis, half = (now[3], now[4], now[5]), (g[3], g[4], g[5]), g[6]
        q0, q1 = along(middle, -half, axis), along(middle, half, axis)
        before = tine_power(tines, m)
        for a in range(n):
            if passes_near(buf, a, middle, axis, now[2]):
                reach = buf[RADIUS + a] + now[2]
                one_tine(buf, a, m, q0, q1, reach, dt, tines, friction)
            elif friction is not None:
                tines.slip[m, a, 0] = tines.slip[m, a, 1] = tines.slip[m, a, 2] = 0.0
        tines.work[0] += dt * (tine_power(tines, m) - before)


@kernel
def tine_power(tines, m):
    """Return the power of a tine's steady motion against all the load summed so far [W]."""
    return -tines.now[m, 1] * dot(point(tines.load, m), point(tines.motion, m))


@kernel
def passes_near(buf, a, middle, axis, radius):
    """Tell whether a sphere around element a, stretched to twice its length, meets the cylinder."""
    w = minus(at(buf, X0, X1, X2, a), middle)
    across = along(w, -dot(w, axis), axis)
    bound = buf[RADIUS + a] + radius + 2.0 * buf[LENGTH + a]
    return buf[LENGTH + a] > 0.0 and dot(across, across) < bound * bound


@formula
def tine_interval(p0, p1, q0, q1, reach):
    """Return the interval of s on segment p that may touch the cylinder with axis q0 q1."""
    u, w0, w1 = minus(q1, q0), minus(p0, q0), minus(p1, q0)
    cap = reach * math.sqrt(dot(u, u))
    low, high = near_line(0.0, 1.0, w0, w1, u, reach)
    if low < high:
        low, high = clip(low, high, dot(w0, u) + cap, dot(w1, u) + cap)
    if low < high:
        low, high = clip(low, high, cap - dot(minus(p0, q1), u), cap - dot(minus(p1, q1), u))
    return low, high


@kernel
def one_tine(buf, a, m, q0, q1, reach, dt, tines, friction):
    """Add the contact of element a with tine m."""
    p0, p1 = at(buf, X0, X1, X2, a), at(buf, X0, X1, X2, a + 1)
    low, high = tine_interval(p0, p1, q0, q1, reach)
    if low >= high:
        if friction is not None:
            tines.slip[m, a, 0] = tines.slip[m, a, 1] = tines.slip[m, a, 2] = 0.0
        return
    line = tines.stiffness * buf[LENGTH + a]
    force, first_s, total, sum_s, sum_t = press_tine(
        buf, a, q0, q1, low, high, reach, line, tines.now[m], tines.motion[m], tines.viscous
    )
    push(buf, F0, F1, F2, a, minus(force, first_s), 1.0)
    push(buf, F0, F1, F2, a + 1, first_s, 1.0)
    tines.work[0] += dt * total * tines.now[m, 6]  # a growing tine pushes along the normal
    if friction is not None and total > 0.0:
        spring = line * (high - low)
        f = rub_tine(buf, a, m, sum_s / total, sum_t / total, total, spring, dt, tines, friction)
        force = along(force, 1.0, f)
    for k in range(3):
        tines.load[m, k] -= force[k]


@kernel
def press_tine(buf, a, q0, q1, low, high, reach, line, now, motion, viscous):
    """Return force [N], its first moment over s, its sum, and that weighted by s and by t."""
    p0, p1 = at(buf, X0, X1, X2, a), at(buf, X0, X1, X2, a + 1)
    if viscous is not None:
        v0, v1 = at(buf, V0, V1, V2, a), at(buf, V0, V1, V2, a + 1)
        drive = (now[1] * motion[0], now[1] * motion[1], now[1] * motion[2])
        v0, v1, growth = minus(v0, drive), minus(v1, drive), now[6]
        return press_damped(
            p0, p1, q0, q1, v0, v1, growth, low, high, reach, line, viscous
        )  # fmt: skip
    force, first_s, _, total, sum_s, sum_t = press(p0, p1, q0, q1, low, high, reach, line)
    return force, first_s, total, sum_s, sum_t


@kernel
def press_damped(p0, p1, q0, q1, v0, v1, growth, low, high, reach, line, viscous):
    """Integrate k (overlap + T d(overlap)/dt), which nowhere pulls, over the contact.

    The overlap grows as the segment, its ends moving at v0 and v1 past the axis, comes nearer to
    it, and as the tine grows [m/s].
    """
    w0, dp, u, dv = minus(p0, q0), minus(p1, p0), minus(q1, q0), minus(v1, v0)
    inverse = 1.0 / (dot(u, u) + 1e-300)
    force = first_s = (0.0, 0.0, 0.0)
    total = sum_s = sum_t = 0.0
    for node, weight in GAUSS:
        s = low + (high - low) * node
        w = along(w0, s, dp)
        t = min(max(dot(w, u) * inverse, 0.0), 1.0)
        gap = along(w, -t, u)
        distance = math.sqrt(dot(gap, gap)) + 1e-300
        rate = growth - dot(along(v0, s, dv), gap) / distance
        deep = reach - distance
        size = line * (high - low) * weight * max(deep + viscous * rate, 0.0)
        size = size if deep > 0.0 else 0.0
        force = along(force, size / distance, gap)
        first_s = along(first_s, s * size / distance, gap)
        total += size
        sum_s += size * s
        sum_t += size * t
    return force, first_s, total, sum_s, sum_t


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
