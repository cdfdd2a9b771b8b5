"""The smooth centreline that contact feels: between its nodes a rod bends on.

A load F in the middle of an element of length l misses the energy F b of the rod's sagitta b there,
to second order in l, and F^2 (l^3 q/B + l p/S)/2 of the bend that the load itself makes and that no
node sees: a washboard of one element (docs/sim.md). So contact acts on the parabolas

    x(s) = x_i + s (x_{i+1} - x_i) + s (1 - s) b,
    b = -l/4 [(1 + A_{i-1}) Z_i + (1 + A_{i+1}) Z_{i+1} - A_{i-1} Z_{i-1} - A_{i+1} Z_{i+2}],

Z the turns of the tangent at nodes, nothing at the ends of a rod. With A = 0 they are right to
second order; A = 16 a adds a times the fourth difference of the nodes on either side, q = -7/128 +
9/4 a + 4 a^2, p = -15/128 + 5/2 a + 10 a^2, and `sim.effects` chooses it by l^3 q/B + l p/S = 0. A
place is linear in six nodes and their weights add up to 1, so the force on it is a force on these
six, the gradient of an energy, and neither momentum nor angular momentum is made.
"""

from sim.kernels.compiled import formula, kernel
from sim.kernels.layout import *  # noqa: F403
from sim.kernels.vectors import along, at, minus, push, put, weighted

NOTHING = (0.0, 0.0, 0.0)
PART = 0.9  # of the bulge that a tine feels


@formula
def turn_at(buf, row0, row1, row2, i):
    """Return the turn of the tangent at node i of what is stored in three rows, if it is inner.

    Next to a shorter element, whose length is taken there, it is less than it should be (KINK); the
    small moves of a short element would be large ones of the long element's middle.
    """
    x = at(buf, row0, row1, row2, i)
    before = minus(x, at(buf, row0, row1, row2, i - 1))
    after = minus(at(buf, row0, row1, row2, i + 1), x)
    left, right = buf[KINK + i] * buf[INV_LENGTH + i - 1], buf[KINK + i] * buf[INV_LENGTH + i]
    return weighted(right, after, -left, before, 0.0, NOTHING)


@formula
def shares(buf, a):
    """Return what the turns at nodes a - 1 to a + 2 count in the bulge of element a [m].

    The first and the last element of a rod bend all along as they do at their inner node.
    """
    size, before, after = 0.25 * buf[LENGTH + a], buf[SHARP + a - 1], buf[SHARP + a + 1]
    left, right = 2.0 + before - buf[NEXT + a + 1], 2.0 + after - buf[PREVIOUS + a]
    return size * before, -size * left, -size * right, size * after


@formula
def bulge(buf, a):
    """Return the bulge of element a from the turns at four nodes [m]."""
    outer, left, right, beyond = shares(buf, a)
    first = weighted(
        outer, at(buf, Z0, Z1, Z2, a - 1), beyond, at(buf, Z0, Z1, Z2, a + 2), 0.0, NOTHING
    )
    return weighted(left, at(buf, Z0, Z1, Z2, a), right, at(buf, Z0, Z1, Z2, a + 1), 1.0, first)


@kernel
def bend_centreline(buf, n):
    """Fill the bulges of all elements and clear the forces on them."""
    for i in range(1, n):
        put(buf, Z0, Z1, Z2, i, turn_at(buf, X0, X1, X2, i))
    for a in range(1, n):
        put(buf, H0, H1, H2, a, bulge(buf, a))
        buf[P0 + a] = buf[P1 + a] = buf[P2 + a] = 0.0


@kernel
def load_nodes(buf, n):
    """Hand the forces on bulges to six nodes each: the transpose of `bend_centreline`."""
    for i in range(2, n):
        far, left = shares(buf, i - 2)[3], shares(buf, i - 1)[2]
        right, beyond = shares(buf, i)[1], shares(buf, i + 1)[0]
        near = weighted(
            left, at(buf, P0, P1, P2, i - 1), right, at(buf, P0, P1, P2, i), 0.0, NOTHING
        )
        outer = weighted(
            far, at(buf, P0, P1, P2, i - 2), beyond, at(buf, P0, P1, P2, i + 1), 1.0, near
        )
        put(buf, Z0, Z1, Z2, i, weighted(buf[KINK + i], outer, 0.0, NOTHING, 0.0, NOTHING))
    for i in range(1, n):
        own, left, right = at(buf, Z0, Z1, Z2, i), buf[INV_LENGTH + i - 1], buf[INV_LENGTH + i]
        push(buf, F0, F1, F2, i, minus(at(buf, Z0, Z1, Z2, i + 1), own), right)
        push(buf, F0, F1, F2, i, minus(own, at(buf, Z0, Z1, Z2, i - 1)), -left)


@kernel
def curve_of(buf, row0, row1, row2, a):
    """Return start, chord and bulge of element a of what is stored in three rows, found anew."""
    start = at(buf, row0, row1, row2, a)
    chord, bow = minus(at(buf, row0, row1, row2, a + 1), start), NOTHING
    for k, share in enumerate(shares(buf, a)):
        if buf[KINK + a - 1 + k] > 0.0:
            bow = along(bow, PART * share, turn_at(buf, row0, row1, row2, a - 1 + k))
    return start, chord, bow


@formula
def place_on(curve, s):
    """Return the place at s."""
    start, chord, bow = curve
    return along(along(start, s, chord), s * (1.0 - s), bow)


@formula
def slope_on(curve, s):
    """Return the derivative of the place at s."""
    _, chord, bow = curve
    return along(chord, 1.0 - 2.0 * s, bow)


@kernel
def load_bulge(buf, a, force):
    """Hand a force on the bulge of element a to its six nodes: the transpose of `curve_of`."""
    for k, share in enumerate(shares(buf, a)):
        i = a - 1 + k
        if buf[KINK + i] > 0.0:
            size = PART * share * buf[KINK + i]
            left, right = size * buf[INV_LENGTH + i - 1], size * buf[INV_LENGTH + i]
            push(buf, F0, F1, F2, i - 1, force, left)
            push(buf, F0, F1, F2, i, force, -left - right)
            push(buf, F0, F1, F2, i + 1, force, right)
