"""Photographs of two twisted tubes by a renderer unlike `drawn.helix`: its own shapes and light.

Parallel view. A tube is the union of spheres along its centreline, exact where it comes towards the
viewer. Three lamps from any side with soft cast shadows, rough or glossy cloth, or a tent of light
whose rims darken; plied yarn and hairs; gamma and JPEG as a camera writes them.
"""

from collections.abc import Callable
from dataclasses import dataclass

import cv2
import numpy as np
import pandas as pd
from scipy.ndimage import gaussian_filter, map_coordinates

from drawn.helix import bent_axis, framed, tilt_strands, twist_strands

Array = np.ndarray
FINE = 3  # points a pixel's side
LIGHTS = ("matte", "gloss", "tent", "yarn")
GROUND = -2.5  # strand radii; where the cloth lies behind the axis
VIEW = np.array([0.0, 0.0, 1.0])


@dataclass(frozen=True)
class Unlike:
    """A photograph (h, w, 3) uint8 with its truth ``s, phi, link, x, y`` and tube radius [px]."""

    pixels: np.ndarray
    truth: pd.DataFrame
    radius: float


@dataclass(frozen=True)
class Surface:
    """What every fine point shows: strand (-1: cloth), height [px], normal, ply phase [rad]."""

    strand: np.ndarray
    height: Array
    normal: Array
    ply: Array


def draw_unlike(
    r: float,
    link: Callable[[Array], Array],
    length: float,
    light: str,
    rng: np.random.Generator,
    *,
    tilt: float = 0.0,
    bend: float = 0.0,
) -> Unlike:
    """Draw a pair of tubes that touch (R = r) with link density ``link(s)`` [1/px]."""
    s = np.linspace(0.0, length, int(4 * length) + 1)
    density = np.broadcast_to(link(s), s.shape).astype(float)
    phi = rng.uniform(0, 2 * np.pi) + 2 * np.pi * np.cumsum(density) * s[1]
    plane = bent_axis(s, bend * np.sin(np.pi * s / length))
    strands = [tilt_strands(p, tilt) for p in twist_strands(plane, phi, r)]
    axis = tilt_strands(np.column_stack([plane, 0 * s]), tilt)
    strands, shape, shift = framed(strands, 8.0 * r)
    strands = [p - [0, 0, axis[:, 2].mean()] for p in strands]
    seen = axis[:, :2] + shift
    pixels = _camera(_lit(_surface(strands, r, shape), r, light, rng), rng)
    if light == "yarn":
        pixels = _hairs(pixels, strands, r, rng)
    truth = pd.DataFrame({"s": s, "phi": phi, "link": density, "x": seen[:, 0], "y": seen[:, 1]})
    return Unlike(_jpeg(pixels, int(rng.integers(75, 96))), truth, r)


def _surface(strands: list[Array], r: float, shape: tuple[int, int]) -> Surface:
    """Paint spheres nearest first: their union is the tube."""
    size = (FINE * shape[0], FINE * shape[1])
    low = min(p[:, 2].min() for p in strands)
    seen = Surface(
        np.full(size, -1),
        np.full(size, low + (GROUND + 1) * r),
        np.zeros((*size, 3)) + VIEW,
        np.zeros(size),
    )
    for k, strand in enumerate(strands):
        for (x, y, z), s in zip(strand[::2], np.arange(0, len(strand), 2) / 4, strict=True):
            _sphere(seen, k, (FINE * (x + 0.5) - 0.5, FINE * (y + 0.5) - 0.5), z, r, s)
    return seen


def _sphere(
    seen: Surface, k: int, centre: tuple[float, float], z: float, r: float, s: float
) -> None:
    span = [slice(int(c - FINE * r), int(c + FINE * r) + 2) for c in centre]
    x, y = (
        (np.arange(cut.start, cut.stop) - c) / (FINE * r)
        for cut, c in zip(span, centre, strict=True)
    )
    up = 1 - x**2 - y[:, None] ** 2
    up = np.sqrt(np.where(up > 0, up, np.nan))
    window = (span[1], span[0])
    front = z + r * up > seen.height[window]
    rows, cols = np.nonzero(front)
    normal = np.column_stack([x[cols], y[rows], up[front]])
    seen.strand[window][front] = k
    seen.height[window][front] = (z + r * up)[front]
    seen.normal[window][front] = normal
    seen.ply[window][front] = 3 * np.arcsin(np.clip(normal[:, 0], -1, 1)) + 2.2 * s / r


def _lit(seen: Surface, r: float, light: str, rng: np.random.Generator) -> Array:
    """Linear light (h, w, 3) of every fine point."""
    albedo = _colours(rng)[seen.strand]
    if light == "yarn":
        albedo = albedo * (1 + 0.25 * np.sin(seen.ply) * (seen.strand >= 0))[..., None]
    if light == "tent":
        return albedo * (0.35 + 0.6 * seen.normal[..., 2:] ** rng.uniform(0.5, 1.5))
    diffuse, gloss = np.full(seen.height.shape, 0.15), np.zeros(seen.height.shape)
    shares = rng.dirichlet([2.0, 2.0, 2.0])
    for share in shares:
        angle, low = rng.uniform(0, 2 * np.pi), rng.uniform(0.3, 1.1)
        lamp = np.array([*(np.sin(low) * np.array([np.cos(angle), np.sin(angle)])), np.cos(low)])
        power = share * _unshadowed(seen.height, lamp, r)
        diffuse += 0.75 * power * _oren_nayar(seen.normal, lamp, 0.4)
        gloss += power * _ward(seen.normal, lamp, rng.uniform(0.15, 0.35))
    amount = rng.uniform(0.1, 0.25) if light == "gloss" else 0.0
    return albedo * diffuse[..., None] + amount * (gloss * (seen.strand >= 0))[..., None]


def _colours(rng: np.random.Generator) -> Array:
    """Albedo of strand a, strand b and, last, the cloth, which is light or dark."""
    pairs = [((0.6, 0.06, 0.05), (0.05, 0.1, 0.5)), ((0.05, 0.3, 0.1), (0.7, 0.45, 0.05))]
    cloth = [0.85, 0.84, 0.8] if rng.random() < 0.7 else [0.012, 0.013, 0.015]
    return np.array([*pairs[rng.integers(2)], cloth])


def _oren_nayar(normal: Array, lamp: Array, rough: float) -> Array:
    """Rough diffuse reflection seen from +z (Oren and Nayar 1994, their qualitative model)."""
    cos_i, cos_r = np.clip(normal @ lamp, 0, 1), np.clip(normal @ VIEW, 1e-3, 1)
    sin_i, sin_r = np.sqrt(1 - cos_i**2), np.sqrt(1 - cos_r**2)
    apart = (lamp @ VIEW - cos_i * cos_r) / np.maximum(sin_i * sin_r, 1e-3)
    a, b = 1 - 0.5 * rough**2 / (rough**2 + 0.33), 0.45 * rough**2 / (rough**2 + 0.09)
    steep = sin_i * sin_r / np.maximum(np.maximum(cos_i, cos_r), 0.05)
    return cos_i * (a + b * np.clip(apart, 0, 1) * steep)


def _ward(normal: Array, lamp: Array, rough: float) -> Array:
    """Gloss of a rough surface seen from +z (Ward 1992, isotropic), without its scale."""
    half = (lamp + VIEW) / np.linalg.norm(lamp + VIEW)
    cos_h, cos_i = np.clip(normal @ half, 1e-3, 1), np.clip(normal @ lamp, 0, 1)
    return np.sqrt(cos_i) * np.exp(-(1 / cos_h**2 - 1) / rough**2)


def _unshadowed(height: Array, lamp: Array, r: float) -> Array:
    """Share of a lamp of some width that each point sees: a march over the heights towards it."""
    row, col = np.mgrid[: height.shape[0], : height.shape[1]].astype(float)
    clear = np.full(height.shape, 1.0)
    for step in np.linspace(0.4, 4.0, 7) * r:
        away = map_coordinates(
            height, [row + FINE * step * lamp[1], col + FINE * step * lamp[0]], order=1,
            mode="nearest",
        )  # fmt: skip
        above = height + step * lamp[2] - away
        clear = np.minimum(clear, np.clip(0.5 + above / (0.3 * step), 0, 1))
    return clear


def _camera(light: Array, rng: np.random.Generator) -> Array:
    """Pixels (h, w, 3) in 0 to 1: means of fine points, blurred, exposed, noisy, coded."""
    h, w = light.shape[0] // FINE, light.shape[1] // FINE
    pixel = light.reshape(h, FINE, w, FINE, 3).mean(axis=(1, 3))
    pixel = gaussian_filter(pixel, (*[rng.uniform(0.6, 1.2)] * 2, 0))
    pixel *= 0.9 / max(np.percentile(pixel, 99), 0.3)
    coded = np.clip(pixel, 0, 1) ** (1 / rng.uniform(1.9, 2.4))
    return np.clip(coded + rng.normal(0, rng.uniform(0.005, 0.02), coded.shape), 0, 1)


def _hairs(picture: Array, strands: list[Array], r: float, rng: np.random.Generator) -> Array:
    """Short fibres that stand off, half as wide as a pixel, of the colour they leave from."""
    drawn = picture.copy()
    for _ in range(int(0.05 * len(strands[0]))):
        start = strands[rng.integers(2)][rng.integers(len(strands[0])), :2]
        end = start + r * rng.normal(0, 0.9, 2)
        x, y = np.rint(start).astype(int)
        line = np.zeros(picture.shape[:2], np.uint8)
        ends = [tuple(int(v) for v in np.rint(16 * p)) for p in (start, end)]
        cv2.line(line, *ends, 255, 1, cv2.LINE_AA, 4)
        drawn += (0.4 * line / 255)[..., None] * (picture[y, x] - drawn)
    return drawn


def _jpeg(picture: Array, quality: int) -> np.ndarray:
    eight = np.rint(255 * picture).astype(np.uint8)[..., ::-1]
    coded = cv2.imencode(".jpg", eight, [cv2.IMWRITE_JPEG_QUALITY, quality])[1]
    return np.ascontiguousarray(cv2.imdecode(coded, cv2.IMREAD_COLOR)[..., ::-1])
