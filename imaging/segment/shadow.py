"""Shadows that strands cast on the ground: its own hue in less light, with soft edges."""

import cv2
import numpy as np

from imaging.segment.ground import Ground

HUE = 0.06  # of (a, b)/(L + 16); a shadow keeps the ground's, which does not change with light
DEEPEST, FAINTEST = 0.1, 0.9  # of the ground's light that is left in a shadow
SOFTER = 1.6  # times the softness of the sharpest colour's edges; a lamp is no point
LEAST = 0.4  # px, by which it must be softer as well
STEEP = 2  # px from the outline to where the edge is steepest, at most
WHOLE = 75  # per cent of a colour's pixels that have less than all its contrast
EVERY = 5  # pixel of a colour is compared with the ground under it
SHARE = 0.1  # of a colour's area; less that is soft is chance
GAUSS = np.sqrt(2 * np.pi)


def erase_shadows(
    labels: np.ndarray,
    colours: np.ndarray,
    lab: np.ndarray,
    contrast: np.ndarray,
    ground: Ground,
    width: float,
) -> np.ndarray | None:
    """Take the labels off shadows on the ground, in place.

    A shadow has the ground's hue, is darker, and its edges are softer than those of a strand, as
    it lies farther from what casts it than a strand's own edge. A grey strand has the ground's hue
    too, but edges as sharp as the others', also where it was taken for one colour with shadows.
    What leaves less light than a shadow is a black strand.

    Parameters
    ----------
    labels : (h, w) uint8 array
        0 = background, k = colour k - 1.
    colours : (k, 3) array
        Lab colours.
    lab : (h, w, 3) float32 array
    contrast : (h, w) float32 array
        Distance to the ground's colour.
    ground : Ground
    width : float
        Typical strand width [px].

    Returns
    -------
    (h, w) bool array or None
        What was taken for shadow; None where there is none.
    """
    darker = np.flatnonzero(colours[:, 0] < ground.coarse[..., 0].max()) + 1
    dim = [k for k in darker.tolist() if _is_dim_ground(labels == k, lab, ground)]
    if not dim or len(colours) == 1:
        return None
    slope = _steepest(contrast)
    rims = {k: _rim(labels, k, contrast, slope) for k in range(1, len(colours) + 1)}
    sharpest = min(float(np.median(softness)) for _, softness in rims.values())
    limit = max(SOFTER * sharpest, sharpest + LEAST)
    shadow = np.zeros(labels.shape, bool)
    for k in dim:
        own = labels == k
        at, softness = rims[k]
        soft = own & _nearest_soft(at, softness > limit, labels.shape, width)
        if soft.sum() > SHARE * own.sum():
            shadow |= soft
    shadow &= ~_black(shadow, lab, ground)
    labels[shadow] = 0
    return shadow if shadow.any() else None


def _black(where: np.ndarray, lab: np.ndarray, ground: Ground) -> np.ndarray:
    """Mark (h, w) what leaves less light than a shadow: a black strand, and its rim."""
    at = np.flatnonzero(where)
    black = np.zeros(where.shape, np.uint8)
    black.ravel()[at] = _light(lab.reshape(-1, 3)[at], ground.at(at)) < DEEPEST
    kernel = np.ones((3, 3), np.uint8)
    return cv2.dilate(cv2.morphologyEx(black, cv2.MORPH_OPEN, kernel), kernel) > 0


def _light(seen: np.ndarray, under: np.ndarray) -> np.ndarray:
    """How much of the ground's light is left (n,), from Lab colours (n, 3)."""
    return ((seen[:, 0] + 16) / (under[:, 0] + 16)) ** 3


def _is_dim_ground(own: np.ndarray, lab: np.ndarray, ground: Ground) -> bool:
    """Tell whether what is seen here is the ground's hue in less light."""
    at = np.flatnonzero(own)[::EVERY]
    if len(at) == 0:
        return False
    seen, under = lab.reshape(-1, 3)[at], ground.at(at)
    light = np.median(_light(seen, under))
    hue = np.abs(seen[:, 1:] / (seen[:, :1] + 16) - under[:, 1:] / (under[:, :1] + 16))
    return bool(DEEPEST < light < FAINTEST and (np.median(hue, axis=0) < HUE).all())


def _steepest(contrast: np.ndarray) -> np.ndarray:
    """Steepest slope (h, w) of the contrast around each pixel, per pixel."""
    across = cv2.Sobel(contrast, cv2.CV_32F, 1, 0, scale=1 / 8)
    down = cv2.Sobel(contrast, cv2.CV_32F, 0, 1, scale=1 / 8)
    side = 2 * STEEP + 1
    return cv2.dilate(cv2.magnitude(across, down), np.ones((side, side), np.uint8))


def _rim(
    labels: np.ndarray, number: int, contrast: np.ndarray, slope: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Places (n,) of a colour's outline on bare ground, and the sd of its blur there (n,) [px].

    A step blurred by sd sigma rises by its height / (sigma sqrt(2 pi)) a pixel where it has half
    its height. A colour's outline runs about there, but that of a strand little darker than the
    ground a pixel or two inside, where it has all its height and rises no more.
    """
    own = (labels == number).view(np.uint8)
    others = (labels > 0).view(np.uint8) - own
    free = cv2.dilate(others, np.ones((7, 7), np.uint8)) == 0
    inner = cv2.erode(own, np.ones((3, 3), np.uint8))
    at = np.flatnonzero((own > inner) & free)
    if len(at) == 0:
        return at, np.full(1, np.inf)
    whole = np.percentile(contrast[own > 0], WHOLE)
    height = np.minimum(2 * contrast.ravel()[at], whole)
    return at, height / np.maximum(slope.ravel()[at], 1e-3) / GAUSS


def _nearest_soft(
    at: np.ndarray, soft: np.ndarray, shape: tuple[int, ...], width: float
) -> np.ndarray:
    """Tell (h, w) where most of the nearest outline, over a strand's width, is soft."""
    off = np.ones(shape, np.uint8)
    off.ravel()[at] = 0
    if len(at) == 0:
        return off == 0
    votes = np.zeros(shape, np.float32)
    votes.ravel()[at] = np.where(soft, 1, -1)
    side = 2 * int(width) + 1
    total = cv2.boxFilter(votes, -1, (side, side), normalize=False)
    _, nearest = cv2.distanceTransformWithLabels(
        off, cv2.DIST_L2, 5, labelType=cv2.DIST_LABEL_PIXEL
    )
    won = np.zeros(nearest.max() + 1, bool)
    won[nearest.ravel()[at]] = total.ravel()[at] > 0
    return won[nearest]
