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

from sim.kernels.compiled import formula, kernel
from sim.kernels.vectors import along, at, dot, minus

# Gauss-Legendre nodes and weights on [0, 1]: exact to degree 5, for a smooth integrand.
GAUSS = (
    (0.5 - math.sqrt(0.15), 5.0 / 18.0),
    (0.5, 8.0 / 18.0),
    (0.5 + math.sqrt(0.15), 5.0 / 18.0),
)

BATCH = 64  # pairs that are pressed together
LANES = 8  # doubles in the widest vector register
STRIDE = BATCH + 8  # of rows in the work space; no power of two, see `sim.kernels.layout`

# Columns of a batch: start of a seen from that of b, vectors along a and b, normals of the planes
# at both ends of b and how far b owns beyond them, reach, line = k l0 ...
OFF0, OFF1, OFF2, DA0, DA1, DA2, DB0, DB1, DB2 = (STRIDE * row for row in range(9))
LOW0, LOW1, LOW2, TOP0, TOP1, TOP2, BELOW, ABOVE = (STRIDE * row for row in range(9, 17))
REACH, LINE = (STRIDE * row for row in range(17, 19))
# ... and what `press` returns, with the spring constant of the whole interval.
PUSH0, PUSH1, PUSH2, BY_S0, BY_S1, BY_S2, BY_T0, BY_T1, BY_T2 = (
    STRIDE * row for row in range(19, 28)
)
TOTAL, SUM_S, SUM_T, SPRING = (STRIDE * row for row in range(28, 32))
WORK = STRIDE * 32


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


@kernel
def press_batch(work, count):
    """Integrate the contact of all columns of a batch."""
    for m in range(count):
        w, dp, u = (
            at(work, OFF0, OFF1, OFF2, m),
            at(work, DA0, DA1, DA2, m),
            at(work, DB0, DB1, DB2, m),
        )
        n0, n1 = at(work, LOW0, LOW1, LOW2, m), at(work, TOP0, TOP1, TOP2, m)
        reach, line = work[REACH + m], work[LINE + m]
        low, high = interval(w, dp, u, n0, n1, work[BELOW + m], work[ABOVE + m], reach)
        touches = low < high
        low, high = low if touches else 0.0, high if touches else 0.0
        force, by_s, by_t, total, sum_s, sum_t = press(
            w, along(w, 1.0, dp), (0.0, 0.0, 0.0), u, low, high, reach, line
        )
        work[PUSH0 + m], work[PUSH1 + m], work[PUSH2 + m] = force
        work[BY_S0 + m], work[BY_S1 + m], work[BY_S2 + m] = by_s
        work[BY_T0 + m], work[BY_T1 + m], work[BY_T2 + m] = by_t
        work[TOTAL + m], work[SUM_S + m], work[SUM_T + m] = total, sum_s, sum_t
        work[SPRING + m] = line * (high - low)
