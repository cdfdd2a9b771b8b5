"""Pieces of one strand colour between crossings, occlusions and ends."""

from dataclasses import dataclass

import cv2
import numpy as np
from skimage.morphology import skeletonize

from imaging.centreline import resample

TRIM = 0.5  # strand widths at each end of a skeleton, where it turns into a corner
REACH = 3.0  # strand widths over which the direction of an end is fitted
SPECK = 1.5  # strand widths; a shorter piece has no direction to speak of
PINHOLE = 0.1  # strand widths; half the gap that is closed
WIDE_ENOUGH = 5.0  # px; strands at least twice as wide are skeletonised in larger pixels
CLEAR = 0.9  # strand widths cleared around a junction of the skeleton


@dataclass(frozen=True)
class End:
    """One end of a branch: where it is, and where it points to (outwards).

    Attributes
    ----------
    branch : int
    last : bool
        False = the branch's first point, True = its last.
    point, direction : (2,) arrays
    """

    branch: int
    last: bool
    point: np.ndarray
    direction: np.ndarray


def branches(mask: np.ndarray, width: float) -> list[np.ndarray]:
    """Split a mask of one colour into simple paths.

    Parameters
    ----------
    mask : (h, w) bool array
    width : float
        Strand width [px].

    Returns
    -------
    list of (n, 2) float arrays
        Ordered skeleton points x, y.
    """
    x0, y0, w, h = cv2.boundingRect(mask.view(np.uint8))
    if w == 0:
        return []
    scale = max(1, int(width / WIDE_ENOUGH))
    small = _shrunk(mask[y0 : y0 + h, x0 : x0 + w], scale)
    paths = _skeleton_paths(np.pad(small, 1), width / scale)
    corner = np.array([x0, y0]) + (scale - 1) / 2  # middle of the first coarse pixel
    return [_pixel_by_pixel((path - 1) * scale, scale) + corner for path in paths]


def _shrunk(mask: np.ndarray, scale: int) -> np.ndarray:
    """Mask in pixels `scale` times as large, set where at least half of one is."""
    if scale == 1:
        return mask
    fill = [(0, -side % scale) for side in mask.shape]
    padded = np.pad(mask.view(np.uint8) * np.uint8(255), fill)
    size = padded.shape[1] // scale, padded.shape[0] // scale
    return cv2.resize(padded, size, interpolation=cv2.INTER_AREA) > 127


def _pixel_by_pixel(path: np.ndarray, scale: int) -> np.ndarray:
    return path if scale == 1 else resample(path)


def _skeleton_paths(mask: np.ndarray, width: float) -> list[np.ndarray]:
    """Skeleton of a mask with an empty rim, in simple paths (n, 2) of points x, y."""
    skeleton = _without_spurs(skeletonize(_without_pinholes(mask, width)), width)
    cut = skeleton & ~_near(_junctions(skeleton), CLEAR * width)
    paths = [path for path in _paths(cut) if len(path) >= max(4, SPECK * width)]
    return [_trimmed(path, width) for path in paths]


def _without_pinholes(mask: np.ndarray, width: float) -> np.ndarray:
    """Close gaps narrower than a fifth of a strand, round which a skeleton would run in a ring."""
    side = 2 * int(PINHOLE * width) + 1
    if side == 1:
        return mask
    kernel = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (side, side))
    return cv2.morphologyEx(mask.astype(np.uint8), cv2.MORPH_CLOSE, kernel) > 0


def _neighbours(skeleton: np.ndarray) -> np.ndarray:
    kernel = np.array([[1, 1, 1], [1, 0, 1], [1, 1, 1]], np.uint8)
    count = cv2.filter2D(skeleton.astype(np.uint8), -1, kernel, borderType=cv2.BORDER_CONSTANT)
    return np.where(skeleton, count, 0)


def _junctions(skeleton: np.ndarray) -> np.ndarray:
    return _neighbours(skeleton) > 2


def _grown(mask: np.ndarray) -> np.ndarray:
    """Mask with all eight neighbours of its pixels."""
    return cv2.dilate(mask.view(np.uint8), np.ones((3, 3), np.uint8)) > 0


def _near(points: np.ndarray, radius: float) -> np.ndarray:
    if not points.any():
        return points
    return cv2.distanceTransform((~points).astype(np.uint8), cv2.DIST_L2, 5) <= radius


def _without_spurs(skeleton: np.ndarray, width: float) -> np.ndarray:
    """Drop side branches shorter than a strand is wide: they are corners of its outline."""
    junctions = _junctions(skeleton)
    if not junctions.any():
        return skeleton
    knots = _grown(junctions)
    arms = (skeleton & ~knots).astype(np.uint8)
    _, number, stats, _ = cv2.connectedComponentsWithStats(arms, connectivity=8)
    short = stats[:, cv2.CC_STAT_AREA] < 0.6 * width
    loose = np.bincount(number[_neighbours(skeleton) == 1], minlength=len(short)) > 0
    bound = np.bincount(number[_grown(knots) & ~knots], minlength=len(short)) > 0
    spur = short & loose & bound
    spur[0] = False
    return skeletonize(skeleton & ~spur[number]) if spur.any() else skeleton


def _paths(cut: np.ndarray) -> list[np.ndarray]:
    """Order the pixels of each simple path, from one end to the other."""
    ys, xs = np.nonzero(cut)
    left = set(zip(xs.tolist(), ys.tolist(), strict=True))
    counts = _neighbours(cut)[ys, xs]
    order = np.argsort(counts, kind="stable")  # ends first, so that only rings start midway
    paths = []
    for i in order.tolist():
        start = (int(xs[i]), int(ys[i]))
        if start in left:
            paths.append(np.array(_walk(start, left), float))
    return paths


_STEPS = [(1, 0), (-1, 0), (0, 1), (0, -1), (1, 1), (1, -1), (-1, 1), (-1, -1)]


def _walk(start: tuple[int, int], left: set[tuple[int, int]]) -> list[tuple[int, int]]:
    path = [start]
    left.discard(start)
    while True:
        x, y = path[-1]
        following = next(((x + i, y + j) for i, j in _STEPS if (x + i, y + j) in left), None)
        if following is None:
            return path
        left.discard(following)
        path.append(following)


def _trimmed(path: np.ndarray, width: float) -> np.ndarray:
    cut = min(int(round(TRIM * width)), (len(path) - 3) // 2)
    return path[cut : len(path) - cut] if cut > 0 else path


def ends_of(paths: list[np.ndarray], width: float) -> list[End]:
    """Both ends of each path with their outward directions, 2 i and 2 i + 1 for path i."""
    found = []
    for number, path in enumerate(paths):
        for last in (False, True):
            outwards = path if last else path[::-1]
            point, direction = _end_fit(outwards[-max(3, int(REACH * width)) :])
            found.append(End(number, last, point, direction))
    return found


def _end_fit(tail: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Last point and direction there, from a parabola (a line when short) through the tail."""
    u = np.linspace(-1, 0, len(tail))
    powers = np.vander(u, 3 if len(tail) > 12 else 2, increasing=True)
    point, slope = np.linalg.lstsq(powers, tail, rcond=None)[0][:2]
    return point, slope / max(np.hypot(*slope), 1e-9)
