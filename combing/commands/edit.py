"""``combing edit``: a page over a photograph, to correct its measurement by hand."""

from pathlib import Path

import click
from tqdm import tqdm

import imaging
from combing.errors import UserError, is_users_fault
from combing.photographs import find_photographs
from combing.writing import write_text
from imaging.correct import SUFFIX, Corrections, beside
from imaging.edit import Place, edit_page
from imaging.measure import measure
from imaging.photo.region import Box, parse_region

PAGE = ".edit.html"


@click.command()
@click.argument("files", nargs=-1, required=True)
@click.option("-o", "--output", type=click.Path(path_type=Path, file_okay=False),
              help="Folder for the pages; by default that of the photograph.")  # fmt: skip
@click.option("--n-sec", type=click.IntRange(min=1), default=20, show_default=True,
              help="Sections of the curl's axis for the N-body table.")  # fmt: skip
@click.option("--roi", help="Look only inside, as in `combing photo`.")
@click.option("--ignore", type=click.Path(), help="Mask picture; white is ignored.")
@click.option("--quiet", is_flag=True, help="No progress.")
def command(
    files: tuple[str, ...],
    output: Path | None,
    n_sec: int,
    roi: str | None,
    ignore: str | None,
    quiet: bool,
) -> None:
    """Write a page on which a photograph's measurement is corrected by hand.

    FILES are photographs, folders or patterns, as for `combing photo`. Open PHOTO.edit.html in a
    browser (it needs no network): click strands to delete, split, join or exchange them, draw what
    is missing, click crossings to say who is on top. Save, and put PHOTO.corrections.json beside
    the photograph: whatever measures it picks that up. A page goes on from the corrections there.

    \b
    Example:
      combing edit curl.jpg
      combing edit session/ -o pages/
    """
    paths = find_photographs(files)
    _refuse_clashes([_page(path, output) for path in paths])
    region = parse_region(roi) if roi else None
    photos, refused = _readable(paths, region, ignore)
    pages = [_page(path, output) for path in photos]
    if output is not None:
        output.mkdir(parents=True, exist_ok=True)
    for number, path in enumerate(tqdm(photos, unit="photo", disable=quiet or len(paths) == 1)):
        photo = imaging.read_photo(path, roi=region, ignore=ignore)
        told = _written(photo, pages[number], n_sec, _place(pages, number))
        click.echo(f"{path.name}: {told}; {pages[number]}")
    for line in refused:
        click.echo(line)
    click.echo(f"open it in a browser; put what it saves, PHOTO{SUFFIX}, beside the photograph")


def _readable(
    paths: list[Path], region: Box | Path | None, ignore: str | None
) -> tuple[list[Path], list[str]]:
    """Part photographs that can be read from those that cannot, and why: no page is linked to."""
    photos, refused = [], []
    for path in paths:
        try:
            imaging.read_photo(path, roi=region, ignore=ignore)
            photos.append(path)
        except Exception as error:
            if not is_users_fault(error) or len(paths) == 1:
                raise
            refused.append(f"{path.name}: REFUSED, {error}")
    return photos, refused


def _page(path: Path, output: Path | None) -> Path:
    return (output or path.parent) / f"{path.name}{PAGE}"


def _refuse_clashes(pages: list[Path]) -> None:
    twice = next((page for page in pages if pages.count(page) > 1), None)
    if twice is not None:
        raise UserError(
            f"{twice}: would be the page of two photographs of one name in two folders; "
            "leave out -o, or give one folder at a time"
        )


def _place(pages: list[Path], number: int) -> Place:
    """Links to the pages before and after, if they lie in the same folder."""
    if len(pages) == 1:
        return Place()
    here = pages[number].parent

    def link(other: int) -> str:
        there = 0 <= other < len(pages) and pages[other].parent == here
        return pages[other].name if there else ""

    return Place(link(number - 1), link(number + 1), f"{number + 1} of {len(pages)}")


def _written(photo: imaging.Photo, page: Path, n_sec: int, place: Place) -> str:
    """Measure a photograph as if nobody had said anything, and write its page."""
    said = beside(photo.source)
    corrections = Corrections() if said is None else imaging.read_corrections(said)
    try:
        found, refused = measure(photo, n_sec=n_sec, corrections=None), ""
    except imaging.Unmeasurable as error:
        found, refused = None, str(error)
    write_text(page, edit_page(photo, found, corrections, refused=refused, place=place))
    told = f"{len(found.strands)} strands" if found is not None else f"not measured ({refused})"
    return told if said is None else f"{told}, corrections of {said.name}"
