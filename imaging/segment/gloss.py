"""Highlights that came out as colours of their own, given back to the strand they lie on."""

import cv2
import numpy as np
from scipy.optimize import nnls
from skimage.color import lab2xyz

from imaging.segment.depths import places_of

WHITE = lab2xyz([[100.0, 0.0, 0.0]])[0]  # XYZ, in which light adds
UNLIKE = 0.15  # of a colour; what body colour and lamp leave unexplained in a highlight
BESIDE = 0.4  # of a highlight's outline that borders on its strand: one of its two sides
NEAR = 0.7  # of a highlight's area that lies within half a strand width of its strand
NARROW = 0.8  # of the strand's width; a highlight is never as wide as the strand it lies on


def without_highlights(
    labels: np.ndarray, colours: np.ndarray, width: float
) -> tuple[np.ndarray, np.ndarray]:
    """Give the highlights of glossy strands the label of the strand.

    By the dichromatic model (Shafer, Color Research & Application 10, 210, 1985) a glossy surface
    shows its own colour under more or less light, plus the lamp's, here taken to be white. A colour
    that is such a sum of another, runs along it and is nowhere as wide as both together is that
    other's highlight. Two strands twisted about each other are as wide as both together wherever
    one passes in front.

    Parameters
    ----------
    labels : (h, w) uint8 array
        0 = background, k = colour k - 1.
    colours : (k, 3) array
        Lab colours.
    width : float
        Typical strand width [px].

    Returns
    -------
    labels : (h, w) uint8 array
    colours : (m, 3) array
    """
    light = lab2xyz(colours)
    body = np.arange(len(colours))
    for shine, other in np.argwhere(_borders(labels, len(colours)) >= BESIDE).tolist():
        settled = body[shine] != shine or body[other] != other
        if settled or not _may_be_highlight(light[shine], light[other]):
            continue
        if _lies_on(labels, shine + 1, other + 1, width):
            body[body == shine] = other
    kept, number = np.unique(body, return_inverse=True)
    if len(kept) == len(colours):
        return labels, colours
    return np.concatenate([[0], number + 1]).astype(np.uint8)[labels], colours[kept]


def _may_be_highlight(shine: np.ndarray, body: np.ndarray) -> bool:
    """Tell whether a colour is more or less of another one, with white light added."""
    (_, lamp), rest = nnls(np.stack([body, WHITE], axis=1), shine)
    return bool(lamp > 0 and rest < UNLIKE * np.linalg.norm(shine))


def _borders(labels: np.ndarray, count: int) -> np.ndarray:
    """Share (k, k) of the outline of each colour, in rows, at which each other one lies."""
    wide = np.pad(labels, 1, mode="edge").ravel()
    y, x = np.divmod(places_of(labels), labels.shape[1])
    at = (y + 1) * (labels.shape[1] + 2) + x + 1
    met = np.zeros((count + 1) ** 2, int)
    for step in (-1, 1, -labels.shape[1] - 2, labels.shape[1] + 2):
        met += np.bincount(wide[at].astype(int) * (count + 1) + wide[at + step], minlength=len(met))
    square = met.reshape(count + 1, count + 1)
    np.fill_diagonal(square, 0)
    around = square[1:]
    return around[:, 1:] / np.maximum(around.sum(axis=1, keepdims=True), 1)


def _lies_on(labels: np.ndarray, shine: int, body: int, width: float) -> bool:
    """Tell whether one label lies close to another and is nowhere as wide as both together."""
    own = (labels == shine).view(np.uint8)
    reach = int(np.ceil(width)) + 2
    x, y, w, h = cv2.boundingRect(own)
    box = np.s_[max(y - reach, 0) : y + h + reach, max(x - reach, 0) : x + w + reach]
    own, both = own[box], (labels[box] == body).view(np.uint8)
    far = cv2.distanceTransform(1 - both, cv2.DIST_L2, 5)
    if (far[own > 0] < width / 2 + 1).mean() < NEAR:
        return False
    both |= own
    return _width(own, own, 90) < NARROW * _width(
        both, cv2.dilate(own, np.ones((5, 5), np.uint8)), 10
    )


def _width(mask: np.ndarray, where: np.ndarray, percentile: float) -> float:
    """Percentile of the width of a mask [px] along its middle, where that lies in another."""
    depth = cv2.distanceTransform(mask, cv2.DIST_L2, 5)
    summit = depth >= cv2.dilate(depth, np.ones((3, 3), np.uint8)) - 0.3
    found = depth[summit & (mask > 0) & (where > 0)]
    return 2 * float(np.percentile(found, percentile)) - 1 if len(found) else 0.0
