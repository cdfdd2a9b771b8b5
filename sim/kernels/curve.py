"""The smooth centreline that contact feels: parabolas through the nodes.

A chain of chords lacks what a rod bends between its nodes. To second order in the length l of an
element a load F at s misses the energy F kappa l^2 s (1 - s)/2, which is F times the sagitta of the
curve between its nodes, and so feels a washboard of one element (docs/sim.md). Contact therefore
acts on

    x(s) = x_i + s (x_{i+1} - x_i) + s (1 - s) b,      b = -1/4 l^2 (H_i + H_{i+1}) + y,

with H the second divided difference at a node, nothing at the ends of a rod. The bulge but for y is
linear in four nodes and sees only their differences, so a force on it is a force on these four, and
neither momentum nor angular momentum is made. Tangents of neighbours agree to third order in l.

To third order the load bends the element itself, by F l^3/16 B in its middle, and shears it by
F l/4 S. The flex y is a degree of freedom of its own, with the stiffness 1/(l^3/B + 4 l/S) and a
quarter of the element's mass, which is enough for the time step not to see it; drag and
material damping act on it.
"""

from sim.kernels.compiled import formula, kernel
from sim.kernels.layout import *  # noqa: F403
from sim.kernels.vectors import along, at, minus, push, put, weighted


@kernel
def bend_centreline(buf, n):
    """Fill the bulges of all elements and clear the forces on them."""
    for i in range(1, n):
        before, own, after = vectors_around(buf, i)
        drawn = bulge(buf, i, before, own, after)
        put(buf, H0, H1, H2, i, along(drawn, 1.0, at(buf, Y0, Y1, Y2, i)))
        buf[P0 + i] = buf[P1 + i] = buf[P2 + i] = 0.0


@formula
def vectors_around(buf, a):
    """Return the vectors along the element before a, along a and along the one after it [m]."""
    x0, x1 = at(buf, X0, X1, X2, a), at(buf, X0, X1, X2, a + 1)
    before, after = at(buf, X0, X1, X2, a - 1), at(buf, X0, X1, X2, a + 2)
    return minus(x0, before), minus(x1, x0), minus(after, x1)


@formula
def bulge(buf, a, before, own, after):
    """Return b - y of element a from the vectors along the one before it, itself and the next."""
    return weighted(buf[BEFORE + a], before, buf[OWN + a], own, buf[AFTER + a], after)


@formula
def skewness(buf, a):
    """Return k of an element: s (1 - s)(1 - 2 s) k makes of its parabola the cubic of linear H.

    k = -1/12 l^2 (H_i - H_{i+1}): a load feels no washboard then either where there is shear.
    """
    before, own, after = vectors_around(buf, a)
    return weighted(
        buf[BEFORE + a] / 3.0, before, skew_share(buf, a), own, -buf[AFTER + a] / 3.0, after
    )


@formula
def skew_share(buf, a):
    """Return what the vector along element a itself is multiplied by in its skewness."""
    before = buf[BEFORE + a] * buf[LENGTH + a - 1] if buf[BEFORE + a] != 0.0 else 0.0
    after = buf[AFTER + a] * buf[LENGTH + a + 1] if buf[AFTER + a] != 0.0 else 0.0
    return (after - before) * buf[INV_LENGTH + a] / 3.0


@formula
def load_skewness(buf, a, force):
    """Add a force on the skewness of element a to its four nodes."""
    before, after, own = buf[BEFORE + a] / 3.0, buf[AFTER + a] / 3.0, skew_share(buf, a)
    push(buf, F0, F1, F2, a - 1, force, -before)
    push(buf, F0, F1, F2, a, force, before - own)
    push(buf, F0, F1, F2, a + 1, force, own + after)
    push(buf, F0, F1, F2, a + 2, force, -after)


@kernel
def load_nodes(buf, n):
    """Hand the forces on bulges to the nodes, each to its four."""
    for i in range(1, n):
        first, last = buf[AFTER + i - 2], buf[BEFORE + i + 1]
        left, right = buf[OWN + i - 1] - buf[AFTER + i - 1], buf[BEFORE + i] - buf[OWN + i]
        for axis in range(3):
            p, f = P0 + axis * PITCH + i, F0 + axis * PITCH + i
            buf[f] += first * buf[p - 2] + left * buf[p - 1] + right * buf[p] - last * buf[p + 1]


@formula
def bulge_velocity(buf, a):
    """Return db/dt of element a [m/s]."""
    v0, v1 = at(buf, V0, V1, V2, a), at(buf, V0, V1, V2, a + 1)
    before = minus(v0, at(buf, V0, V1, V2, a - 1))
    drawn = bulge(buf, a, before, minus(v1, v0), minus(at(buf, V0, V1, V2, a + 2), v1))
    return along(drawn, 1.0, at(buf, U0, U1, U2, a))


@kernel
def drift_flex(buf, n, dt):
    """Change the flex of all elements by its velocity."""
    for i in range(n):
        push(buf, Y0, Y1, Y2, i, at(buf, U0, U1, U2, i), dt)


@kernel
def kick_flex(buf, n, dt, keep, viscous):
    """Change the velocities of all flex by the force on it and its spring; keep < 1 is drag."""
    for i in range(n):
        u = at(buf, U0, U1, U2, i)
        strain = at(buf, Y0, Y1, Y2, i)
        if viscous is not None:
            strain = along(strain, viscous, u)
        force = along(at(buf, P0, P1, P2, i), -buf[FIRM + i], strain)
        u = along(u, dt * buf[INV_FLEX + i], force)
        if keep is not None:
            u = (keep * u[0], keep * u[1], keep * u[2])
        put(buf, U0, U1, U2, i, u)


@kernel
def wedges(buf, n):
    """Fill the normals of the planes at the nodes that divide space among elements.

    Each is normal to the mean of the tangents on either side.
    """
    for i in range(1, n):
        x = buf[PREVIOUS + i] * buf[INV_LENGTH + i - 1]
        y = buf[NEXT + i] * buf[INV_LENGTH + i]
        for axis in range(3):
            p, h = X0 + axis * PITCH + i, H0 + axis * PITCH + i
            end = buf[p] - buf[p - 1] - buf[h - 1]
            start = buf[p + 1] - buf[p] + buf[h]
            buf[B0 + axis * PITCH + i] = x * end + y * start
