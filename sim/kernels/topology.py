"""Gauss link of polylines, segment pair by segment pair, exact to rounding.

`pair_link` is the formula. Sums of it are taken faster without an arc tangent for every pair: the
angles of many pairs add up where complex numbers with these angles are multiplied, and whole turns
are counted where a product passes the negative axis.
"""

import math

import numpy as np

from sim.kernels.compiled import formula, kernel
from sim.kernels.vectors import at, cross, dot, minus, point

WIDTH = 128  # segments of the second curve that are done together
STRIDE = WIDTH + 8

# Nodes of the second curve; seen from them, node i (near) and node i + 1 (far) of the first curve
# and their distances; of every segment of the second curve, the product and its whole turns.
B0, B1, B2 = (STRIDE * row for row in range(3))
NEAR0, NEAR1, NEAR2, NEAR = (STRIDE * row for row in range(3, 7))
FAR0, FAR1, FAR2, FAR = (STRIDE * row for row in range(7, 11))
REAL, IMAGINARY, TURNS = (STRIDE * row for row in range(11, 14))


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
def add_links(first, second, sums):
    """Add to every segment of `second` its link with all of `first`.

    Pairs that share a node add nothing, so a curve's own link, its writhe, may be asked for.
    """
    work = np.zeros(14 * STRIDE)
    for start in range(0, sums.size, WIDTH):
        fill_nodes(work, second, start)
        see_from_nodes(work, point(first, 0))
        for i in range(1, first.shape[0]):
            see_from_nodes(work, point(first, i))
            multiply_links(work)
        for j in range(min(WIDTH, sums.size - start)):
            angle = math.atan2(work[IMAGINARY + j], work[REAL + j])
            sums[start + j] += work[TURNS + j] + angle / (2.0 * math.pi)


@kernel
def fill_nodes(work, curve, start):
    """Fill in the nodes from `start`, the last one again beyond the end, and products of 1."""
    for j in range(WIDTH + 1):
        node = point(curve, min(start + j, curve.shape[0] - 1))
        work[B0 + j], work[B1 + j], work[B2 + j] = node
        work[REAL + j], work[IMAGINARY + j], work[TURNS + j] = 1.0, 0.0, 0.0


@kernel
def see_from_nodes(work, p):
    """Move what was far to near and see the point p from all nodes."""
    for j in range(WIDTH + 1):
        work[NEAR0 + j], work[NEAR1 + j] = work[FAR0 + j], work[FAR1 + j]
        work[NEAR2 + j], work[NEAR + j] = work[FAR2 + j], work[FAR + j]
        view = minus(p, at(work, B0, B1, B2, j))
        work[FAR0 + j], work[FAR1 + j], work[FAR2 + j] = view
        work[FAR + j] = math.sqrt(dot(view, view))


@kernel
def multiply_links(work):
    """Multiply every segment's product by the number of its pair with segment i of the first."""
    for j in range(WIDTH):
        a, b = at(work, NEAR0, NEAR1, NEAR2, j), at(work, NEAR0, NEAR1, NEAR2, j + 1)
        c, d = at(work, FAR0, FAR1, FAR2, j + 1), at(work, FAR0, FAR1, FAR2, j)
        la, lb, lc, ld = work[NEAR + j], work[NEAR + j + 1], work[FAR + j + 1], work[FAR + j]
        x, y = number(a, b, c, la, lb, lc)
        u, v = number(c, d, a, lc, ld, la)
        real, imaginary, turns = product(x, y, u, v)
        # Pairs that share a node have the number 0.
        shared = real == 0.0 and imaginary == 0.0
        real = 1.0 if shared else real
        x, y, more = product(work[REAL + j], work[IMAGINARY + j], real, imaginary)
        lift = 1e100 if x * x + y * y < 1e-150 else 1.0  # keeps a long product from vanishing
        work[REAL + j], work[IMAGINARY + j] = lift * x, lift * y
        work[TURNS + j] += turns + more


@formula
def number(p, q, r, lp, lq, lr):
    """Return a complex number, at most 1 large, with half the solid angle of p q r as its angle."""
    size = lp * lq * lr
    below = size + dot(p, q) * lr + dot(q, r) * lp + dot(r, p) * lq
    scale = 0.25 / (size + 1e-300)
    return scale * below, scale * dot(p, cross(q, r))


@formula
def product(x, y, u, v):
    """Return (x + i y)(u + i v) and the whole turns by which its angle falls short of the sum."""
    real, imaginary = x * u - y * v, x * v + y * u
    turns = 1.0 if y > 0.0 and v > 0.0 and imaginary < 0.0 else 0.0
    turns = -1.0 if y < 0.0 and v < 0.0 and imaginary > 0.0 else turns
    return real, imaginary, turns


@kernel
def crossing_number(first, second):
    """Return the sum of |link| over all pairs: the crossings seen from a random direction."""
    total = 0.0
    for i in range(first.shape[0] - 1):
        a0, a1 = point(first, i), point(first, i + 1)
        for j in range(second.shape[0] - 1):
            total += abs(pair_link(a0, a1, point(second, j), point(second, j + 1)))
    return total


@kernel
def pass_planes(points, normals, curve, guess, found):
    """Fill in where a curve passes each plane, as a fractional index: the place next to the guess.

    Only passages along the normal count; without one, the end of the curve on the near side.
    """
    last = curve.shape[0] - 1
    for i in range(points.shape[0]):
        p, normal = point(points, i), point(normals, i)
        before = dot(minus(point(curve, 0), p), normal)
        found[i], nearest = 0.0 if before > 0.0 else last, np.inf
        for j in range(last):
            after = dot(minus(point(curve, j + 1), p), normal)
            if before <= 0.0 and after > 0.0:
                place = j + before / (before - after)
                if abs(place - guess[i]) < nearest:
                    found[i], nearest = place, abs(place - guess[i])
            before = after
