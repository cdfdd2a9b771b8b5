"""Ends of rods that are moved along a given path or pulled by given loads."""

from typing import NamedTuple

import numpy as np

from sim.kernels.compiled import formula, kernel
from sim.kernels.layout import *  # noqa: F403
from sim.kernels.vectors import along, at, cross, dot, minus, point, push, put, to_body, to_lab


class Driven(NamedTuple):
    """Held ends with a prescribed motion or a direction to slide along.

    `node`, `ghost` (m,): indices of the node and of the clamp's frame, -1 for a pin. `motion`
    (m, 9): velocity [m/s], spin [rad/s], start, ramp and end [s]. `slide` (m, 3): unit direction
    along which the end is free, or zero. `work` (1,): done by the ends so far [J]. `reaction`
    (m, 3): sum over steps of the force that the rod puts on its holder [N].
    """

    node: np.ndarray
    ghost: np.ndarray
    motion: np.ndarray
    slide: np.ndarray
    work: np.ndarray
    reaction: np.ndarray


class Held(NamedTuple):
    """Held ends whose reactions are asked for.

    `node`, `ghost` (m,) and `slide` (m, 3) as those of `Driven`. `net` (m, 6): sum over steps of
    the force [N] and of the moment [N m], about the node, that the rod puts on its holder.
    """

    node: np.ndarray
    ghost: np.ndarray
    slide: np.ndarray
    net: np.ndarray


class Pulled(NamedTuple):
    """Ends under dead loads.

    `node`, `element` (m,): where force and couple act. `load` (m, 10): force [N], couple [N m], a
    point of the force's line [m] (NaN: the node itself) and the time over which the load grows [s].
    `work` (1,): done by the loads so far [J].
    """

    node: np.ndarray
    element: np.ndarray
    load: np.ndarray
    work: np.ndarray


@kernel
def smooth(x):
    """Return 0 below 0, 1 above 1, and 3 x^2 - 2 x^3 between, whose slope is continuous."""
    x = min(max(x, 0.0), 1.0)
    return x * x * (3.0 - 2.0 * x)


@kernel
def share_of_full_speed(time, start, ramp, end):
    """Return how much of its full speed a motion has at `time`."""
    if ramp <= 0.0:
        return 1.0 if start <= time < end else 0.0
    return smooth((time - start) / ramp) * smooth((end - time) / ramp)


@kernel
def drive(buf, driven, time):
    """Give the held nodes and clamps' frames the velocities they have at `time`.

    A sliding node keeps its speed along its direction; what it lacks across is work of its holder.
    """
    for m in range(driven.node.size):
        motion, i, ghost = driven.motion[m], driven.node[m], driven.ghost[m]
        share = share_of_full_speed(time, motion[6], motion[7], motion[8])
        v = at(buf, V0, V1, V2, i)
        free = part_along(v, point(driven.slide, m))
        given, across = (share * motion[0], share * motion[1], share * motion[2]), minus(v, free)
        put(buf, V0, V1, V2, i, along(free, 1.0, given))
        if buf[INV_MASS + i] > 0.0:
            driven.work[0] += 0.5 * buf[MASS + i] * (dot(given, given) - dot(across, across))
        if ghost >= 0:
            spin = to_body(buf, ghost, (share * motion[3], share * motion[4], share * motion[5]))
            buf[W0 + ghost], buf[W1 + ghost], buf[W2 + ghost] = spin


@formula
def part_along(vector, unit):
    """Return the part of a vector along a unit vector, or zero."""
    size = dot(vector, unit)
    return (size * unit[0], size * unit[1], size * unit[2])


@formula
def on_holder(buf, i, slide):
    """Return the force on node i that its holder takes: all of it but what is along a slide."""
    inside = minus(at(buf, N0, N1, N2, i), at(buf, N0, N1, N2, i - 1))
    force = along(at(buf, F0, F1, F2, i), 1.0, inside)
    return minus(force, part_along(force, slide))


@formula
def on_clamp(buf, i, ghost):
    """Return the couple that the vertex at node i puts on the frame of its clamp, in that frame."""
    return at(buf, L0, L1, L2, i) if ghost < i else at(buf, R0, R1, R2, i)


@kernel
def weigh_holders(buf, held):
    """Add up what the rods put on their holders, in the lab frame."""
    for m in range(held.node.size):
        i, ghost = held.node[m], held.ghost[m]
        force = on_holder(buf, i, point(held.slide, m))
        for k in range(3):
            held.net[m, k] += force[k]
        if ghost >= 0:
            couple = to_lab(buf, ghost, on_clamp(buf, i, ghost))
            for k in range(3):
                held.net[m, 3 + k] += couple[k]


@kernel
def react(buf, driven, dt):
    """Add up what the rods put on their driven ends: force, and power times dt.

    What holds a sliding end across its direction takes that part of the force from its node.
    """
    for m in range(driven.node.size):
        i, ghost = driven.node[m], driven.ghost[m]
        force = on_holder(buf, i, point(driven.slide, m))
        for k in range(3):
            driven.reaction[m, k] += force[k]
        if buf[INV_MASS + i] > 0.0:
            push(buf, F0, F1, F2, i, force, -1.0)
        driven.work[0] -= dt * dot(force, at(buf, V0, V1, V2, i))
        if ghost >= 0:
            couple = on_clamp(buf, i, ghost)
            driven.work[0] -= dt * dot(couple, at(buf, W0, W1, W2, ghost))


@kernel
def pull(buf, pulled, time, dt):
    """Add the dead loads to forces and couples, and their work."""
    for m in range(pulled.node.size):
        load, i, a = pulled.load[m], pulled.node[m], pulled.element[m]
        share = smooth(time / load[9]) if load[9] > 0.0 else 1.0
        force = (share * load[0], share * load[1], share * load[2])
        couple = (share * load[3], share * load[4], share * load[5])
        if load[6] == load[6]:
            arm = minus((load[6], load[7], load[8]), at(buf, X0, X1, X2, i))
            lever = cross(arm, force)
            couple = (couple[0] + lever[0], couple[1] + lever[1], couple[2] + lever[2])
        turning = to_body(buf, a, couple)
        push(buf, F0, F1, F2, i, force, 1.0)
        push(buf, C0, C1, C2, a, turning, 1.0)
        power = dot(force, at(buf, V0, V1, V2, i)) + dot(turning, at(buf, W0, W1, W2, a))
        pulled.work[0] += dt * power
