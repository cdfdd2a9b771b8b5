"""Drawn photographs of two twisted tubes whose phase and link density are known."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike
from scipy.ndimage import gaussian_filter
from scipy.spatial import cKDTree

Array = np.ndarray
RED, BLUE, GREY = (200, 40, 40), (40, 70, 190), (90, 92, 95)
SUB = 4  # points per pixel side


@dataclass(frozen=True)
class Light:
    """How a scene is lit: Lambert shading, a highlight, brightness that drifts over the picture.

    ``direction`` points to the lamp (x right, y down, z to the viewer); ``uneven`` is the relative
    change of brightness from one corner of the picture to the opposite one.
    """

    direction: tuple[float, float, float] = (-0.4, -0.3, 0.85)
    ambient: float = 0.45
    highlight: float = 0.35
    shine: float = 30.0
    uneven: float = 0.3


@dataclass(frozen=True)
class SyntheticHelix:
    """A drawn photograph with everything that is true about it.

    Attributes
    ----------
    pixels : (h, w, 3) uint8
    membership : (k, h, w) float32
        Blurred, noiseless coverage of strand a, strand b and, when drawn, the tine.
    strands : two (n, 3) arrays
        Centrelines [px]: x right, y down, z to the viewer, root first.
    truth : DataFrame
        ``s, phi, link, x, y``: arclength in space [px], phase [rad], link density [1/px] and the
        axis in the picture [px].
    radius : float
        Tube radius [px].
    """

    pixels: np.ndarray
    membership: np.ndarray
    strands: list[Array]
    truth: pd.DataFrame
    radius: float


def bent_axis(s: ArrayLike, heading: ArrayLike) -> Array:
    """Plane curve of unit speed whose tangent is turned by ``heading`` [rad] from straight down.

    Parameters
    ----------
    s, heading : (n,) array_like

    Returns
    -------
    (n, 2) array
        Starts at the origin; x right, y down.
    """
    s, heading = np.broadcast_arrays(np.asarray(s, float), np.asarray(heading, float))
    tangent = np.column_stack([np.sin(heading), np.cos(heading)])
    steps = 0.5 * (tangent[1:] + tangent[:-1]) * np.diff(s)[:, None]
    return np.vstack([np.zeros(2), np.cumsum(steps, axis=0)])


def twist_strands(axis: Array, phi: Array, radius: ArrayLike) -> list[Array]:
    """Two strands at +-R(cos(phi) n + sin(phi) b) from a plane axis.

    ``n = (t_y, -t_x)`` lies in the picture and ``b`` points to the viewer, so that (n, b, t) is
    right-handed and a growing phase is a right-handed helix.
    """
    tangent = np.gradient(axis, axis=0)
    tangent /= np.linalg.norm(tangent, axis=1, keepdims=True)
    normal = np.column_stack([tangent[:, 1], -tangent[:, 0]])
    across = (np.asarray(radius) * np.cos(phi))[:, None] * normal
    towards = np.asarray(radius) * np.sin(phi)
    return [np.column_stack([axis + e * across, e * towards]) for e in (1.0, -1.0)]


def twist_in_space(axis: Array, phi: Array, radius: ArrayLike) -> list[Array]:
    """Two strands at +-R(cos(phi) n + sin(phi) b) from an axis (n, 3), z to the viewer.

    ``n`` lies in the picture, normal to the axis as it is seen, and ``b = n x t``; as in
    `twist_strands` a growing phase is a right-handed helix.
    """
    tangent = np.gradient(axis, axis=0)
    tangent /= np.linalg.norm(tangent, axis=1, keepdims=True)
    normal = np.column_stack([tangent[:, 1], -tangent[:, 0], np.zeros(len(axis))])
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    arm = np.cos(phi)[:, None] * normal + np.sin(phi)[:, None] * np.cross(normal, tangent)
    arm *= np.broadcast_to(radius, phi.shape)[:, None]
    return [axis + arm, axis - arm]


def tilt_strands(points: Array, angle: float) -> Array:
    """Turn (n, 3) points about the picture's horizontal: the lower end moves away by ``angle``."""
    x, y, z = points.T
    c, s = np.cos(angle), np.sin(angle)
    return np.column_stack([x, c * y + s * z, c * z - s * y])


def draw_helix(
    r: float,
    link: Callable[[Array], Array],
    length: float,
    *,
    helix_radius: float | Callable[[Array], Array] | None = None,
    heading: Callable[[Array], Array] | None = None,
    phase: float = 0.3,
    tilt: float = 0.0,
    tine: tuple[float, float] | None = None,
    colours: Sequence[tuple[int, int, int]] = (RED, BLUE, GREY),
    background: tuple[int, int, int] = (235, 235, 230),
    blur: float = 1.0,
    noise: float = 0.02,
    light: Light | None = None,
    rng: np.random.Generator | int | None = None,
) -> SyntheticHelix:
    """Draw a hanging pair of tubes with a stated link density.

    Parameters
    ----------
    r : float
        Tube radius [px].
    link : callable
        Link density lambda(s) [1/px] of axis arclength s [px]; negative is left-handed.
    length : float
        Axis length [px].
    helix_radius : float or callable, optional
        R [px], or R(s); ``r`` when left out, so that the tubes touch.
    heading : callable, optional
        Direction of the axis [rad] from straight down, as a function of s.
    phase : float
        Phase at the root [rad].
    tilt : float
        Angle by which the tip hangs away from the viewer [rad].
    tine : (s, radius), optional
        A horizontal bar over both strands at arclength s [px], drawn in the third colour.
    blur, noise : float
        Gaussian blur [px]; standard deviation of the noise over full scale.
    rng : Generator or int, optional

    Returns
    -------
    SyntheticHelix
    """
    s = np.linspace(0.0, length, int(4 * length) + 1)
    density = np.broadcast_to(link(s), s.shape).astype(float)
    phi = phase + 2 * np.pi * _cumulative(density, s)
    radius = np.broadcast_to(_values(helix_radius, s, r), s.shape)
    axis = bent_axis(s, _values(heading, s, 0.0))
    strands = [tilt_strands(p, tilt) for p in twist_strands(axis, phi, radius)]
    axis = tilt_strands(np.column_stack([axis, np.zeros(len(s))]), tilt)[:, :2]
    strands, shape, shift = framed(strands, 16.0 * r)
    axis = axis + shift
    bar = None if tine is None else (float(np.interp(tine[0], s, axis[:, 1])), tine[1])
    pixels, membership = draw_tubes(
        strands, r, shape, colours=colours, background=background, blur=blur, noise=noise,
        light=light or Light(), tine=bar, rng=rng,
    )  # fmt: skip
    truth = pd.DataFrame({"s": s, "phi": phi, "link": density, "x": axis[:, 0], "y": axis[:, 1]})
    return SyntheticHelix(pixels, membership, strands, truth, r)


def draw_tubes(
    strands: Sequence[Array],
    r: float,
    shape: tuple[int, int],
    *,
    colours: Sequence[tuple[int, int, int]],
    background: tuple[int, int, int],
    blur: float,
    noise: float,
    light: Light,
    tine: tuple[float, float] | None = None,
    rng: np.random.Generator | int | None = None,
) -> tuple[np.ndarray, np.ndarray]:
    """Draw tubes of radius ``r`` about (n, 3) centrelines, nearest to the viewer on top.

    Every pixel is the mean of SUB x SUB points. ``tine`` is (y, radius) of a bar in front.
    Brightness is mixed and blurred as light and encoded with gamma 2.2, as a camera does.

    Returns
    -------
    pixels : (h, w, 3) uint8
    membership : (k, h, w) float32
    """
    palette = np.array([*colours[: len(strands)], background], dtype=float)
    top, shade, gloss = _visible(strands, r, shape, light)
    if tine is not None:
        palette = np.vstack([palette[:-1], colours[len(strands)], palette[-1]])
        top = np.where(top == len(strands), len(strands) + 1, top)
        y = _subpixels(shape)[1]
        bar = np.abs(y - tine[0]) < tine[1]
        top, shade = np.where(bar, len(strands), top), np.where(bar, 0.8, shade)
        gloss = gloss * ~bar
    linear = (palette[top] / 255) ** 2.2 * shade[..., None] + gloss[..., None]
    covers = [top == k for k in range(len(palette) - 1)]
    picture = np.stack([_photograph(linear[..., c], blur) for c in range(3)], axis=-1)
    picture = np.clip(picture * _brightness(shape, light.uneven)[..., None], 0, 1) ** (1 / 2.2)
    picture += np.random.default_rng(rng).normal(0.0, noise, picture.shape)
    pixels = np.rint(255 * np.clip(picture, 0, 1)).astype(np.uint8)
    return pixels, np.stack([_photograph(c.astype(float), blur) for c in covers]).astype(np.float32)


def _values(given: float | Callable[[Array], Array] | None, s: Array, default: float) -> Array:
    value = default if given is None else given
    return np.asarray(value(s) if callable(value) else np.full_like(s, value), dtype=float)


def _cumulative(density: Array, s: Array) -> Array:
    return np.concatenate([[0.0], np.cumsum(0.5 * (density[1:] + density[:-1]) * np.diff(s))])


def framed(strands: Sequence[Array], margin: float) -> tuple[list[Array], tuple[int, int], Array]:
    """Move strands (n, 3) into a picture with a margin: strands, the picture's shape, the shift."""
    every = np.vstack(strands)[:, :2]
    low, high = every.min(axis=0) - margin, every.max(axis=0) + margin
    width, height = np.ceil(high - low).astype(int)
    return [p - [*low, 0.0] for p in strands], (int(height), int(width)), -low


def _subpixels(shape: tuple[int, int]) -> tuple[Array, Array]:
    """Coordinates x, y of SUB x SUB points in each pixel, on a sheared lattice.

    No two points of a pixel share a row or a column, so an upright edge is placed to SUB^-2 px.
    """
    row, col = np.mgrid[0 : SUB * shape[0], 0 : SUB * shape[1]]
    i, j = row % SUB, col % SUB
    x = col // SUB + (j + (i + 0.5) / SUB) / SUB - 0.5
    y = row // SUB + (i + (j + 0.5) / SUB) / SUB - 0.5
    return x, y


def _visible(
    strands: Sequence[Array], r: float, shape: tuple[int, int], light: Light
) -> tuple[np.ndarray, Array, Array]:
    """Which tube each point shows (the number of tubes = background), its shade and its gloss."""
    x, y = _subpixels(shape)
    top = np.full(x.shape, len(strands))
    height = np.full(top.shape, -np.inf)
    shade, gloss = np.ones(top.shape), np.zeros(top.shape)
    for k, strand in enumerate(strands):
        rows, cols, offset, z = _tube_points(strand, r, x, y)
        front = z > height[rows, cols]
        rows, cols, offset, z = rows[front], cols[front], offset[front], z[front]
        top[rows, cols], height[rows, cols] = k, z
        shade[rows, cols], gloss[rows, cols] = _shading(offset / r, light)
    return top, shade, gloss


def _tube_points(
    strand: Array, r: float, x: Array, y: Array
) -> tuple[np.ndarray, np.ndarray, Array, Array]:
    """Points under a tube: rows, columns, offset (n, 2) from the centreline, surface height."""
    near = np.zeros(x.shape, dtype=bool)
    reach = int(np.ceil(SUB * (r + 1)))
    for px, py in np.rint(SUB * strand[:: max(1, int(2 * r)), :2]).astype(int):
        near[max(0, py - 2 * reach) : py + 2 * reach, max(0, px - reach) : px + reach] = True
    rows, cols = np.nonzero(near)
    points = np.column_stack([x[rows, cols], y[rows, cols]])
    distance, index = cKDTree(strand[:, :2]).query(points, distance_upper_bound=r)
    inside = np.isfinite(distance)
    rows, cols, distance, index = rows[inside], cols[inside], distance[inside], index[inside]
    surface = strand[index, 2] + np.sqrt(np.maximum(r**2 - distance**2, 0.0))
    return rows, cols, points[inside] - strand[index, :2], surface


def _shading(offset: Array, light: Light) -> tuple[Array, Array]:
    """Lambert shade and Blinn highlight of a tube's surface at offset/r from its centreline."""
    normal = np.column_stack([offset, np.sqrt(np.maximum(1 - (offset**2).sum(axis=1), 0.0))])
    lamp = np.asarray(light.direction) / np.linalg.norm(light.direction)
    half = lamp + [0.0, 0.0, 1.0]
    half /= np.linalg.norm(half)
    lambert = np.maximum(normal @ lamp, 0.0)
    gloss = light.highlight * np.maximum(normal @ half, 0.0) ** light.shine
    return light.ambient + (1 - light.ambient) * lambert, gloss


def _photograph(values: Array, blur: float) -> Array:
    """Mean over each pixel's points, then blur."""
    h, w = values.shape
    pixel = values.reshape(h // SUB, SUB, w // SUB, SUB).mean(axis=(1, 3))
    return gaussian_filter(pixel, blur) if blur else pixel


def _brightness(shape: tuple[int, int], uneven: float) -> Array:
    y, x = np.mgrid[0 : shape[0], 0 : shape[1]]
    return 1 - uneven * (0.5 * x / shape[1] + 0.5 * y / shape[0])
