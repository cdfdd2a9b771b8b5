"""``combing photo``: photographs to strands, crossings, N-body interactions and link density."""

import json
import tempfile
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import click
from tqdm import tqdm

from combing.errors import UserError, is_users_fault
from combing.photo_files import earlier, fingerprint, write_batch, write_photo
from combing.photographs import find_photographs
from combing.view import View, said_of
from imaging.correct import SUFFIX, Hand, beside
from imaging.errors import Unmeasurable
from imaging.measure import BESIDE, Measured, measure
from imaging.photo.decode import Picture, refuse_unless_file
from imaging.photo.pages import pages_of
from imaging.photo.region import FORMS as REGION_FORMS
from imaging.scale import FORMS


@dataclass(frozen=True)
class Options:
    """What was asked for; part of the record that lets a batch be taken up again."""

    scale: str | None
    n_sec: int
    roi: str | None
    ignore: str | None
    corrections: str | None
    strands: int | None
    colours: str | None


@click.command()
@click.argument("files", nargs=-1, required=True)
@click.option("-o", "--output", type=click.Path(path_type=Path, file_okay=False), required=True,
              help="Folder for the results; several photos get a folder each.")  # fmt: skip
@click.option("--scale", help=f"Pixels to metres: {FORMS}. Without it, results are in pixels.")
@click.option("--n-sec", type=click.IntRange(min=1), default=20, show_default=True,
              help="Sections of the curl's axis for N-body interactions.")  # fmt: skip
@click.option("--roi", help=f"Look only inside {REGION_FORMS}.")
@click.option("--ignore", type=click.Path(), help="Mask picture; white is ignored.")
@click.option("--corrections", "file", type=click.Path(),
              help="What a hand says of a photograph (one photograph only); by default the file "
              "PHOTO.corrections.json beside it.")  # fmt: skip
@click.option("--no-corrections", is_flag=True, help="Measure as if nobody had said anything.")
@click.option("--strands", type=click.IntRange(min=1), help="How many strands there are.")
@click.option("--colours", help="Colours of the strands, #rrggbb,#rrggbb,...; others are left out.")
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
    file: str | None,
    no_corrections: bool,
    strands: int | None,
    colours: str | None,
    again: bool,
    as_json: bool,
    quiet: bool,
) -> None:
    """Trace coloured strands and count their crossings and N-body interactions.

    FILES are photographs (JPEG, PNG, TIFF; HEIC and camera RAW with the extra 'formats'), folders,
    patterns, or sequences like frame_%04d.png. A batch that was interrupted takes up where it
    stopped; a photograph that cannot be measured is listed with its reason and does not stop the
    others. Each page of a TIFF of several is a photograph of its own.

    \b
    Example:
      combing photo curl.jpg --scale marker:20mm -o out/
      combing photo session/ --scale 41.5px/mm+-1% --n-sec 20 -o out/
      combing photo session/*.jpg --scale charuco:7x5,15mm,11mm@board.jpg -o out/
      combing photo hairs.jpg --strands 12 --corrections hairs.corrections.json -o out/
    """
    paths = find_photographs(files)
    _refuse_output(output, paths)
    pictures = [picture for path in paths for picture in _pictures(path)]
    _refuse_corrections(file, no_corrections, pictures)
    source = file or (None if no_corrections else BESIDE)
    options = Options(scale, n_sec, roi, ignore, source, strands, colours)
    asked = _Asked(options, View.asked(scale, roi, ignore), again)
    if len(pictures) == 1:
        rows, defect = [_one(pictures[0], output, paths[0].name, asked)], None
    else:
        rows, defect = _batch(pictures, output, asked, quiet)
    click.echo(json.dumps(rows, indent=1) if as_json else _summary(rows, output))
    if defect is not None:
        raise defect
    if all(row["refused"] for row in rows):
        raise UserError(f"none of the {len(rows)} photographs could be measured (reasons above)")


@dataclass(frozen=True)
class _Asked:
    options: Options
    view: View
    again: bool


def _pictures(path: Path) -> list[Picture]:
    """Each page of a TIFF of several; what cannot be read is one picture, and refused later."""
    try:
        refuse_unless_file(path)
        pages = pages_of(path)
    except Unmeasurable:
        return [Picture(path)]
    return [Picture(path, page) for page in pages] if len(pages) > 1 else [Picture(path)]


def _batch(
    pictures: list[Picture], output: Path, asked: _Asked, quiet: bool
) -> tuple[list[dict[str, Any]], Exception | None]:
    """Measure each photograph into a folder of its own; returns the summary and a defect of ours.

    What cannot be measured does not stop the others, and neither does a defect, which is only
    raised in the end.
    """
    rows, done, defect = [], [], None
    for picture, name in tqdm(
        list(zip(pictures, _names(pictures), strict=True)), unit="photo", disable=quiet
    ):
        try:
            rows.append(_one(picture, output / name, name + picture.path.suffix, asked))
            done.append(output / name)
        except Exception as error:
            rows.append(_which(picture) | {"refused": _reason(error)})
            if not is_users_fault(error):
                defect = defect or error
    write_batch(output, done, rows)
    return rows, defect


def _which(picture: Picture) -> dict[str, Any]:
    page = {} if picture.page is None else {"page": picture.page}
    return {"photo": picture.path.name} | page


def _refuse_corrections(file: str | None, none: bool, pictures: list[Picture]) -> None:
    if file and none:
        raise UserError("--corrections and --no-corrections: give one of them")
    if file and len(pictures) > 1:
        raise UserError(
            f"--corrections {file}: is of one photograph, not of {len(pictures)}; put a file "
            f"PHOTO{SUFFIX} beside each"
        )


def _refuse_output(output: Path, paths: list[Path]) -> None:
    """Find out now, not after the last photograph, that results cannot be written."""
    if any(path.absolute().parent.resolve() == output.resolve() for path in paths):
        raise UserError(
            f"{output}: is the folder of the photographs; pictures of the results would be taken "
            "for photographs the next time: give another folder with -o"
        )
    there = next(p for p in (output.absolute(), *output.absolute().parents) if p.exists())
    if not there.is_dir():
        raise UserError(f"{there}: is a file; -o wants a folder")
    try:
        with tempfile.TemporaryDirectory(dir=there, prefix=".partial-"):
            pass
    except OSError as error:
        raise UserError(
            f"{output}: cannot be written ({error.strerror}); give another folder with -o"
        ) from error


def _names(pictures: list[Picture]) -> list[str]:
    """Name each photograph's folder, pages after their file; equal names get a number."""
    names: list[str] = []
    taken: set[str] = set()
    digits = len(str(max(page or 0 for _, page in pictures)))
    for path, page in pictures:
        stem = path.stem if page is None else f"{path.stem}-page-{page:0{digits}d}"
        name, number = stem, 2
        while name.casefold() in taken:  # some file systems do not tell A from a
            name, number = f"{stem}-{number}", number + 1
        taken.add(name.casefold())
        names.append(name)
    return names


def _said_beside(picture: Picture) -> Path | None:
    """Return the corrections beside a photograph; those of all pages at once are refused."""
    said = beside(f"{picture}")
    if said is None and picture.page and (whole := beside(picture.path)) is not None:
        raise UserError(
            f"{whole}: is of one photograph, {picture.path.name} holds several; name it after the "
            f"page it is of, as '{Path(f'{picture}').name}{SUFFIX}'"
        )
    return said


def _reason(error: Exception) -> str:
    if is_users_fault(error):
        return str(error)
    return f"a defect of this program ({type(error).__name__}: {error}); please report it"


def _one(picture: Picture, folder: Path, name: str, asked: _Asked) -> dict[str, Any]:
    """Measure one photograph into its folder; returns its line of the summary."""
    options, view = asked.options, asked.view
    board = view.scale.board if view.scale else None
    said = _said_beside(picture) if options.corrections == BESIDE else options.corrections
    besides = [
        Path(one) for one in (view.roi, view.ignore, board, said) if isinstance(one, str | Path)
    ]
    record: dict[str, Any] = {"input": fingerprint(picture, asdict(options), besides)}
    if not asked.again and (old := earlier(folder, record["input"])) is not None:
        return old | {"kept": True}
    photo = view.read(*picture)
    colours = options.colours.split(",") if options.colours else None
    words = said_of(photo, said, "the command line", strands=options.strands, colours=colours)
    measured = measure(photo, view.scale, options.n_sec, corrections=words)
    record["exif"] = photo.exif
    record["corrections"] = _hand(said, measured.hand)
    record["summary"] = _row(picture, measured)
    write_photo(folder, name, measured, record)
    return record["summary"]


def _hand(file: str | Path | None, hand: Hand) -> dict[str, Any]:
    """Tell what a hand did, for the record."""
    said = hand.corrections.model_dump(mode="json", by_alias=True, exclude_none=True)
    return {
        "file": None if file is None else Path(file).name,
        "said": said if hand.corrections else None,
        "outcomes": [asdict(one) for one in hand.outcomes],
    }


def _row(picture: Picture, measured: Measured) -> dict[str, Any]:
    kinds = measured.crossings["kind"]
    row: dict[str, Any] = {
        **_which(picture),
        "refused": "",
        "strands": len(measured.strands),
        "colours": len(measured.segmentation.colours),
        "crossings": int((kinds == "inter").sum()),
        "self_crossings": int((kinds == "self").sum()),
        "unassigned": len(measured.unassigned),
        "over_unknown": int(measured.crossings["over"][kinds == "inter"].isna().sum()),
        "ends": [list(strand.ends) for strand in measured.strands],
        "strand_width_px": round(measured.segmentation.width, 2),
        "notes": measured.notes,
    }
    if measured.hand.outcomes:
        row["corrections"] = measured.hand.tally()
    if measured.interactions is not None:
        count = measured.interactions.groupby("N")["count"].sum()
        row["n_sec"] = measured.interactions.attrs["n_sec"]
        row["interactions"] = {str(n): int(k) for n, k in count.items() if k}
    if measured.scale is not None:
        row["metres_per_pixel"] = measured.scale.metres_per_pixel
        row["scale_relative_sd"] = measured.scale_sd
        row["scale_from"] = measured.scale.how
    row["wind"] = [
        {"strands": list(pair), "handedness": helix.handedness, "total_link": helix.total_link,
         "total_link_sd": helix.total_link_sd, "notes": list(helix.warnings)}
        for pair, helix in measured.links.items()
    ]  # fmt: skip
    return row


def _summary(rows: list[dict[str, Any]], output: Path) -> str:
    lines = [line for row in rows for line in _lines(row)]
    refused = sum(bool(row["refused"]) for row in rows)
    kept = sum(bool(row.get("kept")) for row in rows)
    before = f" ({kept} of them before; --again measures anew)" if kept else ""
    lines.append(f"{len(rows) - refused} measured{before}, {refused} refused; results in {output}")
    if not any("metres_per_pixel" in row for row in rows) and refused < len(rows):
        lines.append("no scale: lengths in pixels; give --scale for metres")
    return "\n".join(lines)


def _lines(row: dict[str, Any]) -> list[str]:
    """Say what was found in a photograph, and below it what is doubtful."""
    name = f"{row['photo']}, page {row['page']}" if "page" in row else row["photo"]
    if row["refused"]:
        return [f"{name}: REFUSED, {row['refused']}"]
    counts = ", ".join(f"{k} of {n}" for n, k in row.get("interactions", {}).items())
    text = f"{name}: {_number(row['strands'], 'strand')}"
    text += f", {_number(row['crossings'], 'crossing')}"
    if row["over_unknown"]:
        text += f" ({row['over_unknown']} with unknown top)"
    if row["self_crossings"]:
        text += f", {_number(row['self_crossings'], 'self-crossing')}"
    if "n_sec" in row:
        text += f"; interactions in {row['n_sec']} sections: {counts or 'none'}"
    if "metres_per_pixel" in row:
        text += f"; {1e3 * row['metres_per_pixel']:.4g} mm/px"
        text += f" +- {100 * row['scale_relative_sd']:.2g} % ({row['scale_from']})"
    wind = [
        f"  strands {w['strands'][0]} and {w['strands'][1]} wind {w['handedness']}-handed, "
        f"{abs(w['total_link']):.3f} +- {w['total_link_sd']:.3f} turns"
        for w in row["wind"]
    ]
    return [text, *wind, *(f"  note: {note}" for note in row["notes"])]


def _number(count: int, what: str) -> str:
    return f"{count} {what}{'' if count == 1 else 's'}"
