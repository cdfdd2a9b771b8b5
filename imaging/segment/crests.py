"""Pieces of ridges: where a ridge is highest across itself, as lines with a colour and a width.

A piece is cut where its direction jumps, as where one strand disappears under another. Its colour
is an average along it, so that stripes, bands and highlights are part of it.
"""

from collections.abc import Sequence
from typing import NamedTuple

import cv2
import numpy as np
from scipy.sparse import csr_array
from skimage.morphology import skeletonize

from imaging.segment.ridges import LOW, WAYS, Ridges
from imaging.segment.skeleton import degrees, in_order, linked

Array = np.ndarray

TURN = 2  # sixteenths of half a turn from one point of a piece to the next
SHORTEST = 6  # px; a shorter piece has no direction
STEPS = (-2.0, -1.0, 1.0, 2.0)  # px across a ridge, at which it is lower than on its crest
CORE = 0.2  # widths to either side of its middle, over which a piece's colour is averaged
ALARM = 14.0  # sds over five widths; cables have 12 to 30 in most colours
FLOOR = 8.0  # sds, however long: coarse grain of wood has up to 8 along twenty widths
BROAD = 2.5  # times the width of sure pieces; a broader one is several strands side by side
INDEPENDENT = 5.0  # widths along a ridge, over which the ground's texture is another
NEAR = 0.7  # widths around a ridge in which its strand lies


class Piece(NamedTuple):
    """A piece of a ridge.

    Attributes
    ----------
    line : (n, 2) array
        Its crest, a point a pixel or so.
    colour, spread : (3,) arrays
        Mean Lab colour along its middle, and sd of single pixels.
    width : float
        The least width [px] at which it stands out well.
    response : float
        Median along it [sds of the ground's own differences].
    tone : int
        Number of its colour among those of all pieces.
    """

    line: Array
    colour: Array
    spread: Array
    width: float
    response: float
    tone: int = 0


def stands_out(response: float, length: float, width: float) -> bool:
    """Tell whether the ground's texture is unlikely to have made a ridge this strong and long.

    Of a longer ridge the mean is better known, with the root of its length.

    Parameters
    ----------
    response : float
        Median along it [sds of the ground's own differences].
    length, width : float
        [px]
    """
    return response > max(FLOOR, ALARM * np.sqrt(INDEPENDENT * width / length))


def pieces_of(ridges: Ridges, lab: Array) -> list[Piece]:
    """Cut the crests of ridges into pieces.

    Parameters
    ----------
    ridges : Ridges
    lab : (h, w, 3) array

    Returns
    -------
    list of Piece
        Those that are longer than wide.
    """
    high = ridges.response > LOW
    crest = (_crest(ridges) & high).view(np.uint8)
    closed = cv2.morphologyEx(crest, cv2.MORPH_CLOSE, np.ones((3, 3), np.uint8)) > 0
    thin = skeletonize(closed & high)
    thin[[0, -1]] = thin[:, [0, -1]] = False
    if not thin.any():
        return []
    points, touching = linked(thin)
    touching = _going_on(touching, ridges.way[points[:, 1], points[:, 0]])
    simple = degrees(touching) <= 2
    points, touching = points[simple], touching[simple][:, simple]
    paths = [points[path] for path in in_order(touching) if len(path) >= SHORTEST]
    found = [_piece(path, ridges, lab) for path in paths]
    return [piece for piece in found if len(piece.line) > piece.width]


def _crest(ridges: Ridges) -> Array:
    """Where the response is highest across its own direction (h, w)."""
    height = cv2.GaussianBlur(ridges.response, (0, 0), 1.0)
    angle = np.pi * np.arange(WAYS, dtype=np.float32) / WAYS
    across, down = -np.sin(angle)[ridges.way], np.cos(angle)[ridges.way]
    y, x = np.indices(height.shape, np.float32)
    crest = height > 0
    for step in STEPS:
        beside = cv2.remap(height, x + step * across, y + step * down, cv2.INTER_LINEAR)
        crest &= height >= beside
    return crest


def _going_on(touching: csr_array, way: Array) -> csr_array:
    """Links between points (n, n) whose directions are nearly the same."""
    links = touching.tocoo()
    off = np.abs(way[links.row].astype(int) - way[links.col])
    kept = np.minimum(off, WAYS - off) <= TURN
    ends = links.row[kept], links.col[kept]
    return csr_array((links.data[kept], ends), shape=touching.shape)


def _piece(path: Array, ridges: Ridges, lab: Array) -> Piece:
    column, row = path.T
    width = float(np.median(ridges.width[row, column]))
    angle = np.pi * ridges.way[row, column] / WAYS
    aside = CORE * width * np.stack([-np.sin(angle), np.cos(angle)], axis=1)
    around = np.rint(path + np.array([-1, 0, 1])[:, None, None] * aside).astype(int)
    x, y = np.clip(around.reshape(-1, 2), 0, np.subtract(lab.shape[1::-1], 1)).T
    seen = lab[y, x].astype(float)
    response = float(np.median(ridges.response[row, column]))
    return Piece(path.astype(float), seen.mean(axis=0), seen.std(axis=0), width, response)


def near_pieces(pieces: Sequence[Piece], shape: tuple[int, ...]) -> Array:
    """Mask (h, w) of all that lies within about a strand of a piece."""
    near = np.zeros(shape, np.uint8)
    for piece in pieces:
        thick = max(1, round(2 * (NEAR * piece.width + 2)))
        cv2.polylines(near, [np.rint(piece.line).astype(np.int32)], False, 1, thick)
    return near > 0


def sure_ones(pieces: Sequence[Piece]) -> list[Piece]:
    """Return the pieces that stand out by themselves; all, where none does."""
    sure = [p for p in pieces if stands_out(p.response, len(p.line), p.width)]
    return sure or list(pieces)


def usual_width(pieces: Sequence[Piece]) -> float:
    """Median width along sure pieces [px]."""
    sure = sure_ones(pieces)
    return float(np.median(np.repeat([p.width for p in sure], [len(p.line) for p in sure])))
