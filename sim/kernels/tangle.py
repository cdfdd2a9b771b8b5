"""Link and crossings of every pair of segments of many strands: exact near, a series far away.

The triple product of Gauss's integrand is the same for all points of two straight segments, so the
integrand is that product over |r|^3: its sign never changes, and far away the mean of |r|^-3 over
both segments is its value between their middles and a correction of second order in length/r.
"""

import math

from sim.kernels.compiled import formula, kernel
from sim.kernels.topology import pair_link
from sim.kernels.vectors import cross, dot, minus, point


@kernel
def fill_pairs(
    nodes, starts, middles, edges, lengths, error, link, crossings, on_link, on_crossings
):
    """Fill in the link and the crossings of all pairs of strands, and what segments share of both.

    Parameters
    ----------
    nodes, middles, edges : (m, 3)
        Nodes of all strands; of the segment that begins at a node, its middle and its vector.
    starts : (n + 1,)
        First node of every strand, and m.
    lengths : (m,)
        Of the segments.
    error : float
        Largest relative error of a far pair.
    link, crossings : (n, n)
        Filled above and on the diagonal.
    on_link, on_crossings : (m,)
        Half of every pair's value is added to either segment.
    """
    for a in range(starts.size - 1):
        for b in range(a, starts.size - 1):
            for i in range(starts[a], starts[a + 1] - 1):
                first = i + 2 if a == b else starts[b]  # neighbours in a strand are in one plane
                for j in range(first, starts[b + 1] - 1):
                    one = segment_link(nodes, middles, edges, lengths, error, i, j)
                    link[a, b] += one
                    crossings[a, b] += abs(one)
                    on_link[i] += 0.5 * one
                    on_link[j] += 0.5 * one
                    on_crossings[i] += abs(one)
                    on_crossings[j] += abs(one)
            crossings[a, b] *= 2.0


@formula
def segment_link(nodes, middles, edges, lengths, error, i, j):
    """Return the link of two segments: Gauss's integral over both, divided by 4 pi."""
    r = minus(point(middles, i), point(middles, j))
    square = dot(r, r)
    distance = math.sqrt(square)
    la, lb = lengths[i] * lengths[i], lengths[j] * lengths[j]
    nearest = distance - 0.5 * (lengths[i] + lengths[j])
    # Fourth derivatives of |r|^-3 are at most 360 |r|^-7; (la^2 + lb^2)/80 + la lb/24 is the mean
    # fourth power of how far two points lie off the middles.
    fourth = 15.0 * ((la * la + lb * lb) / 80.0 + la * lb / 24.0)
    if nearest > 0.0 and fourth * distance * square < error * nearest**7:
        a, b = point(edges, i), point(edges, j)
        along_a, along_b = dot(a, r), dot(b, r)
        spread = 15.0 * (along_a * along_a + along_b * along_b) / square - 3.0 * (la + lb)
        triple = dot(cross(a, b), r)
        return triple * (1.0 + spread / (24.0 * square)) / (4.0 * math.pi * distance * square)
    return pair_link(point(nodes, i), point(nodes, i + 1), point(nodes, j), point(nodes, j + 1))
