"""Which two colours are twisted together, and how much of each pixel either covers."""

from itertools import combinations

import cv2
import numpy as np
from numpy.typing import NDArray

from imaging.errors import Unmeasurable
from imaging.photo import Photo
from imaging.segment import Segmentation

Mask = NDArray[np.bool_]
TOUCH = 3  # px; strands whose masks come this close touch
PLATEAU = 2.0  # px; further inside than this a strand covers the whole pixel


def twisted_pair(
    segmentation: Segmentation, colours: tuple[int, int] | None = None
) -> tuple[int, int]:
    """Choose the two colours that touch each other along the greatest length.

    Parameters
    ----------
    segmentation : Segmentation
    colours : (i, j), optional
        The answer, if known: indices into ``segmentation.colours``.

    Raises
    ------
    Unmeasurable
        When there is one colour, a colour does not exist, or no two colours touch.
    """
    count = len(segmentation.membership)
    if colours is not None:
        if len(set(colours)) != 2 or not all(0 <= c < count for c in colours):
            raise Unmeasurable(
                f"colours {tuple(colours)} asked for; the picture has {count}, numbered from 0, "
                "and a helix needs two different ones"
            )
        return int(colours[0]), int(colours[1])
    if count < 2:
        raise Unmeasurable(
            f"{count} strand colour found; a double helix needs two strands of different colours"
        )
    masks = [m > 0.5 for m in segmentation.membership]
    touch = {pair: _contact(masks[pair[0]], masks[pair[1]]) for pair in combinations(range(count), 2)}
    best = max(touch, key=lambda pair: touch[pair])
    if touch[best] == 0:
        raise Unmeasurable(f"{count} strand colours found, but no two of them touch: no helix")
    return best


def rough_radius(masks: NDArray[np.bool_]) -> float:
    """Radius [px] of the largest discs that fit typically along the strands' middles."""
    ridges = []
    for mask in masks:
        depth = cv2.distanceTransform(np.pad(mask, 1).astype(np.uint8), cv2.DIST_L2, 5)
        top = cv2.dilate(depth, np.ones((5, 5), np.uint8))
        ridges.append(depth[(depth >= top) & (depth > 1)])
    ridge = np.concatenate(ridges)
    return float(np.percentile(ridge, 75)) if ridge.size else 0.0


def pair_membership(
    segmentation: Segmentation, pair: tuple[int, int], photo: Photo | None = None
) -> NDArray[np.float32]:
    """Coverage (2, h, w) of the two strands, their common border taken from the colours.

    A segmentation votes over a neighbourhood who owns a pixel, which rounds the border between the
    strands. Near that border the share is read off the photograph again: the pixel's colour,
    freed of brightness, between those of the two strands nearby.

    Parameters
    ----------
    segmentation : Segmentation
    pair : (i, j)
    photo : Photo, optional
        Without it the segmentation's membership is returned as it is.
    """
    membership = np.ascontiguousarray(segmentation.membership[list(pair)])
    if photo is None:
        return membership
    owned = np.stack([segmentation.labels == c + 1 for c in pair])
    coverage = _without_holes(membership.sum(axis=0), owned.any(axis=0))
    share = owned[0].astype(np.float32)
    depth = rough_radius(owned)
    near = _grown(owned[0], depth / 2) & _grown(owned[1], depth / 2)
    share[near] = _colour_share(photo, owned)[near]
    return np.stack([coverage * share, coverage * (1 - share)]).astype(np.float32)


def _contact(a: Mask, b: Mask) -> int:
    return int(np.sum(_grown(a, TOUCH) & b))


def _grown(mask: Mask, reach: float) -> Mask:
    size = 2 * max(int(round(reach)), 1) + 1
    disc = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (size, size))
    return cv2.dilate(mask.astype(np.uint8), disc) > 0


def _without_holes(coverage: NDArray[np.float32], inside: Mask) -> NDArray[np.float32]:
    """Full coverage well inside, where a highlight may have made it less."""
    depth = cv2.distanceTransform(inside.astype(np.uint8), cv2.DIST_L2, 5)
    return np.where(depth > PLATEAU, 1.0, coverage).astype(np.float32)


def _colour_share(photo: Photo, owned: NDArray[np.bool_]) -> NDArray[np.float32]:
    """Place of each pixel's hue between those of strand b (0) and strand a (1).

    (a*, b*)/(L + 16) does not change when the light is scaled; L is kept at a low weight for
    strands that are black, white or grey.
    """
    lab = cv2.cvtColor(photo.rgb(), cv2.COLOR_RGB2Lab)
    bright = lab[..., :1] + 16
    feature = np.concatenate([0.3 * np.log(bright), lab[..., 1:] / bright], axis=2)
    core = [cv2.erode(m.astype(np.uint8), np.ones((3, 3), np.uint8)) > 0 for m in owned]
    means = [np.median(feature[c if c.any() else m], axis=0) for c, m in zip(core, owned, strict=True)]
    axis = means[0] - means[1]
    share = (feature - means[1]) @ (axis / (axis @ axis))
    return np.clip(share, 0, 1).astype(np.float32)
