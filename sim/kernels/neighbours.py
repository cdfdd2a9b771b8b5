"""Which pairs of elements may touch: Verlet lists from a grid of cells, and a second, finer sieve.

A list holds every pair that may touch before a node has moved by half the skin. Of these, the pairs
in play may touch before a node has moved by a small part of it: few more than really do.
"""

import math

import numpy as np

from sim.kernels.compiled import formula, kernel
from sim.kernels.layout import *  # noqa: F403
from sim.kernels.overlap import interval
from sim.kernels.runs import LENGTH_OF, bounds, prolong, whole
from sim.kernels.vectors import along, at, dot, minus

FINEST, COARSEST = 1 / 1024, 1 / 8  # of the skin: how far nodes may move before the next sieving
SELDOM, OFTEN = 20, 8  # steps between two sievings
LEAST, MOST = 2.0, 32.0  # steps for which nodes may move on as fast as they are
FORGETS = 0.9  # from one sieving to the next, how fast a node was


@kernel
def moved_far(buf, n, limit):
    """Tell whether a node is farther than `limit` from where the neighbour list was built."""
    far = 0
    for i in range(n):
        step = minus(at(buf, X0, X1, X2, i), at(buf, A0, A1, A2, i))
        far += 1 if dot(step, step) > limit * limit else 0
    return far > 0


@kernel
def roamed_far(buf, n):
    """Tell whether a node is farther from the last sieving than was reckoned with."""
    far = 0
    for i in range(n):
        step, limit = minus(at(buf, X0, X1, X2, i), at(buf, G0, G1, G2, i)), buf[ROAM + i]
        far += 1 if dot(step, step) > limit * limit else 0
    return far > 0


@kernel
def remember(buf, n, row0, row1, row2):
    """Store the present positions in three rows."""
    for i in range(n):
        buf[row0 + i], buf[row1 + i], buf[row2 + i] = buf[X0 + i], buf[X1 + i], buf[X2 + i]


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
    half = 0.5 / edge
    return (
        int(math.floor(half * (buf[X0 + i] + buf[X0 + i + 1]))),
        int(math.floor(half * (buf[X1 + i] + buf[X1 + i + 1]))),
        int(math.floor(half * (buf[X2 + i] + buf[X2 + i + 1]))),
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
def build_list(buf, n, contact, heads, following, pairs):
    """Fill `pairs` (2, room) with all that may touch and return their number.

    Nothing is written beyond the room there is; a larger return value says how much is needed.
    `heads` has a power of two entries.
    """
    edge = longest_reach(buf, n, contact.skin)
    fill_grid(buf, n, contact, edge, heads, following)
    count = 0
    for a in range(n):
        if contact.rod[a] >= 0:
            count = list_partners(buf, a, contact, edge, heads, following, pairs, count)
    remember(buf, n, A0, A1, A2)
    buf[G0 : G0 + n] = np.inf  # nobody knows yet which pairs are in play
    return count


@kernel
def list_partners(buf, a, contact, edge, heads, following, pairs, count):
    """Append the partners of element a from its cell and the 26 around it."""
    home = cell_of(buf, a, edge)
    for k in range(27):
        cell = (home[0] + k % 3 - 1, home[1] + (k // 3) % 3 - 1, home[2] + k // 9 - 1)
        b = heads[bucket(cell, heads.size - 1)]
        while b >= 0:
            # Two cells may share a bucket: count an element only in the cell it is in.
            if eligible(contact, a, b) and cell_of(buf, b, edge) == cell:  # noqa: SIM102
                if may_touch(buf, a, b, contact.skin):
                    if count < pairs.shape[1]:
                        pairs[0, count], pairs[1, count] = a, b
                    count += 1
            b = following[b]
    return count


@kernel
def keep_in_play(buf, n, dt, contact):
    """Find the pairs in play anew if a node has moved too far since.

    How far that is follows its speed, so that few pairs are pressed in vain where nearly all is at
    rest but the tips, and the steps it is to last follow from how long it did last.
    """
    play = contact.play
    play[1] += 1.0
    if not roamed_far(buf, n):
        return
    wider = 2.0 if play[1] < OFTEN else (0.5 if play[1] > SELDOM else 1.0)
    play[0] = min(max(wider * play[0], LEAST), MOST)
    play[1] = 0.0
    let_roam(buf, n, play[0] * dt, FINEST * contact.skin, COARSEST * contact.skin)
    sieve(buf, n, contact)
    remember(buf, n, G0, G1, G2)


@kernel
def let_roam(buf, n, time, least, most):
    """Set how far every node may move: as it does in `time`, or nearly as before."""
    for i in range(n):
        v = at(buf, V0, V1, V2, i)
        way = max(time * math.sqrt(dot(v, v)), FORGETS * buf[ROAM + i])
        buf[ROAM + i] = min(max(way, least), most)
    for i in range(1, n - 1):
        own = max(buf[ROAM + i], buf[ROAM + i + 1])
        buf[SWAY + i] = max(own, max(buf[ROAM + i - 1], buf[ROAM + i + 2]))


@kernel
def sieve(buf, n, contact):
    """Put the pairs that may touch before a node has moved too far together to runs."""
    shortest, longest = lengths_now(buf, n)
    listed, runs, slip, work = contact.listed, contact.runs, contact.slip, contact.work
    which, last = 0, -1
    while listed[LENGTH_OF, which] > 0:
        mark_in_play(buf, listed, which, shortest, longest, work)
        a, b, number, length = bounds(listed, which)
        for k in range(length):
            if work[k] > 0.0:
                last = prolong(runs, last, a + k, b + k, number + k)
            elif slip.shape[1] > 0:
                slip[0, number + k] = slip[1, number + k] = slip[2, number + k] = 0.0
        which += 1
    runs[LENGTH_OF, last + 1] = 0


@kernel
def mark_in_play(buf, listed, which, shortest, longest, marks):
    """Set `marks` to 1 for the pairs of a listed run that are in play, to 0 for the others."""
    a, b, _, length = bounds(listed, which)
    for k in range(whole(length)):
        marks[k] = 1.0 if is_in_play(buf, a + k, b + k, shortest, longest) else 0.0


@kernel
def lengths_now(buf, n):
    """Return the lengths of the shortest and of the longest element as they are now [m]."""
    least, most = np.inf, 0.0
    for i in range(n):
        if buf[LENGTH + i] > 0.0:
            step = minus(at(buf, X0, X1, X2, i + 1), at(buf, X0, X1, X2, i))
            square = dot(step, step)
            least, most = min(least, square), max(most, square)
    return math.sqrt(least), math.sqrt(most)


@formula
def is_in_play(buf, a, b, shortest, longest):
    """Tell whether elements a and b may touch before a node has moved too far.

    Meanwhile no node around a or b moves by more than `play`, unit vectors along elements turn by
    up to ``turn * play``, the planes at b's ends with them, and a point in contact with b stays
    within reach + length of either end of b.
    """
    p0, q0 = at(buf, X0, X1, X2, a), at(buf, X0, X1, X2, b)
    reach = buf[RADIUS + a] + buf[RADIUS + b]
    play = max(buf[SWAY + a], buf[SWAY + b])
    turn = 2.0 / max(shortest - play, 1e-300)
    shift = play * turn * (reach + longest + 2.0 * play)  # of a plane for each vector in its normal
    low = 4.0 * play + shift * (1.0 + buf[PREVIOUS + b])
    top = 4.0 * play + shift * (1.0 + buf[NEXT + b + 1])
    start, end = interval(
        minus(p0, q0), minus(at(buf, X0, X1, X2, a + 1), p0),
        minus(at(buf, X0, X1, X2, b + 1), q0),
        at(buf, B0, B1, B2, b), at(buf, B0, B1, B2, b + 1),
        buf[OVERHANG + b] + low, buf[OVERHANG + b + 1] + top,
        reach + buf[SWAY + a] + buf[SWAY + b],
    )  # fmt: skip
    return start < end
