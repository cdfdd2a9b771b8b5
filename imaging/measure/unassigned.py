"""Ridges that are seen on a textured ground and belong to no strand: where, and how long."""

from collections.abc import Sequence

import cv2
import numpy as np
import pandas as pd
from scipy import ndimage
from skimage.filters import apply_hysteresis_threshold
from skimage.morphology import skeletonize

from imaging.segment import Segmentation
from imaging.segment.ridges import HIGH, LOW
from imaging.trace import Strand

BESIDE = 1.0  # strand widths from a strand's middle; a ridge nearer to it is its own
SHORTEST = 5.0  # strand widths; a shorter ridge is a speck


def unassigned(segmentation: Segmentation, strands: Sequence[Strand]) -> pd.DataFrame:
    """List the ridges that stand out from the ground's texture and were not followed.

    Returns
    -------
    DataFrame
        Longest first: a point ``x``, ``y`` on the ridge and its ``length`` [px]. Empty on a ground
        without texture, where ridges are not looked for.
    """
    rows = [] if segmentation.ridge is None else _ridges(segmentation, strands)
    table = pd.DataFrame(rows, columns=["x", "y", "length"], dtype=float)
    return table.sort_values("length", ascending=False, ignore_index=True)


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


def _ridges(
    segmentation: Segmentation, strands: Sequence[Strand]
) -> list[tuple[float, float, float]]:
    assert segmentation.ridge is not None  # noqa: S101
    strong = apply_hysteresis_threshold(segmentation.ridge, LOW, HIGH)
    thin = skeletonize(strong & ~_claimed(segmentation, strands))
    labels, count = ndimage.label(thin, np.ones((3, 3)))
    rows = []
    for part, place in enumerate(ndimage.find_objects(labels, count), start=1):
        at = np.argwhere(labels[place] == part)
        if len(at) >= SHORTEST * segmentation.width:
            y, x = at[len(at) // 2] + (place[0].start, place[1].start)
            rows.append((float(x), float(y), float(len(at))))
    return rows


def _claimed(segmentation: Segmentation, strands: Sequence[Strand]) -> np.ndarray:
    """Pixels that lie beside some strand's middle."""
    claimed = np.zeros(segmentation.labels.shape, np.uint8)
    reach = max(1, round(2 * BESIDE * segmentation.width))
    for strand in strands:
        cv2.polylines(claimed, [np.round(strand.line).astype(np.int32)], False, 1, reach)
    return claimed > 0
