"""``combing helix``: photographs of two twisted strands to link density along their axis."""

import json
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import click
import cv2
import numpy as np
import pandas as pd
from tqdm import tqdm

from combing.commands.film import FilmOptions, measure
from combing.errors import UserError, is_users_fault
from combing.figures.style import write_pictures
from combing.view import View, measure_pair, metres
from imaging.helix.measurement import HelixMeasurement
from imaging.helix.sequence import HelixSequence, first_link, kymograph, sequence_of
from imaging.photo import Photo
from imaging.photo.film import is_film
from imaging.photo.region import FORMS as REGION_FORMS
from imaging.report.helix_pictures import (
    draw_helix_overlay,
    kymograph_figure,
    link_figure,
    sequence_figure,
)
from imaging.scale import FORMS, METRES

COLUMNS = {
    "s": "arclength of the axis from the root [UNIT]",
    "link": "link density [1/UNIT], right-handed > 0; empty: not resolved",
    "sd": "standard deviation of the column before it",
    "phi": "phase [rad]: pi/2 + 2 pi n where strand a is in front",
    "R": "helix radius [UNIT]",
    "R_sd": "its standard deviation [UNIT]",
    "x, y": "axis in the picture [px], pixel centres at whole numbers, x right, y down",
    "resolved": "whether the helix is measured there",
    "by": "what tells it: edges followed, half-turns counted from the colours, or the sides on "
    "which strands hang behind a tine (sides: the mean over a pitch)",
    "front": "strand in front at a crossing",
    "sense": "+1 right-handed, -1 left-handed",
    "confidence": "width by which the front strand shows more than the other, over its width",
    "frame": "number of the photograph in the series, from 0",
    "change, change_sd": "(lambda - lambda_0) / lambda_0",
    "lambda_0": "link density before combing, but for a pitch at either end [1/UNIT]",
    "reach": "length on either side of the tine that is left out, a quarter of a pitch [UNIT]",
    "behind, ahead": "mean link density over a pitch, 1/lambda_0, beyond the reach on the root's "
    "and on the tip's side [1/UNIT], in the sense of the helix > 0",
    "jump": "(ahead - behind) / lambda_0",
    "tine": "arclength of the tine [UNIT]",
    "turns, turns_sd": "link from root to tip [turns]; what is missing has left by the free end",
}


@dataclass(frozen=True)
class Options:
    """What was asked of every photograph."""

    view: View
    root: str
    pair: int
    tine: tuple[float, ...] | None


@click.command()
@click.argument("photos", nargs=-1, required=True, type=click.Path(path_type=Path))
@click.option(
    "-o",
    "--output",
    type=click.Path(path_type=Path, file_okay=False),
    required=True,
    help="Folder for the results; one folder inside for each of several photos.",
)
@click.option("--scale", help=f"Pixels to metres: {FORMS}. Without it, results are in pixels.")
@click.option("--root", type=click.Choice(["top", "bottom", "left", "right"]), default="top",
              show_default=True, help="Side of the picture where the clamped end is.")  # fmt: skip
@click.option("--pair", type=click.IntRange(min=1), default=1, show_default=True,
              help="Which of several pairs that wind, from the one of the most turns.")  # fmt: skip
@click.option("--tine", help="Where the tine crosses, as X,Y or X,Y,RADIUS [px].")
@click.option("--positions", help="Displacements d of the tine: the photos are a series; as "
              "0.01,0.03,... in metres, or 10mm,30mm,...")  # fmt: skip
@click.option("--combed", help="With --positions: displacement D at which combing ends, as 85mm.")
@click.option("--x", help="Instead of --positions and --combed: x = d/D, as 0.1,0.3,...")
@click.option(
    "--before",
    type=click.Path(path_type=Path),
    help="In a series: photo before combing; else the first one is taken.",
)
@click.option("--every", help="Of a film: a frame every so often, as 0.5s, or so far, as 1mm "
              "[default: 1mm].")  # fmt: skip
@click.option("--speed", help="Of a film: speed of the tine, as 1mm/s.")
@click.option("--log", type=click.Path(path_type=Path),
              help="Of a film: force log with times, instead of --speed.")  # fmt: skip
@click.option("--start", help="Of a film: when the tine starts, as 2.5s; else it is seen.")
@click.option("--jobs", type=click.IntRange(min=1), help="Of a film: processes; else all cores.")
@click.option("--roi", help=f"Look only inside {REGION_FORMS}.")
@click.option("--ignore", type=click.Path(), help="Mask picture; white is ignored.")
@click.option("--json", "as_json", is_flag=True, help="Print the summary as JSON.")
@click.option("--quiet", is_flag=True, help="No progress, no summary.")
def command(
    photos: tuple[Path, ...],
    output: Path,
    scale: str | None,
    root: str,
    pair: int,
    tine: str | None,
    positions: str | None,
    combed: str | None,
    x: str | None,
    before: Path | None,
    roi: str | None,
    ignore: str | None,
    as_json: bool,
    quiet: bool,
    **film: Any,
) -> None:
    """Measure link density, radius and handedness of two strands wound round each other.

    The strands must differ in colour. With --positions or --x, the photographs are a series while
    a tine combs the helix: the change of link density and the jump across the tine are drawn too.
    So are they of a film, with the force; called again it goes on where it stopped.

    \b
    Example:
      combing helix helix.jpg --scale marker:20mm -o out/
      combing helix frame_*.png --positions 10mm,30mm,50mm --combed 85mm --before rest.png \
        --scale 41px/mm -o out/
      combing helix run.mp4 --every 2mm --log run.csv --scale 41px/mm -o out/
    """
    view = View.asked(scale, roi, ignore)
    options = Options(view, root, pair, _numbers("--tine", tine, (2, 3), float))
    if is_film(photos[0]) or any(film.values()):
        others = {"--tine": tine, "--positions": positions, "--combed": combed, "--x": x}
        link = None if before is None else first_link(_measure(before, options)[1])
        asked = FilmOptions(view, root, pair, link, as_json, quiet)
        measure(photos, others, asked, output, film, _put)
        return
    places = _scaled(positions, combed, x, len(photos))
    if before is not None and places is None:
        raise UserError("--before needs --positions or --x, one for each photograph")
    rest = None if before is None else _measure(before, options)[1]
    rows, measured = _measure_all(photos, output, options, places is not None, quiet)
    if places is not None:
        first = rest or measured[0]
        sequence = sequence_of(measured, places, first_link(first))
        _put(output, lambda folder: _fill_sequence(folder, sequence))
    if as_json:
        click.echo(json.dumps(rows, indent=1))
    elif not quiet:
        click.echo("\n".join([*(_line(row) for row in rows), f"results in {output}"]))
    if not measured:
        raise UserError(f"none of the {len(rows)} photographs could be measured (reasons above)")


def _numbers(
    name: str, text: str | None, counts: tuple[int, ...], kind: Callable[[str], Any]
) -> tuple[Any, ...] | None:
    """Read numbers separated by commas from an option."""
    if text is None:
        return None
    try:
        values = tuple(kind(part) for part in text.split(","))
    except ValueError:
        values = ()
    if len(values) not in counts:
        wanted = " or ".join(map(str, counts))
        what = f"lengths, as 0.01 or 10mm ({', '.join(METRES)})," if kind is metres else "numbers"
        raise UserError(f"{name} {text}: give {wanted} {what} separated by commas")
    return values


def _scaled(
    positions: str | None, combed: str | None, x: str | None, count: int
) -> tuple[float, ...] | None:
    """Return x = d/D of every photograph, as given or from d and D; None without a series."""
    if x is not None and (positions or combed):
        raise UserError("--x: is d/D already; leave out --positions and --combed")
    if (positions is None) != (combed is None):
        raise UserError(
            "--positions (d) and --combed (D) go together; where x = d/D is known give --x"
        )
    if positions is None or combed is None:
        return _numbers("--x", x, (count,), float)
    (D,) = _numbers("--combed", combed, (1,), metres) or ()
    if not D > 0:
        raise UserError(f"--combed {combed}: D must be positive")
    return tuple(d / D for d in _numbers("--positions", positions, (count,), metres) or ())


def _measure_all(
    photos: tuple[Path, ...], output: Path, options: Options, whole: bool, quiet: bool
) -> tuple[list[dict[str, Any]], list[HelixMeasurement]]:
    """Measure every photograph into its folder; a bad one is listed unless the series needs it."""
    rows, measured = [], []
    names = _folder_names(photos)
    for path, name in tqdm(
        list(zip(photos, names, strict=True)), unit="photo", disable=quiet or len(photos) < 2
    ):
        try:
            photo, found = _measure(path, options)
        except Exception as error:
            if whole or len(photos) == 1 or not is_users_fault(error):
                raise
            rows.append({"photo": path.name, "refused": str(error)})
            continue
        folder = output if len(photos) == 1 else output / name
        row = _row(path, found)
        _put(folder, partial(_fill, photo=photo, found=found, row=row))
        rows.append(row)
        measured.append(found)
    return rows, measured


def _folder_names(photos: tuple[Path, ...]) -> list[str]:
    names: list[str] = []
    for path in photos:
        taken = names.count(path.stem)
        names.append(f"{path.stem}-{taken + 1}" if taken else path.stem)
    return names


def _measure(path: Path, options: Options) -> tuple[Photo, HelixMeasurement]:
    return measure_pair(path, options.view, root=options.root, pair=options.pair, tine=options.tine)


def _row(path: Path, found: HelixMeasurement) -> dict[str, Any]:
    """Summarise one photograph, in plain numbers."""
    numbers = ("total_link", "total_link_sd", "pitch", "pitch_sd", "R", "R_sd", "r", "resolution")
    return {
        "photo": path.name,
        "refused": "",
        "handedness": found.handedness,
        **{name: float(f"{getattr(found, name):.7g}") for name in numbers},
        "lean_degrees": round(float(np.degrees(found.lean)), 3),
        "tine": found.tine,
        "unit": found.unit,
        "warnings": list(found.warnings),
    }


def _line(row: dict[str, Any]) -> str:
    if row["refused"]:
        return f"{row['photo']}: REFUSED, {row['refused']}"
    unit, factor = ("mm", 1e3) if row["unit"] == "m" else ("px", 1.0)
    text = (
        f"{row['photo']}: {row['handedness']}-handed, {abs(row['total_link']):.3f} "
        f"+- {row['total_link_sd']:.3f} turns, pitch {factor * row['pitch']:.4g} "
        f"+- {factor * row['pitch_sd']:.2g} {unit}, R {factor * row['R']:.4g} {unit}, "
        f"R/r {row['R'] / row['r']:.3f}"
    )
    if row["unit"] == "px":
        text += "; no scale: lengths in pixels"
    return "\n".join([text, *(f"  note: {warning}" for warning in row["warnings"])])


def _put(folder: Path, fill: Callable[[Path], None]) -> None:
    """Write all files to a hidden folder, then move them into place."""
    folder.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=folder, prefix=".partial-") as hidden:
        fill(Path(hidden))
        for file in sorted(Path(hidden).iterdir()):
            file.replace(folder / file.name)


def _fill(folder: Path, photo: Photo, found: HelixMeasurement, row: dict[str, Any]) -> None:
    _write_table(folder / "link.csv", found.link_density)
    _write_table(folder / "phase.csv", found.phase)
    _write_table(folder / "crossings.csv", found.crossings)
    overlay = draw_helix_overlay(photo, found)[..., ::-1]
    (folder / "overlay.png").write_bytes(cv2.imencode(".png", overlay)[1].tobytes())
    write_pictures(link_figure(found), folder / "link")
    (folder / "summary.json").write_text(json.dumps(row, indent=1), encoding="utf-8")
    (folder / "DATA.md").write_text(_data_md(found.unit), encoding="utf-8")


def _fill_sequence(folder: Path, sequence: HelixSequence) -> None:
    _write_table(folder / "profiles.csv", sequence.profiles)
    _write_table(folder / "jumps.csv", sequence.jumps)
    x, s, change = kymograph(sequence)
    names = [f"{number}: x={place:.4g}" for number, place in enumerate(x)]
    table = pd.DataFrame({"s": s} | dict(zip(names, change, strict=True)))
    _write_table(folder / "kymograph.csv", table)
    write_pictures(sequence_figure(sequence), folder / "change")
    write_pictures(kymograph_figure(sequence), folder / "kymograph")
    unit = sequence.measurements[0].unit
    (folder / "DATA.md").write_text(_data_md(unit), encoding="utf-8")


def _write_table(path: Path, table: pd.DataFrame) -> None:
    table.to_csv(path, index=False, float_format="%.7g", lineterminator="\n")


def _data_md(unit: str) -> str:
    rows = "\n".join(f"| {name} | {text.replace('UNIT', unit)} |" for name, text in COLUMNS.items())
    return (
        "# What the files hold\n\n"
        "- `link.csv` link density along the axis; `phase.csv` phase, radius, axis\n"
        "- `crossings.csv` half-turns; `summary.json` the helix in a few numbers\n"
        "- `overlay.png` axis (white), outlines of strand a (amber) and b (cyan), a dot in the "
        "colour of the strand in front at each crossing\n"
        "- `link.png`, `link.svg` link density and radius with 95 % bands\n"
        "- of a series: `profiles.csv`, `jumps.csv`, `kymograph.csv` (a column for each tine "
        "position), `change.png`, "
        "`kymograph.png` and the same as SVG\n\n"
        f"Lengths are in {unit}.\n\n| column | meaning |\n|---|---|\n{rows}\n"
    )
