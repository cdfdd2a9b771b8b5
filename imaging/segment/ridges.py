"""Ridges: where something long and narrow lies that the ground's own texture does not explain.

At each point, for each of sixteen directions and some widths, the colour C averaged along the
direction is compared with the colours A and B beside it, a width away on either side:

    response = min(|C - A|, |C - B|) cos(angle between C - A and C - B) - |A - B| / 2,

which is nothing at the edge of an area: a strand has two sides. Lengths and angles are taken in
units of the ground's own differences C - (A + B)/2 in that direction and at that width (their
covariance, from the three fifths of the picture that differ least), so that grain, weave and gravel
raise no more alarms along their own direction and in their own colours than plain paper does.
Where the sides are unlike it is taken of (a, b) alone as well, and the greater counts: a strand
with its shadow on one side has two unlike sides, but of one hue.
"""

from typing import NamedTuple

import cv2
import numba
import numpy as np

Array = np.ndarray

UNIT = 5  # px; width of a strand in the shrunken picture that is looked at
WAYS = 16  # directions
ROOT = 2**0.5  # from one width to the next
WIDEST = 1 / 10  # of the picture's shorter side
FINEST = 1 / 400  # of the square root of the picture's area; thinner is seen at this width too
JUST_NOTICED = 1.5  # Lab units; smaller differences are no texture
QUIET = 0.6  # of the samples, taken for ground
QUIET_SHARE = 0.36  # of the variance of a Gaussian in three dimensions that these have
SAMPLES = 2500  # at which the ground is looked at, in each direction and width
BROADER = 1.2  # times the response of a narrower ridge that one seen at a larger width must have
UNLIKE = np.float32(0.5)  # of a contrast, by which the sides differ where one lies in shadow
LOW = 4.0  # sds; a ridge exceeds it throughout
RIM = UNIT + 4  # px around that picture, as far as any mean reaches
AHEAD = 1.6 * np.arange(-2, 3)  # px along a direction over which colours are averaged
SHARE = (np.exp(-(AHEAD**2) / 18) / np.exp(-(AHEAD**2) / 18).sum()).astype(np.float32)


class Ridges(NamedTuple):
    """What looks like a strand, each (h, w): response [sds of the ground], direction, width [px].

    Directions count in sixteenths of half a turn, from x towards y.
    """

    response: Array
    way: Array
    width: Array


def find_ridges(lab: Array, ignore: Array | None = None) -> Ridges:
    """Look for ridges in a Lab picture (h, w, 3), at all widths.

    Returns
    -------
    Ridges
    """
    shape = lab.shape[:2]
    found = Ridges(
        np.zeros(shape, np.float32), np.zeros(shape, np.uint8), np.zeros(shape, np.float32)
    )
    for width in _widths(shape):
        _, response, way = at_width(lab, width)
        response = cv2.resize(response, shape[::-1])
        way = cv2.resize(way, shape[::-1], interpolation=cv2.INTER_NEAREST)
        higher = response > BROADER * found.response
        found.response[higher], found.way[higher] = response[higher], way[higher]
        found.width[higher] = width
    if ignore is not None:
        found.response[ignore] = 0
    return found


def _widths(shape: tuple[int, ...]) -> list[float]:
    finest = max(float(UNIT), FINEST * float(np.sqrt(shape[0] * shape[1])))
    count = int(np.log(max(WIDEST * min(shape) / finest, 1)) / np.log(ROOT)) + 1
    return [finest * ROOT**step for step in range(count)]


def at_width(lab: Array, width: float) -> tuple[Array, Array, Array]:
    """Look for ridges of one width, in the picture shrunken so that these are UNIT pixels wide.

    Returns
    -------
    small : (h, w, 3) array
        That picture.
    response, way : (h, w) arrays
        As those of Ridges.
    """
    size = [max(8, round(side * UNIT / width)) for side in lab.shape[1::-1]]
    small = lab if width == UNIT else cv2.resize(lab, size, interpolation=cv2.INTER_AREA)
    small = cv2.GaussianBlur(small, (0, 0), 0.8)
    hue_first = np.ascontiguousarray(small[..., [1, 2, 0]])
    rimmed = cv2.copyMakeBorder(hue_first, RIM, RIM, RIM, RIM, cv2.BORDER_REPLICATE)
    differences = _differences(rimmed, *_grid(small.shape))
    whiten = np.stack([_whitening(part) for part in differences]).astype(np.float32)
    away = small - cv2.GaussianBlur(small, (0, 0), UNIT)
    response = np.zeros(small.shape[:2], np.float32)
    way = np.zeros(small.shape[:2], np.uint8)
    rows, columns = np.nonzero((away**2).sum(axis=-1) > JUST_NOTICED**2)
    _respond(rimmed, rows, columns, ALONG, ASIDE, SHARE, whiten, response, way)
    return small, response, way


def _grid(shape: tuple[int, ...]) -> tuple[Array, Array]:
    """Rows and columns of SAMPLES places spread evenly over a picture."""
    step = max(1, int(np.sqrt(shape[0] * shape[1] / SAMPLES)))
    y, x = np.mgrid[step // 2 : shape[0] : step, step // 2 : shape[1] : step]
    return y.ravel(), x.ravel()


def _differences(rimmed: Array, rows: Array, columns: Array) -> Array:
    """C - (A + B)/2 at these places, in each direction (WAYS, n, 3)."""
    found = np.empty((WAYS, len(rows), 3), np.float32)
    _differ(rimmed, rows, columns, ALONG, ASIDE, SHARE, found)
    return found


def _whitening(difference: Array) -> Array:
    """Matrix (3, 3), lower triangular, that makes the quiet ones among differences unit normal."""
    floor = JUST_NOTICED**2 * np.eye(3)
    quiet = difference
    for _ in range(3):
        covariance = quiet.T @ quiet / len(quiet)
        if len(quiet) < len(difference):
            covariance = covariance / QUIET_SHARE
        whiten = np.linalg.inv(np.linalg.cholesky(covariance + floor))
        square = ((difference @ whiten.T) ** 2).sum(axis=1)
        few = int(QUIET * len(difference))
        quiet = difference[np.argpartition(square, few)[: few + 1]]
    return whiten


def _taps() -> tuple[Array, Array]:
    """Return steps (x, y): along directions (WAYS, 5, 2), and aside by none, a width, minus one."""
    angle = np.pi * np.arange(WAYS) / WAYS
    way = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    along = np.rint(AHEAD[None, :, None] * way[:, None]).astype(np.int64)
    aside = np.rint(UNIT * np.stack([-way[:, 1], way[:, 0]], axis=1)).astype(np.int64)
    return along, np.stack([np.zeros_like(aside), aside, -aside], axis=1)


ALONG, ASIDE = _taps()


@numba.njit(cache=True)
def _three_means(picture, y, x, along, aside, share, mean):
    """Means (3, 3) along a direction: at y, x, and beside it on either side."""
    mean[:] = 0
    for side in range(3):
        v, u = y + RIM + aside[side, 1], x + RIM + aside[side, 0]
        for k in range(len(along)):
            row, column = v + along[k, 1], u + along[k, 0]
            for c in range(3):
                mean[side, c] += share[k] * picture[row, column, c]


@numba.njit(cache=True)
def _differ(picture, rows, columns, along, aside, share, found):
    """Fill `found` (WAYS, n, 3) with C - (A + B)/2 in a picture with a rim of RIM."""
    mean = np.empty((3, 3), np.float32)
    for t in range(len(along)):
        for i in range(len(rows)):
            _three_means(picture, rows[i], columns[i], along[t], aside[t], share, mean)
            for c in range(3):
                found[t, i, c] = mean[0, c] - (mean[1, c] + mean[2, c]) / 2


@numba.njit(cache=True)
def _response(mean, whiten):
    """Response to the means C, A, B (3, 3): min(|a|, |b|) cos - |a - b| / 2, whitened.

    Where the sides are too unlike, of (a, b) alone if that is greater: the first two of three
    whitened parts are made of the first two alone.
    """
    aa = bb = ab = hue = whole = unlike = np.float32(0)
    for c in range(3):
        a = b = np.float32(0)
        for d in range(c + 1):
            a += whiten[c, d] * (mean[0, d] - mean[1, d])
            b += whiten[c, d] * (mean[0, d] - mean[2, d])
        aa, bb, ab = aa + a * a, bb + b * b, ab + a * b
        if c > 0:
            hue, unlike = whole, np.sqrt(max(aa + bb - 2 * ab, np.float32(0)))
            whole = ab / np.sqrt(max(aa, bb)) - unlike / 2 if ab > 0 else np.float32(0)
    if unlike > UNLIKE * np.sqrt(min(aa, bb)):
        whole = max(whole, hue)
    return max(whole, np.float32(0))


@numba.njit(cache=True)
def _respond(picture, rows, columns, along, aside, share, whiten, response, way):
    """Fill `response` and `way` (h, w): every other direction, and those beside the best."""
    mean = np.empty((3, 3), np.float32)
    ways = len(along)
    for i in range(len(rows)):
        best, most = 0, np.float32(0)
        for step in range(0, ways + 4, 2):
            t = step if step < ways else (best + (1 if step == ways else ways - 1)) % ways
            if step >= ways and most == 0:
                break
            _three_means(picture, rows[i], columns[i], along[t], aside[t], share, mean)
            here = _response(mean, whiten[t])
            if here > most:
                most = here
                if step < ways:
                    best = t
                way[rows[i], columns[i]] = t
        response[rows[i], columns[i]] = most
