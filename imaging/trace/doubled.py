"""Where two strands of one colour lie over or beside each other, and look like one.

Both may then be joined past what is seen of them there: it costs them nothing, and the piece
between may be left out of every strand. Two signs tell such a piece: what is seen is broader than
one strand for long, or the piece forks at both its ends, as where two cross at a small angle. The
outline also tells whether they can have crossed there: where they do it is that of one strand.
"""

from collections.abc import Sequence

import cv2
import numpy as np
from scipy.spatial import cKDTree

from imaging.segment.skeleton import blobs
from imaging.trace.branches import End
from imaging.trace.centreline import edges
from imaging.trace.matching import Gain

BROAD = 1.3  # strand widths; what is seen of a colour there is two strands side by side,
SIDE_BY_SIDE = 3.0  # strand widths; if for longer: the parts of a twisted pair are bellied
AHEAD = 6.0  # strand widths from an end to those it forks into
ASIDE = 1.5  # strand widths by which these may lie off its direction
SPREAD = np.radians(50)  # most by which they may turn from it
APART = 1.5  # strand widths; where two strands cross, what is seen is less broad than that
SEEN = 0.7  # of the length of a piece; where less shows both its edges, it does not tell
SWAP = 10.0  # cost of a join that changes sides where two strands lie side by side
OWN = 2.0  # strand widths across a piece on which a join runs under its own colour


def broad_parts(mask: np.ndarray, width: float) -> np.ndarray:
    """Where what is seen of a colour is broader than one strand: two of them side by side.

    Parameters
    ----------
    mask : (h, w) bool array
        Where the colour is seen.
    width : float
        Strand width [px].

    Returns
    -------
    (h, w) bool array
    """
    broad = np.zeros_like(mask)
    deep = 0.5 * (BROAD * width + 1)  # depths count from pixel centres
    x, y, w, h = cv2.boundingRect(mask.view(np.uint8))
    seen, found = mask[y : y + h, x : x + w].view(np.uint8), broad[y : y + h, x : x + w]
    may = cv2.erode(seen, _ring(deep), borderType=cv2.BORDER_CONSTANT, borderValue=0)
    long, rim = SIDE_BY_SIDE * width, int(np.ceil(width)) + 2
    for near, own in blobs(may, long, rim):
        depth = cv2.distanceTransform(np.pad(seen[near], 1), cv2.DIST_L2, 5)[1:-1, 1:-1]
        for inner, core in blobs(own & (depth > deep), long, rim):
            away = cv2.distanceTransform((~core).view(np.uint8), cv2.DIST_L2, 5)
            found[near][inner] |= away < 0.75 * width
    return broad


def _ring(radius: float) -> np.ndarray:
    """Eight pixels at most `radius` from the middle: all are seen wherever that is the depth."""
    straight, slanting = int(radius), int(0.7 * radius)
    ring = np.zeros((2 * straight + 1, 2 * straight + 1), np.uint8)
    ring[[0, straight, straight, -1], [straight, 0, -1, straight]] = 1
    corners = straight + np.array([-slanting, slanting])
    ring[np.ix_(corners, corners)] = 1
    return ring


def is_in(path: np.ndarray, mask: np.ndarray) -> bool:
    """Tell whether most of a piece lies in a mask."""
    x, y = np.rint(path).astype(int).T
    last_y, last_x = np.subtract(mask.shape, 1)
    return bool(mask[y.clip(0, last_y), x.clip(0, last_x)].mean() > 0.5)


def drawn(paths: Sequence[np.ndarray], shape: tuple[int, int], width: float) -> np.ndarray:
    """Mask (h, w) of the bands along pieces in which a join runs under its own colour.

    Not where the colour is seen, but along its pieces: these stop short of crossings, through which
    two strands of one colour must both be able to pass at no cost.
    """
    bands = np.zeros(shape, np.uint8)
    for path in paths:
        cv2.polylines(bands, [np.rint(path).astype(np.int32)], False, 1, max(1, round(OWN * width)))
    return bands.view(bool)


def stems(ends: Sequence[End], width: float) -> np.ndarray:
    """Tell which pieces of one colour fork at both their ends.

    Parameters
    ----------
    ends : sequence of End
        Those of piece i are 2 i and 2 i + 1.
    width : float
        Strand width [px].

    Returns
    -------
    (n,) bool array
        One a piece.
    """
    ahead = _ahead(ends, width)
    forks = np.array([_forks(end, ahead) for end in range(len(ends))], bool)
    return forks[0::2] & forks[1::2]


def _ahead(ends: Sequence[End], width: float) -> list[set[int]]:
    """Find the ends that lie ahead of each end and face it."""
    found: list[set[int]] = [set() for _ in ends]
    if len(ends) < 6:
        return found
    points = np.array([e.point for e in ends])
    directions = np.array([e.direction for e in ends])
    pairs = cKDTree(points).query_pairs(AHEAD * width, output_type="ndarray")
    i, j = np.concatenate([pairs, pairs[:, ::-1]]).T
    way, chord = directions[i], points[j] - points[i]
    aside = np.abs(way[:, 0] * chord[:, 1] - way[:, 1] * chord[:, 0])
    good = (i // 2 != j // 2) & (aside < ASIDE * width)
    good &= ((way * chord).sum(axis=1) > 0) & ((directions[j] * chord).sum(axis=1) < 0)
    good &= -(way * directions[j]).sum(axis=1) > np.cos(SPREAD)
    for a, b in zip(i[good].tolist(), j[good].tolist(), strict=True):
        found[a].add(b)
    return found


def _forks(end: int, ahead: list[set[int]]) -> bool:
    """Tell whether two ends lie ahead that have no other than this one ahead of them."""
    return sum(ahead[other] <= {end} for other in ahead[end]) >= 2


def hold_apart(path: np.ndarray, own: np.ndarray, coverage: np.ndarray, width: float) -> bool:
    """Tell whether two strands lie side by side all along a piece: where they cross, one is seen.

    Parameters
    ----------
    path : (n, 2) array
    own, coverage : (h, w) float32 arrays
        Membership of the piece's colour, and coverage by any strand.
    width : float
        Strand width [px].
    """
    low, high = edges(path, own, coverage, width)
    span = (high - low)[np.isfinite(high - low)]
    return len(span) > SEEN * len(path) and bool(span.min() > APART * width)


def keep_sides(
    gains: Sequence[Gain], ends: Sequence[End], apart: Sequence[int], width: float
) -> list[Gain]:
    """Make joins dearer that change sides along pieces in which two strands lie side by side.

    Parameters
    ----------
    gains : sequence of (int, int, float)
        Joins of ends of one colour.
    ends : sequence of End
    apart : sequence of int
        Pieces of which `hold_apart` is true.
    width : float
        Strand width [px].
    """
    ahead = _ahead(ends, width) if apart else []
    side: dict[tuple[int, int], float] = {}
    for piece in apart:
        for way, end in ((-1, 2 * piece), (1, 2 * piece + 1)):
            (x, y), (u, v) = ends[end].point, ends[end].direction
            for arm in ahead[end]:
                p = ends[arm].point
                side[arm, end] = way * (u * (p[1] - y) - v * (p[0] - x))
    dearer = [(i, j, gain - SWAP * _swaps(i, j, side, apart)) for i, j, gain in gains]
    return [join for join in dearer if join[2] > 0]


def _swaps(i: int, j: int, side: dict[tuple[int, int], float], apart: Sequence[int]) -> bool:
    """Tell whether a join leads past one of the pieces from one side of it to the other."""
    return any(
        side.get((a, 2 * piece), 0) * side.get((b, 2 * piece + 1), 0) < 0
        for piece in apart
        for a, b in ((i, j), (j, i))
    )
