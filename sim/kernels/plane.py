"""Fixed planes, floors and walls: their contact with elements, and friction on them."""

from typing import NamedTuple

import numpy as np

from sim.kernels.compiled import formula, kernel
from sim.kernels.contact import Friction, rubbing_force, surface_velocity
from sim.kernels.layout import *  # noqa: F403
from sim.kernels.vectors import at, cross, dot, minus, push, to_body


class Planes(NamedTuple):
    """All planes of a scene.

    `stiffness`: of a line of contact [N/m^2]. `geometry` (m, 6): a point [m] and the unit normal,
    which leads to the side the rods are on. `load` (m, 3): sum over steps of the force on the plane
    [N]. `slip` (m, n, 3): elastic slip of every element [m], see friction. `viscous`: Kelvin-Voigt
    time of the contact [s], or None.
    """

    stiffness: float
    geometry: np.ndarray
    load: np.ndarray
    slip: np.ndarray
    viscous: float | None


@kernel
def plane_forces(buf, n, dt, planes, friction, ledger):
    """Add the contact of every element with every plane, sum its load, book what it takes."""
    for m in range(planes.geometry.shape[0]):
        for a in range(n):
            if buf[LENGTH + a] > 0.0:
                first, second = borne(buf, a, m, planes, planes.viscous, ledger)
                if first + second > 0.0:
                    press_plane(buf, a, m, first, second, planes)
                if friction is not None:
                    rub_plane(buf, a, m, first, second, dt, planes, friction, ledger)


@kernel
def borne(buf, a, m, planes, viscous, ledger):
    """Return the forces with which the plane bears both halves of element a [N]."""
    first, second = pressed_in(buf, a, m, planes)
    if viscous is not None:
        return dashed(buf, a, m, first, second, planes, viscous, ledger)
    return first, second


@formula
def pressed_in(buf, a, m, planes):
    """Return the same without damping.

    The trapezoid's sum of k times the depth over the element, the gradient of the same sum of its
    energy: on a straight rod that lies flat, exact.
    """
    half = 0.5 * planes.stiffness * buf[LENGTH + a]
    first, second = depth(buf, a, a, m, planes), depth(buf, a, a + 1, m, planes)
    return half * max(first, 0.0), half * max(second, 0.0)


@formula
def depth(buf, a, node, m, planes):
    """Return how deep the surface of element a lies in the plane at a node of it [m]."""
    g = planes.geometry[m]
    height = dot(minus(at(buf, X0, X1, X2, node), (g[0], g[1], g[2])), (g[3], g[4], g[5]))
    return buf[RADIUS + a] - height


@kernel
def dashed(buf, a, m, first, second, planes, viscous, ledger):
    """Add k T d(depth)/dt beside k depth, which nowhere pulls [N]; book what it takes."""
    g, part = planes.geometry[m], 0.5 * planes.stiffness * buf[LENGTH + a] * viscous
    normal = (g[3], g[4], g[5])
    more = -part * dot(at(buf, V0, V1, V2, a), normal)
    beyond = -part * dot(at(buf, V0, V1, V2, a + 1), normal)
    near = max(first + more, 0.0) if first > 0.0 else 0.0
    far = max(second + beyond, 0.0) if second > 0.0 else 0.0
    if ledger is not None:
        for k in range(3):
            ledger.rubbing[k, a] += (near - first) * normal[k]
            ledger.rubbing[k, a + 1] += (far - second) * normal[k]
    return near, far


@kernel
def press_plane(buf, a, m, first, second, planes):
    """Add the plane's force on both nodes of an element and its reaction."""
    g = planes.geometry[m]
    normal = (g[3], g[4], g[5])
    push(buf, F0, F1, F2, a, normal, first)
    push(buf, F0, F1, F2, a + 1, normal, second)
    for k in range(3):
        planes.load[m, k] -= (first + second) * normal[k]


@kernel
def rub_plane(buf, a, m, first, second, dt, planes, friction, ledger):
    """Add the friction of element a on plane m, at the middle of what presses it."""
    total, slip = first + second, planes.slip[m, a]
    if total <= 0.0:
        slip[0] = slip[1] = slip[2] = 0.0
        return
    g, s, r = planes.geometry[m], second / total, buf[RADIUS + a]
    normal, arm = (g[3], g[4], g[5]), (-r * g[3], -r * g[4], -r * g[5])
    dp = minus(at(buf, X0, X1, X2, a + 1), at(buf, X0, X1, X2, a))
    line = planes.stiffness * buf[LENGTH + a]
    spring = line * (0.5 if first == 0.0 or second == 0.0 else 1.0)
    velocity = surface_velocity(buf, a, s, arm)
    own = Friction(friction[m], friction[m])
    f = rubbing_force(velocity, normal, dp, total, spring, dt, own, slip)
    turn = to_body(buf, a, cross(arm, f))
    push(buf, F0, F1, F2, a, f, 1.0 - s)
    push(buf, F0, F1, F2, a + 1, f, s)
    push(buf, C0, C1, C2, a, turn, 1.0)
    if ledger is not None:
        book_rubbing(ledger.rubbing, a, s, f, turn)
    for k in range(3):
        planes.load[m, k] -= f[k]


@kernel
def book_rubbing(rubbing, a, s, f, turn):
    """Add the friction of an element to what works against friction in this step."""
    for k in range(3):
        rubbing[k, a] += (1.0 - s) * f[k]
        rubbing[k, a + 1] += s * f[k]
        rubbing[3 + k, a] += turn[k]
