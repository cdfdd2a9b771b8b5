"""Seams of tiles and bricks, and what else is a lattice: pieces of ridges that are no strands.

A lattice has one colour; its pieces are straight, many, nearly all along one of two directions
across each other, and reach from one side of the picture to the other both ways. Strands have free
ends and bend.
"""

from collections.abc import Sequence

import numpy as np

from imaging.segment.crests import Piece

Array = np.ndarray

STRAIGHT = 0.15  # widths, or
ROUGH = 0.7  # px; RMS distance of a straight piece from its chord
ALIGNED = 10.0  # degrees off one of two directions; seen aslant, seams run together
ACROSS = 45.0  # degrees, at least, between the two
MANY = 10  # pieces; fewer are no lattice
MOSTLY = 0.6  # of the length of a colour, aligned
LEAST = 0.12  # of that, along the rarer direction
WHOLE = 0.75  # of the picture, both ways
SHORT = 5.0  # widths; what is left of a lattice's corners


def of_lattice(pieces: Sequence[Piece], shape: tuple[int, ...]) -> Array:
    """Tell which pieces belong to a lattice.

    Parameters
    ----------
    pieces : sequence of Piece
        With their colours numbered.
    shape : (h, w)

    Returns
    -------
    (n,) bool array
    """
    found = np.zeros(len(pieces), bool)
    if len(pieces) < MANY:
        return found
    tone = np.array([piece.tone for piece in pieces])
    length = np.array([len(piece.line) for piece in pieces], float)
    short = length < SHORT * np.array([piece.width for piece in pieces])
    way = np.array([_direction(piece) for piece in pieces])
    for colour in np.unique(tone):
        own = tone == colour
        aligned = own & _aligned(way, np.where(own, length, 0))
        if aligned.sum() < MANY or length[aligned].sum() < MOSTLY * length[own].sum():
            continue
        ends = [pieces[i].line[[0, -1]] for i in np.flatnonzero(aligned).tolist()]
        if (np.ptp(np.concatenate(ends), axis=0) > WHOLE * np.array(shape[1::-1])).all():
            found |= aligned | (own & short)
    return found


def _direction(piece: Piece) -> float:
    """Direction of a straight piece [degrees]; NaN of one that is not."""
    off = piece.line - piece.line.mean(axis=0)
    _, size, axes = np.linalg.svd(off, full_matrices=False)
    if size[1] / np.sqrt(len(off)) > max(STRAIGHT * piece.width, ROUGH):
        return np.nan
    return float(np.degrees(np.arctan2(axes[0, 1], axes[0, 0]))) % 180


def _aligned(way: Array, weight: Array) -> Array:
    """Which lie along the commonest direction or along the commonest across it (n,)."""
    grid = np.arange(0, 180, 3.0)
    near = _off(way[:, None], grid) < ALIGNED
    total = weight @ near
    first = grid[total.argmax()]
    across = np.where(_off(grid, first) > ACROSS, total, -1)
    if across.max() < LEAST * (across.max() + total.max()):
        return np.zeros(len(way), bool)
    return _off(way[:, None], np.array([first, grid[across.argmax()]])).min(axis=1) < ALIGNED


def _off(a: Array, b: Array | float) -> Array:
    """Angle between directions [degrees]."""
    return np.abs((a - b + 90) % 180 - 90)
