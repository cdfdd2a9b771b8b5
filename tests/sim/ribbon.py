"""The ribbon between two strands, for tests of Lk = Tw + Wr."""

import numpy as np

from sim import gauss_link, link_density, twist, writhe
from sim.topology import extended, net_axis, partners

PIECES = 300  # straight pieces as long as an element: strands whose tips lie apart find partners


def lengthened(strand, axis, step):
    more = step * np.arange(1, PIECES + 1)[:, None] * axis
    return np.vstack([strand[0] - more[::-1], strand, strand[-1] + more])


def link_twist_writhe(first, second):
    """Return Lk of two strands, and Tw and Wr of the ribbon from the first to the second.

    Both are prolonged in parallel along their net axis; the ribbon joins each node to the place of
    the second strand in the plane normal to the pair's axis.
    """
    axis = net_axis(first, second)
    step = float(np.linalg.norm(np.diff(first, axis=0), axis=1).mean())
    turns = abs(link_density(first, second).attrs["total_link"])
    first, second = (lengthened(strand, axis, step) for strand in (first, second))
    partner, index = partners(first, second, turns), np.arange(len(second))
    across = np.column_stack([np.interp(partner, index, second[:, k]) for k in range(3)]) - first
    across = np.vstack([across[:1], across, across[-1:]])
    first, second = (extended(strand, axis, 1e5 * step) for strand in (first, second))
    return gauss_link(first, second), twist(first, across), writhe(first)
