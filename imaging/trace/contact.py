"""Where a strand runs under or beside others: its place from what its colours leave unexplained.

At each point of a rough centreline the picture's colours along the normal are taken apart into
ground, this strand and the best of the strands beside it. A place for the strand is the worse

- the more ground is seen where the strand would be (nothing hides it there), and
- the more of its colour is seen where it would not be.

Other strands may hide it at no cost, so that one that disappears under another is kept inside the
silhouette, and a sliver narrower than a pixel tells on which side it comes out.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from scipy import ndimage
from scipy.spatial import cKDTree

from imaging.trace.centreline import arclength, normals, sample

SEARCH = 1.2  # strand widths to either side in which a strand may be
SIGHT = 1.8  # strand widths to either side that are looked at
STEP = 0.1  # strand widths between samples along a normal
TOLERANCE = 0.04  # strand widths of colour unexplained that make no difference between two places
ALONG = 0.5  # strand widths along the strand over which evidence is gathered
LAZY = 1e-3  # of a strand width for each it has to move: of equal places the nearest
ALIKE = 0.25  # of its own contrast; a strand whose colour differs by less cannot be told apart
FAINT = 0.2  # share of a colour that shading may feign
UNIT = 0.045  # strand widths; the sd that counts as 1 beside the strand's own edges


class Known(NamedTuple):
    """A strand as known so far: points, normals (n, 2), colour (n, 3) and width (n,) along it."""

    points: cKDTree
    normal: np.ndarray
    colour: np.ndarray
    width: np.ndarray


class Sight(NamedTuple):
    """What is looked at: lines across a strand, `distance` (m,) along `normal` from `middle`."""

    middle: np.ndarray
    normal: np.ndarray
    distance: np.ndarray

    @property
    def points(self) -> np.ndarray:
        """Points (n, m, 2) of all lines."""
        return self.middle[:, None] + self.distance[None, :, None] * self.normal[:, None]


def known(line: np.ndarray, width: np.ndarray, edges: np.ndarray, picture: np.ndarray) -> Known:
    """Learn the colour along a strand from where both its edges are seen.

    Parameters
    ----------
    line : (n, 2) array
    width : (n,) array
    edges : (n,) array
        How many of the two edges are seen.
    picture : (h, w, 3) float32 array
        Colours above the ground.
    """
    at = np.flatnonzero(edges == 2)
    if len(at) == 0:
        at = np.arange(len(line))
    spacing = arclength(line)[-1] / (len(line) - 1)
    at = at[:: max(1, int(width[0] / (2 * spacing)))]
    across = np.array([-0.2, 0, 0.2]) * width[at, None]
    colour = sample(picture, line[at, None] + across[..., None] * normals(line)[at, None])
    seen = ndimage.median_filter(np.median(colour, axis=1), size=(min(21, len(at)), 1))
    even = np.arange(len(line))
    along = np.stack([np.interp(even, at, seen[:, i]) for i in range(3)], axis=1)
    return Known(cKDTree(line), normals(line), along.astype(np.float32), width)


def moved(strand: Known, line: np.ndarray) -> Known:
    """Return what is known of a strand, along another line of as many points."""
    return strand._replace(points=cKDTree(line), normal=normals(line))


def place(
    line: np.ndarray,
    unsure: np.ndarray,
    own: Known,
    others: Sequence[Known],
    picture: np.ndarray,
) -> tuple[np.ndarray, np.ndarray]:
    """Find how far the strand is from a rough centreline, and how well that is known.

    Parameters
    ----------
    line : (n, 2) array
        Evenly spaced points.
    unsure : (n,) bool array
        Where to look.
    own : Known
        The strand itself, along as many points.
    others : sequence of Known
        All other strands.
    picture : (h, w, 3) float32 array
        Colours above the ground.

    Returns
    -------
    offset : (n,) array
        Along the normal [px].
    sd : (n,) array
        In units of `UNIT`; both are meaningless where it is not unsure.
    """
    width = float(np.median(own.width))
    offset, sd = np.zeros(len(line)), np.full(len(line), np.nan)
    along = ALONG * width * (len(line) - 1) / arclength(line)[-1]
    rows = np.flatnonzero(ndimage.binary_dilation(unsure, iterations=int(2 * along) + 1))
    if len(rows) == 0:
        return offset, sd
    reach = round(SIGHT / STEP)
    across = STEP * width * np.arange(-reach, reach + 1)
    sight = Sight(line[rows], normals(line)[rows], across)
    ground, mine = _taken_apart(sight, own.colour[rows], others, picture, width)
    cost = _cost(ground, mine)
    cost = ndimage.gaussian_filter1d(cost, along, axis=0, mode="nearest")
    middle, half = _valley(cost)
    offset[rows], sd[rows] = middle * width, half / UNIT
    return offset, sd


def _taken_apart(
    sight: Sight, own: np.ndarray, others: Sequence[Known], picture: np.ndarray, width: float
) -> tuple[np.ndarray, np.ndarray]:
    """Share of the ground and of the strand itself in each sample, (n, m) both."""
    colours = sample(picture, sight.points)
    mine = np.clip(_dot(colours, own[:, None]) / _square(own)[:, None], 0, 1)
    left = _norm(colours - mine[..., None] * own[:, None])
    ground = 1 - mine
    for other in others:
        i, j, colour = _beside(sight, other, width)
        if len(i) == 0:
            continue
        a, b, rest = _shares(colours[i, j], own[i], colour)
        alike = _norm(own[i] - colour) < ALIKE * _norm(own[i])
        a[alike], b[alike], rest[alike] = 0, 1, 0
        better = rest < left[i, j]
        i, j, a, b = i[better], j[better], a[better], b[better]
        mine[i, j], ground[i, j], left[i, j] = a, 1 - a - b, rest[better]
    return ground, np.clip((mine - FAINT) / (1 - FAINT), 0, 1)


def _beside(sight: Sight, other: Known, width: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Find the samples within another strand (rows, columns), and its colour there.

    The other is taken as straight near its point nearest to the middle of the row.
    """
    within = (SIGHT + 0.5) * width + 1
    far, nearest = other.points.query(sight.middle, distance_upper_bound=within)
    rows = np.flatnonzero(np.isfinite(far))
    nearest = nearest[rows]
    normal = other.normal[nearest]
    away = _dot(sight.middle[rows] - other.points.data[nearest], normal)
    away = away[:, None] + _dot(sight.normal[rows], normal)[:, None] * sight.distance
    i, j = np.nonzero(np.abs(away) < 0.5 * width + 1)
    return rows[i], j, other.colour[nearest[i]]


def _shares(
    colours: np.ndarray, first: np.ndarray, second: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Least-squares shares a, b >= 0, a + b <= 1 of two colours, and the distance left (n,)."""
    p, q, r = _square(first), _dot(first, second), _square(second)
    u, v = _dot(colours, first), _dot(colours, second)
    free = np.maximum(p * r - q * q, 1e-6 * p * r)
    a, b = (r * u - q * v) / free, (p * v - q * u) / free
    # On the side a + b = 1: the share of the first on the line between the two.
    between = np.clip(
        _dot(colours - second, first - second) / np.maximum(p - 2 * q + r, 1e-6), 0, 1
    )
    full = a + b > 1
    a, b = np.where(full, between, a), np.where(full, 1 - between, b)
    alone_a, alone_b = np.clip(u / p, 0, 1), np.clip(v / r, 0, 1)
    a, b = np.where(b < 0, alone_a, a), np.where(b < 0, 0, b)
    a, b = np.where(a < 0, 0, a), np.where(a < 0, alone_b, b)
    return a, b, _norm(colours - a[:, None] * first - b[:, None] * second)


def _dot(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    return np.einsum("...i,...i", a, b)


def _square(a: np.ndarray) -> np.ndarray:
    return np.maximum(_dot(a, a), 1e-6)  # a strand may have the ground's colour


def _norm(a: np.ndarray) -> np.ndarray:
    return np.sqrt(_dot(a, a))


def _cost(ground: np.ndarray, mine: np.ndarray) -> np.ndarray:
    """Ground seen inside, and own colour seen outside, were the strand at each sample [widths]."""
    half = 0.5 / STEP
    reach = int(np.ceil(half))
    kernel = np.clip(half + 0.5 - np.abs(np.arange(-reach, reach + 1)), 0, 1)
    inside = ndimage.correlate1d(ground - mine, kernel, axis=1, mode="nearest")
    return STEP * (inside + mine.sum(axis=1, keepdims=True))


def _valley(cost: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Middle and half-length [widths] of the places as good as the best, within TOLERANCE."""
    index = np.arange(cost.shape[1])
    across = STEP * (index - cost.shape[1] // 2)
    cost = np.where(np.abs(across) <= SEARCH, cost + LAZY * np.abs(across), np.inf)
    best = cost.argmin(axis=1)[:, None]
    good = cost <= cost.min(axis=1, keepdims=True) + TOLERANCE
    # The run of good places that holds the best one.
    low = np.where(~good & (index < best), index, -1).max(axis=1) + 1
    high = np.where(~good & (index > best), index, len(index)).min(axis=1) - 1
    return (across[low] + across[high]) / 2, (across[high] - across[low] + STEP) / 2
