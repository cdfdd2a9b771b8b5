"""Contact of a segment with a polyline as an integral along the segment.

The potential between strand A and strand B is a line integral over A,

    U = integral 1/2 k (reach - d(s))_+^2 ds,      d(s) = distance from x_A(s) to polyline B,

so the force varies continuously as one strand slides along another, whatever their angle and
whether they are parallel, and no closest-point problem between two segments is solved. Space
around B is divided among its elements by the planes that bisect the angle at each node; every
point of A then has one owner, so nothing counts twice. On the plane the distances to the two
elements are equal, hence U has no jump.

Nothing here branches: the compiler turns the loop over many pairs into vector instructions.
"""

import math

from sim.kernels.compiled import formula
from sim.kernels.vectors import along, dot, minus

# Gauss-Legendre nodes and weights on [0, 1]: exact to degree 5, for a smooth integrand.
GAUSS = (
    (0.5 - math.sqrt(0.15), 5.0 / 18.0),
    (0.5, 8.0 / 18.0),
    (0.5 + math.sqrt(0.15), 5.0 / 18.0),
)


@formula
def clip(low, high, at_0, at_1):
    """Return the part of [low, high] where the linear function from at_0 to at_1 is positive.

    Empty, low >= high, where it is negative all along: its zero then lies outside [0, 1].
    """
    zero = at_0 / (at_0 - at_1)
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
def interval(w0, dp, u, n0, n1, h0, h1, reach):
    """Return the part of a segment that another one owns and that may touch it, as [low, high].

    Parameters: start of the segment seen from that of the other one, vectors along both, normals of
    the planes at both ends of the other one, how far it owns beyond them, reach [m].
    """
    at_0, at_1 = dot(w0, n0) + h0, h1 - dot(minus(w0, u), n1)
    low, high = clip(0.0, 1.0, at_0, at_0 + dot(dp, n0))
    low, high = clip(low, high, at_1, at_1 - dot(dp, n1))
    return near_line(low, high, w0, along(w0, 1.0, dp), u, reach)


@formula
def press(p0, p1, q0, q1, low, high, reach, line):
    """Integrate the contact of segment p over [low, high] with segment q.

    Parameters: ends of both segments [m], interval of s on p, reach [m], and line = k l0 [N/m].
    Returns the force on p [N], its first moments over s and t (the positions on p and q), the sum
    of the force's magnitudes and that sum weighted by s and by t.
    """
    w0, dp, u = minus(p0, q0), minus(p1, p0), minus(q1, q0)
    inverse = 1.0 / (dot(u, u) + 1e-300)
    t_start, t_step = dot(w0, u) * inverse, dot(dp, u) * inverse
    force = first_s = first_t = (0.0, 0.0, 0.0)
    total = sum_s = sum_t = 0.0
    for node, weight in GAUSS:
        s = low + (high - low) * node
        w = along(w0, s, dp)
        t = t_start + s * t_step
        t = 0.0 if t < 0.0 else (1.0 if t > 1.0 else t)
        gap = along(w, -t, u)
        distance = math.sqrt(dot(gap, gap))
        deep = reach - distance if distance < reach else 0.0
        size = line * (high - low) * weight * deep
        unit = size / (distance + 1e-300)
        force = along(force, unit, gap)
        first_s = along(first_s, unit * s, gap)
        first_t = along(first_t, unit * t, gap)
        total += size
        sum_s += size * s
        sum_t += size * t
    return force, first_s, first_t, total, sum_s, sum_t
