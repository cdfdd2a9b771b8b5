"""Colours named after the pieces of ridges that have them, and which one each pixel shows."""

from collections.abc import Sequence

import cv2
import numpy as np
from scipy.cluster.hierarchy import fcluster, linkage
from scipy.spatial import cKDTree

from imaging.segment.crests import Piece

Array = np.ndarray

ALIKE = 14.0  # Lab units between the mean colours of pieces that have one name
REACH = 1.5  # strand widths from a crest, within which a pixel may be its own
BLUR = 1.0  # px over which a pixel's colour is averaged
STEEP = 4  # power with which the distance from a crest speaks against it, beside colour


def named(pieces: Sequence[Piece]) -> tuple[list[Piece], Array]:
    """Give colours numbers: groups of the pieces' mean colours within ALIKE (average linkage).

    Returns
    -------
    pieces : list of Piece
        With their `tone`.
    colours : (k, 3) array
        Lab colours, means over the length of their pieces.
    """
    colour = np.array([piece.colour for piece in pieces])
    length = np.array([len(piece.line) for piece in pieces], float)
    tone = np.zeros(len(pieces), int)
    if len(pieces) > 1:
        tone = fcluster(linkage(colour, "average"), ALIKE, "distance") - 1
    share = (tone == np.arange(tone.max() + 1)[:, None]) * length
    mean = share @ colour / share.sum(axis=1, keepdims=True)
    return [p._replace(tone=int(k)) for p, k in zip(pieces, tone, strict=True)], mean


def of_enough(pieces: Sequence[Piece], length: float) -> list[Piece]:
    """Leave out the pieces of colours of which less than a length [px] is seen."""
    total = np.bincount([p.tone for p in pieces], [len(p.line) for p in pieces])
    return [piece for piece in pieces if total[piece.tone] >= length]


def painted(pieces: Sequence[Piece], strand: Array, lab: Array, width: float) -> Array:
    """Give each strand pixel the number of the colour of the piece it lies on.

    Where pieces of several colours are near, as at a crossing, the pixel's own colour and its
    distance from each decide.

    Parameters
    ----------
    pieces : sequence of Piece
        With their colours numbered.
    strand : (h, w) bool array
    lab : (h, w, 3) array
    width : float
        Strand width [px].

    Returns
    -------
    (h, w) uint8 array
        0 beside all pieces, else 1 + the colour.
    """
    labels = np.zeros(strand.shape, np.uint8)
    y, x = np.nonzero(strand)
    seen = cv2.GaussianBlur(lab, (0, 0), BLUR)[y, x]
    places, far = np.stack([x, y], axis=1), REACH * width
    least, found = np.full(len(x), np.inf), np.zeros(len(x), np.uint8)
    for tone in sorted({piece.tone for piece in pieces}):
        own = [piece for piece in pieces if piece.tone == tone]
        which = np.repeat(np.arange(len(own)), [len(piece.line) for piece in own])
        crest = cKDTree(np.concatenate([piece.line for piece in own]))
        away, nearest = crest.query(places, distance_upper_bound=far)
        at = np.flatnonzero(np.isfinite(away))
        colour = np.array([piece.colour for piece in own])[which[nearest[at]]]
        off = np.linalg.norm(seen[at] - colour, axis=1) / ALIKE
        cost = off**2 + (2 * away[at] / far) ** STEEP
        better = cost < least[at]
        least[at[better]], found[at[better]] = cost[better], tone + 1
    labels[y, x] = found
    return labels
