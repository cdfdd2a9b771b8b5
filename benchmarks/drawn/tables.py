"""Drawn photographs of cables on laboratory tables: grounds with texture, cables of every make.

A renderer unlike `drawn.strands`: each cable is a distance field along a spline, shaded by the
angle across it, painted from the lowest to the highest with a soft outline, its shadow cast
before. What lies on top at a crossing changes from place to place.
"""

from collections.abc import Callable
from dataclasses import dataclass

import cv2
import numpy as np
from scipy.interpolate import CubicSpline
from scipy.spatial import cKDTree

Array = np.ndarray
Rng = np.random.Generator
COLOURS = (
    (200, 30, 40), (30, 70, 170), (40, 140, 70), (235, 200, 40), (25, 25, 28), (235, 235, 230),
    (120, 120, 125), (130, 80, 45), (230, 120, 40), (110, 50, 130), (60, 62, 66), (225, 140, 160),
)  # fmt: skip
MAKES = ("plain", "plain", "glossy", "striped", "banded", "fuzzy", "plied")


@dataclass(frozen=True)
class Table:
    """A drawn table: pixels (h, w, 3) uint8, the cables' centrelines, radii [px], and its name."""

    pixels: Array
    lines: list[Array]
    radii: list[float]
    name: str


def draw_table(
    ground: str,
    seed: int,
    *,
    shape: tuple[int, int] = (480, 640),
    makes: tuple[str, ...] = MAKES,
    hard: bool = False,
) -> Table:
    """Draw three to nine cables on one of the GROUNDS.

    Parameters
    ----------
    ground : str
        One of GROUNDS.
    seed : int
    shape : (h, w)
    makes : tuple of str
        Of which each cable takes one.
    hard : bool
        Light from one lamp near by: dark shadows, all to one side, that part from cables which
        do not lie on the table.
    """
    rng = np.random.default_rng(seed)
    beam = np.random.default_rng(seed + 1) if hard else None
    lee = None if beam is None else _unit(beam.uniform(0, 2 * np.pi))
    picture = GROUNDS[ground](shape, rng)
    picture = picture * _lamp(shape, rng)[..., None]
    count, one_size = int(rng.integers(3, 10)), rng.uniform(3.0, 6.5)
    lines = [_course(shape, rng) for _ in range(count)]
    radii = [one_size * rng.uniform(0.8, 1.25) for _ in range(count)]
    colours = rng.permutation(np.array(COLOURS))[:count] / 255
    for line, radius, colour in zip(lines, radii, colours, strict=True):
        while _contrast(picture, line, colour) < 25:
            colour = rng.permutation(np.array(COLOURS))[0] / 255
        height = _Cable(line, radius, _linear(colour), str(rng.choice(makes)), rng)
        if beam is not None and lee is not None:
            _shade_hard(picture, line, radius, lee, beam)
        height.paint(picture, shaded=hard)
    soft = cv2.GaussianBlur(picture.astype(np.float32), (0, 0), rng.uniform(0.5, 1.1))
    coded = np.clip(soft, 0, 1) ** (1 / 2.2) + rng.normal(0, rng.uniform(0.004, 0.015), (*shape, 1))
    pixels = np.round(255 * np.clip(coded, 0, 1)).astype(np.uint8)
    quality = int(rng.integers(70, 96))
    jpeg = cv2.imencode(".jpg", pixels[..., ::-1], [cv2.IMWRITE_JPEG_QUALITY, quality])[1]
    return Table(cv2.imdecode(jpeg, cv2.IMREAD_COLOR)[..., ::-1].copy(), lines, radii, ground)


def _unit(angle: float) -> Array:
    return np.array([np.cos(angle), np.sin(angle)])


def _shade_hard(picture: Array, line: Array, radius: float, lee: Array, rng: Rng) -> None:
    """Darken what lies in the lee of a cable that rises from the table here and there, in place."""
    v = np.linspace(0, 1, len(line))
    rise = np.sin(np.pi * rng.uniform(0.5, 2) * v) ** 2
    lift = rng.uniform(0.6, 2.5) + rng.uniform(0, 6) * rise
    points = np.rint(16 * (line + (radius * lift)[:, None] * lee)).astype(np.int32)
    mask = np.zeros(picture.shape[:2], np.float32)
    cv2.polylines(mask, [points], False, 1, max(1, round(2 * radius)), cv2.LINE_AA, 4)
    soft = cv2.GaussianBlur(mask, (0, 0), rng.uniform(0.25, 0.6) * radius + 1)
    picture *= 1 - rng.uniform(0.5, 0.85) * soft[..., None]


def _linear(coded: Array) -> Array:
    return np.asarray(coded, float) ** 2.2


def _lamp(shape: tuple[int, int], rng: Rng) -> Array:
    y, x = np.mgrid[-1 : 1 : shape[0] * 1j, -1 : 1 : shape[1] * 1j]
    way = rng.uniform(0, 2 * np.pi)
    return 0.9 + rng.uniform(0, 0.25) * (x * np.cos(way) + y * np.sin(way))


def _course(shape: tuple[int, int], rng: Rng) -> Array:
    """Centreline (n, 2) of a cable, a point each half pixel, that never bends sharply."""
    size = np.array(shape[::-1], float)
    while True:
        start, end = rng.uniform(0.02, 0.98, (2, 2)) * size
        if np.hypot(*(end - start)) < 0.5 * size.min():
            continue
        chord = end - start
        normal = np.array([-chord[1], chord[0]])
        v = np.linspace(0, 1, 5)
        aside = np.append(np.append(0, rng.normal(0, 0.18, 3)), 0)
        knots = start + v[:, None] * chord + aside[:, None] * normal
        curve = CubicSpline(v, knots)
        fine = curve(np.linspace(0, 1, int(3 * np.hypot(*chord))))
        first, second = curve(v, 1), curve(v, 2)
        turn = first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0]
        bend = np.abs(turn) / np.hypot(*first.T) ** 3
        if bend.max() < 1 / 25 and (fine > 3).all() and (fine < size - 4).all():
            return fine


def _contrast(picture: Array, line: Array, colour: Array) -> float:
    """Lab distance, to the tenth percentile along the line, of a colour from what lies there."""
    x, y = np.rint(line[::8]).astype(int).T
    under = np.clip(picture[y, x], 0, 1)[None].astype(np.float32) ** np.float32(1 / 2.2)
    own = np.float32(colour).reshape(1, 1, 3)
    lab = [cv2.cvtColor(part, cv2.COLOR_RGB2Lab) for part in (under, own)]
    return float(np.percentile(np.linalg.norm(lab[0] - lab[1], axis=-1), 10))


class _Cable:
    """A cable's surface: at each pixel near it where along and across it that lies."""

    def __init__(self, line: Array, radius: float, colour: Array, make: str, rng: Rng):
        self.line, self.radius, self.colour, self.make, self.rng = line, radius, colour, make, rng

    def paint(self, picture: Array, *, shaded: bool = False) -> None:
        """Draw the cable, and its shadow if none is yet, over a linear picture (h, w, 3)."""
        if not shaded:
            self._shade(picture)
        y, x, along, across = self._near(picture.shape[:2])
        rim = self.radius * (1 + self._fuzz(along))
        cover = np.clip(rim - np.abs(across) + 0.5, 0, 1)[:, None]
        u = np.clip(across / rim, -1, 1)
        light = (0.5 + 0.5 * np.sqrt(1 - u**2) + 0.25 * u * self._lean)[:, None]
        surface = self._paint(along, u) * light + self._gloss(u)[:, None]
        picture[y, x] = cover * surface + (1 - cover) * picture[y, x]
        if self.make == "fuzzy":
            self._fibres(picture)

    @property
    def _lean(self) -> float:
        return 0.6

    def _near(self, shape: tuple[int, int]) -> tuple[Array, Array, Array, Array]:
        """Rows, columns, arclength and signed distance of the pixels near the cable."""
        drawn = np.zeros(shape, np.uint8)
        thick = int(2 * self.radius * 1.5 + 6)
        cv2.polylines(drawn, [np.rint(self.line).astype(np.int32)], False, 1, thick)
        y, x = np.nonzero(drawn)
        far, nearest = cKDTree(self.line).query(np.stack([x, y], 1))
        tangent = np.gradient(self.line, axis=0)
        step = np.hypot(*tangent.T)
        offset = np.stack([x, y], 1) - self.line[nearest]
        side = np.sign(tangent[nearest, 0] * offset[:, 1] - tangent[nearest, 1] * offset[:, 0])
        return y, x, np.cumsum(step)[nearest], far * side

    def _paint(self, along: Array, u: Array) -> Array:
        other = np.array([0.85, 0.85, 0.8]) if self.colour.mean() < 0.35 else self.colour * 0.2
        turn = np.arcsin(u)
        share = np.zeros(len(u))
        if self.make == "striped":
            share = (np.cos(turn - along / (2.5 * self.radius)) > 0.75).astype(float)
        if self.make == "banded":
            share = (np.mod(along / (6 * self.radius), 1) > 0.8).astype(float)
        if self.make == "plied":
            return (
                self.colour
                * (0.72 + 0.28 * np.cos(2 * (turn - along / (1.5 * self.radius))))[:, None]
            )
        return self.colour + share[:, None] * (other - self.colour)

    def _gloss(self, u: Array) -> Array:
        strength = {"glossy": 0.6}.get(self.make, 0.05)
        return strength * np.exp(-(((u - 0.35) / 0.14) ** 2))

    def _fuzz(self, along: Array) -> Array:
        if self.make != "fuzzy":
            return np.zeros(len(along))
        knots = self.rng.normal(0, 0.13, int(along.max() / 2) + 2)
        return np.interp(along, 2 * np.arange(len(knots)), knots)

    def _fibres(self, picture: Array) -> None:
        for _ in range(int(len(self.line) / 12)):
            at = self.line[self.rng.integers(len(self.line))]
            end = at + self.rng.normal(0, 1.6 * self.radius, 2)
            mask = np.zeros(picture.shape[:2], np.uint8)
            ends = np.rint(16 * np.stack([at, end])).astype(int)
            cv2.line(mask, *map(tuple, ends.tolist()), 255, 1, cv2.LINE_AA, 4)
            share = mask[..., None] / 255 * 0.7
            picture += share * (self.colour * 0.8 - picture)

    def _shade(self, picture: Array) -> None:
        drop = self.radius * self.rng.uniform(0.2, 1.2)
        mask = np.zeros(picture.shape[:2], np.float32)
        points = np.rint(16 * (self.line + [drop, drop])).astype(np.int32)
        cv2.polylines(mask, [points], False, 1, int(2 * self.radius), cv2.LINE_AA, 4)
        soft = cv2.GaussianBlur(mask, (0, 0), 0.6 * drop + 1)
        picture *= 1 - self.rng.uniform(0.2, 0.5) * soft[..., None]


def _noise(shape: tuple[int, int], sigma: tuple[float, float], rng: Rng) -> Array:
    rough = cv2.GaussianBlur(rng.normal(size=shape), (0, 0), sigma[0], sigmaY=sigma[1])
    return rough / rough.std()


def _paper(shape: tuple[int, int], rng: Rng) -> Array:
    return _linear(np.array([0.9, 0.9, 0.88])) * (1 + 0.015 * _noise(shape, (2, 2), rng))[..., None]


def _wood(shape: tuple[int, int], rng: Rng) -> Array:
    y, _ = np.mgrid[: shape[0], : shape[1]].astype(float)
    waves = y + 14 * _noise(shape, (120, 25), rng)
    rings = np.sin(waves / rng.uniform(4, 9)) + 0.6 * np.sin(waves / rng.uniform(14, 30))
    pores = _noise(shape, (rng.uniform(15, 40), 0.7), rng)
    tone = 1 + rng.uniform(0.06, 0.14) * rings + rng.uniform(0.05, 0.1) * pores
    base = _linear(rng.permutation([[0.78, 0.6, 0.4], [0.55, 0.36, 0.24], [0.85, 0.72, 0.54]])[0])
    wood = base * np.clip(tone, 0.2, 2)[..., None] ** np.array([0.9, 1.0, 1.2])
    return wood if rng.random() < 0.5 else _turned(wood, shape)


def _turned(picture: Array, shape: tuple[int, int]) -> Array:
    return cv2.resize(np.ascontiguousarray(np.rot90(picture)), shape[::-1])


def _card(shape: tuple[int, int], rng: Rng) -> Array:
    y, x = np.mgrid[: shape[0], : shape[1]].astype(float)
    way, period = rng.uniform(0, np.pi), rng.uniform(9, 20)
    flutes = np.sin(2 * np.pi * (x * np.cos(way) + y * np.sin(way)) / period)
    tone = 1 + 0.05 * flutes + 0.05 * _noise(shape, (1.2, 1.2), rng)
    return _linear(np.array([0.72, 0.58, 0.43])) * tone[..., None]


def _cloth(shape: tuple[int, int], rng: Rng) -> Array:
    y, x = np.mgrid[: shape[0], : shape[1]].astype(float)
    pitch = rng.uniform(4, 8)
    warp, weft = np.sin(2 * np.pi * x / pitch), np.sin(2 * np.pi * y / pitch)
    tone = 1 + 0.13 * warp * weft + 0.06 * _noise(shape, (1.5, 1.5), rng)
    tone += 0.12 * _noise(shape, (60, 30), rng)  # folds
    return _linear(rng.uniform(0.2, 0.85, 3) * 0.3 + 0.45) * np.clip(tone, 0.2, 2)[..., None]


def _tiles(shape: tuple[int, int], rng: Rng) -> Array:
    y, x = np.mgrid[: shape[0], : shape[1]].astype(float)
    side, grout = rng.uniform(110, 200), rng.uniform(2, 5)
    seam = np.minimum(np.mod(x + 31, side), np.mod(y + 57, side)) < grout
    tiles = (
        _linear(np.array([0.82, 0.8, 0.75])) * (1 + 0.03 * _noise(shape, (9, 9), rng))[..., None]
    )
    tiles[seam] = _linear(rng.uniform(0.4, 0.65, 3) * 0.2 + 0.45)
    return tiles


def _board(shape: tuple[int, int], rng: Rng) -> Array:
    y, x = np.mgrid[: shape[0], : shape[1]].astype(float)
    pitch = rng.uniform(22, 42)
    hole = np.hypot(np.mod(x, pitch) - pitch / 2, np.mod(y, pitch) - pitch / 2)
    dark = np.clip(rng.uniform(0.18, 0.28) * pitch - hole, 0, 1)[..., None]
    board = _linear(rng.permutation([[0.7, 0.7, 0.72], [0.8, 0.7, 0.45], [0.9, 0.9, 0.9]])[0])
    return board * (1 + 0.03 * _noise(shape, (3, 3), rng))[..., None] * (1 - 0.9 * dark)


def _mat(shape: tuple[int, int], rng: Rng) -> Array:
    y, x = np.mgrid[: shape[0], : shape[1]].astype(float)
    pitch = rng.uniform(28, 60)
    fine = (np.mod(x, pitch) < 1.5) | (np.mod(y, pitch) < 1.5)
    mat = np.ones((*shape, 3)) * _linear(np.array([0.1, 0.36, 0.32]))
    mat[fine] = _linear(np.array([0.5, 0.68, 0.6]))
    return mat * (1 + 0.05 * _noise(shape, (1, 1), rng))[..., None]


def _sheet(shape: tuple[int, int], rng: Rng) -> Array:
    """Lay a sheet of paper, its shadow beside it, on wood or cloth."""
    table = (_wood if rng.random() < 0.6 else _cloth)(shape, rng)
    h, w = shape
    corners = np.array([[0.1, 0.12], [0.85, 0.05], [0.9, 0.9], [0.06, 0.85]])
    corners = (corners + rng.uniform(-0.06, 0.06, (4, 2))) * [w, h]
    for shift, value in ((5, None), (0, _paper(shape, rng))):
        mask = np.zeros(shape, np.float32)
        cv2.fillConvexPoly(mask, np.rint(corners + shift).astype(np.int32), 1, cv2.LINE_AA)
        mask = cv2.GaussianBlur(mask, (0, 0), 0.7 + shift / 2)[..., None]
        table = table * (1 - 0.4 * mask) if value is None else mask * value + (1 - mask) * table
    return table


def _texture(name: str) -> Callable[[tuple[int, int], Rng], Array]:
    def ground(shape: tuple[int, int], rng: Rng) -> Array:
        import skimage.data

        grey = getattr(skimage.data, name)().astype(np.float32) / 255
        height = min(384, len(grey))
        top, left = rng.integers(0, len(grey) - height + 1, 2)
        cut = grey[top : top + height, left : left + height]
        tint = rng.uniform(0.85, 1.1, 3)
        return _linear(np.clip(cv2.resize(cut, shape[::-1])[..., None] * tint, 0, 1))

    return ground


GROUNDS: dict[str, Callable[[tuple[int, int], Rng], Array]] = {
    "paper": _paper,
    "wood": _wood,
    "card": _card,
    "cloth": _cloth,
    "tiles": _tiles,
    "perforated": _board,
    "mat": _mat,
    "sheet": _sheet,
    "brick": _texture("brick"),
    "gravel": _texture("gravel"),
    "grass": _texture("grass"),
}
