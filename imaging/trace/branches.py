"""Pieces of one strand colour between crossings, occlusions and ends."""

from dataclasses import dataclass

import cv2
import numpy as np
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from imaging.segment.skeleton import degrees, in_order, linked, thinned
from imaging.trace.centreline import resample

TRIM = 0.5  # strand widths at each end of a skeleton, where it turns into a corner
REACH = 3.0  # strand widths over which the direction of an end is fitted
SPECK = 1.5  # strand widths; a shorter piece has no direction to speak of
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
    points, touching = linked(without_spurs(thinned(mask), width))
    junctions = points[degrees(touching) > 2]
    if len(junctions):
        away = cKDTree(junctions).query(points)[0] > CLEAR * width
        points, touching = points[away], touching[away][:, away]
    paths = [points[path].astype(float) for path in in_order(touching)]
    return [_trimmed(path, width) for path in paths if len(path) >= max(4, SPECK * width)]


def without_spurs(skeleton: np.ndarray, width: float) -> np.ndarray:
    """Drop side branches shorter than a strand is wide: they are corners of its outline."""
    points, touching = linked(skeleton)
    degree = degrees(touching)
    junction = degree > 2
    if not junction.any():
        return skeleton
    knot = junction | (touching @ junction > 0)
    arm = np.flatnonzero(~knot)
    count, number = connected_components(touching[arm][:, arm], directed=False)
    short = np.bincount(number) < 0.6 * width
    loose = np.bincount(number[degree[arm] == 1], minlength=count) > 0
    bound = np.bincount(number[(touching @ knot)[arm] > 0], minlength=count) > 0
    spur = np.zeros(len(points), bool)
    spur[arm] = (short & loose & bound)[number]
    if not spur.any():
        return skeleton
    spur |= knot & ~junction & (touching @ spur > 0)  # its stump, or else the junction stays
    x, y = points[spur].T
    skeleton[y, x] = False
    return thinned(skeleton)


def _trimmed(path: np.ndarray, width: float) -> np.ndarray:
    cut = min(int(round(TRIM * width)), (len(path) - 3) // 2)
    return path[cut : len(path) - cut] if cut > 0 else path


def ends_of(paths: list[np.ndarray], width: float) -> list[End]:
    """Both ends of each path with their outward directions, 2 i and 2 i + 1 for path i."""
    found = []
    for number, path in enumerate(paths):
        for last in (False, True):
            outwards = path if last else path[::-1]
            point, direction = end_fit(outwards[-max(3, int(REACH * width)) :])
            found.append(End(number, last, point, direction))
    return found


def end_fit(tail: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Last point and direction there, from a parabola (a line when short) through the tail."""
    u = np.linspace(-1, 0, len(tail))
    powers = np.vander(u, 3 if len(tail) > 12 else 2, increasing=True)
    point, slope = np.linalg.lstsq(powers, tail, rcond=None)[0][:2]
    return point, slope / max(np.hypot(*slope), 1e-9)
