"""Stiffness of the contact of two elements: how the forces on their nodes change with these."""

from sim.kernels.compiled import kernel
from sim.kernels.contact import contact_interval
from sim.kernels.layout import *  # noqa: F403
from sim.kernels.overlap import press
from sim.kernels.runs import LENGTH_OF, bounds
from sim.kernels.vectors import along, at, minus


@kernel
def pair_forces(buf, contact, a, b, force):
    """Fill the forces on the nodes a, a + 1, b, b + 1 of a pair, (12,) [N]."""
    p0, q0 = at(buf, X0, X1, X2, a), at(buf, X0, X1, X2, b)
    w, dp = minus(p0, q0), minus(at(buf, X0, X1, X2, a + 1), p0)
    u = minus(at(buf, X0, X1, X2, b + 1), q0)
    reach = buf[RADIUS + a] + buf[RADIUS + b]
    low, high = contact_interval(buf, a, b, reach)
    force[:] = 0.0
    if low < high:
        line = contact.stiffness * buf[LENGTH + a]
        f, by_s, by_t, _, _, _ = press(
            w, along(w, 1.0, dp), (0.0, 0.0, 0.0), u, low, high, reach, line
        )
        for axis in range(3):
            force[axis], force[3 + axis] = f[axis] - by_s[axis], by_s[axis]
            force[6 + axis], force[9 + axis] = by_t[axis] - f[axis], -by_t[axis]


@kernel
def touching_pairs(buf, contact, force, pairs):
    """Fill the pairs in play that touch, (2, room), and return their number."""
    count = run = 0
    while contact.runs[LENGTH_OF, run] > 0:
        first, second, _, length = bounds(contact.runs, run)
        for k in range(length):
            pair_forces(buf, contact, first + k, second + k, force)
            if (force != 0.0).any():
                pairs[0, count], pairs[1, count] = first + k, second + k
                count += 1
        run += 1
    return count


@kernel
def pair_stiffness(buf, contact, pairs, step, forces, blocks):
    """Fill -d(force)/d(node) of pairs, (m, 12, 12) [N/m], by central differences of `step` [m].

    The planes between neighbouring elements stay where they are. `forces` (2, 12) is work space.
    """
    for m in range(pairs.shape[1]):
        a, b = pairs[0, m], pairs[1, m]
        for column in range(12):
            where = (a + column // 3 if column < 6 else b + column // 3 - 2) + PITCH * (column % 3)
            here = buf[X0 + where]
            for side in range(2):
                buf[X0 + where] = here + (2 * side - 1) * step
                pair_forces(buf, contact, a, b, forces[side])
            buf[X0 + where] = here
            for row in range(12):
                blocks[m, row, column] = (forces[0, row] - forces[1, row]) / (2.0 * step)
