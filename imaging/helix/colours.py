"""Tell strands apart by colour where they touch all along.

`segment` learns its colours from the middles of strands. The middle of a tightly wound pair is the
border between its strands, where light mixes; here colours are learnt from all that is inside.
"""

from dataclasses import replace

import cv2
import numpy as np
from scipy.ndimage import gaussian_filter, map_coordinates, maximum_filter
from scipy.spatial import cKDTree

from imaging.photo import Photo
from imaging.segment import Segmentation

BRIGHTNESS = 0.5  # weight of log(L + 16) beside the hue
CELL = 0.06  # width of a histogram cell in hue units
SMOOTH = 1.5  # cells
VALLEY = 0.5  # two colours are separate if density falls below this share of the lesser between
LEAST = 0.03  # of all pixels; fewer are a reflection or dirt
INSIDE = 1.5  # px
CLEAR = 4.0  # times the ground's typical contrast; less is noise
LEAST_CLEAR = 4.0  # Lab units
RIM = 2.5  # px; over which a bright strand is blurred into the ground
MISSED = 0.02  # of the strands' area that a dim strand adds, at least


def with_dim_strands(segmentation: Segmentation) -> Segmentation:
    """Add to the strands what stands out as little as a dark strand before a dark cloth.

    Single pixels of a dark cloth scatter in Lab by as much as a dark strand stands out. As colours
    averaged over 3 x 3 pixels before their contrast is taken they do not: noise cancels. Left as it
    is unless whole stretches are found that touch the strands already known.
    """
    if segmentation.contrast is None:
        return segmentation
    known = segmentation.labels > 0
    beside = known if segmentation.blocks is None else known | segmentation.blocks
    seen = np.linalg.norm(cv2.blur(segmentation.contrast, (3, 3)), axis=2)
    level = max(CLEAR * float(np.median(seen[~beside])), LEAST_CLEAR)
    found = _without_rim(seen, (seen > level) | known)
    if segmentation.blocks is not None:
        found &= ~_grown(segmentation.blocks, RIM)
    _, blobs = cv2.connectedComponents((found | known).astype(np.uint8))
    added = np.isin(blobs, np.unique(blobs[known])) & found & ~known
    disc = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (3, 3))
    thick = cv2.morphologyEx(added.astype(np.uint8), cv2.MORPH_OPEN, disc)
    if thick.sum() < MISSED * known.sum():
        return segmentation
    return replace(segmentation, labels=np.where(added, 1, segmentation.labels))


def _without_rim(seen: np.ndarray, found: np.ndarray) -> np.ndarray:
    """Leave out the border's pixels that stand out half as much as others near them."""
    depth = cv2.distanceTransform(found.astype(np.uint8), cv2.DIST_L2, 5)
    brightest = maximum_filter(seen, 2 * int(RIM) + 1)
    return found & ((depth > RIM) | (seen > 0.5 * brightest))


def _grown(mask: np.ndarray, reach: float) -> np.ndarray:
    away = cv2.distanceTransform((~mask).astype(np.uint8), cv2.DIST_L2, 5)
    return away <= reach


def split_colours(photo: Photo, segmentation: Segmentation) -> Segmentation:
    """Label the strand pixels anew by the dense places of their colours.

    Hue is (a*, b*)/(L + 16), which shading hardly moves; log(L + 16) is kept at a lower weight for
    strands that are black, grey or white. A pixel takes the colour of the nearest dense place,
    then of most of its neighbourhood.

    Parameters
    ----------
    photo : Photo
    segmentation : Segmentation
        Its labels say where strands are; its colours are not used.

    Returns
    -------
    Segmentation
        Colours from the most to the least frequent.
    """
    strand = segmentation.labels > 0
    lab = cv2.GaussianBlur(cv2.cvtColor(photo.rgb(), cv2.COLOR_RGB2Lab), (0, 0), 0.8)
    depth = cv2.distanceTransform(strand.astype(np.uint8), cv2.DIST_L2, 5)
    feature = _features(lab[strand])
    core = depth[strand] > INSIDE
    centres = _dense_places(feature[core if core.any() else slice(None)])
    nearest = cKDTree(centres).query(feature)[1]
    labels = np.zeros(strand.shape, np.int32)
    labels[strand] = nearest + 1
    labels = _voted(labels, len(centres), strand, segmentation.width)
    masks = np.stack([labels == k + 1 for k in range(len(centres))])
    colours = np.array([np.median(lab[m], axis=0) if m.any() else np.zeros(3) for m in masks])
    return replace(
        segmentation, labels=labels, membership=masks.astype(np.float32), colours=colours
    )


def _features(lab: np.ndarray) -> np.ndarray:
    bright = lab[:, :1].astype(float) + 16
    return np.hstack([BRIGHTNESS * np.log(bright), lab[:, 1:] / bright])


def _dense_places(values: np.ndarray) -> np.ndarray:
    """Return the peaks (k, 3) of the values' density that valleys separate, highest first."""
    low = values.min(axis=0) - 3 * CELL
    cells = ((values - low) / CELL).astype(int)
    density = np.zeros(cells.max(axis=0) + 4)
    np.add.at(density, tuple(cells.T), 1.0)
    density = gaussian_filter(density, SMOOTH)
    tops = np.argwhere((density == maximum_filter(density, 3)) & (density > 0.02 * density.max()))
    tops = tops[np.argsort(-density[tuple(tops.T)])]
    peaks = [tops[0]]
    for top in tops[1:]:
        if all(_valley(density, top, peak) for peak in peaks):
            peaks.append(top)
    return _frequent(low + (np.array(peaks) + 0.5) * CELL, values)


def _valley(density: np.ndarray, lesser: np.ndarray, greater: np.ndarray) -> bool:
    """Whether density falls low enough on the straight way between two peaks."""
    way = lesser + np.linspace(0, 1, 25)[:, None] * (greater - lesser)
    return bool(map_coordinates(density, way.T, order=1).min() < VALLEY * density[tuple(lesser)])


def _frequent(centres: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Keep the centres that enough values are nearest to, the most frequent first."""
    share = np.bincount(cKDTree(centres).query(values)[1], minlength=len(centres)) / len(values)
    order = np.argsort(-share)
    return centres[order[share[order] > min(LEAST, share.max())]]


def _voted(labels: np.ndarray, count: int, strand: np.ndarray, width: float) -> np.ndarray:
    """Give every strand pixel the label of most of its neighbours within an eighth of a width."""
    side = 2 * max(int(width / 8), 1) + 1
    votes = [cv2.blur((labels == k + 1).astype(np.float32), (side, side)) for k in range(count)]
    return np.where(strand, np.argmax(votes, axis=0) + 1, 0).astype(np.int32)
