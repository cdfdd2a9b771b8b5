"""Which two colours are twisted together, and how much of each pixel either covers."""

from itertools import combinations

import cv2
import numpy as np

from imaging.errors import Unmeasurable
from imaging.photo import Photo
from imaging.segment import Segmentation

Mask = np.ndarray
TOUCH = 3  # px; strands whose masks come this close touch
EDGE = 3.0  # px; how far a segmentation's borders may be off
BAND = 128  # rows of a picture that are worked on at once
EVERYWHERE = (slice(None), slice(None))
SEAM = 0.4  # strand radii; a region no wider than twice that is a seam of mixed light, no strand
THIN = 2.5  # px; strands thinner than this have no middle to measure
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
    masks = [np.asarray(m > 0.5) for m in segmentation.membership]
    # The seam between two strands may have the colour of a third thing, such as a tine.
    typical = float(np.median([rough_radius(mask[None]) for mask in masks]))
    thick = masks if count == 2 else [_thick(mask, SEAM * typical) for mask in masks]
    touch = {
        pair: _contact(thick[pair[0]], thick[pair[1]]) for pair in combinations(range(count), 2)
    }
    best = max(touch, key=lambda pair: touch[pair])
    if touch[best] == 0:
        raise Unmeasurable(f"{count} strand colours found, but no two of them touch: no helix")
    return best


def rough_radius(masks: np.ndarray) -> float:
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
) -> np.ndarray:
    """Coverage (2, h, w) of the two strands, their edges read off the photograph.

    A segmentation knows what each region is; where its regions end it may be off by a pixel or two,
    by its votes, its smoothing or the shading of the strand. Near every border the coverage is
    therefore unmixed again: the place of a pixel's light between the colours a few pixels away on
    either side of the border. Light mixes linearly, so the coding (gamma 2.2) is undone first.

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
    r = rough_radius(owned)
    window = _window(np.any(owned, axis=0), int(4 * r) + 4)
    membership = np.zeros_like(membership)
    membership[:, *window] = _unmixed(
        linear_light(photo, window),
        owned[:, *window],
        segmentation.labels[window] == 0,
        max(0.5 * r, 1.5),
    )
    return membership


def linear_light(photo: Photo, window: tuple[slice, slice] = EVERYWHERE) -> np.ndarray:
    """Light (h, w, 3) in a window of a photograph, its coding (gamma 2.2) undone."""
    most = np.iinfo(photo.pixels.dtype).max
    return ((np.arange(most + 1, dtype=np.float32) / most) ** 2.2)[photo.pixels[window]]


def _window(mask: Mask, margin: int) -> tuple[slice, slice]:
    """Rows and columns that hold a mask and a margin."""
    spans = []
    for along in (1, 0):
        where = np.flatnonzero(mask.any(axis=along))
        first, last = (where[0], where[-1]) if where.size else (0, 0)
        spans.append(slice(max(int(first) - margin, 0), int(last) + margin + 1))
    return spans[0], spans[1]


def _unmixed(light: np.ndarray, owned: np.ndarray, bare: Mask, sigma: float) -> np.ndarray:
    """Coverage (2, h, w) of both strands from their colours and the background's nearby."""
    both: Mask = np.any(owned, axis=0)
    coverage, share = np.where(both, 1.0, 0.0).astype(np.float32), owned[0].astype(np.float32)
    rim = _grown(both, EDGE) & _grown(~both, EDGE)
    border = _grown(owned[0], EDGE) & _grown(owned[1], EDGE)
    for part, where, zero, one in ((coverage, rim, bare, both), (share, border, *owned[::-1])):
        low, high = (_local_colour(light, mask, sigma, where) for mask in (zero, one))
        part[where] = _place(light[where], low, high)
    return np.stack([coverage * share, coverage * (1 - share)])


def _local_colour(light: np.ndarray, mask: Mask, sigma: float, where: Mask) -> np.ndarray:
    """Mean colour (n, 3) of a region near some pixels, its own border left out."""
    core = cv2.distanceTransform(mask.astype(np.uint8), cv2.DIST_L2, 5) > PLATEAU
    some = core if core.any() else mask
    mean = np.array(cv2.mean(light, some.astype(np.uint8))[:3], np.float32)
    colour = np.empty_like(light)
    for rows in range(0, len(mask), BAND):
        band = slice(rows, rows + BAND)
        columns = np.flatnonzero(where[band].any(axis=0))
        if columns.size:
            inner = band, slice(columns[0], columns[-1] + 1)
            colour[inner] = _blurred(light, some, sigma, mean, inner)
    return colour[where]


def _blurred(
    light: np.ndarray, some: Mask, sigma: float, mean: np.ndarray, inner: tuple[slice, slice]
) -> np.ndarray:
    """Mean colour of what is near in a window; that of all where nothing is."""
    reach = int(4 * sigma) + 2  # of OpenCV's kernel
    low = [max(cut.start - reach, 0) for cut in inner]
    around = tuple(slice(first, cut.stop + reach) for first, cut in zip(low, inner, strict=True))
    weight = some[around].astype(np.float32)
    total = cv2.GaussianBlur(weight, (0, 0), sigma) + 1e-4
    colour = cv2.GaussianBlur(light[around] * weight[..., None], (0, 0), sigma) + 1e-4 * mean
    size = [cut.stop - cut.start for cut in inner]
    y, x = (slice(cut.start - first, cut.start - first + n)
            for cut, first, n in zip(inner, low, size, strict=True))  # fmt: skip
    return (colour / total[..., None])[y, x]


def _place(light: np.ndarray, zero: np.ndarray, one: np.ndarray) -> np.ndarray:
    """Place (n,) of each light (n, 3) between two colours, 0 to 1."""
    span = one - zero
    length = np.maximum((span**2).sum(axis=1), 1e-6)
    return np.clip(((light - zero) * span).sum(axis=1) / length, 0, 1)


def _contact(a: Mask, b: Mask) -> int:
    return int(np.sum(_grown(a, TOUCH) & b))


def _thick(mask: Mask, reach: float) -> Mask:
    """Leave out what is narrower than a disc of radius ``reach``."""
    size = 2 * int(round(reach)) + 1
    disc = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (size, size))
    return cv2.morphologyEx(mask.astype(np.uint8), cv2.MORPH_OPEN, disc) > 0


def _grown(mask: Mask, reach: float) -> Mask:
    size = 2 * max(int(round(reach)), 1) + 1
    disc = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (size, size))
    return cv2.dilate(mask.astype(np.uint8), disc) > 0
