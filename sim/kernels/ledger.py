"""Where energy goes: what drag, material and friction take in a step, what contact stores."""

import math
from typing import NamedTuple

import numpy as np

from sim.kernels.compiled import kernel
from sim.kernels.contact import GAUSS, contact_interval, wedges
from sim.kernels.layout import *  # noqa: F403
from sim.kernels.rod import kick, logarithm, strain_rate, turning_rate
from sim.kernels.tine import Tines, energy_with
from sim.kernels.touch import touching_loads
from sim.kernels.vectors import along, at, dot, minus


class Ledger(NamedTuple):
    """Energy taken so far by drag, material and contact [J], (1,) each, and room to book it.

    `before`, `after`, `loads`, `rubbing` (6, n): velocities and spins on either side of a kick,
    forces and couples without friction and of friction alone.
    """

    drag: np.ndarray
    material: np.ndarray
    friction: np.ndarray
    before: np.ndarray
    after: np.ndarray
    loads: np.ndarray
    rubbing: np.ndarray


@kernel
def touch_and_book(buf, n, time, dt, contact, friction, tines, tine_friction, ledger):
    """Add all that touches; without friction and damping first, to tell what these two take."""
    copy_rows(buf, n, F0, C0, ledger.loads)
    smooth = without_records(tines)
    touching_loads(buf, n, time, dt, contact, None, smooth, None)
    copy_rows(buf, n, F0, C0, ledger.rubbing)
    set_rows(buf, n, F0, C0, ledger.loads)
    before = recorded(tines)
    touching_loads(buf, n, time, dt, contact, friction, tines, tine_friction)
    copy_rows(buf, n, F0, C0, ledger.loads)
    ledger.rubbing[:] = ledger.loads - ledger.rubbing
    if tines is not None:  # what they do against friction and damping is lost as well
        ledger.friction[0] += tines.work[0] - before - smooth.work[0]


@kernel
def recorded(tines):
    """Return the work done by the tines so far, if there are any [J]."""
    if tines is not None:
        return tines.work[0]
    return 0.0


@kernel
def without_records(tines):
    """Return the tines with loads and work of their own, undamped, if there are any."""
    if tines is not None:
        return Tines(
            tines.stiffness, tines.geometry, tines.motion, tines.now,
            np.zeros_like(tines.load), np.zeros(1), tines.slip, nil(tines.viscous), None, None,
        )  # fmt: skip
    return None


@kernel
def nil(viscous):
    """Return zero for a number, None for None: of the same type, but without effect."""
    if viscous is not None:
        return 0.0
    return None


@kernel
def kick_and_book(buf, n, dt, keep, viscous, ledger):
    """Kick, and book what was lost: a load works on the mean of the old and the new velocity.

    The viscous load is linear in the old velocity; with the dissipation P, a quadratic form, its
    work is dt [P(old)/2 + P(old, new)/2], and P(old, new) follows by polarisation.
    """
    power = material_power(buf, n, viscous)
    copy_rows(buf, n, V0, W0, ledger.before)
    kick(buf, n, dt, keep)
    copy_rows(buf, n, V0, W0, ledger.after)
    ledger.friction[0] -= 0.5 * dt * np.sum(ledger.rubbing * (ledger.before + ledger.after))
    if keep is not None:
        ledger.drag[0] += (1.0 / (keep * keep) - 1.0) * kinetic(buf, n)
    if viscous is not None:
        later = material_power(buf, n, viscous)
        set_rows(buf, n, V0, W0, ledger.after - ledger.before)
        change = material_power(buf, n, viscous)
        set_rows(buf, n, V0, W0, ledger.after)
        ledger.material[0] += dt * (0.75 * power + 0.25 * later - 0.25 * change)


@kernel
def copy_rows(buf, n, first, second, store):
    """Copy two vectors of all indices, at rows `first` and `second`, from the buffer."""
    for k in range(3):
        for i in range(n):
            store[k, i] = buf[first + k * PITCH + i]
            store[3 + k, i] = buf[second + k * PITCH + i]


@kernel
def set_rows(buf, n, first, second, store):
    """Copy two vectors of all indices into the buffer."""
    for k in range(3):
        for i in range(n):
            buf[first + k * PITCH + i] = store[k, i]
            buf[second + k * PITCH + i] = store[3 + k, i]


@kernel
def kinetic(buf, n):
    """Return the kinetic energy of everything that is free to move [J]."""
    total = 0.0
    for i in range(n):
        v, w = at(buf, V0, V1, V2, i), at(buf, W0, W1, W2, i)
        if buf[INV_MASS + i] > 0.0:
            total += buf[MASS + i] * dot(v, v)
        if buf[INV_J1 + i] > 0.0:
            total += (w[0] * w[0] + w[1] * w[1]) / buf[INV_J1 + i] + w[2] * w[2] / buf[INV_J3 + i]
    return 0.5 * total


@kernel
def material_power(buf, n, viscous):
    """Return the power that the Kelvin-Voigt material takes at the present velocities [W]."""
    if viscous is None:
        return 0.0
    total = 0.0
    for i in range(n):
        total += buf[LENGTH + i] * stretching_power(buf, i)
        if buf[INV_VORONOI + i] > 0.0:
            total += buf[INV_VORONOI + i] * turning_power(buf, i)
    return viscous * total


@kernel
def stretching_power(buf, i):
    """Return d(sigma)/dt . S d(sigma)/dt of element i [N/s^2]."""
    step = minus(at(buf, X0, X1, X2, i + 1), at(buf, X0, X1, X2, i))
    inv = buf[INV_LENGTH + i]
    r0, r1, r2 = strain_rate(
        buf,
        i,
        inv * dot(at(buf, Q00, Q01, Q02, i), step),
        inv * dot(at(buf, Q10, Q11, Q12, i), step),
        inv * dot(at(buf, Q20, Q21, Q22, i), step),
    )
    return buf[SHEAR + i] * (r0 * r0 + r1 * r1) + buf[STRETCH + i] * r2 * r2


@kernel
def turning_power(buf, i):
    """Return dp/dt . B dp/dt of the rotation vector at vertex i [N m^2/s^2]."""
    p0, p1, p2 = logarithm(buf, i)
    square = p0 * p0 + p1 * p1 + p2 * p2
    theta = math.sqrt(square)
    # Below a thousandth of a radian the coefficient is 1/12 to a part in 10^7.
    gamma = (1.0 - 0.5 * theta / math.tan(0.5 * theta)) / square if theta > 1e-3 else 1.0 / 12.0
    r0, r1, r2 = turning_rate(buf, i, p0, p1, p2, gamma)
    return buf[BEND + i] * (r0 * r0 + r1 * r1) + buf[TWIST + i] * r2 * r2


@kernel
def pressed(p0, p1, q0, q1, low, high, reach, line):
    """Return the energy of the contact of segment p over [low, high] with segment q [J]."""
    dp, u = minus(p1, p0), minus(q1, q0)
    inverse = 1.0 / (dot(u, u) + 1e-300)
    total = 0.0
    for node, weight in GAUSS:
        x = along(p0, low + (high - low) * node, dp)
        w = minus(x, q0)
        t = min(max(dot(w, u) * inverse, 0.0), 1.0)
        gap = along(w, -t, u)
        deep = max(reach - math.sqrt(dot(gap, gap)), 0.0)
        total += 0.5 * line * (high - low) * weight * deep * deep
    return total


@kernel
def contact_energy(buf, n, contact):
    """Return the energy stored in the contact of rods [J]."""
    wedges(buf, n)
    total = 0.0
    for k in range(contact.pairs.shape[1]):
        a, b = contact.pairs[0, k], contact.pairs[1, k]
        reach = buf[RADIUS + a] + buf[RADIUS + b]
        low, high = contact_interval(buf, a, b, reach)
        if low < high:
            p0, p1 = at(buf, X0, X1, X2, a), at(buf, X0, X1, X2, a + 1)
            q0, q1 = at(buf, X0, X1, X2, b), at(buf, X0, X1, X2, b + 1)
            line = contact.stiffness * buf[LENGTH + a]
            total += pressed(p0, p1, q0, q1, low, high, reach, line)
    return total


@kernel
def tine_energy(buf, n, tines):
    """Return the energy stored in the contact of rods with tines, where they are placed [J]."""
    total = 0.0
    for m in range(tines.geometry.shape[0]):
        for a in range(n):
            if buf[LENGTH + a] > 0.0:
                total += energy_with(buf, a, m, tines)
    return total
