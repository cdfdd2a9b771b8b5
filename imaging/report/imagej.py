"""Centrelines and crossings as ImageJ regions of interest, to be corrected by hand there.

ImageJ counts from the corner of the first pixel: points move by half a pixel.
"""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pandas as pd

from imaging.errors import Unmeasurable
from imaging.trace import Strand
from imaging.trace.centreline import arclength

STEP = 4  # centreline points to one vertex, so that a line can be dragged by hand
CORNER = 0.5  # px; from pixel centres at whole numbers to ImageJ's corners at whole numbers


def available() -> bool:
    """Tell whether the package for ImageJ files is installed."""
    try:
        import roifile  # noqa: F401 - only whether it is there
    except ImportError:
        return False
    return True


def write_rois(
    path: Path,
    strands: Sequence[Strand],
    crossings: pd.DataFrame,
    contacts: pd.DataFrame | None = None,
) -> None:
    """Write a zip for ImageJ's ROI manager: a freeline a strand, a point a crossing.

    Stretches of unresolved contact (of `imaging.unresolved`) are freelines along the first strand.

    Raises
    ------
    Unmeasurable
        When the package for ImageJ files is not installed.
    """
    if not available():
        raise Unmeasurable(f"{path}: ImageJ files need the extra: pip install 'combing[formats]'")
    import roifile

    lines = {f"strand-{number}": s.line for number, s in enumerate(strands, start=1)}
    lines |= _stretches(strands, contacts)
    thick = max(1, round(float(np.median(np.concatenate([s.width for s in strands]))) / 8))
    rois = []
    for name, line in lines.items():
        roi = roifile.ImagejRoi.frompoints(_vertices(line) + CORNER, name=name)
        roi.roitype = roifile.ROI_TYPE.FREELINE
        roi.stroke_width = thick
        rois.append(roi)
    for number, row in enumerate(crossings.to_dict("records"), start=1):
        name = f"crossing-{number}-strands-{row['strand_a']}-{row['strand_b']}"
        roi = roifile.ImagejRoi.frompoints(np.array([[row["x"], row["y"]]]) + CORNER, name=name)
        roi.roitype = roifile.ROI_TYPE.POINT
        rois.append(roi)
    roifile.roiwrite(path, rois, mode="w")


def _stretches(strands: Sequence[Strand], contacts: pd.DataFrame | None) -> dict[str, np.ndarray]:
    """Unresolved contact along the first strand, by name."""
    found = {}
    rows = [] if contacts is None else contacts.to_dict("records")
    for number, row in enumerate(rows, start=1):
        line = strands[row["strand_a"] - 1].line
        s = arclength(line)
        name = f"unresolved-{number}-strands-{row['strand_a']}-{row['strand_b']}"
        found[name] = line[(s >= row["s_a_from"]) & (s <= row["s_a_to"])]
    return found


def _vertices(line: np.ndarray) -> np.ndarray:
    """Every STEP-th point and the last."""
    return np.concatenate([line[:-1:STEP], line[-1:]])
