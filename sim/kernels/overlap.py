"""Contact of one smooth centreline with another as an integral along the first.

The potential between strand A and strand B is a line integral over A,

    U = integral 1/2 k (reach - d(s))_+^2 ds,      d(s) = distance from x_A(s) to the curve of B,

so the force varies continuously as one strand slides along another, whatever their angle and
whether they are parallel, and no closest-point problem between two segments is solved. Space
around B is divided among its elements by the planes normal to B at its nodes; every point of A then
has one owner, so nothing counts twice. On the plane the distances to the two elements are equal,
hence U has no jump. Both curves are the parabolas of `sim.kernels.curve`; points beyond an end of B
are in contact with its round cap.

Nothing here branches: the compiler turns the loop over many pairs into vector instructions.
"""

import math

from sim.kernels.compiled import formula
from sim.kernels.layout import *  # noqa: F403
from sim.kernels.vectors import along, at, dot, minus, weighted

# Gauss-Legendre nodes and weights on [0, 1]: exact to degree 5, for a smooth integrand.
GAUSS = (
    (0.5 - math.sqrt(0.15), 5.0 / 18.0),
    (0.5, 8.0 / 18.0),
    (0.5 + math.sqrt(0.15), 5.0 / 18.0),
)


@formula
def clip(low, high, at_0, at_1, bow):
    """Return the part of [low, high] where at_0 + s (at_1 - at_0) + s (1 - s) bow is positive.

    Empty, low >= high, where it is negative at 0 and 1. Both owners at a plane find the same zero.
    """
    slope = at_1 - at_0 + bow
    root = math.sqrt(max(slope * slope + 4.0 * bow * at_0, 0.0))
    steep = slope + (root if at_1 > at_0 else -root)
    zero = inside(-2.0 * at_0 / steep)
    return (
        zero if at_0 < 0.0 and zero > low else low,
        zero if at_1 < 0.0 and zero < high else high,
    )


@formula
def facing(buf, a, b):
    """Return what `meeting` asks of elements a and b."""
    p, q = at(buf, X0, X1, X2, a), at(buf, X0, X1, X2, b)
    return (
        minus(p, q),
        minus(at(buf, X0, X1, X2, a + 1), p),
        at(buf, H0, H1, H2, a),
        minus(at(buf, X0, X1, X2, b + 1), q),
        at(buf, H0, H1, H2, b),
        at(buf, B0, B1, B2, b),
        at(buf, B0, B1, B2, b + 1),
        buf[OVERHANG + b],
        buf[OVERHANG + b + 1],
        buf[RADIUS + a] + buf[RADIUS + b],
    )


@formula
def arc(w, s, u, b):
    """Return w + s u + s (1 - s) b: a place on a parabola with chord u and bulge b from w on."""
    return along(along(w, s, u), s * (1.0 - s), b)


@formula
def inside(t):
    """Return the value of [0, 1] next to t."""
    return 0.0 if t < 0.0 else (1.0 if t > 1.0 else t)


@formula
def gap_at(w, t, u, sag):
    """Return the vector to w from t on a parabola from the origin on, and the slope there."""
    return along(along(w, -t, u), -t * (1.0 - t), sag), along(u, 1.0 - 2.0 * t, sag)


@formula
def firmness(gap, there, u, sag):
    """Return half the second derivative of the squared gap over the place on the parabola.

    A bend as tight as the gap is wide has no nearest place, and a step to it is held short there.
    """
    size, least = dot(there, there) + 2.0 * dot(gap, sag), 0.25 * dot(u, u)
    return size if size > least else least


@formula
def owned(w0, dp, bow, u, n0, n1, h0, h1):
    """Return the part of a curve that another one owns, as [low, high].

    Parameters: start of the curve seen from that of the other one, its chord and bulge, the chord
    of the other one, normals of the planes at its ends, how far it owns beyond them.
    """
    at_0, at_1 = dot(w0, n0) + h0, h1 - dot(minus(w0, u), n1)
    low, high = clip(0.0, 1.0, at_0, at_0 + dot(dp, n0), dot(bow, n0))
    return clip(low, high, at_1, at_1 - dot(dp, n1), -dot(bow, n1))


@formula
def crossing(low, high, guess, w0, dp, u):
    """Return where on [low, high] two lines are closest, near a guess if they are parallel.

    And where on the other one, held within [0, 1].
    """
    inverse, square, both = 1.0 / dot(u, u), dot(dp, dp), dot(dp, u)
    start, skew = dot(w0, u), both * inverse
    across = dot(w0, dp) + guess * square - (start + guess * both) * skew
    s = guess - across / (1.01 * square - both * skew)
    s = s if s > low else low
    s = s if s < high else high
    return s, inside((start + s * both) * inverse)


@formula
def refined(low, high, s, t, w0, dp, bow, u, sag):
    """Return `crossing` of the lines that touch two curves at s and t: a step towards theirs."""
    first, second = along(dp, 1.0 - 2.0 * s, bow), along(u, 1.0 - 2.0 * t, sag)
    start = along(along(w0, s * s, bow), -t * t, sag)  # from line to line, at 0 of both
    return crossing(low, high, s, start, first, second)


@formula
def touching(low, high, s, t, w0, dp, bow, u, sag, reach):
    """Return what of [low, high] touches another curve, empty or not, and where on that.

    s and t are where both are closest. The place on the other one next to s is, to second order,
    t + rate s; the last value is the step to it over the gap's component along the slope there.
    """
    gap, there = gap_at(arc(w0, s, dp, bow), t, u, sag)
    ahead, inverse = along(dp, 1.0 - 2.0 * s, bow), 1.0 / firmness(gap, there, u, sag)
    step, rate = dot(gap, there) * inverse, dot(ahead, there) * inverse
    gap, ahead = along(gap, -step, there), along(ahead, -rate, there)
    bend = along(bow, -rate * rate, sag)
    start, end = within(
        low, high, s, dot(gap, gap) - reach * reach, dot(gap, ahead),
        dot(ahead, ahead) - 2.0 * dot(gap, bend),
    )  # fmt: skip
    return start, (start if low >= high else end), (t + step - rate * s, rate, inverse)


@formula
def meeting(w0, dp, bow, u, sag, n0, n1, h0, h1, reach):
    """Return what of a curve another one owns and touches, as in `touching`.

    Parameters as in `owned`, and the bulge of the other one and the reach [m].
    """
    low, high = owned(w0, dp, bow, u, n0, n1, h0, h1)
    s, t = crossing(low, high, 0.5 * (low + high), w0, dp, u)
    s, t = refined(low, high, s, t, w0, dp, bow, u, sag)
    s, t = refined(low, high, s, t, w0, dp, bow, u, sag)
    return touching(low, high, s, t, w0, dp, bow, u, sag, reach)


@formula
def within(low, high, middle, offset, slope, square):
    """Return the part of [low, high] where a squared distance is less than that of touching.

    With x = s - middle it is offset + 2 slope x + square x^2 more than that.
    """
    least = 1e-8 * abs(square) + 1e-300
    curve = square if square > least else least
    root = slope * slope - curve * offset
    size = math.sqrt(root if root > 0.0 else 0.0)
    inverse = 1.0 / curve
    enter, leave = middle - (slope + size) * inverse, middle + (size - slope) * inverse
    enter, leave = enter if enter > low else low, leave if leave < high else high
    return enter, leave if root > 0.0 else enter


@formula
def press_at(node, weight, w0, dp, bow, u, sag, low, high, there, reach, line):
    """Return the force at a node of the quadrature [N], the places on both curves and its size."""
    s = low + (high - low) * node
    gap, t = gap_next_to(arc(w0, s, dp, bow), s, there, u, sag)
    distance = math.sqrt(dot(gap, gap))
    deep = reach - distance if distance < reach else 0.0
    size = line * (high - low) * weight * deep
    unit = size / (distance + 1e-300)
    return (unit * gap[0], unit * gap[1], unit * gap[2]), s, t, size


@formula
def gap_next_to(w, s, there, u, sag):
    """Return the vector to w, at s of a curve, from the place next to it on a parabola, and that.

    One step of Newton's method from where `meeting` says that it is.
    """
    start, rate, yields = there
    near = inside(start + rate * s)
    gap, slope = gap_at(w, near, u, sag)
    t = inside(near + yields * dot(gap, slope))
    step = t - near
    return along(along(gap, -step, slope), step * step, sag), t


@formula
def press(w0, dp, bow, u, sag, low, high, there, reach, line):
    """Integrate the contact of a curve over [low, high] with another one.

    Parameters as in `meeting`, which finds `low`, `high` and `there`; line = k l0 [N/m].
    Returns the force on the first [N], its first moments over s and t (the places on both) and
    those over s (1 - s) and t (1 - t), the sum of the force's magnitudes and that sum weighted by s
    and by t. Written out, since the compiler vectorises no loop that has another one in it.
    """
    (node, weight), (middle, heavy), (last, _) = GAUSS
    f0, s0, t0, z0 = press_at(node, weight, w0, dp, bow, u, sag, low, high, there, reach, line)
    f1, s1, t1, z1 = press_at(middle, heavy, w0, dp, bow, u, sag, low, high, there, reach, line)
    f2, s2, t2, z2 = press_at(last, weight, w0, dp, bow, u, sag, low, high, there, reach, line)
    return (
        weighted(1.0, f0, 1.0, f1, 1.0, f2),
        weighted(s0, f0, s1, f1, s2, f2),
        weighted(t0, f0, t1, f1, t2, f2),
        weighted(s0 * (1.0 - s0), f0, s1 * (1.0 - s1), f1, s2 * (1.0 - s2), f2),
        weighted(t0 * (1.0 - t0), f0, t1 * (1.0 - t1), f1, t2 * (1.0 - t2), f2),
        z0 + z1 + z2,
        z0 * s0 + z1 * s1 + z2 * s2,
        z0 * t0 + z1 * t1 + z2 * t2,
    )
