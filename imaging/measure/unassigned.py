"""Ridges that are seen and belong to no strand: where, and how long."""

from collections.abc import Sequence

import cv2
import numpy as np
import pandas as pd

from imaging.segment import Segmentation
from imaging.segment.crests import stands_out
from imaging.segment.skeleton import degrees, in_order, linked, thinned
from imaging.trace import Strand

BESIDE = 1.0  # strand widths from a strand's middle; a ridge nearer to it is its own
SHORTEST = 5.0  # strand widths; a shorter ridge is a speck


def unassigned(segmentation: Segmentation, strands: Sequence[Strand]) -> list[np.ndarray]:
    """Find what stands out from the ground, is long, and was not followed.

    Returns
    -------
    list of (n, 2) array
        Lines along it, the longest first [px].
    """
    free = ~_claimed(segmentation, strands)
    lines = _along_pieces(segmentation, free)
    if segmentation.pieces is None:
        lines = _along_colours(segmentation, free)
    long = [line for line in lines if len(line) >= SHORTEST * segmentation.width]
    return sorted(long, key=len, reverse=True)


def unassigned_table(lines: Sequence[np.ndarray]) -> pd.DataFrame:
    """Tabulate lines of `unassigned`: the point ``x``, ``y`` half-way along, ``length`` [px]."""
    rows = [(*line[len(line) // 2], float(len(line))) for line in lines]
    return pd.DataFrame(rows, columns=["x", "y", "length"], dtype=float)


def unassigned_notes(table: pd.DataFrame) -> list[str]:
    """Say how much stands out and belongs to no strand, and where the longest of it lies."""
    if table.empty:
        return []
    places = ", ".join(f"({row.x:.0f}, {row.y:.0f})" for row in table.head(5).itertuples())
    more = ", ..." if len(table) > 5 else ""
    return [
        f"unassigned: {len(table)} ridges, {table['length'].sum():.0f} px in all, stand out from "
        f"the ground and belong to no strand (x, y): {places}{more}"
    ]


def _along_pieces(segmentation: Segmentation, free: np.ndarray) -> list[np.ndarray]:
    """Parts of pieces of ridges that lie where no strand is, and that no texture has made."""
    found = []
    for piece in segmentation.pieces or []:
        x, y = np.rint(piece.line).astype(int).T
        line = piece.line[free[y, x]]
        if len(line) and stands_out(piece.response, len(line), segmentation.width):
            found.append(line)
    return found


def _along_colours(segmentation: Segmentation, free: np.ndarray) -> list[np.ndarray]:
    """Middles of what shows a strand's colour where no strand is."""
    rest = (segmentation.labels > 0) & free
    x, y, w, h = cv2.boundingRect(rest.view(np.uint8))
    if w == 0:
        return []
    thin = thinned(np.pad(rest[y : y + h, x : x + w], 1))
    points, touching = linked(thin)
    simple = degrees(touching) <= 2
    points, touching = points[simple], touching[simple][:, simple]
    return [points[path] + [x - 1.0, y - 1.0] for path in in_order(touching)]


def _claimed(segmentation: Segmentation, strands: Sequence[Strand]) -> np.ndarray:
    """Pixels that lie beside some strand's middle."""
    claimed = np.zeros(segmentation.labels.shape, np.uint8)
    reach = max(1, round(2 * BESIDE * segmentation.width))
    for strand in strands:
        cv2.polylines(claimed, [np.round(strand.line).astype(np.int32)], False, 1, reach)
    return claimed > 0
