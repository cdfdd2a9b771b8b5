"""Gauss link of polylines, segment pair by segment pair, exact to rounding."""

import math

from sim.kernels.compiled import kernel
from sim.kernels.vectors import cross, dot, minus


@kernel
def point(curve, i):
    """Return row i of an (n, 3) array as a tuple."""
    return curve[i, 0], curve[i, 1], curve[i, 2]


@kernel
def half_solid_angle(p, q, r):
    """Return half the solid angle of the triangle p q r (van Oosterom & Strackee 1983)."""
    lp, lq, lr = math.sqrt(dot(p, p)), math.sqrt(dot(q, q)), math.sqrt(dot(r, r))
    below = lp * lq * lr + dot(p, q) * lr + dot(q, r) * lp + dot(r, p) * lq
    return math.atan2(dot(p, cross(q, r)), below)


@kernel
def pair_link(a0, a1, b0, b1):
    """Return the Gauss integral of segments a and b, divided by 4 pi (Arai, PTEP 2013, 063A01)."""
    a, b, c, d = minus(a0, b0), minus(a0, b1), minus(a1, b1), minus(a1, b0)
    return (half_solid_angle(a, b, c) + half_solid_angle(c, d, a)) / (2.0 * math.pi)


@kernel
def link_rows(first, second, rows, columns):
    """Add every pair's link to the row of its segment on `first` and the column on `second`."""
    for i in range(first.shape[0] - 1):
        a0, a1 = point(first, i), point(first, i + 1)
        for j in range(second.shape[0] - 1):
            g = pair_link(a0, a1, point(second, j), point(second, j + 1))
            rows[i] += g
            columns[j] += g


@kernel
def writhe_rows(curve, rows):
    """Add every pair's link of a curve with itself to both rows; neighbours contribute zero."""
    for i in range(curve.shape[0] - 1):
        a0, a1 = point(curve, i), point(curve, i + 1)
        for j in range(i + 2, curve.shape[0] - 1):
            g = pair_link(a0, a1, point(curve, j), point(curve, j + 1))
            rows[i] += g
            rows[j] += g


@kernel
def crossing_number(first, second):
    """Return the sum of |link| over all pairs: the crossings seen from a random direction."""
    total = 0.0
    for i in range(first.shape[0] - 1):
        a0, a1 = point(first, i), point(first, i + 1)
        for j in range(second.shape[0] - 1):
            total += abs(pair_link(a0, a1, point(second, j), point(second, j + 1)))
    return total
