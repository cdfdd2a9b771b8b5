"""Strands about to pass through each other: which listed pairs have all but given way.

The march calls for a look after every step in which `contact.GIVES_WAY` is passed.
"""

import math

from sim.kernels.compiled import formula, kernel
from sim.kernels.contact import contact_interval, wedges
from sim.kernels.layout import *  # noqa: F403
from sim.kernels.overlap import press
from sim.kernels.vectors import along, at, dot, minus


@formula
def within(x):
    """Return the value of [0, 1] next to x."""
    return 0.0 if x < 0.0 else (1.0 if x > 1.0 else x)


@formula
def nearest_points(w, dp, u):
    """Return s and t where the segments w + s dp and t u are closest."""
    a, b, e = dot(dp, dp), dot(dp, u), dot(u, u)
    c, f = dot(dp, w), dot(u, w)
    det = a * e - b * b
    s = within((b * f - c * e) / det) if det > 1e-12 * a * e else 0.0
    t = (b * s + f) / e
    if t < 0.0:
        return within(-c / a), 0.0
    if t > 1.0:
        return within((b - c) / a), 1.0
    return s, t


@kernel
def nearness(buf, a, b, contact):
    """Return the squared distance of elements a and b over that of touching, infinite if far.

    Also where two elements of one rod have too little of it between them to be in contact.
    """
    p0, q0 = at(buf, X0, X1, X2, a), at(buf, X0, X1, X2, b)
    dp, u = minus(at(buf, X0, X1, X2, a + 1), p0), minus(at(buf, X0, X1, X2, b + 1), q0)
    w, reach = minus(p0, q0), buf[RADIUS + a] + buf[RADIUS + b]
    if dot(w, w) > 3.0 * (dot(dp, dp) + dot(u, u) + reach * reach):
        return math.inf  # farther apart than both are long
    s, t = nearest_points(w, dp, u)
    between = contact.arc[b] + t * buf[LENGTH + b] - contact.arc[a] - s * buf[LENGTH + a]
    if contact.rod[a] == contact.rod[b] and between < contact.self_gap:
        return math.inf
    gap = along(along(w, s, dp), -t, u)
    return dot(gap, gap) / (reach * reach)


@kernel
def note(found, count, a, b):
    """Put a pair behind `count` others if there is room, and return how many there are then."""
    if count < found.shape[0]:
        found[count, 0], found[count, 1] = a, b
    return count + 1


@kernel
def near_pairs(buf, n, contact, limit, found):
    """Fill `found` (m, 2) with listed pairs nearer than `limit` of touching; return how many."""
    count = 0
    for k in range(contact.pairs.shape[1]):
        a, b = contact.pairs[0, k], contact.pairs[1, k]
        if nearness(buf, a, b, contact) < limit * limit:
            count = note(found, count, a, b)
    return count


@kernel
def haste(buf, contact, moved, depth, slide):
    """Return by how much listed pairs would move too far if nodes moved so, (n, 3) [m].

    The nearest points of a pair may come nearer until they are `depth` of the contact distance
    apart, or by a tenth of it, and move against each other by `slide` times it.
    """
    worst = 0.0
    for k in range(contact.pairs.shape[1]):
        a, b = contact.pairs[0, k], contact.pairs[1, k]
        p0, q0 = at(buf, X0, X1, X2, a), at(buf, X0, X1, X2, b)
        dp, u = minus(at(buf, X0, X1, X2, a + 1), p0), minus(at(buf, X0, X1, X2, b + 1), q0)
        s, t = nearest_points(minus(p0, q0), dp, u)
        gap = along(along(minus(p0, q0), s, dp), -t, u)
        of_a, of_b = between_nodes(moved, a, s), between_nodes(moved, b, t)
        step, reach = minus(of_a, of_b), buf[RADIUS + a] + buf[RADIUS + b]
        distance = math.sqrt(dot(gap, gap)) + 1e-300
        nearer = -dot(step, gap) / distance
        worst = max(worst, nearer / max(distance - depth * reach, 0.1 * reach))
        worst = max(worst, math.sqrt(dot(step, step)) / (slide * reach))
    return worst


@formula
def between_nodes(values, i, s):
    """Return what (n, 3) values are at s of element i."""
    here, there = values[i], values[i + 1]
    return along((here[0], here[1], here[2]), s, (
        there[0] - here[0], there[1] - here[1], there[2] - here[2]
    ))  # fmt: skip


@kernel
def tightness(buf, a, b, contact):
    """Return the distance of elements a and b of one rod over that which a turn round r leaves.

    A rod cannot be bent more tightly than round its own radius; points 2 r phi apart along it are
    then 2 r sin(phi) apart. Contact does not see to that, beginning half a turn away.
    """
    p0, q0 = at(buf, X0, X1, X2, a), at(buf, X0, X1, X2, b)
    dp, u = minus(at(buf, X0, X1, X2, a + 1), p0), minus(at(buf, X0, X1, X2, b + 1), q0)
    w, reach = minus(p0, q0), 2.0 * buf[RADIUS + a]
    s, t = nearest_points(w, dp, u)
    gap = along(along(w, s, dp), -t, u)
    between = contact.arc[b] + t * buf[LENGTH + b] - contact.arc[a] - s * buf[LENGTH + a]
    return math.sqrt(dot(gap, gap)) / (reach * math.sin(min(between / reach, 0.5 * math.pi)))


@kernel
def tight_bends(buf, n, contact, limit, found):
    """Fill `found` (m, 2) with pairs of one rod too near along it for contact, whose tightness is
    below `limit`; return their number.
    """
    count = 0
    for a in range(n):
        b = a + 2
        while contact.rod[a] >= 0 and is_within(contact, a, b, n):
            if tightness(buf, a, b, contact) < limit:
                count = note(found, count, a, b)
            b += 1
    return count


@kernel
def is_within(contact, a, b, n):
    """Tell whether element b is on the rod of a and too near along it for contact."""
    if b >= n or contact.rod[b] != contact.rod[a]:
        return False
    return contact.arc[b] - contact.arc[a] <= contact.self_gap


@kernel
def load_around(buf, n, contact, a, b, arc):
    """Return the force between the rods of a and b within a length `arc` of both [N]."""
    wedges(buf, n)
    total = (0.0, 0.0, 0.0)
    for k in range(contact.pairs.shape[1]):
        i, j = contact.pairs[0, k], contact.pairs[1, k]
        same = contact.rod[i] == contact.rod[a] and contact.rod[j] == contact.rod[b]
        off = max(abs(contact.arc[i] - contact.arc[a]), abs(contact.arc[j] - contact.arc[b]))
        reach = buf[RADIUS + i] + buf[RADIUS + j]
        if same and off < arc + reach:
            low, high = contact_interval(buf, i, j, reach)
            if low < high:
                force, _, _, _, _, _ = press(
                    at(buf, X0, X1, X2, i), at(buf, X0, X1, X2, i + 1),
                    at(buf, X0, X1, X2, j), at(buf, X0, X1, X2, j + 1),
                    low, high, reach, contact.stiffness * buf[LENGTH + i],
                )  # fmt: skip
                total = along(total, 1.0, force)
    return math.sqrt(dot(total, total))
