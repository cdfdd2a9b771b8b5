"""``combing view``: a page on which a simulation moves."""

from __future__ import annotations

from pathlib import Path

import click

from combing.errors import UserError
from combing.progress import Bar


@click.command()
@click.argument("runs", nargs=-1, required=True, type=click.Path(path_type=Path))
@click.option("-o", "--output", type=click.Path(path_type=Path, dir_okay=False),
              help="The page; by default the run's name with .html for .nc.")  # fmt: skip
@click.option("--film", "film_path", type=click.Path(path_type=Path, dir_okay=False),
              help="Also a film of one run, .mp4 or .gif; needs combing[render].")  # fmt: skip
@click.option("--quiet", is_flag=True, help="No progress.")
def command(
    runs: tuple[Path, ...], output: Path | None, film_path: Path | None, quiet: bool
) -> None:
    """Write a page on which RUNS move: strands in space, force and link density.

    A RUN is the run.nc of `combing simulate` or a point of a sweep; of a run that has not ended its
    folder run.nc.part. Several stand side by side, moved together by x = d/D, or by time where a
    scene has no tine. Open the page in a browser: it needs no network. Drag to turn, wheel to come
    nearer, arrow keys or the bar for the next snapshot, space to play.

    \b
    Example:
      combing view out/run.nc
      combing view pi18/run.nc pi24/run.nc -o both.html
      combing view out/run.nc --film out/run.mp4
    """
    from combing.viewer import LIMIT, run_page, shown
    from combing.writing import write_text
    from sim import open_run

    opened = [open_run(path) for path in runs]
    if len({bool(run.scene.tines) for run in opened}) > 1:
        raise UserError(
            f"{runs[0]} and others: some have a tine and some have none; they have no common axis"
        )
    if film_path is not None and len(opened) > 1:
        raise UserError(f"--film {film_path}: shows one run, not {len(opened)}")
    if film_path is not None:
        from combing.viewer.film import film

        with Bar(total=1.0, desc=str(film_path), disable=quiet) as bar:
            film(opened[0], film_path, progress=lambda done: bar.update(done - bar.n))
        click.echo(f"{film_path}: {film_path.stat().st_size / 1e6:.1f} MB")
    packed = [shown(run, limit=LIMIT / len(opened)) for run in opened]
    page = output or runs[0].with_name(runs[0].name.removesuffix(".part")).with_suffix(".html")
    write_text(page, run_page(packed))
    thinned = [
        f"; {path}: every {one.every}th snapshot, for the page's size"
        for path, one in zip(runs, packed, strict=True)
        if one.every > 1
    ]
    click.echo(f"{page}: {page.stat().st_size / 1e6:.1f} MB" + "".join(thinned))
