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

import math
import mmap
from dataclasses import dataclass
from itertools import product

import cv2
import numpy as np

from imaging.errors import Unmeasurable
from imaging.photo import Photo
from imaging.segment.gloss import without_highlights
from imaging.segment.ground import Ground, contrast_of, ground_between, ground_of, in_even_light
from imaging.segment.palette import colour_features, find_colours, unmixed, vote
from imaging.segment.ridges import find_ridges, near_ridges
from imaging.segment.ruling import erase_ruling
from imaging.segment.shadow import erase_shadows

EDGE = 0.5  # fraction of the strand's contrast that marks its edge
NOISE_FACTOR = 4.0  # times the background's median contrast after a 3 x 3 mean; above is strand
GRAINY = 9.0  # Lab units from the ground, of half the picture; more is smoothed first
GRAIN = 1.0  # px, sd of that
RASTER = 20.0  # Lab units; no sensor's noise, but dots of black and white
MIN_CONTRAST = 6.0  # Lab units; about three just-noticeable differences
MEDIAN = 0.6745  # sds of a Gaussian; half of it lies within
LARGER = 4  # px; side of the pixels in which texture is told from noise
COVERED = 0.3  # of the picture; strands cover less, so that more is ground of another colour
LEVEL = 0.4  # of the median contrast around ridges; between the ground's and the strands'
FAINT = 0.25  # of the strands' contrast; fainter is shadow, reflection or texture
BORDER = 0.5  # change of (L, a, b)/(L + 16), summed, that tells two strands from shading
DEEPER = 1.25  # times the depth of a single strand; the border of two that touch lies deeper
BLOCK = 3.0  # strand widths; a patch of one colour this wide is no strand
JUST_NOTICED = 2.0  # Lab units; a smaller change of colour says nothing
SPARSE = 2**24  # pixels of all colours; from there on memory is saved, below it time
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
    labels : (h, w) uint8 array
        0 = background, k = colour k - 1 of `colours`; the strand on top wins.
    membership : (k, h, w) float32 array in [0, 1]
        How much of the pixel is covered by each colour; 0.5 is a strand's edge.
    colours : (k, 3) float array
        Lab colour of each strand in its middle (L 0..100).
    width : float
        Typical strand width [px].
    contrast : (h, w, 3) float32 array, optional
        Lab colour above the background's, as it would be in even light.
    blocks : (h, w) bool array, optional
        What stands out but is too wide to be a strand: a clamp, a card, a thick tine.
    coverage : (h, w) float32 array, optional
        How much of the pixel is covered by any strand: the sum of `membership`.
    ruling : (h, w) bool array, optional
        Lines printed on the ground that were taken for ground.
    shadow : (h, w) bool array, optional
        What was taken for shadow on the ground.
    ridge : (h, w) float32 array, optional
        How far what runs along here stands out from both its sides, in sds of what the ground's
        texture makes (`imaging.segment.ridges`); None on a ground without texture.
    """

    labels: np.ndarray
    membership: np.ndarray
    colours: np.ndarray
    width: float
    contrast: np.ndarray | None = None
    blocks: np.ndarray | None = None
    coverage: np.ndarray | None = None
    ruling: np.ndarray | None = None
    shadow: np.ndarray | None = None
    ridge: np.ndarray | None = None


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
    lab = photo.lab()
    ground = ground_of(lab, photo.ignore)
    contrast = contrast_of(lab, ground)
    ruling = erase_ruling(lab, contrast, ground)
    near = ridge = None
    if _hides_strands(lab, ground):
        ridges = find_ridges(lab, photo.ignore)
        ridge = ridges.response
        near, width = near_ridges(ridges)
        ground = ground_between(lab, near, width, ground)
        contrast = contrast_of(lab, ground)
    elif GRAINY < float(np.median(contrast[::13, ::11])) < RASTER:
        lab = cv2.GaussianBlur(lab, (0, 0), GRAIN)  # before the modulus, which adds noise up
        contrast = contrast_of(lab, ground)
    coverage, width = _coverage(photo.source, contrast, photo.ignore, near)
    labels, colours, width, blocks = _labelled(lab, ground, coverage, width)
    shadow = erase_shadows(labels, colours, lab, contrast, ground, width)
    if shadow is not None:
        width = _strip_width(_depth(labels)[labels > 0])
        labels, colours = _with_enough(labels, colours, width)
    if len(colours) == 0:
        raise Unmeasurable(f"{photo.source}: {NO_STRAND}")
    membership = _shared_out(coverage, labels, len(colours))
    contrast = in_even_light(lab, ground)
    return Segmentation(
        labels, membership, colours, width, contrast, blocks, coverage, ruling, shadow, ridge
    )


def _labelled(
    lab: np.ndarray, ground: Ground, coverage: np.ndarray, width: float
) -> tuple[np.ndarray, np.ndarray, float, np.ndarray]:
    """Colour of each pixel (h, w), colours, width of the strands, and what is no strand (h, w)."""
    strand = coverage > EDGE
    features, say, centres, colours = _palette(lab, ground, coverage, width)
    if len(colours) == 0:
        return np.zeros(strand.shape, np.uint8), colours, width, np.zeros_like(strand)
    labels, depth, width = _voted(features, strand, centres, width, say)
    matt, bodies = without_highlights(labels, colours, width)
    if len(bodies) < len(colours):
        labels, colours, depth = matt, bodies, _depth(matt)
        width = _typical_width(depth)
    blocks = _blocks(labels, depth, width)
    labels[blocks] = 0
    width = _strip_width(depth[labels > 0])
    labels, colours = _with_enough(labels, colours, width)
    return labels, colours, width, blocks


def _palette(
    lab: np.ndarray, ground: Ground, coverage: np.ndarray, width: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Features of the strand pixels and how much each has to say; colours, as features and Lab."""
    strand = coverage > EDGE
    at = np.flatnonzero(strand)
    covered = coverage.ravel()[at]
    seen = _pixels(lab, at)
    under = ground.at(at)
    pure = unmixed(seen, under, covered)
    features = colour_features(pure, under)
    middle = _middles(lab, strand, width)
    middle = np.searchsorted(at, middle[strand.ravel()[middle]])
    centres, colours = find_colours(features[middle], pure[middle], width)
    return features, covered**4 / _change(lab, at), centres, colours


def _voted(
    features: np.ndarray, strand: np.ndarray, centres: np.ndarray, width: float, say: np.ndarray
) -> tuple[np.ndarray, np.ndarray, float]:
    """Colour of each pixel, depth within its colour (h, w both), and width of single strands."""
    labels = vote(features, strand, centres, width, say)
    depth = _depth(labels)
    alone = _typical_width(depth)
    if alone < width / DEEPER:  # strands that touch: votes came from too far
        labels = vote(features, strand, centres, alone, say)
        depth = _depth(labels)
    return labels, depth, alone


def _pixels(picture: np.ndarray, at: np.ndarray) -> np.ndarray:
    """Colours (n, 3) of the pixels at these places in the flattened picture."""
    return np.take(picture.reshape(-1, 3), at, axis=0)


def _coverage(
    source: str, contrast: np.ndarray, ignore: np.ndarray | None, near: np.ndarray | None
) -> tuple[np.ndarray, float]:
    """How much of each pixel a strand covers (h, w), and the typical strand width [px]."""
    if ignore is not None:
        contrast[ignore] = 0
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
            f"{source}: nothing stands out from the background by {threshold:.1f} Lab units; "
            "photograph the strands on a plain surface of another colour"
        )
    coarse = smooth > max(threshold, FAINT * float(np.percentile(smooth[coarse], 75)))
    box = _around_all(coarse)
    coverage = _against_ridge(contrast[box], smooth[box], coarse[box])
    strand = coverage > EDGE
    width = _typical_width(_inside(strand))
    long = _without_dirt(strand, width)
    if not long.any():
        raise Unmeasurable(f"{source}: {NO_STRAND}")
    keep = cv2.dilate(long, np.ones((5, 5), np.uint8))
    whole = np.zeros(contrast.shape, np.float32)
    np.multiply(coverage, keep, out=whole[box])
    return whole, width


def _hides_strands(lab: np.ndarray, ground: Ground) -> bool:
    """Tell a ground whose texture, or patches, would hide strands or be taken for some.

    Looked at in larger pixels, over which a sensor's noise is averaged; what is left of it is
    known from how single pixels differ from those around them.
    """
    size = [max(1, side // LARGER) for side in lab.shape[1::-1]]
    seen = cv2.resize(lab, size, interpolation=cv2.INTER_AREA)
    under = cv2.resize(ground.coarse, size, interpolation=cv2.INTER_LINEAR)
    off = np.linalg.norm(seen - under, axis=-1)
    texture = max(float(np.median(off)) ** 2 - (_noise(lab) / LARGER) ** 2, 0) ** 0.5
    threshold = NOISE_FACTOR * texture
    return threshold > MIN_CONTRAST or float((off > MIN_CONTRAST).mean()) > COVERED


def _noise(lab: np.ndarray) -> float:
    """Sd of what differs from pixel to pixel [Lab units], all three channels together."""
    if min(lab.shape[:2]) < 3:
        return 0.0
    around = (lab[1:-1, :-2] + lab[1:-1, 2:] + lab[:-2, 1:-1] + lab[2:, 1:-1]) / 4
    off = np.median(np.abs(lab[1:-1, 1:-1] - around).reshape(-1, 3)[::7], axis=0)
    return float(np.linalg.norm(off)) / (MEDIAN * 1.25**0.5)  # a mean of four adds a quarter


def _around_all(mask: np.ndarray) -> tuple[slice, slice]:
    """Rows and columns that hold all of a mask and, but at the picture's border, a rim."""
    x, y, w, h = cv2.boundingRect(mask.view(np.uint8))
    return np.s_[max(y - 2, 0) : y + h + 2, max(x - 2, 0) : x + w + 2]


def _against_ridge(contrast: np.ndarray, smooth: np.ndarray, coarse: np.ndarray) -> np.ndarray:
    """Contrast divided by that of the nearest ridge, clipped to [0, 1]."""
    ridge = _summit(_inside(coarse))
    off = np.ones(coarse.shape, np.uint8)
    off.ravel()[ridge] = 0
    _, nearest = cv2.distanceTransformWithLabels(
        off, cv2.DIST_L2, 5, labelType=cv2.DIST_LABEL_PIXEL
    )
    nearest = nearest.ravel()
    level = np.full(len(ridge) + 1, 1e-6, np.float32)
    level[nearest[ridge]] = np.maximum(smooth.ravel()[ridge], np.float32(1e-6))
    at = np.flatnonzero(coarse)
    coverage = np.zeros(coarse.shape, np.float32)
    coverage.ravel()[at] = np.minimum(contrast.ravel()[at] / level[nearest[at]], 1)
    return coverage


def _inside(mask: np.ndarray) -> np.ndarray:
    """Distance to the outside of a mask [px], 0 outside."""
    return cv2.distanceTransform(mask.view(np.uint8), cv2.DIST_L2, 5)


def _summit(depth: np.ndarray, least: float = 0.0) -> np.ndarray:
    """Medial axis deeper than `least`: places in the flattened picture of the deepest around."""
    highest = cv2.dilate(depth, np.ones((3, 3), np.uint8)).ravel()
    at = np.flatnonzero(depth > least)
    return at[depth.ravel()[at] >= highest[at] - np.float32(0.3)]


def _middles(lab: np.ndarray, strand: np.ndarray, width: float) -> np.ndarray:
    """Places in the flattened picture of pixels in the middle of strands.

    Those of the medial axis, unless it runs deeper than in a single strand and the colour half-way
    to the rim is another on one side than on the other: then two strands touch there, and the two
    sides are their middles.
    """
    depth = _inside(strand)
    at = _summit(depth, 0.35 * width)
    deep = depth.ravel()[at]
    wide = deep > DEEPER * np.percentile(deep, 20)
    y, x = np.divmod(at[wide], strand.shape[1])
    last = np.subtract(strand.shape, 1)
    angle = np.pi * np.arange(16)[:, None] / 8
    rows = np.clip(np.rint(y + deep[wide] / 2 * np.sin(angle)), 0, last[0]).astype(int)
    columns = np.clip(np.rint(x + deep[wide] / 2 * np.cos(angle)), 0, last[1]).astype(int)
    hue = _hue(_mean_around(lab, rows, columns))
    apart = np.abs(hue[:8] - hue[8:]).sum(axis=-1)
    border = np.flatnonzero(apart.max(axis=0) > BORDER)
    side = apart.argmax(axis=0)[border]
    aside = rows * strand.shape[1] + columns
    single = np.delete(at, np.flatnonzero(wide)[border])
    return np.concatenate([single, aside[side, border], aside[side + 8, border]])


def _mean_around(lab: np.ndarray, rows: np.ndarray, columns: np.ndarray) -> np.ndarray:
    """Mean colour (..., 3) of the 3 x 3 pixels around each of these."""
    around = _places_around((rows * lab.shape[1] + columns).ravel(), lab.shape)
    return np.mean([_pixels(lab, places) for places in around], axis=0).reshape(*rows.shape, 3)


def _change(lab: np.ndarray, at: np.ndarray) -> np.ndarray:
    """Square of the colour's change per pixel [Lab units^2], noise included, at these places."""
    height, width = lab.shape[:2]
    y, x = np.divmod(at, width)
    below, above = np.minimum(y + 1, height - 1) * width + x, np.maximum(y - 1, 0) * width + x
    right, left = at + (x + 1 < width), at - (x > 0)
    down = _pixels(lab, below) - _pixels(lab, above)
    across = _pixels(lab, right) - _pixels(lab, left)
    return (down**2 + across**2) @ np.full(3, 0.25, np.float32) + np.float32(JUST_NOTICED**2)


def _hue(lab: np.ndarray) -> np.ndarray:
    return lab / (lab[..., :1] + 16)


def _typical_width(depth: np.ndarray) -> float:
    """Twice the depth of the medial axis (mean of its middle half), less half a pixel a side."""
    depths = np.sort(depth.ravel()[_summit(depth, 1.2)])
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
    long = mask.astype(np.uint8)
    outlines, nested = cv2.findContours(long, cv2.RETR_CCOMP, cv2.CHAIN_APPROX_SIMPLE)
    for outline, (_, _, _, within) in zip(
        outlines, () if nested is None else nested[0], strict=True
    ):
        if within < 0 and math.hypot(*cv2.boundingRect(outline)[2:]) <= MIN_LENGTH * width:
            cv2.drawContours(long, [outline], 0, 0, cv2.FILLED)
    return long


def _depth(labels: np.ndarray) -> np.ndarray:
    """Distance of each strand pixel to the nearest one that is not of its colour [px]."""
    lowest, highest = _around(labels)
    return _inside((labels > 0) & (lowest == highest))


def _around(labels: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Lowest and highest label of the strand pixels in the 3 x 3 around each, 0 where none is."""
    kernel = np.ones((3, 3), np.uint8)
    lowest = cv2.erode(labels - np.uint8(1), kernel) + np.uint8(1)  # none (0) counts as 256
    return lowest, cv2.dilate(labels, kernel)


def _blocks(labels: np.ndarray, depth: np.ndarray, width: float) -> np.ndarray:
    """Patches of one colour wider than strands are: a clamp, a card, a finger."""
    core = depth > 0.5 * BLOCK * width + 1
    if not core.any():
        return core
    return (labels > 0) & (_inside(~core) <= 0.5 * BLOCK * width + 3)


def _with_enough(
    labels: np.ndarray, colours: np.ndarray, width: float
) -> tuple[np.ndarray, np.ndarray]:
    """Drop colours of which less is left than the shortest strand covers; number the rest."""
    area = np.bincount(labels[labels > 0], minlength=len(colours) + 1)[1:]
    kept = area >= MIN_LENGTH * width**2
    if kept.all():
        return labels, colours
    number = np.concatenate([[0], np.where(kept, np.cumsum(kept), 0)]).astype(np.uint8)
    return number[labels], colours[kept]


def _shared_out(coverage: np.ndarray, labels: np.ndarray, count: int) -> np.ndarray:
    """Coverage of each colour (k, h, w), by who owns the nearest strand pixels.

    What nobody owns is taken out of `coverage`, in place: it is the sum.
    """
    membership = _sparse_zeros((count, *labels.shape))
    flat = membership.reshape(-1)
    lowest, highest = _around(labels)
    coverage[highest == 0] = 0
    at = np.flatnonzero(highest > 0)
    colour = highest.ravel()[at].astype(np.intp) - 1
    several = lowest.ravel()[at] <= colour
    one = ~several
    flat[colour[one] * labels.size + at[one]] = coverage.ravel()[at[one]]
    at = at[several]
    neighbours = labels.ravel()[_places_around(at, labels.shape)]
    share = coverage.ravel()[at] / (neighbours > 0).sum(axis=0)
    for own in neighbours.astype(np.intp):
        shown = own > 0
        flat[(own[shown] - 1) * labels.size + at[shown]] += share[shown]
    return membership


def _places_around(at: np.ndarray, shape: tuple[int, ...]) -> np.ndarray:
    """Places (9, n) in the flattened picture of the 3 x 3 pixels around each of these."""
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
