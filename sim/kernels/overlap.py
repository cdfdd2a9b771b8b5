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
from sim.kernels.vectors import along, dot, minus, weighted

# Gauss-Legendre nodes and weights on [0, 1]: exact to degree 5, for a smooth integrand.
GAUSS = (
    (0.5 - math.sqrt(0.15), 5.0 / 18.0),
    (0.5, 8.0 / 18.0),
    (0.5 + math.sqrt(0.15), 5.0 / 18.0),
)


@formula
def clip(low, high, at_0, at_1, bow):
    """Return the part of [low, high] where at_0 + s (at_1 - at_0) + s (1 - s) bow is positive.

    Empty, low >= high, where it is negative at 0 and 1. Its zero is that of the chord, mended by a
    step of Newton's method: both owners at a plane find the same one, which matters more than its
    last digits.
    """
    step = at_1 - at_0
    chord = -at_0 / step
    better = chord - chord * (1.0 - chord) * bow / (step + (1.0 - 2.0 * chord) * bow)
    zero = better if 0.0 < chord < 1.0 else chord
    zero = 0.0 if zero < 0.0 else (1.0 if zero > 1.0 else zero)
    return (
        zero if at_0 < 0.0 and zero > low else low,
        zero if at_1 < 0.0 and zero < high else high,
    )


@formula
def near_line(low, high, w0, w1, u, reach):
    """Return the part of [low, high] where the point w0 + s (w1 - w0) is within reach of line u."""
    dp, inverse = minus(w1, w0), 1.0 / (dot(u, u) + 1e-300)
    a = along(w0, -dot(w0, u) * inverse, u)
    c = along(dp, -dot(dp, u) * inverse, u)
    square, middle, offset = dot(c, c), dot(a, c), dot(a, a) - reach * reach
    root = middle * middle - square * offset
    # No crossing of the cylinder's surface: parallel inside it, or outside all along.
    parallel = root <= 0.0 or square <= 1e-16 * dot(u, u)
    size = math.sqrt(root if root > 0.0 else 0.0)
    slope = 1.0 / square
    enter = low if parallel else (-middle - size) * slope
    leave = (high if offset < 0.0 else low) if parallel else (size - middle) * slope
    return enter if enter > low else low, leave if leave < high else high


@formula
def chord_interval(w0, dp, u, n0, n1, h0, h1, reach):
    """Return the part of a chord that another one owns and that may touch it, as [low, high].

    Parameters: start of the chord seen from that of the other one, vectors along both, normals of
    the planes at both ends of the other one, how far it owns beyond them, reach [m].
    """
    at_0, at_1 = dot(w0, n0) + h0, h1 - dot(minus(w0, u), n1)
    low, high = clip(0.0, 1.0, at_0, at_0 + dot(dp, n0), 0.0)
    low, high = clip(low, high, at_1, at_1 - dot(dp, n1), 0.0)
    return near_line(low, high, w0, along(w0, 1.0, dp), u, reach)


@formula
def arc(w, s, u, b):
    """Return w + s u + s (1 - s) b: a place on a parabola with chord u and bulge b from w on."""
    return along(along(w, s, u), s * (1.0 - s), b)


@formula
def foot(w, t, u, b):
    """Return a better t than the one given of the place next to w on a parabola from the origin on.

    One step of Newton's method; a bend as tight as w is far has no such place, and the step is held
    short there.
    """
    slope = 1.0 - 2.0 * t
    gap = minus(w, arc((0.0, 0.0, 0.0), t, u, b))
    square, across = dot(u, u), dot(gap, b)
    size = square + 2.0 * across + slope * (2.0 * dot(u, b) + slope * dot(b, b))
    size = size if size > 0.25 * square else 0.25 * square
    return t + (dot(gap, u) + slope * across) / size


@formula
def owned(w0, dp, bow, u, n0, n1):
    """Return the part of a curve that another one owns, as [low, high].

    Parameters: start of the curve seen from that of the other one, its chord and bulge, the chord
    of the other one, normals of the planes at its ends.
    """
    at_0, at_1 = dot(w0, n0), -dot(minus(w0, u), n1)
    low, high = clip(0.0, 1.0, at_0, at_0 + dot(dp, n0), dot(bow, n0))
    return clip(low, high, at_1, at_1 - dot(dp, n1), -dot(bow, n1))


@formula
def crossing(low, high, w0, dp, u):
    """Return the place of [low, high] where two chords are closest; the middle of parallel ones."""
    middle, inverse = 0.5 * (low + high), 1.0 / dot(u, u)
    w = along(w0, middle, dp)
    c = along(dp, -dot(dp, u) * inverse, u)
    s = middle - dot(w, c) / (dot(c, c) + 0.01 * dot(dp, dp))
    s = s if s > low else low
    return s if s < high else high


@formula
def meeting(w0, dp, bow, u, sag, n0, n1, reach):
    """Return what of a curve touches another one, as [low, high], empty or not, and where on it.

    The place on the other one next to s is, to second order, t + rate s. Parameters as in `owned`,
    and the bulge of the other one and the reach [m].
    """
    low, high = owned(w0, dp, bow, u, n0, n1)
    empty = low >= high
    s = crossing(low, high, w0, dp, u)
    w = arc(w0, s, dp, bow)
    t = dot(w, u) / dot(u, u)
    t = foot(w, 0.0 if t < 0.0 else (1.0 if t > 1.0 else t), u, sag)
    gap = minus(w, arc((0.0, 0.0, 0.0), t, u, sag))
    ahead, there = along(dp, 1.0 - 2.0 * s, bow), along(u, 1.0 - 2.0 * t, sag)
    size, least = dot(there, there) + 2.0 * dot(gap, sag), 0.25 * dot(u, u)
    rate = dot(ahead, there) / (size if size > least else least)
    along_it, bend = along(ahead, -rate, there), along(bow, -rate * rate, sag)
    low, high = within(
        low, high, s, dot(gap, gap) - reach * reach, dot(gap, along_it),
        dot(along_it, along_it) - 2.0 * dot(gap, bend), dot(along_it, bend), dot(bend, bend),
    )  # fmt: skip
    return low, (low if empty else high), t - rate * s, rate


@formula
def within(low, high, middle, offset, slope, square, skew, curl):
    """Return the part of [low, high] where a squared distance is less than that of touching.

    With x = s - middle it is offset + 2 slope x + square x^2 - 2 skew x^3 + curl x^4 more than
    that: the zeros without the last two terms, then a step of Newton's method with them.
    """
    least = 1e-8 * (abs(square) + curl) + 1e-300
    curve = square if square > least else least
    root = slope * slope - curve * offset
    size = math.sqrt(root if root > 0.0 else 0.0)
    inverse = 1.0 / curve
    first, last = low - middle, high - middle
    enter, leave = (-slope - size) * inverse, (size - slope) * inverse
    enter, leave = enter if enter > first else first, leave if leave < last else last
    enter = enter + outside(enter, offset, slope, square, skew, curl)
    leave = leave - outside(leave, offset, slope, square, skew, curl)
    enter, leave = enter if enter > first else first, leave if leave < last else last
    return middle + enter, middle + (leave if root > 0.0 else enter)


@formula
def outside(x, offset, slope, square, skew, curl):
    """Return how far x is outside of touching (`within`), below 0 inside: a step of Newton's."""
    value = offset + x * (2.0 * slope + x * (square + x * (x * curl - 2.0 * skew)))
    rate = 2.0 * slope + x * (2.0 * square + x * (4.0 * curl * x - 6.0 * skew))
    return value / (abs(rate) + 1e-300)


@formula
def cap_interval(w0, dp, bow, normal, reach):
    """Return the part of a curve that touches the round cap of another one, as [low, high].

    Parameters: start of the curve seen from the end of the other one, its chord and bulge, normal
    out of that end, reach [m].
    """
    at_0 = dot(w0, normal)
    low, high = clip(0.0, 1.0, at_0, at_0 + dot(dp, normal), dot(bow, normal))
    s = -dot(w0, dp) / dot(dp, dp)
    s = s if s > low else low
    s = s if s < high else high
    w, ahead = arc(w0, s, dp, bow), along(dp, 1.0 - 2.0 * s, bow)
    start, end = within(
        low, high, s, dot(w, w) - reach * reach, dot(w, ahead),
        dot(ahead, ahead) - 2.0 * dot(w, bow), dot(ahead, bow), dot(bow, bow),
    )  # fmt: skip
    return start, (start if low >= high else end)


@formula
def press_at(node, weight, w0, dp, bow, u, sag, low, high, start, rate, reach, line):
    """Return the force at a node of the quadrature [N], the places on both curves and its size."""
    s = low + (high - low) * node
    w = arc(w0, s, dp, bow)
    t = foot(w, start + rate * s, u, sag)
    gap = minus(w, arc((0.0, 0.0, 0.0), t, u, sag))
    distance = math.sqrt(dot(gap, gap))
    deep = reach - distance if distance < reach else 0.0
    size = line * (high - low) * weight * deep
    unit = size / (distance + 1e-300)
    return (unit * gap[0], unit * gap[1], unit * gap[2]), s, t, size


@formula
def press(w0, dp, bow, u, sag, low, high, start, rate, reach, line):
    """Integrate the contact of a curve over [low, high] with another one.

    Parameters as in `meeting`, which finds `low`, `high`, `start` and `rate`; line = k l0 [N/m].
    Returns the force on the first [N], its first moments over s and t (the places on both) and
    those over s (1 - s) and t (1 - t), the sum of the force's magnitudes and that sum weighted by s
    and by t. Written out, since the compiler vectorises no loop that has another one in it.
    """
    (node, weight), (middle, heavy), (last, _) = GAUSS
    f0, s0, t0, z0 = press_at(
        node, weight, w0, dp, bow, u, sag, low, high, start, rate, reach, line
    )
    f1, s1, t1, z1 = press_at(
        middle, heavy, w0, dp, bow, u, sag, low, high, start, rate, reach, line
    )
    f2, s2, t2, z2 = press_at(
        last, weight, w0, dp, bow, u, sag, low, high, start, rate, reach, line
    )
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
