"""Where ridges are, coarsely: what a line drawn by hand is drawn towards (the live wire's cost).

Computed here, not in the page: the page then holds no image processing, opens at once with a
photograph of any size, and what draws the hand's line is tested like the rest. It adds 0.1 to 1 MB.
"""

import cv2
import numpy as np

from imaging.photo import Photo

ACROSS = 4.0  # px of the coarse picture across a strand; enough for a ridge
LARGEST = 1.2e6  # px of the coarse picture; Dijkstra's algorithm takes 0.1 s in a browser then
ANGLES = 8
WIDTHS = (0.7, 1.0, 1.5)  # of the typical strand; others' are unlike
STRONG = 12.0  # Lab units of contrast to both sides from which on a ridge is cheapest
DEAREST = 255
CHEAPEST = 6  # so that a way does not wind


def wire_cost(photo: Photo, width: float) -> tuple[np.ndarray, list[float]]:
    """Return what it costs a line to pass a place, and the size of a place.

    Parameters
    ----------
    photo : Photo
    width : float
        Typical strand width [px].

    Returns
    -------
    cost : (h, w) uint8 array
        6 on a ridge of good contrast to 255 in the open.
    scale : [float, float]
        Pixels of the photograph in one of `cost`, along x and along y.
    """
    height, across = photo.shape
    scale = max(width / ACROSS, np.sqrt(height * across / LARGEST), 1.0)
    size = (max(round(across / scale), 1), max(round(height / scale), 1))
    small = cv2.resize(photo.eight_bits(), size, interpolation=cv2.INTER_AREA)
    lab = cv2.cvtColor(small.astype(np.float32) / 255, cv2.COLOR_RGB2Lab)
    narrow = max(width / scale, 1.5)
    ridge = np.max([_ridge(lab, factor * narrow) for factor in WIDTHS], axis=0)
    across_it = np.ones((2 * round(narrow / 2) + 1,) * 2, np.uint8)
    middle = ridge / np.maximum(cv2.dilate(ridge, across_it), 1e-6)
    ease = np.clip(ridge / STRONG, 0, 1) * middle**2
    cost = CHEAPEST + (DEAREST - CHEAPEST) * (1 - ease) ** 2
    return np.rint(cost).astype(np.uint8), [across / size[0], height / size[1]]


def _ridge(lab: np.ndarray, width: float) -> np.ndarray:
    """Contrast of a strand of a width to what lies on both its sides, (h, w) [Lab units].

    In the best of some directions, the smaller of the contrasts to either side, times how far the
    two agree in direction: the border of an area, which has but one side, gives nothing.
    """
    core = cv2.GaussianBlur(lab, (0, 0), max(0.3 * width, 0.5))
    best = np.zeros(lab.shape[:2], np.float32)
    for angle in np.pi * np.arange(ANGLES) / ANGLES:
        aside = width * np.array([np.cos(angle), np.sin(angle)])
        left, right = (core - _moved(core, way * aside) for way in (1, -1))
        a, b = (np.sqrt((side**2).sum(axis=-1)) for side in (left, right))
        agree = (left * right).sum(axis=-1) / np.maximum(a * b, 1e-6)
        np.maximum(best, np.minimum(a, b) * np.maximum(agree, 0), out=best)
    return best


def _moved(picture: np.ndarray, by: np.ndarray) -> np.ndarray:
    """Take the colour that lies `by` aside of each place."""
    shift = np.array([[1, 0, by[0]], [0, 1, by[1]]], np.float32)
    flags = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
    size = picture.shape[1::-1]
    return cv2.warpAffine(picture, shift, size, flags=flags, borderMode=cv2.BORDER_REPLICATE)
