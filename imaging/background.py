"""The background under the strands: a smooth surface of colour that also tells how light falls."""

from collections.abc import Iterator

import cv2
import numpy as np

GRID = 72  # cells along the shorter side of a picture, of which the background is learned
ROUNDS = 8  # of reweighting
BAND = 64  # rows worked on at once: they stay in the processor's cache


def above_background(lab: np.ndarray, ignore: np.ndarray | None = None) -> np.ndarray:
    """Return a Lab picture (h, w, 3) less the smooth background under it, float32."""
    background = background_of(lab, ignore)
    return cv2.subtract(lab, background, dst=background)


def in_even_light(above: np.ndarray, lab: np.ndarray) -> np.ndarray:
    """Scale colours above the background, in place, to what they would be in even light.

    (L + 16, a, b) go with the cube root of the light, whose level the background shows.
    """
    mean = np.mean(lab[..., 0] - above[..., 0], dtype=float) + 16
    for rows in bands(len(lab)):
        level = lab[rows, :, 0] - above[rows, :, 0] + np.float32(16)
        cv2.multiply(above[rows], cv2.merge([np.float32(mean) / level] * 3), dst=above[rows])
    return above


def contrast_of(above: np.ndarray) -> np.ndarray:
    """Length of each pixel's (L, a, b), shape (h, w) float32."""
    contrast = np.empty(above.shape[:2], np.float32)
    total = np.ones((1, 3), np.float32)
    for rows in bands(len(above)):
        square = cv2.multiply(above[rows], above[rows])
        cv2.sqrt(cv2.transform(square, total), dst=contrast[rows])
    return contrast


def bands(height: int) -> Iterator[slice]:
    """Cut the rows of a picture into bands."""
    return (slice(top, top + BAND) for top in range(0, height, BAND))


def background_of(lab: np.ndarray, ignore: np.ndarray | None = None) -> np.ndarray:
    """Return the smooth background under a Lab picture, shape (h, w, 3)."""
    height, width = lab.shape[:2]
    step = max(1, min(height, width) // GRID)
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
