"""Strands by their colours: which one each pixel shows; the number of colours is unknown.

Strategy:

1. Coverage tells strands from the ground, which is smooth (`imaging.segment.coverage`).
2. Colours are the dense places of the ridge pixels in a space where shading moves a colour little:
   (a, b)/(L + 16) is unchanged when the light is scaled, and log(L + 16) is kept at a low weight
   because strands may be black, white and grey.
3. Every strand pixel takes the colour most of its neighbourhood, half a strand wide, votes for;
   a pixel where the colour changes (a rim, the border of two strands) has little say.
"""

import cv2
import numpy as np

from imaging.errors import Unmeasurable
from imaging.photo import Photo
from imaging.segment.coverage import (
    EDGE,
    MIN_LENGTH,
    NO_STRAND,
    coverage_of,
    depth_in_colour,
    places_around,
    shared_out,
    single_width,
    strip_width,
    typical_width,
)
from imaging.segment.depths import depth_of, places_of, summit
from imaging.segment.gloss import without_highlights
from imaging.segment.ground import Ground, contrast_of, in_even_light
from imaging.segment.palette import colour_features, find_colours, unmixed, vote
from imaging.segment.segmentation import Segmentation
from imaging.segment.shadow import erase_shadows

GRAINY = 9.0  # Lab units from the ground, of half the picture; more is smoothed first
GRAIN = 1.0  # px, sd of that
RASTER = 20.0  # Lab units; no sensor's noise, but dots of black and white
BORDER = 0.5  # change of (L, a, b)/(L + 16), summed, that tells two strands from shading
DEEPER = 1.25  # times the depth of a single strand; the border of two that touch lies deeper
BLOCK = 3.0  # strand widths; a patch of one colour this wide is no strand
BUNDLE = 8.0  # the same, where all strands have one colour: a dozen may lie side by side
JUST_NOTICED = 2.0  # Lab units; a smaller change of colour says nothing


def by_colour(
    photo: Photo, lab: np.ndarray, ground: Ground, contrast: np.ndarray, ruling: np.ndarray | None
) -> Segmentation:
    """Separate strands from a smooth ground and from each other by colour.

    Parameters
    ----------
    photo : Photo
    lab : (h, w, 3) array
        Taken over: turned into colours in even light.
    ground : Ground
    contrast : (h, w) array
        Distance of each pixel from the ground; 0 where lines of a grid were erased.
    ruling : (h, w) bool array or None
        Those lines.
    """
    if GRAINY < float(np.median(contrast[::13, ::11])) < RASTER:
        lab = cv2.GaussianBlur(lab, (0, 0), GRAIN)  # before the modulus, which adds noise up
        contrast = contrast_of(lab, ground)
    coverage, width = coverage_of(photo, contrast)
    labels, colours, width, blocks = _labelled(lab, ground, coverage, width)
    shadow = erase_shadows(labels, colours, lab, contrast, ground, width)
    if shadow is not None:
        width = strip_width(depth_in_colour(labels)[labels > 0])
        labels, colours = _with_enough(labels, colours, width)
    if len(colours) == 0:
        raise Unmeasurable(f"{photo.source}: {NO_STRAND}")
    membership = shared_out(coverage, labels, len(colours))
    contrast = in_even_light(lab, ground)
    return Segmentation(
        labels, membership, colours, width, contrast, blocks, coverage, ruling, shadow
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
        labels, colours, depth = matt, bodies, depth_in_colour(matt)
        width = typical_width(depth)
    alone = len(colours) == 1
    blocks = _blocks(labels, depth, width, BUNDLE if alone else BLOCK)
    labels[blocks] = 0
    width = (
        single_width(np.where(labels > 0, depth, 0)) if alone else strip_width(depth[labels > 0])
    )
    labels, colours = _with_enough(labels, colours, width)
    return labels, colours, width, blocks


def _palette(
    lab: np.ndarray, ground: Ground, coverage: np.ndarray, width: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Features of the strand pixels and how much each has to say; colours, as features and Lab."""
    strand = coverage > EDGE
    at = places_of(strand)
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
    depth = depth_in_colour(labels)
    alone = typical_width(depth)
    if alone < width / DEEPER:  # strands that touch: votes came from too far
        labels = vote(features, strand, centres, alone, say)
        depth = depth_in_colour(labels)
    return labels, depth, alone


def _pixels(picture: np.ndarray, at: np.ndarray) -> np.ndarray:
    """Colours (n, 3) of the pixels at these places in the flattened picture."""
    return np.take(picture.reshape(-1, 3), at, axis=0)


def _middles(lab: np.ndarray, strand: np.ndarray, width: float) -> np.ndarray:
    """Places in the flattened picture of pixels in the middle of strands.

    Those of the medial axis, unless it runs deeper than in a single strand and the colour half-way
    to the rim is another on one side than on the other: then two strands touch there, and the two
    sides are their middles.
    """
    depth = depth_of(strand)
    at = summit(depth, 0.35 * width)
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
    around = places_around((rows * lab.shape[1] + columns).ravel(), lab.shape)
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


def _blocks(labels: np.ndarray, depth: np.ndarray, width: float, most: float) -> np.ndarray:
    """Patches of one colour wider than so many strands: a clamp, a card, a finger."""
    core = depth > 0.5 * most * width + 1
    if not core.any():
        return core
    return (labels > 0) & (depth_of(~core) <= 0.5 * most * width + 3)


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
