"""Which pairs of elements may touch: Verlet lists from a grid of cells."""

import math

from sim.kernels.compiled import kernel
from sim.kernels.layout import *  # noqa: F403
from sim.kernels.vectors import along, at, dot, minus


@kernel
def moved_far(buf, n, limit):
    """Tell whether a node is farther than `limit` from where it was when the list was built."""
    worst = 0.0
    for i in range(n):
        d0, d1, d2 = buf[X0 + i] - buf[A0 + i], buf[X1 + i] - buf[A1 + i], buf[X2 + i] - buf[A2 + i]
        worst = max(worst, d0 * d0 + d1 * d1 + d2 * d2)
    return worst > limit * limit


@kernel
def remember(buf, n):
    """Store the present positions as those of the neighbour list."""
    for i in range(n):
        buf[A0 + i], buf[A1 + i], buf[A2 + i] = buf[X0 + i], buf[X1 + i], buf[X2 + i]


@kernel
def longest_reach(buf, n, skin):
    """Return the edge of a cell: the largest distance of two midpoints that may touch."""
    length = radius = 0.0
    for i in range(n):
        if buf[LENGTH + i] > 0.0:
            step = minus(at(buf, X0, X1, X2, i + 1), at(buf, X0, X1, X2, i))
            length = max(length, dot(step, step))
            radius = max(radius, buf[RADIUS + i])
    return 2.0 * radius + math.sqrt(length) + skin


@kernel
def cell_of(buf, i, edge):
    """Return the integer coordinates of the cell that holds the midpoint of element i."""
    return (
        int(math.floor(0.5 * (buf[X0 + i] + buf[X0 + i + 1]) / edge)),
        int(math.floor(0.5 * (buf[X1 + i] + buf[X1 + i + 1]) / edge)),
        int(math.floor(0.5 * (buf[X2 + i] + buf[X2 + i + 1]) / edge)),
    )


@kernel
def bucket(cell, mask):
    """Return the hash bucket of a cell (Teschner et al., VMV 2003)."""
    return ((cell[0] * 73856093) ^ (cell[1] * 19349663) ^ (cell[2] * 83492791)) & mask


@kernel
def may_touch(buf, a, b, skin):
    """Tell whether elements a and b come within reach plus skin of each other.

    No point of a is farther than an eighth of its length from one of five samples, so the smallest
    sampled distance minus that is a lower bound of the true one.
    """
    p0, p1 = at(buf, X0, X1, X2, a), at(buf, X0, X1, X2, a + 1)
    q0, q1 = at(buf, X0, X1, X2, b), at(buf, X0, X1, X2, b + 1)
    dp, u = minus(p1, p0), minus(q1, q0)
    inverse = 1.0 / (dot(u, u) + 1e-300)
    nearest = 1e300
    for k in range(5):
        w = minus(along(p0, 0.25 * k, dp), q0)
        gap = along(w, -min(max(dot(w, u) * inverse, 0.0), 1.0), u)
        nearest = min(nearest, dot(gap, gap))
    bound = math.sqrt(nearest) - 0.125 * math.sqrt(dot(dp, dp))
    return bound < buf[RADIUS + a] + buf[RADIUS + b] + skin


@kernel
def eligible(contact, a, b):
    """Tell whether a pair is in contact at all: other rods, or far enough along the same one."""
    if b <= a or contact.rod[b] < 0:
        return False
    if contact.rod[a] != contact.rod[b]:
        return True
    return contact.arc[b] - contact.arc[a] > contact.self_gap


@kernel
def fill_grid(buf, n, contact, edge, heads, following):
    """Chain the elements of each bucket: heads[bucket] -> element -> following[element]."""
    heads[:] = -1
    for i in range(n - 1, -1, -1):
        if contact.rod[i] >= 0:
            slot = bucket(cell_of(buf, i, edge), heads.size - 1)
            following[i] = heads[slot]
            heads[slot] = i


@kernel
def build_list(buf, n, contact, heads, following, start, partner):
    """Fill start and partner with all pairs that may touch and return their number.

    Nothing is written beyond the room that `partner` has; a larger return value says how much
    is needed. `heads` has a power of two entries.
    """
    edge = longest_reach(buf, n, contact.skin)
    fill_grid(buf, n, contact, edge, heads, following)
    count = 0
    for a in range(n):
        start[a] = count
        if contact.rod[a] >= 0:
            count = list_partners(buf, a, contact, edge, heads, following, partner, count)
    start[n] = count
    remember(buf, n)
    return count


@kernel
def list_partners(buf, a, contact, edge, heads, following, partner, count):
    """Append the partners of element a from its cell and the 26 around it."""
    home = cell_of(buf, a, edge)
    for k in range(27):
        cell = (home[0] + k % 3 - 1, home[1] + (k // 3) % 3 - 1, home[2] + k // 9 - 1)
        b = heads[bucket(cell, heads.size - 1)]
        while b >= 0:
            # Two cells may share a bucket: count an element only in the cell it is in.
            here = cell_of(buf, b, edge) == cell
            if here and eligible(contact, a, b) and may_touch(buf, a, b, contact.skin):
                if count < partner.size:
                    partner[count] = b
                count += 1
            b = following[b]
    return count


@kernel
def carry_slip(n, old_start, old_partner, old_slip, start, partner, slip):
    """Hand the elastic slip of every pair that is still listed on to the new list."""
    for a in range(n):
        for k in range(start[a], start[a + 1]):
            slip[k, 0] = slip[k, 1] = slip[k, 2] = 0.0
            for j in range(old_start[a], old_start[a + 1]):
                if old_partner[j] == partner[k]:
                    slip[k, 0], slip[k, 1], slip[k, 2] = (
                        old_slip[j, 0],
                        old_slip[j, 1],
                        old_slip[j, 2],
                    )
