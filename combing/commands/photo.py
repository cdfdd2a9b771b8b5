"""``combing photo``: photographs to strands, crossings and N-body interactions."""

import glob
import hashlib
import json
import shutil
import tempfile
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import click
import cv2
import numpy as np
import pandas as pd
from tqdm import tqdm

import imaging
from combing import __version__
from combing.errors import UserError, is_users_fault
from imaging.overlay import draw_overlay, histogram, labels_picture, overlay_svg
from imaging.scale import FORMS, Request, parse_scale
from imaging.tables import (
    Measured,
    columns_of,
    crossings_table,
    densities_table,
    measure,
    strands_table,
)

SUFFIXES = {".jpg", ".jpeg", ".png", ".tif", ".tiff", ".heic", ".dng", ".nef", ".cr2", ".arw"}
TABLES = ("strands.csv", "crossings.csv", "interactions.csv", "densities.csv")
RECORD = "provenance.json"  # written last: its presence says that a photograph is done


@dataclass(frozen=True)
class Options:
    """What was asked for; part of the record that lets a batch be taken up again."""

    scale: str | None
    n_sec: int
    roi: tuple[int, int, int, int] | None
    ignore: str | None


@click.command()
@click.argument("files", nargs=-1, required=True)
@click.option("-o", "--output", type=click.Path(path_type=Path, file_okay=False), required=True,
              help="Folder for the results; several photos get a folder each.")  # fmt: skip
@click.option("--scale", help=f"Pixels to metres: {FORMS}. Without it, results are in pixels.")
@click.option("--n-sec", type=click.IntRange(min=1), default=20, show_default=True,
              help="Sections of the curl's axis for N-body interactions.")  # fmt: skip
@click.option("--roi", help="Look only inside x0,y0,x1,y1 [px].")
@click.option("--ignore", type=click.Path(), help="Mask picture; what is not black is ignored.")
@click.option("--again", is_flag=True, help="Measure anew what is already in the output folder.")
@click.option("--json", "as_json", is_flag=True, help="Print the summary as JSON.")
@click.option("--quiet", is_flag=True, help="No progress.")
def command(
    files: tuple[str, ...],
    output: Path,
    scale: str | None,
    n_sec: int,
    roi: str | None,
    ignore: str | None,
    again: bool,
    as_json: bool,
    quiet: bool,
) -> None:
    """Trace coloured strands and count their crossings and N-body interactions.

    FILES are photographs (JPEG, PNG, TIFF; HEIC and camera RAW with the extra 'formats'), folders
    or patterns. A batch that was interrupted takes up where it stopped; a photograph that cannot
    be measured is listed with its reason and does not stop the others.

    \b
    Example:
      combing photo curl.jpg --scale marker:20mm -o out/
      combing photo session/ --scale 41.5px/mm --n-sec 20 -o out/
    """
    paths = _expand(files)
    request = parse_scale(scale) if scale else None
    options = Options(scale, n_sec, _parse_roi(roi), ignore)
    if len(paths) > 1:  # one photograph alone makes no folder before it is measured
        output.mkdir(parents=True, exist_ok=True)
    folders = _folders(paths, output)
    rows = []
    for path, folder in tqdm(
        list(zip(paths, folders, strict=True)), unit="photo", disable=quiet or len(paths) < 2
    ):
        rows.append(_one(path, folder, request, options, again, alone=len(paths) == 1))
    if len(paths) > 1:
        _combine(output, [f for f, row in zip(folders, rows, strict=True) if not row["refused"]])
        _write_text(output / "summary.json", json.dumps(rows, indent=1))
    click.echo(json.dumps(rows, indent=1) if as_json else _summary(rows, output))
    if all(row["refused"] for row in rows):
        raise UserError(f"none of the {len(rows)} photographs could be measured (reasons above)")


def _expand(files: tuple[str, ...]) -> list[Path]:
    """Replace patterns and folders by the photographs they stand for."""
    found: list[Path] = []
    for text in files:
        path = Path(text)
        if path.is_dir():
            inside = sorted(p for p in path.iterdir() if p.suffix.lower() in SUFFIXES)
            if not inside:
                raise UserError(f"{path}: no photographs ({', '.join(sorted(SUFFIXES))}) in it")
            found += inside
        elif path.exists():
            found.append(path)
        else:
            matches = sorted(map(Path, glob.glob(text)))  # noqa: PTH207 - also absolute patterns
            if not matches:
                raise UserError(f"{path}: no such file; give photographs, folders or patterns")
            found += matches
    return list(dict.fromkeys(found))


def _parse_roi(text: str | None) -> tuple[int, int, int, int] | None:
    if text is None:
        return None
    try:
        x0, y0, x1, y1 = (int(part) for part in text.split(","))
    except ValueError:
        raise UserError(f"--roi {text}: give four whole numbers x0,y0,x1,y1 in pixels") from None
    return x0, y0, x1, y1


def _folders(paths: list[Path], output: Path) -> list[Path]:
    """Name a folder for each photograph; equal names get a number."""
    if len(paths) == 1:
        return [output]
    names: list[str] = []
    for path in paths:
        name, number = path.stem, 2
        while name in names:
            name, number = f"{path.stem}-{number}", number + 1
        names.append(name)
    return [output / name for name in names]


def _one(
    path: Path, folder: Path, request: Request | None, options: Options, again: bool, alone: bool
) -> dict[str, Any]:
    """Measure one photograph into its folder, or say why not; returns its line of the summary."""
    try:
        record = _record_of(path, options)
        if not again and (old := _earlier(folder, record)) is not None:
            return old
        photo = imaging.read_photo(path, roi=options.roi, ignore=options.ignore)
        measured = measure(photo, request, options.n_sec)
        record["summary"] = _row(path, measured)
        name = path.name if alone else folder.name + path.suffix
        _write(folder, name, measured, record)
    except Exception as error:
        if alone or not is_users_fault(error):
            raise
        return {"photo": path.name, "refused": str(error)}
    return record["summary"]


def _record_of(path: Path, options: Options) -> dict[str, Any]:
    digest = hashlib.sha256(path.read_bytes()).hexdigest()
    versions = {"combing": __version__, "opencv": cv2.__version__, "numpy": np.__version__}
    asked = json.loads(json.dumps(asdict(options)))
    return {"input": {"photo": path.name, "sha256": digest, "options": asked} | versions}


def _earlier(folder: Path, record: dict[str, Any]) -> dict[str, Any] | None:
    """Return the summary of the same measurement done before, if its record is whole."""
    try:
        old = json.loads((folder / RECORD).read_text(encoding="utf-8"))
        return old["summary"] if old["input"] == record["input"] else None
    except (OSError, ValueError, KeyError):
        return None


def _row(path: Path, measured: Measured) -> dict[str, Any]:
    kinds = measured.crossings["kind"]
    row: dict[str, Any] = {
        "photo": path.name,
        "refused": "",
        "strands": len(measured.strands),
        "colours": len(measured.segmentation.colours),
        "crossings": int((kinds == "inter").sum()),
        "self_crossings": int((kinds == "self").sum()),
        "over_unknown": int(measured.crossings["over"][kinds == "inter"].isna().sum()),
        "ends": [list(strand.ends) for strand in measured.strands],
        "strand_width_px": round(measured.segmentation.width, 2),
    }
    if measured.interactions is not None:
        count = measured.interactions.groupby("N")["count"].sum()
        row["n_sec"] = measured.interactions.attrs["n_sec"]
        row["interactions"] = {str(n): int(k) for n, k in count.items() if k}
    if measured.scale is not None:
        row["metres_per_pixel"] = measured.scale.metres_per_pixel
        row["scale_relative_sd"] = measured.scale.relative_sd
        row["scale_from"] = measured.scale.how
    return row


def _write(folder: Path, name: str, measured: Measured, record: dict[str, Any]) -> None:
    """Write all files to a hidden folder, then move them into place, the record last."""
    folder.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=folder, prefix=".partial-") as partial:
        _fill(Path(partial), name, measured)
        (folder / RECORD).unlink(missing_ok=True)
        for file in sorted(Path(partial).iterdir()):
            file.replace(folder / file.name)
    _write_text(folder / RECORD, json.dumps(record, indent=1))


def _fill(folder: Path, name: str, measured: Measured) -> None:
    tables = [
        strands_table(measured, name),
        crossings_table(measured, name),
        densities_table(measured.interactions, measured.scale, name),
        densities_table(measured.densities, measured.scale, name),
    ]
    for file, table in zip(TABLES, tables, strict=True):
        table.to_csv(folder / file, index=False, float_format="%.7g", lineterminator="\n")
    found = (measured.photo, measured.segmentation, measured.strands, measured.crossings)
    labels = labels_picture(measured.segmentation, measured.strands)
    _write_picture(folder / "labels.png", labels)
    _write_picture(folder / "overlay.png", draw_overlay(*found)[..., ::-1])
    (folder / "overlay.svg").write_text(overlay_svg(*found), encoding="utf-8")
    if measured.densities is not None:
        _write_histogram(folder, measured)
    (folder / "DATA.md").write_text(_data_md(tables), encoding="utf-8")


def _write_picture(path: Path, pixels: np.ndarray) -> None:
    """Write a PNG through Python's own file handling, which knows any path and raises."""
    path.write_bytes(cv2.imencode(".png", pixels)[1].tobytes())


def _write_histogram(folder: Path, measured: Measured) -> None:
    assert measured.densities is not None
    assert measured.interactions is not None
    asked = measured.interactions.attrs["n_sec"]
    shown = measured.densities[measured.densities["rule"] == f"{asked} sections"].copy()
    shown.attrs = {"n_sec": asked}
    unit = "px"
    if measured.scale is not None:
        shown[["density", "low", "high"]] /= measured.scale.metres_per_pixel
        unit = "m"
    figure = histogram(shown, unit)
    figure.savefig(folder / "histogram.png", dpi=150)
    figure.savefig(folder / "histogram.svg", metadata={"Date": None})


def _data_md(tables: list[pd.DataFrame]) -> str:
    return (
        "# What the files hold\n\n"
        "Picture points are pixel centres at whole numbers, x to the right, y down; ImageJ counts "
        "from the corner: add 0.5.\nAn empty cell is unknown.\n\n"
        "- `strands.csv` centrelines, root (upper end) to tip\n"
        "- `crossings.csv` where strands cross, and which is on top\n"
        "- `interactions.csv` N-body interactions by section of the curl\n"
        "- `densities.csv` rho_N with intervals; by the rule asked for, by coarser and finer "
        "sections, and without sections\n"
        "- `labels.png` strand number of each pixel, 0 = background, the top strand wins\n"
        "- `overlay.png`, `overlay.svg` what was found, over the photograph\n"
        "- `provenance.json` what was measured, how, and by which versions\n\n"
    ) + columns_of(tables)


def _combine(output: Path, folders: list[Path]) -> None:
    """Gather the tables of all photographs."""
    for name in TABLES:
        parts = [pd.read_csv(folder / name) for folder in folders]
        parts = [part for part in parts if len(part)]
        if parts:
            text = pd.concat(parts, ignore_index=True).to_csv(index=False, float_format="%.7g")
            _write_text(output / name, text)
    if folders:
        shutil.copyfile(folders[0] / "DATA.md", output / "DATA.md")


def _write_text(path: Path, text: str) -> None:
    partial = path.with_name(f".{path.name}.partial")
    partial.write_text(text, encoding="utf-8")
    partial.replace(path)


def _summary(rows: list[dict[str, Any]], output: Path) -> str:
    lines = [_line(row) for row in rows]
    refused = sum(bool(row["refused"]) for row in rows)
    lines.append(f"{len(rows) - refused} measured, {refused} refused; results in {output}")
    return "\n".join(lines)


def _line(row: dict[str, Any]) -> str:
    if row["refused"]:
        return f"{row['photo']}: REFUSED, {row['refused']}"
    counts = ", ".join(f"{k} of {n}" for n, k in row.get("interactions", {}).items())
    text = f"{row['photo']}: {row['strands']} strands, {row['crossings']} crossings"
    text += f" (+ {row['self_crossings']} with themselves)"
    if "n_sec" in row:
        text += f"; interactions in {row['n_sec']} sections: {counts or 'none'}"
    if "metres_per_pixel" in row:
        text += f"; {1e3 * row['metres_per_pixel']:.4g} mm/px"
        text += f" +- {100 * row['scale_relative_sd']:.2g} % ({row['scale_from']})"
    else:
        text += "; no scale: lengths in pixels"
    return text
