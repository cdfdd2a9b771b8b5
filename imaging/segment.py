"""Photograph -> which strand colour each pixel belongs to; the number of colours is unknown.

Strategy:

1. The background is the smooth surface most pixels lie on (robust quadratic in Lab, then a local
   mean of what is left); its brightness evens out the light.
2. A pixel is strand where its colour has moved at least half-way from the background to the colour
   of the nearest ridge (middle of a strand): the half-contrast edge, wherever the strand is bright
   or dark.
3. Colours are the dense places of the ridge pixels in a space where shading moves a colour little:
   (a, b)/(L + 16) is unchanged when the light is scaled, and log(L + 16) is kept at a low weight
   because strands may be black, white and grey.
4. Every strand pixel takes the colour most of its neighbourhood, half a strand wide, votes for.
"""

from dataclasses import dataclass

import cv2
import numpy as np
from scipy.stats import trim_mean

from imaging.errors import Unmeasurable
from imaging.palette import colour_features, find_colours, unmixed, vote
from imaging.photo import Photo

EDGE = 0.5  # fraction of the strand's contrast that marks its edge
NOISE_FACTOR = 4.0  # times the background's median contrast after a 3 x 3 mean; above is strand
MIN_CONTRAST = 6.0  # Lab units; about three just-noticeable differences
FAINT = 0.25  # of the strands' contrast; fainter is shadow, reflection or texture
BLOCK = 3.0  # strand widths; a patch of one colour this wide is no strand
MIN_LENGTH = 5.0  # strand widths; a shorter blob is dirt


@dataclass(frozen=True)
class Segmentation:
    """Which strand colour each pixel shows.

    Attributes
    ----------
    labels : (h, w) int32 array
        0 = background, k = colour k - 1 of `colours`; the strand on top wins.
    membership : (k, h, w) float32 array in [0, 1]
        How much of the pixel is covered by each colour; 0.5 is a strand's edge.
    colours : (k, 3) float array
        Lab colour of each strand in its middle (L 0..100).
    width : float
        Typical strand width [px].
    """

    labels: np.ndarray
    membership: np.ndarray
    colours: np.ndarray
    width: float


def segment(photo: Photo) -> Segmentation:
    """Separate the strands of a photograph from its background and from each other by colour.

    Parameters
    ----------
    photo : Photo

    Returns
    -------
    Segmentation

    Raises
    ------
    Unmeasurable
        When nothing stands out from the background.
    """
    ignore = photo.ignore
    lab = cv2.cvtColor(photo.rgb(), cv2.COLOR_RGB2Lab)
    background = background_of(lab, ignore)
    coverage, width = _coverage(photo.source, lab, background, ignore)
    strand = coverage > EDGE
    covered, ground = coverage[strand], background[strand]
    pure = unmixed(lab[strand], ground, covered)
    features = colour_features(pure, ground)
    middle = _ridge(strand, 0.35 * width)[strand]
    centres, colours = find_colours(features[middle], pure[middle], width)
    labels = _without_blocks(vote(features, strand, centres, width, covered**4), width)
    labels, colours = _with_enough(labels, colours, width)
    if len(colours) == 0:
        raise Unmeasurable(f"{photo.source}: what stands out from the background is no strand")
    return Segmentation(labels, _membership(labels, coverage, len(colours)), colours, width)


def background_of(lab: np.ndarray, ignore: np.ndarray | None = None) -> np.ndarray:
    """Return the smooth background under a Lab picture, shape (h, w, 3)."""
    height, width = lab.shape[:2]
    step = max(1, min(height, width) // 72)
    small = cv2.resize(lab, (width // step, height // step), interpolation=cv2.INTER_AREA)
    weight = np.ones(small.shape[:2], np.float32)
    if ignore is not None:
        hidden = cv2.resize(ignore.astype(np.float32), small.shape[1::-1])
        weight = (hidden < 0.01).astype(np.float32)
    surface, weight = _robust_quadratic(small, weight)
    rest = _local_mean(small - surface, weight, sigma=0.08 * min(small.shape[:2]))
    return cv2.resize(surface + rest, (width, height), interpolation=cv2.INTER_LINEAR)


def _robust_quadratic(small: np.ndarray, weight: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Fit a quadratic surface to each channel, by Tukey-weighted least squares from the mode."""
    height, width = weight.shape
    y, x = np.mgrid[-1 : 1 : height * 1j, -1 : 1 : width * 1j].astype(np.float32)
    basis = np.stack([np.ones_like(x), x, y, x * x, x * y, y * y], -1).reshape(-1, 6)
    values = small.reshape(-1, 3)
    prior = weight.ravel()
    surface = np.broadcast_to(_mode_colour(values[prior > 0]), values.shape)
    for _ in range(8):
        distance = np.linalg.norm(values - surface, axis=1)
        scale = max(4.7 * 1.5 * float(np.median(distance[prior > 0])), 3.0)
        robust = prior * np.clip(1 - (distance / scale) ** 2, 0, None) ** 2
        root = np.sqrt(robust)[:, None]
        surface = basis @ np.linalg.lstsq(basis * root, values * root, rcond=None)[0]
    return surface.reshape(small.shape), (robust > 0.25).reshape(height, width).astype(np.float32)


def _mode_colour(values: np.ndarray) -> np.ndarray:
    """Most common colour: the fullest cell of a coarse Lab grid, averaged."""
    cell = np.floor(values / 8).astype(int) + 32
    number = np.ravel_multi_index(tuple(cell.T), (64, 64, 64))
    return np.median(values[number == np.bincount(number).argmax()], axis=0)


def _local_mean(rest: np.ndarray, weight: np.ndarray, sigma: float) -> np.ndarray:
    total = cv2.GaussianBlur(weight, (0, 0), sigma)
    mean = cv2.GaussianBlur(rest * weight[..., None], (0, 0), sigma)
    return mean / (total[..., None] + 0.05)


def _coverage(
    source: str, lab: np.ndarray, background: np.ndarray, ignore: np.ndarray | None
) -> tuple[np.ndarray, float]:
    """How much of each pixel a strand covers (h, w), and the typical strand width [px]."""
    contrast = np.sqrt(((lab - background) ** 2).sum(axis=2))
    if ignore is not None:
        contrast[ignore] = 0
    smooth = cv2.blur(contrast, (3, 3))
    noise = float(np.median(smooth))
    threshold = max(NOISE_FACTOR * noise, MIN_CONTRAST)
    coarse = smooth > threshold
    if not coarse.any():
        raise Unmeasurable(
            f"{source}: nothing stands out from the background by {threshold:.1f} Lab units; "
            "photograph the strands on a plain surface of another colour"
        )
    coarse = smooth > max(threshold, FAINT * float(np.percentile(smooth[coarse], 75)))
    coverage = _against_ridge(contrast, smooth, coarse)
    width = _typical_width(coverage > EDGE)
    keep = _without_dirt(coverage > EDGE, width)
    return np.where(cv2.dilate(keep, np.ones((5, 5), np.uint8)) > 0, coverage, 0), width


def _against_ridge(contrast: np.ndarray, smooth: np.ndarray, coarse: np.ndarray) -> np.ndarray:
    """Contrast divided by that of the nearest ridge, clipped to [0, 1]."""
    ridge = _ridge(coarse, 0.0)
    _, nearest = cv2.distanceTransformWithLabels(
        (~ridge).astype(np.uint8), cv2.DIST_L2, 5, labelType=cv2.DIST_LABEL_PIXEL
    )
    level = np.zeros(nearest.max() + 1, np.float32)
    level[nearest[ridge]] = smooth[ridge]
    return np.where(coarse, np.clip(contrast / np.maximum(level[nearest], 1e-6), 0, 1), 0)


def _ridge(mask: np.ndarray, least: float) -> np.ndarray:
    """Medial axis: where the distance to the outside is a local maximum and above `least`."""
    depth = cv2.distanceTransform(mask.astype(np.uint8), cv2.DIST_L2, 5)
    top = cv2.dilate(depth, np.ones((3, 3), np.uint8))
    return (depth >= top - 0.3) & (depth > least) & mask


def _typical_width(mask: np.ndarray) -> float:
    """Twice the depth of the medial axis (mean of its middle half), less half a pixel a side."""
    depth = cv2.distanceTransform(mask.astype(np.uint8), cv2.DIST_L2, 5)
    ridge = _ridge(mask, 1.2)
    if not ridge.any():
        return 1.5
    return max(2 * float(trim_mean(depth[ridge], 0.25)) - 1, 1.5)


def _without_dirt(mask: np.ndarray, width: float) -> np.ndarray:
    """Drop blobs too short to be a strand (uint8 mask)."""
    _, blobs, stats, _ = cv2.connectedComponentsWithStats(mask.astype(np.uint8))
    extent = np.hypot(stats[:, cv2.CC_STAT_WIDTH], stats[:, cv2.CC_STAT_HEIGHT])
    good = extent > MIN_LENGTH * width
    good[0] = False
    return good[blobs].astype(np.uint8)


def _without_blocks(labels: np.ndarray, width: float) -> np.ndarray:
    """Clear patches of one colour wider than strands are: a clamp, a card, a finger."""
    kernel = np.ones((3, 3), np.uint8)
    narrow = labels.astype(np.float32)
    same = (cv2.dilate(narrow, kernel) == cv2.erode(narrow, kernel)) & (labels > 0)
    depth = cv2.distanceTransform(same.astype(np.uint8), cv2.DIST_L2, 5)
    core = depth > 0.5 * BLOCK * width
    if not core.any():
        return labels
    away = cv2.distanceTransform((~core).astype(np.uint8), cv2.DIST_L2, 5)
    return np.where(away > 0.5 * BLOCK * width + 3, labels, 0).astype(np.int32)


def _with_enough(
    labels: np.ndarray, colours: np.ndarray, width: float
) -> tuple[np.ndarray, np.ndarray]:
    """Drop colours of which less is left than the shortest strand covers; number the rest."""
    area = np.bincount(labels.ravel(), minlength=len(colours) + 1)[1:]
    kept = area >= MIN_LENGTH * width**2
    if kept.all():
        return labels, colours
    number = np.concatenate([[0], np.where(kept, np.cumsum(kept), 0)]).astype(np.int32)
    return number[labels], colours[kept]


def _membership(labels: np.ndarray, coverage: np.ndarray, count: int) -> np.ndarray:
    """Coverage of each colour: shared out by who owns the nearest strand pixels."""
    membership = np.empty((count, *labels.shape), np.float32)
    for colour in range(count):
        membership[colour] = cv2.blur((labels == colour + 1).astype(np.float32), (3, 3))
    total = membership.sum(axis=0)
    membership *= np.divide(coverage, total, out=np.zeros_like(total), where=total > 0)
    return membership
