"""The background under the strands: a smooth surface of colour that also tells how light falls."""

from itertools import pairwise
from typing import NamedTuple

import cv2
import numpy as np

from imaging.photo import bands

GRID = 72  # cells along the shorter side of a picture, of which the background is learned
UNEVEN = 6.0  # Lab units; ground that lies farther off the smooth surface is uneven
PATCHY = 0.1  # of the ground; where more is uneven it is learned beside the strands instead
BESIDE = ((1.2, 1.0), (4.0, 0.03))  # strand widths of a mean, and its say: near by, or farther off
ROUNDS = 8  # of reweighting


class Ground(NamedTuple):
    """The smooth background under a picture.

    Attributes
    ----------
    coarse : (n, w, 3) float32 array
        Lab colours in n rows spread evenly over the picture, each as wide as the picture.
    height : int
        Rows of the picture.
    """

    coarse: np.ndarray
    height: int

    def rows(self, band: slice) -> np.ndarray:
        """Colours (m, w, 3) in a band of rows, between coarse ones by hat functions."""
        flat = self.coarse.reshape(len(self.coarse), -1)
        above, share = self._between(np.arange(band.start, band.stop))
        hat = np.stack([1 - share, share], axis=1)
        found = np.empty((len(hat), flat.shape[1]), np.float32)
        starts = np.flatnonzero(np.diff(above, prepend=-1)).tolist()
        for start, stop in pairwise([*starts, len(hat)]):  # rows between the same two coarse ones
            pair = flat[above[start] : above[start] + 2]
            np.matmul(hat[start:stop], pair, out=found[start:stop])
        return found.reshape(len(hat), -1, 3)

    def at(self, places: np.ndarray) -> np.ndarray:
        """Colours (n, 3) at places in the flattened picture."""
        across = self.coarse.shape[1]
        row, column = np.divmod(places, across)
        above, share = (of_rows[row] for of_rows in self._between(np.arange(self.height)))
        flat = self.coarse.reshape(-1, 3)
        first = above * across + column
        upper, lower = flat.take(first, axis=0), flat.take(first + across, axis=0)
        return upper + share[:, None] * (lower - upper)

    def _between(self, row: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Find the coarse row above each row (n,), and the share of the one below it (n,)."""
        last = len(self.coarse) - 1
        at = ((row + 0.5) * len(self.coarse) / self.height - 0.5).clip(0, last)
        above = np.minimum(at.astype(int), last - 1)
        return above, (at - above).astype(np.float32)


def in_even_light(lab: np.ndarray, ground: Ground) -> np.ndarray:
    """Turn a Lab picture, in place, into colours above the ground, as they would be in even light.

    (L + 16, a, b) go with the cube root of the light, whose level the ground shows.
    """
    mean = np.mean(ground.coarse[..., 0], dtype=float) + 16
    for band in bands(lab.shape):
        under = ground.rows(band)
        even = np.float32(mean) / (under[..., 0] + np.float32(16))
        cv2.multiply(cv2.subtract(lab[band], under), cv2.merge([even] * 3), dst=lab[band])
    return lab


def contrast_of(lab: np.ndarray, ground: Ground) -> np.ndarray:
    """Distance of each pixel's colour from the ground's, shape (h, w) float32."""
    contrast = np.empty(lab.shape[:2], np.float32)
    total = np.ones((1, 3), np.float32)
    for band in bands(lab.shape):
        above = cv2.subtract(lab[band], ground.rows(band))
        cv2.sqrt(cv2.transform(cv2.multiply(above, above), total), dst=contrast[band])
    return contrast


def ground_of(lab: np.ndarray, ignore: np.ndarray | None = None) -> Ground:
    """Learn the smooth background under a Lab picture (h, w, 3), but for what is ignored (h, w)."""
    height, width = lab.shape[:2]
    step = max(1, min(height, width) // GRID)
    small = cv2.resize(lab, (width // step, height // step), interpolation=cv2.INTER_AREA)
    weight = np.ones(small.shape[:2], np.float32)
    if ignore is not None:
        hidden = cv2.resize(ignore.astype(np.float32), small.shape[1::-1])
        weight = (hidden < 0.01).astype(np.float32)
    surface, weight = _robust_quadratic(small, weight)
    rest = _local_mean(small - surface, weight, sigma=0.08 * min(small.shape[:2]))
    surface += rest
    np.clip(
        surface[..., 0], 0, 100, out=surface[..., 0]
    )  # a parabola may leave what light there is
    rows = max(len(small), 2)  # to lie between
    return Ground(cv2.resize(surface, (width, rows)), height)


def _robust_quadratic(small: np.ndarray, weight: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Fit a quadratic surface to each channel, by Tukey-weighted least squares from the mode."""
    height, width = weight.shape
    y, x = np.mgrid[-1 : 1 : height * 1j, -1 : 1 : width * 1j]
    basis = np.stack([np.ones_like(x), x, y, x * x, x * y, y * y], -1).reshape(-1, 6)
    values = small.reshape(-1, 3).astype(float)
    prior = weight.ravel()
    surface = np.broadcast_to(_mode_colour(values[prior > 0]), values.shape)
    for _ in range(ROUNDS):
        square = ((values - surface) ** 2) @ np.ones(3)
        scale = max(4.7 * 1.5 * float(np.sqrt(np.median(square[prior > 0]))), 3.0)
        robust = prior * np.clip(1 - square / scale**2, 0, None) ** 2
        weighted = basis.T * robust
        surface = basis @ np.linalg.lstsq(weighted @ basis, weighted @ values, rcond=None)[0]
    smooth = surface.reshape(small.shape).astype(np.float32)
    return smooth, (robust > 0.25).reshape(height, width).astype(np.float32)


def _mode_colour(values: np.ndarray) -> np.ndarray:
    """Most common colour: the fullest cell of a coarse Lab grid, averaged."""
    cell = np.floor(values / 8).astype(int) + 32
    number = np.ravel_multi_index(tuple(cell.T), (64, 64, 64))
    return np.median(values[number == np.bincount(number).argmax()], axis=0)


def _local_mean(rest: np.ndarray, weight: np.ndarray, sigma: float) -> np.ndarray:
    total = cv2.GaussianBlur(weight, (0, 0), sigma)
    mean = cv2.GaussianBlur(rest * weight[..., None], (0, 0), sigma)
    return mean / (total[..., None] + 0.05)


def ground_between(lab: np.ndarray, strands: np.ndarray, width: float, smooth: Ground) -> Ground:
    """Learn the ground under strands from what is seen of it beside them, where it is not smooth.

    Parameters
    ----------
    lab : (h, w, 3) array
    strands : (h, w) bool array
        Where strands may lie, or where nothing is to be learned.
    width : float
        Strand width [px].
    smooth : Ground
        Taken where no ground is seen within some widths, and everywhere on a smooth ground.
    """
    height, across = strands.shape
    step = max(1, round(width / 2))
    size = (max(across // step, 2), max(height // step, 2))
    seen = cv2.resize((~strands).astype(np.float32), size, interpolation=cv2.INTER_AREA)
    off = lab - np.concatenate([smooth.rows(band) for band in bands(lab.shape)])
    off[strands] = 0
    small = cv2.resize(off, size, interpolation=cv2.INTER_AREA)
    bare = seen > 0.5
    uneven = np.linalg.norm(small[bare] / seen[bare, None], axis=-1) > UNEVEN
    if uneven.mean() < PATCHY:
        return smooth
    rest, total = np.zeros(small.shape, np.float32), np.zeros(seen.shape, np.float32)
    for reach, say in BESIDE:
        total = total + say * cv2.GaussianBlur(seen, (0, 0), reach * width / step)
        rest = rest + say * cv2.GaussianBlur(small, (0, 0), reach * width / step)
    rest /= total[..., None] + 1e-3
    row = ((np.arange(size[1]) + 0.5) * height / size[1]).astype(int)
    under = smooth.at((row[:, None] * across + np.arange(across)).ravel())
    return Ground(under.reshape(size[1], across, 3) + cv2.resize(rest, (across, size[1])), height)
