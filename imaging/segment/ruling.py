"""Lines printed on the ground, as on a cutting mat or graph paper: found, and taken for ground."""

import cv2
import numpy as np

from imaging.segment.ground import Ground

PROBES = 5  # rows, and columns, on which thin marks are counted
MARKS = 4  # at least so many on most of them; below, there is no grid
NOISE_FACTOR = 3.0  # times the contrast of half the picture; above is a mark
MIN_CONTRAST = 6.0  # Lab units
FAINT = 0.2  # of the strands' contrast; fainter lines are no strand in any case
THICK = 0.01  # of the picture's shorter side; lines of a grid are thinner
LONG = 0.4  # of the picture's shorter side, along which a line is seen
LINES = 3  # at least so many one way and across
PARALLEL = 3.0  # degrees from the commonest direction, or from the one across it
SIDE = 900  # pixels; a larger picture is searched in larger ones, at least so many to a side
BESIDE = 3  # such pixels to the side of a line that its ink reaches, with lens and rounding
INK = 12.0  # Lab units off the mixtures of ground and ink; farther is a strand
DEEPEST = 1.3  # times the ink's contrast; the same


def erase_ruling(lab: np.ndarray, contrast: np.ndarray, ground: Ground) -> np.ndarray | None:
    """Give the lines of a grid printed on the ground the ground's colour, in place.

    A grid is told from strands by straight thin lines of one colour, three or more of them one
    way and as many across; what lies on them and is no mixture of ground and ink is left.

    Parameters
    ----------
    lab : (h, w, 3) float32 array
    contrast : (h, w) float32 array
        Distance to the ground's colour; made 0 where a line is erased.
    ground : Ground

    Returns
    -------
    (h, w) bool array or None
        What was erased; None where there is no grid.
    """
    half, highest = np.percentile(contrast[::13, ::11], [50, 98])
    level = max(NOISE_FACTOR * half, FAINT * highest, MIN_CONTRAST)
    if not _has_marks(contrast, level):
        return None
    thin = _thin(contrast > level)
    drawn = _grid(thin)
    if drawn is None:
        return None
    at = np.flatnonzero(drawn)
    above = lab.reshape(-1, 3)[at] - ground.at(at)
    ink = np.median(above[thin.ravel()[at] > 0], axis=0)
    share = np.clip(above @ ink / (ink @ ink), 0, DEEPEST)
    printed = at[np.linalg.norm(above - share[:, None] * ink, axis=1) < INK]
    lab.reshape(-1, 3)[printed] = ground.at(printed)
    contrast.ravel()[printed] = 0
    erased = np.zeros(contrast.shape, bool)
    erased.ravel()[printed] = True
    return erased


def _has_marks(contrast: np.ndarray, level: float) -> bool:
    """Tell whether most of a few rows, and of a few columns, meet many thin marks."""
    height, width = contrast.shape
    rows = contrast[np.linspace(0, height - 1, PROBES + 2).astype(int)[1:-1]] > level
    columns = contrast[:, np.linspace(0, width - 1, PROBES + 2).astype(int)[1:-1]] > level
    for probes in (rows, columns.T):
        step = np.diff(np.pad(probes, ((0, 0), (1, 1))).astype(np.int8), axis=1)
        if np.median((step > 0).sum(axis=1)) < MARKS:
            return False
        thickness = np.nonzero(step < 0)[1] - np.nonzero(step > 0)[1]
        if np.median(thickness) > _thickest(contrast.shape):
            return False
    return True


def _thickest(shape: tuple[int, ...]) -> int:
    return max(int(THICK * min(shape)), 6)


def _thin(mask: np.ndarray) -> np.ndarray:
    """Leave of a mask what is thinner than lines of a grid are, uint8."""
    mask = mask.view(np.uint8)
    kernel = np.ones((_thickest(mask.shape) + 1,) * 2, np.uint8)
    nothing = cv2.BORDER_CONSTANT  # beyond the picture
    return mask - cv2.morphologyEx(mask, cv2.MORPH_OPEN, kernel, borderType=nothing, borderValue=0)


def _grid(thin: np.ndarray) -> np.ndarray | None:
    """Where the lines of a grid run (h, w) uint8, a few pixels wide; None where there is none."""
    pixel = max(1, min(thin.shape) // SIDE)
    small = cv2.resize(255 * thin, None, fx=1 / pixel, fy=1 / pixel, interpolation=cv2.INTER_AREA)
    found = cv2.HoughLines(small, 1, np.pi / 360, int(LONG * min(small.shape)))
    if found is None:
        return None
    rho, theta = found[:, 0].T.astype(float) * [[pixel], [1]]
    step = np.degrees(theta)
    middle = np.bincount(np.round(step % 90).astype(int) % 90).argmax()
    off = (step - middle + 45) % 90 - 45
    across = np.round((step - middle) / 90).astype(int) % 2
    straight = np.abs(off) < PARALLEL
    if min(_count(rho[straight & (across == way)], thin.shape) for way in (0, 1)) < LINES:
        return None
    drawn = np.zeros(thin.shape, np.uint8)
    far = float(sum(thin.shape))
    for r, angle in zip(rho[straight], theta[straight], strict=True):
        normal = np.array([np.cos(angle), np.sin(angle)])
        along = far * np.array([-normal[1], normal[0]])
        ends = [np.round(r * normal + way * along).astype(int).tolist() for way in (-1, 1)]
        cv2.line(drawn, ends[0], ends[1], 1, pixel * (2 * BESIDE + 1))
    return drawn


def _count(rho: np.ndarray, shape: tuple[int, ...]) -> int:
    """Count the lines among detections at these distances; those of one line lie close."""
    gap = 2 * _thickest(shape)
    return int((np.diff(np.sort(np.abs(rho))) > gap).sum()) + (len(rho) > 0)
