"""Drawn photographs in the light, on the grounds and with the clutter that a laboratory has.

Six strands of ten colours hang from the top, as in `imaging_curls.py`; every scene changes one
thing. Shadows fall on the ground only. Truth is the drawing.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial

import cv2
import numpy as np
from drawn.strands import Look, random_curl, render
from numpy.typing import ArrayLike
from scipy import ndimage

SHAPE = (1000, 760)
STRANDS = 6
DARK = (0.02, 0.02, 0.02)
PALETTE = (
    (230, 25, 75), (60, 180, 75), (255, 225, 25), (0, 90, 200), (245, 130, 48),
    (145, 30, 180), (70, 240, 240), (240, 50, 230), (20, 20, 20), (170, 110, 40),
)  # fmt: skip
GREYS = (12, 12, 12), (245, 245, 245), (128, 128, 128), (200, 40, 50)
BLUES = (25, 45, 95), (200, 40, 50), (240, 220, 40), (20, 20, 20)

Ground = Callable[[np.random.Generator], np.ndarray]


@dataclass(frozen=True)
class Scene:
    """How a photograph is taken: strands, ground, lamp, camera, and what is done to the picture."""

    look: Look = Look()
    ground: Ground | None = None
    shadow: float = 0.0
    fall: tuple[float, float] = (5, 6)
    softness: float = 3.0
    colours: tuple[tuple[int, int, int], ...] = PALETTE
    radii: tuple[float, ...] = (4.0,)
    slope: float = 0.25
    strands: int = STRANDS
    spread: float = 380.0
    columns: tuple[int, int] | None = None
    spoil: Callable[[np.ndarray], np.ndarray] | None = None


def draw(scene: Scene, seed: int) -> tuple[np.ndarray, list[np.ndarray]]:
    """Pixels (h, w, 3) uint8 of a scene and the strands' true centrelines."""
    rng = np.random.default_rng(seed)
    lines, heights = random_curl(
        scene.strands, 900, scene.spread, slope=scene.slope, rng=np.random.default_rng(seed)
    )
    lines = [line + [SHAPE[1] / 2, 40] for line in lines]
    colours = rng.permutation(np.array(scene.colours)) / 255
    colours = colours[np.arange(scene.strands) % len(colours)]
    radii = np.resize(scene.radii, scene.strands)
    ground = plain(scene.look.background) if scene.ground is None else scene.ground(rng)
    if scene.shadow:
        ground = lit(ground, 1 - scene.shadow * cast(lines, radii, scene))
    look = replace(scene.look, background=ground)
    pixels = render(lines, heights, colours, radii, SHAPE, look=look, rng=rng).pixels
    if scene.columns:
        pixels = np.ascontiguousarray(pixels[:, slice(*scene.columns)])
        lines = [line - [scene.columns[0], 0] for line in lines]
    return (pixels if scene.spoil is None else scene.spoil(pixels)), lines


def lit(coded: np.ndarray, light: np.ndarray) -> np.ndarray:
    """SRGB in [0, 1] under so much of the light, which scales linear light."""
    return coded * np.power(light, 1 / 2.2)[..., None]


def cast(lines: list[np.ndarray], radii: np.ndarray, scene: Scene) -> np.ndarray:
    """How much of the lamp strands hide from the ground, (h, w) in [0, 1]."""
    hidden = np.zeros(SHAPE, np.float32)
    for line, radius in zip(lines, radii, strict=True):
        points = np.round((line + scene.fall) * 8).astype(np.int32)
        cv2.polylines(hidden, [points], False, 1.0, round(2 * radius), cv2.LINE_AA, 3)
    return ndimage.gaussian_filter(hidden, scene.softness)


def wood(rng: np.random.Generator, grain: float = 0.08) -> np.ndarray:
    streaks = ndimage.gaussian_filter(rng.standard_normal(SHAPE), (60, 2))
    colour = np.array([0.72, 0.55, 0.38])
    return np.clip(colour * (1 + grain * streaks / streaks.std())[..., None], 0, 1)


def cloth(
    _: np.random.Generator,
    colour: tuple[float, float, float] = (0.8, 0.8, 0.78),
    period: float = 4,
    depth: float = 0.1,
) -> np.ndarray:
    y, x = np.mgrid[: SHAPE[0], : SHAPE[1]]
    weave = np.sin(2 * np.pi * x / period) * np.sin(2 * np.pi * y / period)
    return np.clip(np.array(colour) * (1 + depth * weave)[..., None], 0, 1)


def ruled(
    _: np.random.Generator,
    paper: tuple[float, float, float],
    ink: tuple[float, float, float],
    step: float,
    thick: float,
    turned: float = 0.0,
) -> np.ndarray:
    """Lines printed at equal steps both ways, turned by so many degrees."""
    ground = plain(paper)
    y, x = np.mgrid[: SHAPE[0], : SHAPE[1]]
    angle = np.radians(turned)
    u, v = x * np.cos(angle) + y * np.sin(angle), y * np.cos(angle) - x * np.sin(angle)
    ground[(u % step < thick) | (v % step < thick)] = ink
    return ground


def plain(colour: ArrayLike) -> np.ndarray:
    return np.broadcast_to(np.asarray(colour, float), (*SHAPE, 3)).copy()


def with_clamp(_: np.random.Generator) -> np.ndarray:
    """White ground with the clamp that the strands hang from."""
    ground = plain(Look().background)
    ground[:45, 130:630] = (0.35, 0.35, 0.38)
    return ground


def with_hand(_: np.random.Generator) -> np.ndarray:
    """Grey ground with three fingers coming in from the right."""
    ground = plain((0.68, 0.68, 0.66))
    for top in (300, 360, 415):
        cv2.line(ground, (680, top), (759, top + 20), (0.85, 0.62, 0.5), 44, cv2.LINE_AA)
    return ground


def with_label(_: np.random.Generator) -> np.ndarray:
    """Grey ground with a white paper label, written on."""
    ground = plain((0.5, 0.5, 0.48))
    ground[820:960, 20:240] = 0.95
    written = np.zeros(SHAPE, np.uint8)
    for row, text in enumerate(("curl 12", "no. 3, dry")):
        place = (35, 870 + 50 * row)
        cv2.putText(written, text, place, cv2.FONT_HERSHEY_SIMPLEX, 1, 255, 2, cv2.LINE_AA)
    return ground * (1 - 0.9 * written[..., None] / 255)


def jpeg(pixels: np.ndarray, quality: int) -> np.ndarray:
    coded = cv2.imencode(".jpg", pixels[..., ::-1], [cv2.IMWRITE_JPEG_QUALITY, quality])[1]
    return cv2.imdecode(coded, cv2.IMREAD_COLOR)[..., ::-1].copy()


def vignette(pixels: np.ndarray, left: float) -> np.ndarray:
    """Light that falls to so much in the corners, with the square of the distance."""
    y, x = np.mgrid[-1 : 1 : SHAPE[0] * 1j, -1 : 1 : SHAPE[1] * 1j]
    return np.round(lit(pixels, 1 - (1 - left) * (x * x + y * y) / 2)).astype(np.uint8)


def lamp(pixels: np.ndarray, colour: tuple[float, float, float]) -> np.ndarray:
    """Colours under a lamp that lets through so much of the linear light."""
    return np.round(pixels * np.power(colour, 1 / 2.2)).astype(np.uint8)


YELLOW = (1.0, 0.62, 0.18)
CUTTING_MAT = partial(ruled, paper=(0.1, 0.35, 0.25), ink=(0.85, 0.85, 0.6), step=60, thick=2)
SCENES = {
    "white ground": Scene(),
    "strands of two widths (6, 11 px)": Scene(radii=(3.0, 5.5)),
    "light to a tenth at a corner": Scene(Look(uneven=0.9)),
    "vignetting to a third": Scene(spoil=partial(vignette, left=0.33)),
    "yellow lamp": Scene(spoil=partial(lamp, colour=YELLOW)),
    "JPEG quality 30": Scene(spoil=partial(jpeg, quality=30)),
    "shadow of half the light": Scene(shadow=0.5),
    "shadow of 0.8 of the light, sharp": Scene(shadow=0.8, softness=1.5),
    "shadow apart from the strand": Scene(shadow=0.6, fall=(18, 20), softness=6),
    "graph paper": Scene(
        ground=partial(ruled, paper=(0.95,) * 3, ink=(0.6, 0.75, 0.9), step=40, thick=1.5)
    ),
    "cutting mat": Scene(ground=CUTTING_MAT),
    "cutting mat, turned, half shadow": Scene(ground=partial(CUTTING_MAT, turned=11), shadow=0.5),
    "fine cloth": Scene(ground=cloth),
    "thin strands (4 px) on cloth": Scene(ground=cloth, radii=(2.0,)),
    "coarse cloth": Scene(ground=partial(cloth, period=9)),
    "wood grain of 8 %": Scene(ground=wood),
    "wood grain of 20 %": Scene(ground=partial(wood, grain=0.2)),
    "black, white, grey on green": Scene(
        Look(background=(0.35, 0.55, 0.4)), colours=GREYS, strands=4, spread=160
    ),
    "black, white, grey on blue": Scene(
        Look(background=(0.25, 0.4, 0.7)), colours=GREYS, strands=4, spread=160
    ),
    "dark blue on light blue": Scene(
        Look(background=(0.6, 0.7, 0.9)), colours=BLUES, strands=4, spread=250
    ),
    "gloss of 0.6, 8 px": Scene(Look(highlight=0.6)),
    "gloss of 0.9, 8 px": Scene(Look(highlight=0.9)),
    "gloss of 0.9, 14 px": Scene(Look(highlight=0.9), radii=(7.0,), slope=0.15),
    "dark ground": Scene(Look(background=DARK)),
    "dark ground, gloss of 0.6, 14 px": Scene(
        Look(background=DARK, highlight=0.6), radii=(7.0,), slope=0.15
    ),
    "noise of 4 %": Scene(Look(noise=0.04)),
    "noise of 8 %": Scene(Look(noise=0.08)),
    "paper label": Scene(ground=with_label),
    "fingers at the rim": Scene(ground=with_hand),
    "clamp at the top": Scene(ground=with_clamp),
    "ground less than half": Scene(radii=(13.0,), slope=0.1, spread=280, columns=(200, 560)),
}
