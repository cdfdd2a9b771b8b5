"""How much of each pixel a strand covers, bright or dark; depths and widths of strands.

A pixel is strand where its colour has moved at least half-way from the ground to the colour of the
nearest ridge (middle of a strand): the half-contrast edge.
"""

import math
import mmap
from itertools import product

import cv2
import numpy as np

from imaging.errors import Unmeasurable
from imaging.photo import Photo
from imaging.segment.depths import depth_of, nearest_level, places_of, summit

EDGE = 0.5  # fraction of the strand's contrast that marks its edge
NOISE_FACTOR = 4.0  # times the background's median contrast after a 3 x 3 mean; above is strand
MIN_CONTRAST = 6.0  # Lab units; about three just-noticeable differences
LEVEL = 0.4  # of the median contrast around ridges; between the ground's and the strands'
FAINT = 0.25  # of the strands' contrast; fainter is shadow, reflection or texture
SPARSE = 2**24  # pixels of all colours; from there on memory is saved, below it time
MIN_LENGTH = 5.0  # strand widths; a shorter blob is dirt
BUNDLED = 0.85  # of the width of all, of single strands; where they are less, many lie in bundles
NO_STRAND = (
    "what stands out from the background is no strand: it is not long or not of one colour; "
    "photograph strands of distinct colours on a plain surface"
)


def coverage_of(
    photo: Photo, contrast: np.ndarray, near: np.ndarray | None = None
) -> tuple[np.ndarray, float]:
    """Tell how much of each pixel a strand covers (h, w), and the typical strand width [px].

    Parameters
    ----------
    photo : Photo
    contrast : (h, w) array
        Distance of each pixel from the ground; what is ignored is made 0 in it.
    near : (h, w) bool array, optional
        Where alone strands may lie.

    Raises
    ------
    Unmeasurable
        When nothing stands out.
    """
    if photo.ignore is not None:
        contrast[photo.ignore] = 0
    smooth = cv2.blur(contrast, (3, 3))
    noise = float(np.median(smooth[::3, ::3]))  # the blur ties three neighbours together
    threshold = max(NOISE_FACTOR * noise, MIN_CONTRAST)
    if near is not None and near.any():
        threshold = max(min(threshold, LEVEL * float(np.median(smooth[near]))), MIN_CONTRAST)
    coarse = smooth > threshold
    if near is not None:
        coarse &= near
    if not coarse.any():
        raise Unmeasurable(
            f"{photo.source}: nothing stands out from the background by {threshold:.1f} Lab units; "
            "photograph the strands on a plain surface of another colour"
        )
    if near is None:
        seen = smooth.ravel()[places_of(coarse)]
        coarse = smooth > max(threshold, FAINT * float(np.percentile(seen, 75)))
    box = around_all(coarse)
    coverage = _against_ridge(contrast[box], smooth[box], coarse[box])
    strand = coverage > EDGE
    width = typical_width(depth_of(strand))
    long = _without_dirt(strand, width)
    if not long.any():
        raise Unmeasurable(f"{photo.source}: {NO_STRAND}")
    keep = cv2.dilate(long, np.ones((5, 5), np.uint8))
    whole = np.zeros(contrast.shape, np.float32)
    np.multiply(coverage, keep, out=whole[box])
    return whole, width


def around_all(mask: np.ndarray) -> tuple[slice, slice]:
    """Return rows and columns that hold all of a mask and, but at the picture's border, a rim."""
    x, y, w, h = cv2.boundingRect(mask.view(np.uint8))
    return np.s_[max(y - 2, 0) : y + h + 2, max(x - 2, 0) : x + w + 2]


def _against_ridge(contrast: np.ndarray, smooth: np.ndarray, coarse: np.ndarray) -> np.ndarray:
    """Contrast divided by that of the nearest ridge, clipped to [0, 1]."""
    ridge, at = summit(depth_of(coarse)), places_of(coarse)
    level = nearest_level(at, ridge, np.maximum(smooth.ravel()[ridge], 1e-6), coarse.shape)
    coverage = np.zeros(coarse.shape, np.float32)
    coverage.ravel()[at] = np.minimum(contrast.ravel()[at] / level, 1)
    return coverage


def typical_width(depth: np.ndarray) -> float:
    """Twice the depth of the medial axis (mean of its middle half), less half a pixel a side."""
    depths = np.sort(depth.ravel()[summit(depth, 1.2)])
    if len(depths) == 0:
        return 1.5
    quarter = len(depths) // 4
    return max(2 * float(depths[quarter : len(depths) - quarter].mean()) - 1, 1.5)


def strip_width(depth: np.ndarray) -> float:
    """Width of the strip whose depths have this mean square over mean (w/3, at pixel centres).

    Finer than the medial axis, which gives whole numbers, and thin rims of a wrong colour hardly
    count; but a single clamp would outweigh all strands.
    """
    inside = depth[depth > 0] - 0.5
    if len(inside) == 0:
        return 1.5
    return max(3 * float((inside**2).sum() / inside.sum()), 1.5)


def single_width(depth: np.ndarray) -> float:
    """Width of single strands where those of one colour lie side by side: what is broader left out.

    `strip_width` of what is not near anything 1.25 times as broad, again with the width so found
    until it stays, or a fifth of what is seen would be left; that of all, if it is hardly more.
    """
    whole = width = strip_width(depth)
    seen = depth > 0
    for _ in range(8):
        near = depth_of(~(depth > 0.625 * width + 0.5)) <= 0.625 * width + 1.5
        alone = seen & ~near
        if alone.sum() < 0.2 * seen.sum():
            break
        narrower = strip_width(depth[alone])
        if narrower > 0.98 * width:
            break
        width = narrower
    return width if width < BUNDLED * whole else whole


def _without_dirt(mask: np.ndarray, width: float) -> np.ndarray:
    """Drop blobs too short to be a strand (uint8 mask)."""
    long = mask.astype(np.uint8)
    outlines, nested = cv2.findContours(long, cv2.RETR_CCOMP, cv2.CHAIN_APPROX_SIMPLE)
    for outline, (_, _, _, within) in zip(
        outlines, () if nested is None else nested[0], strict=True
    ):
        if within < 0 and math.hypot(*cv2.boundingRect(outline)[2:]) <= MIN_LENGTH * width:
            cv2.drawContours(long, [outline], 0, 0, cv2.FILLED)
    return long


def depth_in_colour(labels: np.ndarray) -> np.ndarray:
    """Distance of each strand pixel to the nearest one that is not of its colour [px]."""
    lowest, highest = _around(labels)
    return depth_of((labels > 0) & (lowest == highest))


def _around(labels: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Lowest and highest label of the strand pixels in the 3 x 3 around each, 0 where none is."""
    kernel = np.ones((3, 3), np.uint8)
    lowest = cv2.erode(labels - np.uint8(1), kernel) + np.uint8(1)  # none (0) counts as 256
    return lowest, cv2.dilate(labels, kernel)


def shared_out(coverage: np.ndarray, labels: np.ndarray, count: int) -> np.ndarray:
    """Return the coverage of each colour (k, h, w), by who owns the nearest strand pixels.

    What nobody owns is taken out of `coverage`, in place: it is the sum.
    """
    membership = _sparse_zeros((count, *labels.shape))
    flat = membership.reshape(-1)
    lowest, highest = _around(labels)
    np.multiply(coverage, highest > 0, out=coverage)
    at = places_of(highest)
    colour = highest.ravel()[at].astype(np.intp) - 1
    several = lowest.ravel()[at] <= colour
    one = ~several
    flat[colour[one] * labels.size + at[one]] = coverage.ravel()[at[one]]
    at = at[several]
    neighbours = labels.ravel()[places_around(at, labels.shape)]
    share = coverage.ravel()[at] / (neighbours > 0).sum(axis=0)
    for own in neighbours.astype(np.intp):
        shown = own > 0
        flat[(own[shown] - 1) * labels.size + at[shown]] += share[shown]
    return membership


def places_around(at: np.ndarray, shape: tuple[int, ...]) -> np.ndarray:
    """Return places (9, n) in the flattened picture of the 3 x 3 pixels around each of these."""
    y, x = np.divmod(at, shape[1])
    rows = [(y + down).clip(0, shape[0] - 1) * shape[1] for down in (-1, 0, 1)]
    columns = [(x + right).clip(0, shape[1] - 1) for right in (-1, 0, 1)]
    return np.stack([row + column for row, column in product(rows, columns)])


def _sparse_zeros(shape: tuple[int, ...]) -> np.ndarray:
    """Zeros (float32) of which, where they are many, only pages of 4 KB written to take memory.

    numpy asks for pages of 2 MB, in which every row of a large picture is touched by some strand.
    But 2 us a page is more than it takes to write zeros to a small picture's memory.
    """
    if math.prod(shape) < SPARSE:
        return np.zeros(shape, np.float32)
    memory = mmap.mmap(-1, 4 * math.prod(shape), access=mmap.ACCESS_COPY)
    return np.frombuffer(memory, np.float32).reshape(shape)
