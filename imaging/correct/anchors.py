"""Strands found again by a place and a direction, or by a line they lie along."""

from collections.abc import Sequence

import numpy as np
from scipy.spatial import cKDTree

from imaging.correct.schema import Anchor, Point
from imaging.trace import Strand
from imaging.trace.centreline import resample

ASKEW = np.deg2rad(40)  # between a strand's direction and the one that was noted
NEAR = 1.0  # strand widths; a strand farther from where it was is another
AT_LEAST = 6.0  # px; the same for thin strands: a hand points no better
CHORD = 1.0  # strand widths to both sides over which a direction is taken


def reach(strand: Strand) -> float:
    """How far a strand may be from a place and still be the one meant there [px]."""
    return max(AT_LEAST, NEAR * float(np.median(strand.width)))


def beside(strand: Strand) -> float:
    """How far a line may be from a strand to be the same and not its neighbour's [px]."""
    return reach(strand) / 2


def direction(strand: Strand, at: int) -> np.ndarray:
    """Return the unit vector along a strand at its point `at`, root to tip."""
    half = max(2, round(CHORD * float(np.median(strand.width))))
    line = strand.line
    chord = line[min(at + half, len(line) - 1)] - line[max(at - half, 0)]
    return chord / max(float(np.hypot(*chord)), 1e-9)


def between(a: Point | np.ndarray, b: Point | np.ndarray) -> float:
    """Angle between two undirected lines, 0 to pi/2 [rad]."""
    a, b = np.asarray(a, float), np.asarray(b, float)
    return float(np.arctan2(abs(a[0] * b[1] - a[1] * b[0]), abs(a @ b)))


def place_on(strand: Strand, at: Point) -> tuple[int, float]:
    """Index of a strand's point nearest to a place, and how far it is [px]."""
    far = np.hypot(*(strand.line - at).T)
    nearest = int(far.argmin())
    return nearest, float(far[nearest])


def passing(strands: Sequence[Strand], here: Anchor) -> tuple[int, int] | None:
    """Find which strand passes a place in a direction, and at which of its points."""
    best, found = np.inf, None
    for number, strand in enumerate(strands):
        at, far = place_on(strand, here.at)
        askew = between(direction(strand, at), here.along)
        misfit = far / reach(strand) + askew / ASKEW
        if far <= reach(strand) and askew <= ASKEW and misfit < best:
            best, found = misfit, (number, at)
    return found


def ending(strands: Sequence[Strand], end: Anchor) -> tuple[int, bool] | None:
    """Find which strand ends near a place, going out in a direction; True = its last point."""
    best, found = np.inf, None
    for number, strand in enumerate(strands):
        for last in (False, True):
            point = strand.line[-last]
            out = direction(strand, len(strand.line) - 1 if last else 0) * (1 if last else -1)
            far = float(np.hypot(*(point - end.at)))
            ahead = out @ end.along / np.hypot(*end.along)
            if far <= 3 * reach(strand) and ahead >= np.cos(ASKEW) and far < best:
                best, found = far, (number, last)
    return found


def share_along(line: np.ndarray, other: np.ndarray, near: float) -> float:
    """Share of a line's length within `near` [px] of another line."""
    even, dense = resample(np.asarray(line, float)), resample(np.asarray(other, float))
    return float((cKDTree(dense).query(even)[0] <= near).mean())


def apart(line: np.ndarray, other: np.ndarray) -> float:
    """Mean distance of a line's points from another line [px]."""
    return float(cKDTree(resample(np.asarray(other, float))).query(line)[0].mean())
