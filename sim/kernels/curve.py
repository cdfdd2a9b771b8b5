"""The smooth centreline that contact feels: between its nodes a rod bends on.

To second order in the length l of an element, a load F at the place s of a chord misses the energy
F h s (1 - s)/2 of the sagitta l^2 h/8 that the rod has there, and feels a washboard of one element
(docs/sim.md). Here the curvature is linear between nodes,

    x(s) = x_i + s (x_{i+1} - x_i) - l^2/6 s (1 - s) [(2 - s) H_i + (1 + s) H_{i+1}],

H nine tenths of the second divided difference at a node, nothing at the ends of a rod. A place is
linear in four nodes and their weights add up to 1, so the force on it is a force on these four, the
gradient of an energy, and neither momentum nor angular momentum is made.
"""

from sim.kernels.compiled import formula, kernel
from sim.kernels.layout import *  # noqa: F403
from sim.kernels.vectors import along, at, minus, push

# Of the bend that a rod has. With all of it a stiff strand on a tine is held by the middles of its
# elements; every second node swings free of that, and friction feeds the swing: the capstan of
# 0.3 E was 18 % low, 0.8 % with 0.97. So the nodes bear first; a tenth of the washboard is left.
SHARE = 0.9


@formula
def bend_share(buf, i):
    """Return what multiplies the difference of the unit tangents at node i in its bend, l^2 H/l.

    Next to a shorter element, whose length is taken there, a bend is less than it should be; the
    small moves of a short element would be large ones of the long element's middle.
    """
    left, right = buf[LENGTH + i - 1], buf[LENGTH + i]
    inner = buf[PREVIOUS + i] * buf[NEXT + i]
    return inner * 2.0 * SHARE * min(left, right) / (left + right) if inner > 0.0 else 0.0


@formula
def bend_at(buf, row0, row1, row2, i, share):
    """Return the bend at node i of what is stored in three rows, positions or velocities."""
    x = at(buf, row0, row1, row2, i)
    before = minus(x, at(buf, row0, row1, row2, i - 1))
    after = minus(at(buf, row0, row1, row2, i + 1), x)
    left, right = share * buf[INV_LENGTH + i - 1], share * buf[INV_LENGTH + i]
    return (
        right * after[0] - left * before[0],
        right * after[1] - left * before[1],
        right * after[2] - left * before[2],
    )


@formula
def curve_of(buf, row0, row1, row2, a):
    """Return start, chord and the bends at both ends, times l/6, of element a."""
    start, sixth = at(buf, row0, row1, row2, a), buf[LENGTH + a] / 6.0
    chord = minus(at(buf, row0, row1, row2, a + 1), start)
    first = bend_at(buf, row0, row1, row2, a, sixth * bend_share(buf, a))
    last = bend_at(buf, row0, row1, row2, a + 1, sixth * bend_share(buf, a + 1))
    return start, chord, first, last


@formula
def place_on(curve, s):
    """Return the place at s."""
    start, chord, first, last = curve
    off = -s * (1.0 - s)
    return along(along(along(start, s, chord), off * (2.0 - s), first), off * (1.0 + s), last)


@formula
def slope_on(curve, s):
    """Return the derivative of the place at s."""
    _, chord, first, last = curve
    return along(along(chord, s * (6.0 - 3.0 * s) - 2.0, first), 3.0 * s * s - 1.0, last)


@kernel
def load_bend(buf, a, i, force):
    """Add a force on the bend at node i, as the curve of element a has it, to its three nodes."""
    share = buf[LENGTH + a] / 6.0 * bend_share(buf, i)
    left, right = share * buf[INV_LENGTH + i - 1], share * buf[INV_LENGTH + i]
    push(buf, F0, F1, F2, i - 1, force, left)
    push(buf, F0, F1, F2, i, force, -left - right)
    push(buf, F0, F1, F2, i + 1, force, right)
