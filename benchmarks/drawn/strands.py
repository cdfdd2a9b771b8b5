"""Pictures of strands with known truth: shaded tubes, over and under, blur, noise, uneven light.

A flat stand-in for a photograph, to test the measurement against. Each strand is a tube lit from
one side, with its own height above the picture plane; the highest surface wins in every
sub-pixel.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import ArrayLike
from scipy import ndimage

SUBPIXELS = 3  # per pixel and direction; odd, so that one lies on the pixel's centre
CHUNK = 12.0  # px of strand drawn at once


@dataclass(frozen=True)
class Look:
    """What light, lens and sensor do to the picture.

    Attributes
    ----------
    background : (3,) floats or (h, w, 3) array
        sRGB in [0, 1].
    light : (3,) floats
        Direction towards the lamp, x right, y down, z towards the camera.
    ambient, highlight : float
        Share of light from everywhere; strength of the specular spot (0 = matt).
    blur : float
        Standard deviation of the lens and focus blur [px].
    noise : float
        Standard deviation of the sensor noise, of full scale.
    uneven : float
        Relative fall-off of the light from one corner to the opposite one.
    """

    background: tuple[float, float, float] | np.ndarray = (0.9, 0.9, 0.88)
    light: tuple[float, float, float] = (-0.4, -0.3, 0.85)
    ambient: float = 0.45
    highlight: float = 0.15
    blur: float = 0.8
    noise: float = 0.01
    uneven: float = 0.3


@dataclass(frozen=True)
class Picture:
    """A rendered picture and its truth.

    Attributes
    ----------
    pixels : (h, w, 3) uint8 array
    labels : (h, w) int array
        1 + the number of the strand on top at the pixel's centre, 0 = background.
    """

    pixels: np.ndarray
    labels: np.ndarray


def render(
    strands: list[np.ndarray],
    heights: list[np.ndarray],
    colours: Sequence[ArrayLike] | np.ndarray,
    radius: float | ArrayLike,
    shape: tuple[int, int],
    *,
    look: Look | None = None,
    rng: np.random.Generator | int | None = None,
) -> Picture:
    """Draw strands as shaded tubes.

    Parameters
    ----------
    strands : list of (n, 2) arrays
        Centrelines in picture points [px].
    heights : list of (n,) arrays
        Height of each centreline point above the picture plane [px].
    colours : sequence of (3,) or (n, 3) arrays
        sRGB colour of each strand, or of each of its points, in [0, 1].
    radius : float or (k,) array
        Strand radius [px].
    shape : (h, w)
    look : Look, optional
    rng : seed or Generator, optional

    Returns
    -------
    Picture
    """
    look = look or Look()
    radii = np.broadcast_to(np.asarray(radius, float), (len(strands),))
    big = (shape[0] * SUBPIXELS, shape[1] * SUBPIXELS)
    top = np.full(big, -np.inf, np.float32)
    owner = np.zeros(big, np.int32)
    light = np.empty((*big, 3), np.float32)
    ground = _to_linear(np.asarray(look.background, float))
    light[:] = ground if ground.ndim == 1 else cv2.resize(ground, big[::-1])
    for number, (line, height) in enumerate(zip(strands, heights, strict=True)):
        albedo = np.broadcast_to(_to_linear(np.asarray(colours[number], float)), (len(line), 3))
        for piece in _chunks(line, height, albedo):
            _draw(top, owner, light, piece, radii[number], number, look)
    middle = SUBPIXELS // 2
    labels = owner[middle::SUBPIXELS, middle::SUBPIXELS].copy()
    linear = cv2.resize(light, shape[::-1], interpolation=cv2.INTER_AREA)
    return Picture(_expose(linear, look, np.random.default_rng(rng)), labels)


def _chunks(line: np.ndarray, height: np.ndarray, albedo: np.ndarray) -> list[np.ndarray]:
    """Cut a strand into short pieces sampled every half pixel: x, y, height, albedo (m, 6)."""
    step = np.hypot(*np.diff(line, axis=0).T)
    s = np.concatenate([[0], np.cumsum(step)])
    fine = np.linspace(0, s[-1], max(2, int(2 * s[-1])))
    columns = np.column_stack([line, height, albedo]).T
    sampled = np.stack([np.interp(fine, s, column) for column in columns], axis=1)
    size = int(2 * CHUNK)
    return [sampled[i : i + size + 1] for i in range(0, max(1, len(fine) - 1), size)]


def _draw(
    top: np.ndarray,
    owner: np.ndarray,
    light: np.ndarray,
    piece: np.ndarray,
    radius: float,
    number: int,
    look: Look,
) -> None:
    """Draw one piece of tube into the height, owner and light buffers, in place."""
    points, levels, albedo = piece[:, :2], piece[:, 2], piece[:, 3:]
    low = np.floor((points.min(axis=0) - radius + 0.5) * SUBPIXELS).astype(int)
    high = np.ceil((points.max(axis=0) + radius + 0.5) * SUBPIXELS).astype(int) + 1
    low = np.maximum(low, 0)
    high = np.minimum(high, top.shape[::-1])
    if np.any(low >= high):
        return
    box = np.s_[low[1] : high[1], low[0] : high[0]]
    x = (np.arange(low[0], high[0]) + 0.5) / SUBPIXELS - 0.5
    y = (np.arange(low[1], high[1]) + 0.5) / SUBPIXELS - 0.5
    away = np.stack(np.broadcast_arrays(x[None, :], y[:, None]), -1)[:, :, None] - points
    nearest = (away**2).sum(axis=-1).argmin(axis=-1)
    offset = np.take_along_axis(away, nearest[..., None, None], axis=2)[:, :, 0]
    square = (offset**2).sum(axis=-1)
    rise = np.sqrt(np.maximum(radius**2 - square, 0))
    surface = levels[nearest] + rise
    wins = (square < radius**2) & (surface > top[box])
    normal = np.concatenate([offset, rise[..., None]], axis=-1)[wins] / radius
    top[box][wins] = surface[wins]
    owner[box][wins] = number + 1
    light[box][wins] = _shade(normal, albedo[nearest][wins], look)


def _shade(normal: np.ndarray, albedo: np.ndarray, look: Look) -> np.ndarray:
    """Lambert's law with ambient light and a Blinn highlight; linear light."""
    lamp = np.asarray(look.light, float)
    lamp = lamp / np.linalg.norm(lamp)
    half = lamp + [0, 0, 1]
    half = half / np.linalg.norm(half)
    diffuse = np.clip(normal @ lamp, 0, None)
    spot = np.clip(normal @ half, 0, None) ** 40
    return (
        albedo * (look.ambient + (1 - look.ambient) * diffuse)[:, None]
        + look.highlight * spot[:, None]
    )


def _expose(linear: np.ndarray, look: Look, rng: np.random.Generator) -> np.ndarray:
    height, width = linear.shape[:2]
    y, x = np.mgrid[0 : 1 : height * 1j, 0 : 1 : width * 1j]
    linear = linear * (1 - look.uneven * 0.5 * (x + y))[..., None]
    if look.blur > 0:
        linear = ndimage.gaussian_filter(linear, (look.blur, look.blur, 0))
    coded = _to_srgb(np.clip(linear, 0, 1)) + rng.normal(0, look.noise, linear.shape)
    return np.round(255 * np.clip(coded, 0, 1)).astype(np.uint8)


def _to_linear(coded: np.ndarray) -> np.ndarray:
    """Decode sRGB to linear light (IEC 61966-2-1)."""
    return np.where(coded <= 0.04045, coded / 12.92, ((coded + 0.055) / 1.055) ** 2.4)


def _to_srgb(linear: np.ndarray) -> np.ndarray:
    """Code linear light as sRGB (IEC 61966-2-1)."""
    return np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)


def random_curl(
    count: int = 12,
    length: float = 1200.0,
    width: float = 400.0,
    *,
    slope: float = 0.25,
    correlation: float = 90.0,
    rng: np.random.Generator | int | None = None,
) -> tuple[list[np.ndarray], list[np.ndarray]]:
    """Draw strands that hang from a clamp at the top and wander: smooth Gaussian directions.

    Parameters
    ----------
    count : int
    length, width : float
        Length of each strand and width of the clamp [px].
    slope : float
        Standard deviation of the angle from the vertical at the free end [rad].
    correlation : float
        Arclength over which direction and height are remembered [px].
    rng : seed or Generator, optional

    Returns
    -------
    strands : list of (n, 2) arrays
        From the clamp down; the middle of the clamp is the origin [px].
    heights : list of (n,) arrays
        Height above the picture plane [px].
    """
    rng = np.random.default_rng(rng)
    n = int(length)
    grow = np.minimum(1.0, 0.3 + np.arange(n) / (0.7 * n))
    strands, heights = [], []
    for root in np.linspace(-width / 2, width / 2, count):
        # pull the strand back towards its share of the bundle, which narrows away from the clamp
        angle = slope * grow * _smooth_noise(n, correlation, rng)
        x = root * np.exp(-np.arange(n) / (0.4 * n)) + np.cumsum(np.sin(angle))
        y = np.cumsum(np.cos(angle))
        strands.append(np.stack([x, y], axis=1))
        heights.append(15 * _smooth_noise(n, 1.5 * correlation, rng))
    return strands, heights


def _smooth_noise(n: int, correlation: float, rng: np.random.Generator) -> np.ndarray:
    """Gaussian process of unit variance along a line, remembered over `correlation`."""
    margin = int(2 * correlation)
    white = rng.standard_normal(n + 2 * margin)
    noise = ndimage.gaussian_filter1d(white, correlation / 2, mode="wrap")
    return (noise / noise.std())[margin : margin + n]
