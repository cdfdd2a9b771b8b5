"""Strands that change colour along their length: pieces of two colours that meet head-on.

Two colours are one strand where the end of a piece of one faces the end of a piece of the other,
and the outline around both is that of a single strand: it neither narrows nor steps aside where
the colour changes. Ends of two strands that merely meet leave a notch or a step. A change of
colour beneath another strand, or in contact with one, leaves no outline to judge by: there two ends
in line are joined as a guess, at a price.
"""

from collections.abc import Sequence

import cv2
import numpy as np

from imaging.segment import Segmentation
from imaging.trace.branches import End
from imaging.trace.bundle import bundled, normals_of
from imaging.trace.centreline import edges, normals
from imaging.trace.matching import GIVE_UP, Gain, as_arrays, bending, bridge

FARTHEST = 10.0  # strand widths between the ends, where colours blend and are taken for others
PRICE = 0.5 * GIVE_UP  # of a join across colours; one within a colour is preferred
CORNER = 0.6  # rad; strands that meet at a larger angle are two
AROUND = 1.0  # strand widths beyond both ends over which the outline is looked at
NARROW, WIDE = 0.85, 1.15  # of its width beside the change; a notch is narrower, two strands wider
ASIDE = 0.06  # strand widths (RMS) by which its middle may leave a parabola
UNSEEN = 1.25 * GIVE_UP  # price of a join across colours where the change is not seen
UNSEEN_FARTHEST = 12.0  # strand widths between the ends, the same
UNSEEN_BEND = 4.0  # times what a join that is seen bends; its two colours speak against it
BARE = 3.0  # cost of each strand width of such a join that no third strand hides or touches
MOST_BARE = 0.6  # of its length; a change more in the open than that would be seen
BESIDE = 1.2  # strand widths to the side at which a third strand is looked for
BLEND = 2.0  # strand widths around a change of colour in which any colour is the strand's own


def head_on(
    ends: Sequence[End], colours: np.ndarray, coverage: np.ndarray, width: float
) -> list[Gain]:
    """Find ends of different colours that face each other within the outline of one strand.

    Parameters
    ----------
    ends : sequence of End
    colours : (n,) int array
        Of each end.
    coverage : (h, w) float32 array
        How much of each pixel any strand covers.
    width : float
        Strand width [px].

    Returns
    -------
    list of (int, int, float)
        Indices into `ends`, and how much less the join costs than to leave both.
    """
    facing = _facing(ends, colours, width, farthest=FARTHEST, price=PRICE)
    if not facing:
        return []
    paths = bundled([_along(ends[a], ends[b], width) for a, b, _ in facing])
    normal = normals_of(paths)
    low, high = edges(paths.points, coverage, coverage, width, normal)
    middle = paths.points + (low + high)[:, None] / 2 * normal
    outlines = zip(paths.parted(high - low), paths.parted(middle), strict=True)
    return [
        join
        for join, (span, line) in zip(facing, outlines, strict=True)
        if _one_outline(span, line, width)
    ]


def _facing(
    ends: Sequence[End],
    colours: np.ndarray,
    width: float,
    *,
    farthest: float,
    price: float,
    dearer: float = 1.0,
) -> list[Gain]:
    """Find joins of ends of different colours, nearly in line, that are worth their price.

    `farthest` is in strand widths; `dearer` is how many times its usual cost a bend costs.
    """
    if len(ends) < 2:
        return []
    points, directions, _ = as_arrays(ends)
    i, j = np.nonzero(np.triu(np.not_equal.outer(colours, colours), 1))
    bend, gap = bending(points[i], directions[i], points[j], directions[j], width)
    gain = 2 * GIVE_UP - price - dearer * bend
    straight = -(directions[i] * directions[j]).sum(axis=1) > np.cos(CORNER)
    good = (gain > 0) & (gap < farthest * width) & straight
    return list(zip(i[good].tolist(), j[good].tolist(), gain[good].tolist(), strict=True))


def _along(first: End, second: End, width: float) -> np.ndarray:
    """Path (n, 2) from a little before a join to a little beyond it."""
    ahead = np.arange(1, int(AROUND * width) + 1)[:, None]
    before = first.point - ahead[::-1] * first.direction
    after = second.point - ahead * second.direction
    return np.concatenate([before, bridge(first, second), after])


def _one_outline(span: np.ndarray, middle: np.ndarray, width: float) -> bool:
    """Tell whether an outline along a join, this wide about this middle, is of a single strand.

    It is as wide as before or after the join, and its middle follows a parabola.
    """
    if not np.isfinite(span).all():
        return False
    beside = int(AROUND * width)
    usual = [np.median(part) for part in (span[:beside], span[-beside:])]
    if span.min() < NARROW * min(usual) or span.max() > WIDE * max(usual):
        return False
    at = np.linspace(-1, 1, len(middle))
    smooth = np.polynomial.polynomial.polyfit(at, middle, 2)
    off = middle - np.polynomial.polynomial.polyval(at, smooth).T
    return bool(np.sqrt((off**2).sum(axis=1).mean()) < ASIDE * width)


def beneath(
    ends: Sequence[End], colours: np.ndarray, labels: np.ndarray, width: float
) -> list[Gain]:
    """Find ends of different colours that continue each other beneath or beside a third strand.

    That both strands end there, in line and out of sight, is less likely than that one changes its
    colour; that the ends found are not the strands' own is likelier than either, hence the price.

    Parameters
    ----------
    ends : sequence of End
    colours : (n,) int array
        Of each end.
    labels : (h, w) int array
        1 + the colour seen, 0 = ground.
    width : float
        Strand width [px].

    Returns
    -------
    list of (int, int, float)
        Indices into `ends`, and how much less the join costs than to leave both.
    """
    found = []
    facing = _facing(
        ends, colours, width, farthest=UNSEEN_FARTHEST, price=UNSEEN, dearer=UNSEEN_BEND
    )
    for a, b, most in facing:
        own = (colours[a] + 1, colours[b] + 1)
        path = bridge(ends[a], ends[b])
        bare = _bare(path, labels, own, width)
        left = most - BARE * bare.sum() / width
        if left > 0 and bare.mean() < MOST_BARE:
            found.append((a, b, left))
    return found


def _bare(path: np.ndarray, labels: np.ndarray, own: tuple[int, int], width: float) -> np.ndarray:
    """Tell which points of a join lie on the ground or have no third strand over or beside them."""
    aside = BESIDE * width * normals(path)
    x, y = np.rint([path - aside, path, path + aside]).astype(int).transpose(2, 0, 1)
    last_y, last_x = np.subtract(labels.shape, 1)
    seen = labels[y.clip(0, last_y), x.clip(0, last_x)]
    third = (seen > 0) & (seen != own[0]) & (seen != own[1])
    return (seen[1] == 0) | ~third.any(axis=0)


def own_membership(
    segmentation: Segmentation, coverage: np.ndarray, line: np.ndarray, tones: np.ndarray
) -> np.ndarray:
    """Coverage by a strand's own colours (h, w), each only where the strand has it.

    Parameters
    ----------
    segmentation : Segmentation
    coverage : (h, w) float32 array
    line : (n, 2) array
        Rough centreline.
    tones : (n,) int array
        Index of its colour at each point.
    """
    changes = np.flatnonzero(np.diff(tones)) + 1
    if len(changes) == 0:
        return segmentation.membership[tones[0]]
    own = np.zeros_like(coverage)
    reach = BLEND * segmentation.width
    for run in np.split(np.arange(len(line)), changes):
        box, near = _band(line[run], coverage.shape, reach)
        np.add(own[box], segmentation.membership[tones[run[0]]][box], out=own[box], where=near)
    np.minimum(own, 1, out=own)
    for change in changes:
        box, near = _band(line[change - 1 : change + 1], coverage.shape, reach)
        np.copyto(own[box], coverage[box], where=near)
    return own


def _band(
    line: np.ndarray, shape: tuple[int, ...], reach: float
) -> tuple[tuple[slice, slice], np.ndarray]:
    """Rows and columns around a line, and which pixels there are within reach of it."""
    half = int(np.ceil(reach))
    low = np.maximum(np.rint(line.min(axis=0)).astype(int) - half, 0)
    high = np.minimum(np.rint(line.max(axis=0)).astype(int) + half + 1, shape[::-1])
    drawn = np.zeros((high - low)[::-1], np.uint8)
    points = np.append(line[:: max(1, half // 8)], line[-1:], axis=0)
    cv2.polylines(drawn, [np.rint(points - low).astype(np.int32)], False, 1, 2 * half + 1)
    return np.s_[low[1] : high[1], low[0] : high[0]], drawn > 0
