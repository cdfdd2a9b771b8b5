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
4. Every strand pixel takes the colour most of its neighbourhood, half a strand wide, votes for;
   a pixel where the colour changes (a rim, the border of two strands) has little say.
"""

from dataclasses import dataclass

import cv2
import numpy as np

from imaging.errors import Unmeasurable
from imaging.palette import colour_features, find_colours, unmixed, vote
from imaging.photo import Photo

EDGE = 0.5  # fraction of the strand's contrast that marks its edge
NOISE_FACTOR = 4.0  # times the background's median contrast after a 3 x 3 mean; above is strand
MIN_CONTRAST = 6.0  # Lab units; about three just-noticeable differences
FAINT = 0.25  # of the strands' contrast; fainter is shadow, reflection or texture
BORDER = 0.5  # change of (L, a, b)/(L + 16), summed, that tells two strands from shading
DEEPER = 1.25  # times the depth of a single strand; the border of two that touch lies deeper
BLOCK = 3.0  # strand widths; a patch of one colour this wide is no strand
JUST_NOTICED = 2.0  # Lab units; a smaller change of colour says nothing
MIN_LENGTH = 5.0  # strand widths; a shorter blob is dirt
NO_STRAND = (
    "what stands out from the background is no strand: it is not long or not of one colour; "
    "photograph strands of distinct colours on a plain surface"
)


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
    contrast : (h, w, 3) float32 array, optional
        Lab colour above the background's, as it would be in even light.
    """

    labels: np.ndarray
    membership: np.ndarray
    colours: np.ndarray
    width: float
    contrast: np.ndarray | None = None


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
    if not strand.any():
        raise Unmeasurable(f"{photo.source}: {NO_STRAND}")
    covered, ground = coverage[strand], background[strand]
    pure = unmixed(lab[strand], ground, covered)
    features = colour_features(pure, ground)
    at = _middles(lab, strand, width)
    number = np.cumsum(strand).reshape(strand.shape) - 1
    middle = number[at][strand[at]]
    centres, colours = find_colours(features[middle], pure[middle], width)
    if len(centres) == 0:
        raise Unmeasurable(f"{photo.source}: {NO_STRAND}")
    say = covered**4 / _change(lab, strand)
    labels = vote(features, strand, centres, width, say)
    depth = _depth(labels)
    together, width = width, _typical_width(depth)
    if width < together / DEEPER:  # strands that touch: votes came from too far
        labels = vote(features, strand, centres, width, say)
        depth = _depth(labels)
    labels = _without_blocks(labels, depth, width)
    width = _strip_width(depth[labels > 0])
    labels, colours = _with_enough(labels, colours, width)
    if len(colours) == 0:
        raise Unmeasurable(f"{photo.source}: {NO_STRAND}")
    membership = _membership(labels, coverage, len(colours))
    return Segmentation(labels, membership, colours, width, _contrast(lab, background))


def _contrast(lab: np.ndarray, background: np.ndarray) -> np.ndarray:
    """Colour above the background in even light: (L + 16, a, b) go with its cube root."""
    level = background[..., 0] + np.float32(16)
    above = cv2.subtract(lab, background)
    return cv2.multiply(above, cv2.merge([np.float32(level.mean()) / level] * 3), dst=above)


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
    away = lab - background
    contrast = np.sqrt(np.einsum("ijk,ijk->ij", away, away))
    if ignore is not None:
        contrast[ignore] = 0
    smooth = cv2.blur(contrast, (3, 3))
    noise = float(np.median(smooth[::3, ::3]))  # the blur ties three neighbours together
    threshold = max(NOISE_FACTOR * noise, MIN_CONTRAST)
    coarse = smooth > threshold
    if not coarse.any():
        raise Unmeasurable(
            f"{source}: nothing stands out from the background by {threshold:.1f} Lab units; "
            "photograph the strands on a plain surface of another colour"
        )
    coarse = smooth > max(threshold, FAINT * float(np.percentile(smooth[coarse], 75)))
    coverage = _against_ridge(contrast, smooth, coarse)
    width = _typical_width(_inside(coverage > EDGE))
    keep = _without_dirt(coverage > EDGE, width)
    return np.where(cv2.dilate(keep, np.ones((5, 5), np.uint8)) > 0, coverage, 0), width


def _against_ridge(contrast: np.ndarray, smooth: np.ndarray, coarse: np.ndarray) -> np.ndarray:
    """Contrast divided by that of the nearest ridge, clipped to [0, 1]."""
    ridge = _summit(_inside(coarse))
    _, nearest = cv2.distanceTransformWithLabels(
        (~ridge).astype(np.uint8), cv2.DIST_L2, 5, labelType=cv2.DIST_LABEL_PIXEL
    )
    level = np.zeros(nearest.max() + 1, np.float32)
    level[nearest[ridge]] = smooth[ridge]
    return np.where(coarse, np.clip(contrast / np.maximum(level[nearest], 1e-6), 0, 1), 0)


def _inside(mask: np.ndarray) -> np.ndarray:
    """Distance to the outside of a mask [px], 0 outside."""
    return cv2.distanceTransform(mask.astype(np.uint8), cv2.DIST_L2, 5)


def _summit(depth: np.ndarray) -> np.ndarray:
    """Medial axis: where the distance to the outside is a local maximum."""
    return (depth >= cv2.dilate(depth, np.ones((3, 3), np.uint8)) - 0.3) & (depth > 0)


def _middles(lab: np.ndarray, strand: np.ndarray, width: float) -> tuple[np.ndarray, np.ndarray]:
    """Rows and columns of pixels in the middle of strands.

    Those of the medial axis, unless it runs deeper than in a single strand and the colour half-way
    to the rim is another on one side than on the other: then two strands touch there, and the two
    sides are their middles.
    """
    depth = _inside(strand)
    y, x = np.nonzero(_summit(depth) & (depth > 0.35 * width))
    deep = depth[y, x]
    last = np.subtract(strand.shape, 1)
    angle = np.pi * np.arange(16)[:, None] / 8
    rows = np.clip(np.rint(y + deep / 2 * np.sin(angle)), 0, last[0]).astype(int)
    columns = np.clip(np.rint(x + deep / 2 * np.cos(angle)), 0, last[1]).astype(int)
    hue = _hue(cv2.blur(lab, (3, 3))[rows, columns])
    apart = np.abs(hue[:8] - hue[8:]).sum(axis=-1)
    border = (apart.max(axis=0) > BORDER) & (deep > DEEPER * np.percentile(deep, 20))
    at = apart.argmax(axis=0)[border], np.flatnonzero(border)
    opposite = at[0] + 8, at[1]
    return (
        np.concatenate([y[~border], rows[at], rows[opposite]]),
        np.concatenate([x[~border], columns[at], columns[opposite]]),
    )


def _change(lab: np.ndarray, strand: np.ndarray) -> np.ndarray:
    """Square of the colour's change per pixel [Lab units^2], noise included, in strand pixels."""
    y, x = np.nonzero(strand)
    height, width = strand.shape
    down = lab[np.minimum(y + 1, height - 1), x] - lab[np.maximum(y - 1, 0), x]
    right = lab[y, np.minimum(x + 1, width - 1)] - lab[y, np.maximum(x - 1, 0)]
    return ((down**2 + right**2) / 4).sum(axis=1) + JUST_NOTICED**2


def _hue(lab: np.ndarray) -> np.ndarray:
    return lab / (lab[..., :1] + 16)


def _typical_width(depth: np.ndarray) -> float:
    """Twice the depth of the medial axis (mean of its middle half), less half a pixel a side."""
    depths = np.sort(depth[_summit(depth) & (depth > 1.2)])
    if len(depths) == 0:
        return 1.5
    quarter = len(depths) // 4
    return max(2 * float(depths[quarter : len(depths) - quarter].mean()) - 1, 1.5)


def _strip_width(depth: np.ndarray) -> float:
    """Width of the strip whose depths have this mean square over mean (w/3, at pixel centres).

    Finer than the medial axis, which gives whole numbers, and thin rims of a wrong colour hardly
    count; but a single clamp would outweigh all strands.
    """
    inside = depth[depth > 0] - 0.5
    if len(inside) == 0:
        return 1.5
    return max(3 * float((inside**2).sum() / inside.sum()), 1.5)


def _without_dirt(mask: np.ndarray, width: float) -> np.ndarray:
    """Drop blobs too short to be a strand (uint8 mask)."""
    _, blobs, stats, _ = cv2.connectedComponentsWithStats(mask.astype(np.uint8))
    extent = np.hypot(stats[:, cv2.CC_STAT_WIDTH], stats[:, cv2.CC_STAT_HEIGHT])
    good = extent > MIN_LENGTH * width
    good[0] = False
    return good[blobs].astype(np.uint8)


def _depth(labels: np.ndarray) -> np.ndarray:
    """Distance of each strand pixel to the nearest one that is not of its colour [px]."""
    kernel = np.ones((3, 3), np.uint8)
    values = labels.astype(np.float32)
    highest = cv2.dilate(values, kernel)
    lowest = cv2.erode(np.where(labels > 0, values, np.inf), kernel)
    return _inside((labels > 0) & (highest == lowest))


def _without_blocks(labels: np.ndarray, depth: np.ndarray, width: float) -> np.ndarray:
    """Clear patches of one colour wider than strands are: a clamp, a card, a finger."""
    core = depth > 0.5 * BLOCK * width + 1
    if not core.any():
        return labels
    away = _inside(~core)
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
    membership = np.zeros((count, *labels.shape), np.float32)
    total = _around((labels > 0).astype(np.uint8))
    for colour in range(count):
        own = (labels == colour + 1).astype(np.uint8)
        x, y, w, h = cv2.boundingRect(own)
        box = np.s_[max(y - 1, 0) : y + h + 1, max(x - 1, 0) : x + w + 1]
        share = _around(own[box])
        # Only where the colour is: pages of a large picture that stay zero are never touched.
        at = np.nonzero(share)
        membership[colour][box][at] = coverage[box][at] * share[at] / total[box][at]
    return membership


def _around(mask: np.ndarray) -> np.ndarray:
    """Count the pixels of a mask in the 3 x 3 around each pixel."""
    return cv2.boxFilter(mask, -1, (3, 3), normalize=False, borderType=cv2.BORDER_REFLECT)
