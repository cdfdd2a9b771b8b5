"""Where in a photograph two strands of different colours wind round each other: the coarse look.

Strategy: what stands out from the ground in hue (else also in lightness), in a picture of at most
FINEST pixels, is cut into long bodies. The colours along each are sorted into a few; every two that
take turns on its midline are tried as the strands of a pair, and `imaging.helix.turning` tells how
much better they wind than lie still.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from itertools import combinations

import cv2
import numpy as np
from scipy.ndimage import gaussian_filter1d, median_filter

from imaging.errors import Unmeasurable
from imaging.helix.axis import Axis, bilinear, find_axis, smoothed
from imaging.helix.turning import PLACES, WIDE, Turning, turning
from imaging.photo import Photo
from imaging.segment import Segmentation
from imaging.segment.ground import ground_of

Array = np.ndarray
Mask = np.ndarray
FINEST = 1600  # px, of the picture looked at
WEIGHTS = ((0.0, 1.0, 1.0), (1.0, 1.0, 1.0))  # of log lightness and hue: without shadows, with
CLEAR = 5.0  # times the ground's typical contrast; less is noise
MOST = 8  # bodies, the largest, that are looked at
LONG = 5.0  # body widths; a shorter body is no pair
COLOURS = (3, 4)  # that the pixels of a band are sorted into, the ground's among them
RATIOS = (1.0, 1.5, 2.3)  # helix radius over strand radius
COARSE = 3  # every so many sections tell which colours and which R/r may be right
NEARLY = 0.8  # of the best there; the better ones are compared in all sections
SWAPS = 4  # changes of colour on the midline: two turns
GAIN = 2.5  # log evidence a strand radius; less is chance
AGREED = 0.85  # of what is seen of the strands, on average where they wind
AGREED_APART = 0.91  # the same of strands that lie apart, which fit more
TURNED = 1.5  # turns
PERHAPS = 1.0  # log evidence a strand radius; less is not even looked at again
FOUR = 0.06  # of the sections `crowded`; measured: pairs below 0.015, plies above 0.1
FOUR_APART = 0.15  # the same of strands that lie apart, which may run aslant: 0.06, 0.28


@dataclass(frozen=True)
class Pair:
    """Two strands that wind round each other, in the coarse picture.

    Attributes
    ----------
    labels : (h, w) uint8 array
        1 where strand a is seen, 2 where strand b is.
    axis : Axis
    s : (n,) array
        Arclength of the sections [px of the coarse picture].
    turning : Turning
    half_width : float
        Of the pair [px].
    step : float
        Pixels of the photograph to one of the coarse picture.
    crowd : float
        Share of the sections where the strands wind that show more than two can; see `crowded`.
    others : (h, w) bool array
        What else stands out from the ground.
    """

    labels: np.ndarray
    axis: Axis
    s: Array
    turning: Turning
    half_width: float
    step: float
    crowd: float
    others: Mask

    @property
    def turns(self) -> float:
        """Turns that the strands make, either way."""
        return float(np.abs(self.turning.phi[-1] - self.turning.phi[0]) / (2 * np.pi))

    @property
    def winds(self) -> bool:
        """Whether this is more than chance."""
        known = self.turning.winds
        agreed = AGREED if self.turning.ratio == 1 else AGREED_APART
        return (
            self.turns > TURNED
            and self.turning.gain > GAIN
            and float(self.turning.agreement[known].mean()) > agreed
        )

    @property
    def four(self) -> bool:
        """Whether this is a pair folded and plied back on itself."""
        return self.crowd > (FOUR if self.turning.ratio == 1 else FOUR_APART)


def find_pairs(photo: Photo) -> tuple[list[Pair], bool]:
    """Look for pairs of strands that wind round each other, those of the most turns first.

    Returns
    -------
    pairs : list of Pair
    perhaps : bool
        Whether, where there is none, something else swaps colours along it that may be one.
    """
    colours, step, bare = _above_ground(photo)
    found: list[Pair] = []
    perhaps = False
    for weights in WEIGHTS:
        for body, width in _bodies(colours, np.array(weights, np.float32)):
            pair = _best_pair(colours, body, width, step)
            perhaps |= pair is not None and pair.turning.gain > PERHAPS
            if pair is not None and pair.winds:
                found.append(pair)
        if found:
            break
    return sorted(found, key=lambda pair: (pair.four, -pair.turns)), perhaps


def coarse(photo: Photo) -> Photo:
    """Return the photograph in at most FINEST pixels a side; itself where it has no more."""
    step = max(photo.shape) / FINEST
    if step <= 1:
        return photo
    size = (round(photo.shape[1] / step), round(photo.shape[0] / step))
    pixels, bare = cv2.resize(photo.pixels, size, interpolation=cv2.INTER_AREA), photo.ignore
    if bare is not None:
        bare = cv2.resize(bare.astype(np.uint8), size, interpolation=cv2.INTER_NEAREST) > 0
    return Photo(pixels, photo.source, bare)


def segmentation_of(photo: Photo, pair: Pair) -> Segmentation:
    """Return the pair's two strands, a the first colour, and what else stands out."""
    size = photo.shape[1], photo.shape[0]
    labels, others = (
        cv2.resize(part.astype(np.uint8), size, interpolation=cv2.INTER_NEAREST)
        for part in (pair.labels, pair.others)
    )
    membership = np.stack([(labels == k).astype(np.float32) for k in (1, 2)])
    colours = np.stack([np.median(photo.eight_bits()[labels == k], axis=0) for k in (1, 2)])
    return Segmentation(labels, membership, colours, 2 * pair.half_width, blocks=others > 0)


def _above_ground(photo: Photo) -> tuple[Array, float, Mask | None]:
    """Colours (h, w, 3) above the ground's in the coarse picture, its step, what to ignore.

    Log lightness and (a, b)/(L + 16): the latter stay as they are in shadow.
    """
    small, step = coarse(photo), max(1.0, max(photo.shape) / FINEST)
    bare = small.ignore
    lab = small.lab()
    ground = ground_of(lab, bare)
    under = ground.rows(slice(0, len(lab)))
    lab = cv2.GaussianBlur(lab, (0, 0), 0.8)
    light, below = (np.maximum(part[..., :1], 0) + 16 for part in (lab, under))
    above = [0.5 * np.log(light / below), lab[..., 1:] / light - under[..., 1:] / below]
    colours = np.concatenate(above, axis=2)
    if bare is not None:
        colours[bare] = 0
    return colours, step, bare


def _bodies(colours: Array, weights: Array) -> Iterator[tuple[Mask, float]]:
    """Long things that stand out, the largest first, and their widths [px]."""
    contrast = np.sqrt(((colours * weights) ** 2).sum(axis=2))
    level = max(CLEAR * float(np.median(contrast)), _between(contrast[::3, ::3]))
    mask = (cv2.blur(contrast, (3, 3)) > level).astype(np.uint8)
    mask = cv2.morphologyEx(mask, cv2.MORPH_CLOSE, np.ones((3, 3), np.uint8))
    _, blobs, stats, _ = cv2.connectedComponentsWithStats(mask)
    for number in np.argsort(-stats[1:, cv2.CC_STAT_AREA])[:MOST] + 1:
        x, y, w, h = stats[number, :4]
        inside = np.pad(blobs[y : y + h, x : x + w] == number, 1)
        depth = cv2.distanceTransform(inside.astype(np.uint8), cv2.DIST_L2, 5)
        width = 2 * float(np.percentile(depth[inside], 95))
        if np.hypot(w, h) > LONG * width and width > 3:
            yield blobs == number, width


def _between(contrast: Array) -> float:
    """Level between two classes (Otsu 1979), of the root: most of the picture is ground."""
    count, edges = np.histogram(np.sqrt(contrast), bins=128)
    x, share = 0.5 * (edges[1:] + edges[:-1]), count / count.sum()
    below, mean = np.cumsum(share), np.cumsum(share * x)
    apart = (mean[-1] * below - mean) ** 2 / np.maximum(below * (1 - below), 1e-9)
    return float(x[np.argmax(apart)] ** 2)


def _best_pair(colours: Array, body: Mask, width: float, step: float) -> Pair | None:
    """Sort the colours along a body and return the two that wind best, if any do."""
    try:
        axis = smoothed(find_axis(body.astype(np.float32), width / 4), width)
    except Unmeasurable:
        return None
    u = np.linspace(-1.1 * width, 1.1 * width, 61)
    rows = np.unique(np.rint(np.arange(0, axis.s[-1], max(width / 12, 0.7))).astype(int))
    xy = axis.points[rows, None] + u[:, None] * axis.normals[rows, None]
    band = np.moveaxis(bilinear(np.moveaxis(colours, -1, 0), xy, nearest=True), 0, -1)
    tried = [
        (one, centres, two)
        for kinds, centres in _sorted_colours(band)
        for two in combinations(_strands_of(centres), 2)
        for one in _tries(kinds, two, u, axis.s[rows])
    ]
    if not tried:
        return None
    most = max(one.coarsely for one, *_ in tried)
    near = [some for some in tried if some[0].coarsely >= most - (1 - NEARLY) * abs(most)]
    best, centres, two = max(near, key=lambda some: some[0].finely)
    labels = _labelled(colours, body, centres, two)
    others = np.linalg.norm(colours, axis=2) > 0.5 * np.linalg.norm(centres[[*two]], axis=1).min()
    return Pair(
        labels, axis, axis.s[rows], best.found, best.half, step, best.crowd, others & (labels == 0)
    )  # fmt: skip


@dataclass(frozen=True)
class _Try:
    """Two colours taken for strands of a ``ratio`` R/r: what (n, PLACES, 3) the sections show.

    ``half`` is the pair's half width and ``apart`` the distance between sections [px].
    """

    shown: Array
    half: float
    apart: float
    ratio: float

    @cached_property
    def found(self) -> Turning:
        """How they turn."""
        return self._from_every(1)

    @property
    def crowd(self) -> float:
        """Share of the sections where they wind that are `crowded`."""
        winds = self.found.winds
        return float(crowded(self.shown)[winds].mean()) if winds.any() else 0.0

    @cached_property
    def finely(self) -> float:
        """Log evidence that they wind, per length."""
        return self.found.gain * (1 + self.ratio) / self.half

    @cached_property
    def coarsely(self) -> float:
        """Return the same from fewer sections."""
        return self._from_every(COARSE).gain * (1 + self.ratio) / self.half

    def _from_every(self, stride: int) -> Turning:
        step = stride * self.apart * (1 + self.ratio) / self.half
        return turning(self.shown[::stride], step, self.ratio)


def _strands_of(centres: Array) -> list[int]:
    """All colours but the ground's, the one nearest to nothing."""
    ground = int(np.linalg.norm(centres, axis=1).argmin())
    return [k for k in range(len(centres)) if k != ground]


def _sorted_colours(band: Array) -> Iterator[tuple[np.ndarray, Array]]:
    """Kinds (n, m) of colour, and their middles, by k-means."""
    values = np.ascontiguousarray(band.reshape(-1, 3), np.float32)
    stop = (cv2.TERM_CRITERIA_EPS + cv2.TERM_CRITERIA_MAX_ITER, 30, 1e-3)
    for count in COLOURS:
        cv2.setRNGSeed(1)
        none = np.empty(0, np.int32)
        _, kinds, centres = cv2.kmeans(values, count, none, stop, 3, cv2.KMEANS_PP_CENTERS)
        yield np.asarray(kinds).reshape(band.shape[:2]), np.asarray(centres)


def _tries(kinds: np.ndarray, two: tuple[int, int], u: Array, s: Array) -> list[_Try]:
    """Take two of the colours for strands, near and apart; none where they do not take turns."""
    spots = np.isin(kinds, two).astype(np.uint8)
    both = cv2.morphologyEx(spots, cv2.MORPH_OPEN, np.ones((3, 3), np.uint8)) > 0
    some = both.any(axis=1)
    if some.sum() < SWAPS:
        return []
    first, last = u[np.argmax(both, axis=1)], u[len(u) - 1 - np.argmax(both[:, ::-1], axis=1)]
    n, apart = np.arange(len(both)), (s[-1] - s[0]) / (len(s) - 1)
    middle = np.interp(n, n[some], (0.5 * (first + last))[some])
    half = max(float(np.percentile(0.5 * (last - first)[some], 70)), 2.0)
    middle = gaussian_filter1d(median_filter(middle, 5), 2 * half / apart, mode="nearest")
    places = middle[:, None] + np.linspace(-WIDE, WIDE, PLACES) * half
    column = np.rint((places - u[0]) / (u[1] - u[0])).astype(int)
    seen = np.take_along_axis(kinds, column.clip(0, len(u) - 1), axis=1)
    if swaps(seen == two[0], seen == two[1]) < SWAPS:
        return []
    shown = np.stack([seen == two[0], seen == two[1], ~np.isin(seen, two)], axis=-1)
    return [_Try(shown, half, apart, ratio) for ratio in RATIOS]


def crowded(shown: Array) -> Mask:
    """Sections (n, m, 3) in which one colour is seen on both sides of the other.

    Two strands of one width show that only where they run aslant: whatever the distance between
    them, the one behind sticks out on one side. Stretches of one colour in a row count once, as
    gloss may part them.
    """
    a, b = (cv2.morphologyEx(shown[..., k].astype(np.uint8), cv2.MORPH_OPEN, np.ones((3, 3)))
            for k in (0, 1))  # fmt: skip
    stretches, before = np.zeros((2, len(shown)), int)
    for here in (a.astype(int) - b).T:
        stretches += (here != 0) & (here != before)
        before = np.where(here != 0, here, before)
    return stretches > 2


def swaps(a: Mask, b: Mask) -> int:
    """How often the colour changes on the midline of sections (n, m)."""
    third = slice(a.shape[1] // 3 + 1, -(a.shape[1] // 3) - 1)
    side = a[:, third].sum(axis=1) - b[:, third].sum(axis=1).astype(int)
    side = np.sign(median_filter(side, 3))
    side = side[side != 0]
    return int(np.count_nonzero(np.diff(side)))


def _labelled(colours: Array, body: Mask, centres: Array, two: tuple[int, int]) -> np.ndarray:
    """Label the pixels in and around a body by the nearest of the colours (0, or 1 and 2)."""
    around = cv2.dilate(body.astype(np.uint8), np.ones((3, 3), np.uint8)) > 0
    values = colours[around]
    apart = [((values - centre) ** 2).sum(axis=1) for centre in centres]
    labels = np.zeros(body.shape, np.uint8)
    number = np.zeros(len(centres), np.uint8)
    number[list(two)] = 1, 2
    labels[around] = number[np.argmin(apart, axis=0)]
    return labels
