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

SPARE = 4.0  # a wave of 1 to 2 was seen in double helices of 8 elements a pitch


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
def bent(bow, sag):
    """Return the sum of two bulges' sizes."""
    return math.sqrt(dot(bow, bow)) + math.sqrt(dot(sag, sag))


@formula
def reached(low, high, w0, dp, bow, u, sag, reach):
    """Return what of [low, high] may touch another curve, empty or not: all that does and more.

    A curve is nowhere farther from its chord than a quarter of its bulge, and the distance of a
    chord from the other one's line is known exactly.
    """
    far = reach + 0.25 * bent(bow, sag)
    inverse = 1.0 / dot(u, u)
    gap = along(w0, -dot(w0, u) * inverse, u)
    ahead = along(dp, -dot(dp, u) * inverse, u)
    enter, leave = roots(dot(gap, gap) - far * far, dot(gap, ahead), dot(ahead, ahead))
    enter, leave = enter if enter > low else low, leave if leave < high else high
    return enter, (leave if leave > enter else enter)


@formula
def touching(low, high, w0, dp, bow, u, sag, reach):
    """Return what of [low, high] touches another curve, empty or not, and where on that.

    By the parabola through the squared distances at three places, less SPARE times the square of
    what both curves bend over half the interval: the distance of wound strands is a wave within an
    element. The place on the other one next to s is start + rate s, near enough for a `closer`.
    """
    middle, half = 0.5 * (low + high), 0.5 * (high - low)
    first, before = excess(low, w0, dp, bow, u, sag, reach)
    between, _ = excess(middle, w0, dp, bow, u, sag, reach)
    last, after = excess(high, w0, dp, bow, u, sag, reach)
    wave = bent(bow, sag) * half * half
    spare = SPARE * wave * wave
    first, between, last = first - spare, between - spare, last - spare
    start, end = roots(between, 0.25 * (last - first), 0.5 * (first + last) - between)
    start, end = -1.0 if first < 0.0 else start, 1.0 if last < 0.0 else end
    start, end = start if start > -1.0 else -1.0, end if end < 1.0 else 1.0
    rate = (after - before) / (high - low if high > low else 1.0)
    return middle + half * start, middle + half * end, (before - rate * low, rate)


@formula
def excess(s, w0, dp, bow, u, sag, reach):
    """Return by how much the squared distance at s is more than that of touching, and where."""
    w = arc(w0, s, dp, bow)
    t = inside(dot(w, u) / dot(u, u))
    t = closer(w, closer(w, t, u, sag), u, sag)
    gap, _ = gap_at(w, t, u, sag)
    return dot(gap, gap) - reach * reach, t


@formula
def closer(w, t, u, sag):
    """Return a place on a parabola closer to w than t is: a step of Newton's method."""
    gap, there = gap_at(w, t, u, sag)
    return inside(t + dot(gap, there) / firmness(gap, there, u, sag))


@formula
def meeting(w0, dp, bow, u, sag, n0, n1, h0, h1, reach):
    """Return what of a curve another one owns and touches, and where on that, as in `touching`.

    Parameters as in `owned`, and the bulge of the other one and the reach [m].
    """
    low, high = owned(w0, dp, bow, u, n0, n1, h0, h1)
    low, high = reached(low, high, w0, dp, bow, u, sag, reach)
    return touching(low, high, w0, dp, bow, u, sag, reach)


@formula
def roots(offset, slope, square):
    """Return where offset + 2 slope x + square x^2 becomes negative and where positive again.

    The second before the first if it is never negative. If it bends down these are where the second
    of its two negative parts begins and the first one ends. No digits are lost as square -> 0.
    """
    curve = square if abs(square) > 1e-290 else 1e-290
    square_of = slope * slope - curve * offset
    steep = abs(slope) + math.sqrt(square_of if square_of > 0.0 else 0.0) + 1e-300
    far, near = steep / curve, offset / steep
    return (near, far) if slope < 0.0 else (-far, -near)


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
    start, rate = there
    t = closer(w, inside(start + rate * s), u, sag)
    gap, _ = gap_at(w, t, u, sag)
    return gap, t


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
