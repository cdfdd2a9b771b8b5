"""Shadows among pieces of ridges: the ground's hue in less light, soft, in the lee of a strand.

One lamp casts all of a picture's shadows to one side. A strand may be grey, or lie beside another,
or be out of focus; it is taken for a shadow only where all of that comes together.
"""

from collections.abc import Sequence

import cv2
import numpy as np
from scipy.ndimage import map_coordinates
from scipy.spatial import cKDTree

from imaging.segment.coverage import MIN_CONTRAST
from imaging.segment.crests import Piece, stands_out
from imaging.segment.ground import Ground

Array = np.ndarray

OFF = 7.0  # Lab units from the ground's hue, as strands reflect theirs, at any saturation up to
RICHEST = 2.0  # times the ground's; a camera's tone curve saturates what is dark
PALE, LEAST = 5.0, 0.4  # Lab units of chroma; on ground with more, a shadow has this share of it
DEEPEST, FAINTEST = 0.05, 0.9  # of the ground's light that is left in a shadow
REACH, STEP = 1.5, 0.1  # widths to either side in which edges are looked for
SOFT = 1.6  # times the usual softness of strands' edges, on both sides: a shadow wherever it lies
HAZY = 1.15  # times that, on both sides, or
ONE_SIDE = 1.5  # times on one, where the other is the strand's own: a shadow in the lee of a strand
FAR = 8.0  # widths from a shadow to its strand
WAYS = 32  # directions of the light that are tried
MOSTLY = 0.7  # of a piece's length, in the lee
GAUSS = float(np.sqrt(2 * np.pi))


def of_ground(pieces: Sequence[Piece], under: Array) -> Array:
    """Tell which pieces show nothing but the ground, as between a strand and its shadow (n,)."""
    return np.linalg.norm(_colours(pieces) - under, axis=1) < MIN_CONTRAST


def of_shadow(pieces: Sequence[Piece], under: Array, lab: Array, width: float) -> Array:
    """Tell which pieces are shadows on the ground (n,).

    Parameters
    ----------
    pieces : sequence of Piece
    under : (n, 3) array
        Lab colour of the ground beneath each, from `grounds`.
    lab : (h, w, 3) array
    width : float
        Usual strand width [px].
    """
    dim = _dim_ground(_colours(pieces), under)
    sure = ~dim & [stands_out(p.response, len(p.line), p.width) for p in pieces]
    if not dim.any() or not sure.any():
        return np.zeros(len(pieces), bool)
    soft = np.array([softness(piece, lab) for piece in pieces])
    usual = float(np.median(np.repeat(soft[sure].min(axis=1), _lengths(pieces)[sure])))
    sharper, softer = np.sort(soft / max(usual, 1e-3), axis=1).T
    hazy = dim & ((sharper > HAZY) | (softer > ONE_SIDE))
    casting = np.concatenate([p.line for p, own in zip(pieces, sure, strict=True) if own])
    return (dim & (sharper > SOFT)) | (hazy & _in_lee(pieces, hazy, casting, width))


def grounds(pieces: Sequence[Piece], ground: Ground, across: int) -> Array:
    """Lab colour (n, 3) of the ground beneath each piece, in a picture so many pixels wide."""
    places = [np.rint(piece.line).astype(int) @ [1, across] for piece in pieces]
    return np.array([np.median(ground.at(place), axis=0) for place in places])


def _colours(pieces: Sequence[Piece]) -> Array:
    return np.array([piece.colour for piece in pieces])


def _lengths(pieces: Sequence[Piece]) -> Array:
    return np.array([len(piece.line) for piece in pieces])


def _dim_ground(colour: Array, under: Array) -> Array:
    """Tell which colours (n, 3) are the ground's hue, darker."""
    own, hue = colour[:, 1:], under[:, 1:]
    square = (hue**2).sum(axis=1)
    share = np.clip((own * hue).sum(axis=1) / np.maximum(square, 1), 0, RICHEST)
    off = np.linalg.norm(own - share[:, None] * hue, axis=1)
    light = ((colour[:, 0] + 16) / (under[:, 0] + 16)) ** 3
    tinted = (share > LEAST) | (square < PALE**2)
    return (off < OFF) & tinted & (light > DEEPEST) & (light < FAINTEST)


def softness(piece: Piece, lab: Array) -> Array:
    """Sd of the blur of a piece's edges (2,) [px], on either side, from how steeply they rise."""
    steps = piece.width * np.arange(0, REACH, STEP)
    ahead = np.gradient(cv2.blur(piece.line, (1, 2 * int(piece.width) + 1)), axis=0)
    normal = np.stack([-ahead[:, 1], ahead[:, 0]], axis=1)[::3]
    normal /= np.maximum(np.hypot(*normal.T), 1e-6)[:, None]
    found = []
    for side in (-1, 1):
        x, y = np.moveaxis(piece.line[::3, None] + side * steps[:, None] * normal[:, None], -1, 0)
        seen = [map_coordinates(lab[..., c], [y, x], order=1, mode="nearest") for c in range(3)]
        colour = np.stack(seen, axis=-1)
        rise = np.linalg.norm(colour - colour[:, :1], axis=-1).max(axis=1)
        slope = np.linalg.norm(np.diff(colour, axis=1), axis=-1).max(axis=1) / steps[1]
        found.append(np.median(rise / np.maximum(slope, 1e-3)) / GAUSS)
    return np.array(found)


def _in_lee(pieces: Sequence[Piece], hazy: Array, casting: Array, width: float) -> Array:
    """Tell which pieces lie beyond strands (m, 2), all seen along the one best direction (n,)."""
    tree, far = cKDTree(casting), width * np.arange(0.5, FAR, 0.5)
    angle = 2 * np.pi * np.arange(WAYS) / WAYS
    share = np.zeros((len(pieces), WAYS))
    for number in np.flatnonzero(hazy).tolist():
        towards = np.stack([np.cos(angle), np.sin(angle)], axis=1)[:, None] * far[:, None]
        rays = pieces[number].line[::5, None, None] + towards
        away = tree.query(rays, distance_upper_bound=width / 2)[0]
        share[number] = np.isfinite(away).any(axis=2).mean(axis=0)
    best = int((_lengths(pieces) @ share).argmax())
    return share[:, best] > MOSTLY
