"""The files `combing photo` leaves: tables, pictures and their record, whole or not at all."""

import hashlib
import json
import platform
import tempfile
from collections.abc import Sequence
from functools import lru_cache
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pandas as pd
import scipy

from combing import __version__
from combing.figures.style import write_pictures
from combing.writing import write_text
from imaging.measure import Measured
from imaging.photo.decode import Picture, refuse_unless_file
from imaging.report.figures import histogram, kymograph
from imaging.report.imagej import available, write_rois
from imaging.report.overlay import as_jpeg, draw_overlay, labels_picture, overlay_svg
from imaging.report.tables import (
    columns_of,
    crossings_table,
    densities_table,
    link_table,
    strands_table,
    unassigned_table,
    unresolved_table,
)

TABLES = (
    "strands.csv", "crossings.csv", "unresolved.csv", "interactions.csv", "densities.csv",
    "link.csv", "unassigned.csv",
)  # fmt: skip
RECORD = "provenance.json"  # written last: its presence says that a photograph is done
ABOUT = """# What the files hold

Picture points are pixel centres at whole numbers, x to the right, y down. ImageJ counts from the
corner of the first pixel: add 0.5 (`rois.zip` has it added). An empty cell is unknown.

- `strands.csv` centrelines, root (upper end) to tip
- `crossings.csv` where strands cross, and which is on top
- `unresolved.csv` where two strands run so close together that the number or the place of their
  crossings is a guess
- `interactions.csv` N-body interactions by section of the curl
- `densities.csv` rho_N with intervals; by the rule asked for, by coarser and finer sections, and
  without sections
- `unassigned.csv` ridges that stand out from the ground and belong to no strand, longest first
- `link.csv` link density lambda(s) of each pair of strands that wind round each other
- `labels.png` strand number of each pixel, 0 = background, the top strand wins
- `overlay.jpg`, `overlay.svg` what was found, over the photograph: a ring is a crossing, the bar in
  it lies along the strand on top and is missing when that is unknown; a long outline is unresolved
  contact, a dashed line is seen and belongs to no strand
- `rois.zip` the same for ImageJ's ROI manager (with the extra `formats`)
- `histogram.png`, `.svg` rho_N; of several photographs `kymograph.png`, `.svg`: strands in
  interactions, section by section, photograph by photograph
- `provenance.json` what was measured, how, and by which versions

"""


def fingerprint(
    picture: Picture, options: dict[str, Any], others: Sequence[Path]
) -> dict[str, Any]:
    """Return what a measurement depends on: file, options, versions; equal means done already.

    Parameters
    ----------
    picture : Picture
        The photograph.
    options : dict
        What was asked for, in plain values.
    others : sequence of Path
        Masks and the board's photograph.

    Raises
    ------
    imaging.Unmeasurable
        If one of the files is not there or cannot be opened.
    """
    versions = {
        "combing": __version__,
        "python": platform.python_version(),
        "numpy": np.__version__,
        "scipy": scipy.__version__,
        "opencv": cv2.__version__,
    }
    asked = json.loads(json.dumps(options))
    besides = {str(other): _sha256(other) for other in others}
    return {"photo": picture.path.name, "page": picture.page, "sha256": _sha256(picture.path),
            "options": asked, "besides": besides, "versions": versions}  # fmt: skip


def _sha256(path: Path) -> str:
    refuse_unless_file(path)
    about = path.stat()
    return _digest(path, about.st_mtime_ns, about.st_size)


@lru_cache(maxsize=16)
def _digest(path: Path, changed: int, size: int) -> str:
    """Read a stack of many pages once, not once a page."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def earlier(folder: Path, asked: dict[str, Any]) -> dict[str, Any] | None:
    """Return the summary of the same measurement done before, if it is all there."""
    try:
        old = json.loads((folder / RECORD).read_text(encoding="utf-8"))
        whole = old["input"] == asked and all((folder / name).exists() for name in TABLES)
        return old["summary"] if whole else None
    except (OSError, ValueError, KeyError, TypeError):
        return None


def write_photo(folder: Path, name: str, measured: Measured, record: dict[str, Any]) -> None:
    """Write all files to a hidden folder, then move them into place, the record last."""
    folder.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=folder, prefix=".partial-") as partial:
        _fill(Path(partial), name, measured)
        (folder / RECORD).unlink(missing_ok=True)
        for file in sorted(Path(partial).iterdir()):
            file.replace(folder / file.name)
    write_text(folder / RECORD, json.dumps(record, indent=1))


def _fill(folder: Path, name: str, measured: Measured) -> None:
    tables = [
        strands_table(measured, name),
        crossings_table(measured, name),
        unresolved_table(measured, name),
        densities_table(measured.interactions, measured, name),
        densities_table(measured.densities, measured, name),
        link_table(measured, name),
        unassigned_table(measured, name),
    ]
    for file, table in zip(TABLES, tables, strict=True):
        table.to_csv(folder / file, index=False, float_format="%.7g", lineterminator="\n")
    found = (
        measured.photo, measured.segmentation, measured.strands, measured.crossings,
        measured.unresolved, measured.unassigned,
    )  # fmt: skip
    _write_picture(folder / "labels.png", labels_picture(measured.segmentation, measured.strands))
    (folder / "overlay.jpg").write_bytes(as_jpeg(draw_overlay(*found)))
    (folder / "overlay.svg").write_text(overlay_svg(*found), encoding="utf-8")
    if available():
        write_rois(folder / "rois.zip", *found[2:5])
    if measured.densities is not None:
        _write_histogram(folder, measured)
    (folder / "DATA.md").write_text(ABOUT + columns_of(tables), encoding="utf-8")


def _write_picture(path: Path, pixels: np.ndarray) -> None:
    """Write a PNG through Python's own file handling, which knows any path and raises."""
    path.write_bytes(cv2.imencode(".png", pixels)[1].tobytes())


def _write_histogram(folder: Path, measured: Measured) -> None:
    assert measured.interactions is not None
    asked = measured.interactions.attrs["n_sec"]
    table = densities_table(measured.densities, measured, "")
    shown = table[table["rule"] == f"{asked} sections"]
    unit = "px" if measured.scale is None else "m"
    if unit == "m":
        shown = shown.drop(columns=["low", "high"])
    shown = shown.rename(
        columns={f"{part}_per_{unit}": part for part in ("density", "low", "high")}
    )
    shown.attrs = {"n_sec": asked}
    write_pictures(histogram(shown, unit), folder / "histogram")


def write_batch(output: Path, folders: Sequence[Path], rows: Sequence[dict[str, Any]]) -> None:
    """Gather the tables of all photographs, draw their kymograph, write the summary."""
    output.mkdir(parents=True, exist_ok=True)
    write_text(output / "summary.json", json.dumps(rows, indent=1))
    if not folders:
        return
    tables = {name: _joined([pd.read_csv(folder / name) for folder in folders]) for name in TABLES}
    with tempfile.TemporaryDirectory(dir=output, prefix=".partial-") as partial:
        room = Path(partial)
        for name, table in tables.items():
            table.to_csv(room / name, index=False, float_format="%.7g", lineterminator="\n")
        (room / "DATA.md").write_text(ABOUT + columns_of(list(tables.values())), encoding="utf-8")
        if tables["interactions.csv"]["photo"].nunique() > 1:
            write_pictures(kymograph(tables["interactions.csv"]), room / "kymograph")
        for file in sorted(room.iterdir()):
            file.replace(output / file.name)


def _joined(parts: list[pd.DataFrame]) -> pd.DataFrame:
    """One below the other; where all are empty, the columns of the first."""
    filled = [part for part in parts if len(part)]
    return pd.concat(filled, ignore_index=True) if filled else parts[0]
