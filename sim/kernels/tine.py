"""Rigid cylinders that are driven through the rods: their motion, contact and measured load."""

import math
from typing import NamedTuple

import numpy as np

from sim.kernels.compiled import formula, kernel
from sim.kernels.contact import rubbing_force, surface_velocity
from sim.kernels.curve import curve_of, load_bend, place_on, slope_on
from sim.kernels.ends import smooth
from sim.kernels.layout import *  # noqa: F403
from sim.kernels.vectors import along, at, cross, dot, minus, point, push, to_body

# Five Gauss-Legendre points on [0, 1]: a wide tine touches far enough along an element for its
# curve to be no polynomial of low degree.
_X, _W = np.polynomial.legendre.leggauss(5)
GAUSS = tuple((0.5 + 0.5 * x, 0.5 * w) for x, w in zip(_X.tolist(), _W.tolist(), strict=True))


class Tines(NamedTuple):
    """All tines of a scene.

    `geometry` (m, 8): start of the axis' midpoint [m], unit axis, half length and radius [m].
    `motion` (m, 10): unit direction, insertion time [s], travel [m], speed [m/s] and its ramp [s]
    on the way there, dwell [s], speed and ramp on the way back. `now` (m, 7): travel [m], speed
    [m/s], radius [m], midpoint [m], rate of the radius [m/s]; filled every step. `load` (m, 3):
    sum over steps of the force on the tine [N]. `work` (1,): done by all tines so far [J].
    `slip` (m, n, 3): see friction. `viscous`: Kelvin-Voigt time of the contact [s], or None.
    `strands` (rods, 3): sum over steps of the force of all tines on each rod [N], `rod` (n,): the
    rod of every element; both None where they are not asked for.
    """

    stiffness: float
    geometry: np.ndarray
    motion: np.ndarray
    now: np.ndarray
    load: np.ndarray
    work: np.ndarray
    slip: np.ndarray
    viscous: float | None
    strands: np.ndarray | None = None
    rod: np.ndarray | None = None


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


@kernel
def passes_near(buf, a, middle, axis, radius):
    """Tell whether a sphere around element a, stretched to twice its length, meets the cylinder."""
    w = minus(at(buf, X0, X1, X2, a), middle)
    across = along(w, -dot(w, axis), axis)
    bound = buf[RADIUS + a] + radius + 2.0 * buf[LENGTH + a]
    return buf[LENGTH + a] > 0.0 and dot(across, across) < bound * bound


@formula
def facing_tine(buf, a, m, tines):
    """Return the curve of element a as seen from the start of tine m, its axis, and the reach."""
    g, now = tines.geometry[m], tines.now[m]
    axis, half = (g[3], g[4], g[5]), g[6]
    start, chord, first, last = curve_of(buf, X0, X1, X2, a)
    start = minus(start, along((now[3], now[4], now[5]), -half, axis))
    u = (2.0 * half * axis[0], 2.0 * half * axis[1], 2.0 * half * axis[2])
    return (start, chord, first, last), u, buf[RADIUS + a] + now[2]


@formula
def off_axis(w, u):
    """Return the vector to w from the next place on the axis from the origin to u."""
    return along(w, -min(max(dot(w, u) / dot(u, u), 0.0), 1.0), u)


@formula
def outside(curve, s, u, reach):
    """Return squared distance less reach^2 of a curve at s from an axis, and half its slope."""
    gap = off_axis(place_on(curve, s), u)
    return dot(gap, gap) - reach * reach, dot(gap, slope_on(curve, s))


@kernel
def border(curve, inside, beyond, u, reach):
    """Return where touching ends between a place that touches and one that does not.

    Newton's method, kept between the two by bisection.
    """
    s = 0.5 * (inside + beyond)
    for _ in range(60):
        value, slope = outside(curve, s, u, reach)
        inside, beyond = (s, beyond) if value < 0.0 else (inside, s)
        new = s - 0.5 * value / slope if slope != 0.0 else beyond
        if not min(inside, beyond) < new < max(inside, beyond):
            new = 0.5 * (inside + beyond)
        if abs(new - s) < 1e-14:
            break
        s = new
    return s


@kernel
def nearest(curve, u):
    """Return the place on a curve that is nearest to an axis, by bisection of the slope."""
    low, high = 0.0, 1.0
    for _ in range(40):
        s = 0.5 * (low + high)
        _, slope = outside(curve, s, u, 0.0)
        low, high = (low, s) if slope > 0.0 else (s, high)
    return s


@kernel
def tine_interval(curve, u, reach):
    """Return the part of a curve that touches the cylinder with axis u, as [low, high]."""
    at_0, slope_0 = outside(curve, 0.0, u, reach)
    at_1, slope_1 = outside(curve, 1.0, u, reach)
    if at_0 >= 0.0 and at_1 >= 0.0:
        if slope_0 >= 0.0 or slope_1 <= 0.0:
            return 0.0, 0.0
        inside = nearest(curve, u)
        if outside(curve, inside, u, reach)[0] >= 0.0:
            return 0.0, 0.0
    else:
        inside = 0.0 if at_0 < 0.0 else 1.0
    low = border(curve, inside, 0.0, u, reach) if at_0 >= 0.0 else 0.0
    return low, border(curve, inside, 1.0, u, reach) if at_1 >= 0.0 else 1.0


@kernel
def energy_with(buf, a, m, tines):
    """Return the energy stored in the contact of element a with tine m [J]."""
    curve, u, reach = facing_tine(buf, a, m, tines)
    low, high = tine_interval(curve, u, reach)
    line, total = tines.stiffness * buf[LENGTH + a] * (high - low), 0.0
    for node, weight in GAUSS:
        gap = off_axis(place_on(curve, low + (high - low) * node), u)
        deep = max(reach - math.sqrt(dot(gap, gap)), 0.0)
        total += 0.5 * line * weight * deep * deep
    return total


@kernel
def one_tine(buf, a, m, dt, tines, friction):
    """Add the contact of element a with tine m."""
    curve, u, reach = facing_tine(buf, a, m, tines)
    low, high = tine_interval(curve, u, reach)
    if low >= high:
        if friction is not None:
            tines.slip[m, a, 0] = tines.slip[m, a, 1] = tines.slip[m, a, 2] = 0.0
        return
    spring = tines.stiffness * buf[LENGTH + a] * (high - low)
    force, total, sum_s = press_tine(
        buf, a, m, curve, u, low, high, reach, spring, tines, tines.viscous
    )
    tines.work[0] += dt * total * tines.now[m, 6]  # a growing tine pushes along the normal
    if friction is not None and total > 0.0:
        f = rub_tine(buf, a, m, curve, u, sum_s / total, total, spring, dt, tines, friction)
        force = along(force, 1.0, f)
    for k in range(3):
        tines.load[m, k] -= force[k]
    credit(tines.strands, tines.rod, a, force)


@kernel
def credit(strands, rod, a, force):
    """Add the force on element a to that on its strand, if that is asked for."""
    if strands is not None:
        for k in range(3):
            strands[rod[a], k] += force[k]


@kernel
def press_tine(buf, a, m, curve, u, low, high, reach, spring, tines, viscous):
    """Add the contact of element a with a tine over [low, high] to the nodes.

    Returns the force [N], the sum of its magnitudes and that sum weighted by s.
    """
    force = by_s = first = last = (0.0, 0.0, 0.0)
    total = sum_s = 0.0
    for node, weight in GAUSS:
        s = low + (high - low) * node
        gap = off_axis(place_on(curve, s), u)
        distance = math.sqrt(dot(gap, gap)) + 1e-300
        deep = max(reach - distance, 0.0)
        if viscous is not None:
            deep = damped(buf, a, m, s, gap, distance, deep, tines, viscous)
        size = spring * weight * deep
        unit, off = size / distance, -s * (1.0 - s) * size / distance
        force, by_s = along(force, unit, gap), along(by_s, unit * s, gap)
        first, last = along(first, off * (2.0 - s), gap), along(last, off * (1.0 + s), gap)
        total, sum_s = total + size, sum_s + size * s
    push(buf, F0, F1, F2, a, minus(force, by_s), 1.0)
    push(buf, F0, F1, F2, a + 1, by_s, 1.0)
    load_bend(buf, a, a, first)
    load_bend(buf, a, a + 1, last)
    return force, total, sum_s


@kernel
def damped(buf, a, m, s, gap, distance, deep, tines, viscous):
    """Return overlap + T d(overlap)/dt at s on element a [m], which nowhere pulls.

    The overlap grows as the element comes nearer to the axis and as the tine grows.
    """
    now, motion = tines.now[m], tines.motion[m]
    v = place_on(curve_of(buf, V0, V1, V2, a), s)
    v = along(v, -now[1], (motion[0], motion[1], motion[2]))
    rate = now[6] - dot(v, gap) / distance
    return max(deep + viscous * rate, 0.0) if deep > 0.0 else 0.0


@kernel
def rub_tine(buf, a, m, curve, u, s, normal, spring, dt, tines, friction):
    """Add the friction of element a at s on tine m and return the force on the element [N].

    Its arm about the tine is that of the chord, along which the tension acts that it changes; that
    of the curve would raise the exponent of the capstan by l^2/8R^2.
    """
    now, motion = tines.now[m], tines.motion[m]
    start, chord, _, _ = curve
    gap = off_axis(along(start, s, chord), u)
    to_tine = (-gap[0], -gap[1], -gap[2])
    share = buf[RADIUS + a] / (buf[RADIUS + a] + now[2])
    arm = (share * to_tine[0], share * to_tine[1], share * to_tine[2])
    drive = (now[1] * motion[0], now[1] * motion[1], now[1] * motion[2])
    velocity = minus(surface_velocity(buf, a, s, arm), drive)
    f = rubbing_force(velocity, to_tine, chord, normal, spring, dt, friction, tines.slip[m, a])
    push(buf, F0, F1, F2, a, f, 1.0 - s)
    push(buf, F0, F1, F2, a + 1, f, s)
    push(buf, C0, C1, C2, a, to_body(buf, a, cross(arm, f)), 1.0)
    return f
