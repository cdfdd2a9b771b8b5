"""What ``combing helix`` does with a film."""

import json
import os
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import click

import instron
from combing.errors import UserError
from combing.figures.film import draw_film
from combing.figures.style import write_pictures
from combing.film import Asked, Way, film_sequence, film_table, measure_film, started
from combing.view import View, metres
from imaging.photo.film import is_film


@dataclass(frozen=True)
class FilmOptions:
    """What was asked of every frame, lambda_0 where it is known, and what is printed."""

    view: View
    root: str
    pair: int
    before: tuple[float, float] | None
    as_json: bool
    quiet: bool


def measure(
    films: tuple[Path, ...],
    others: Mapping[str, Any],
    options: FilmOptions,
    output: Path,
    told: Mapping[str, Any],
    put: Callable[[Path, Callable[[Path], None]], None],
) -> None:
    """Measure a film, write its tables and its figure, print a summary.

    Parameters
    ----------
    films : tuple of Path
        One.
    others : mapping
        Options that are not for a film; each must be None.
    options : FilmOptions
    output : Path
    told : mapping
        ``every, speed, log, start, jobs`` as on the command line.
    put : callable
        Has a folder filled, whole or not at all.

    Raises
    ------
    UserError
        If an option is not understood or does not go with a film.
    """
    if len(films) != 1 or not is_film(films[0]):
        raise UserError("--every, --speed, --log, --start and --jobs are for one film, as run.mp4")
    wrong = [name for name, value in others.items() if value is not None]
    if wrong:
        raise UserError(f"{wrong[0]}: is for photographs, not for a film")
    way = _way(told["speed"], told["log"], told["start"])
    asked = Asked(
        films[0], options.view, options.root, options.pair, way, _every(told["every"] or "1mm")
    )
    jobs = told["jobs"] or os.cpu_count() or 1
    records = measure_film(asked, output / "frames", options.before, jobs=jobs, quiet=options.quiet)
    table, sequence = film_table(records), film_sequence(records)
    unit = next(one["unit"] for one in records if not one["refused"])

    def fill(folder: Path) -> None:
        profiles = sequence.profiles.rename(columns={"x": "d"})
        for name, one in (("film", table), ("profiles", profiles)):
            one.to_csv(
                folder / f"{name}.csv", index=False, float_format="%.7g", lineterminator="\n"
            )
        write_pictures(draw_film(table, sequence, way.log, unit), folder / "film")

    put(output, fill)
    if options.as_json:
        click.echo(json.dumps([{k: v for k, v in one.items() if k not in ("profile", "key")}
                               for one in records], indent=1))  # fmt: skip
    elif not options.quiet:
        refused = table[table["refused"] != ""]
        click.echo(
            f"{films[0].name}: {len(table)} frames, d from 0 to {1e3 * table['d'].max():.1f} mm, "
            f"{len(refused)} not measured; results in {output}"
        )


def _way(speed: str | None, log: Path | None, start: str | None) -> Way:
    """Understand where the tine is over time."""
    if (speed is None) == (log is None):
        raise UserError("a film needs --speed of the tine, as 1mm/s, or --log, a force log")
    begins = None if start is None else _seconds(start)
    if log is None:
        return Way(speed=_speed(str(speed)), start=begins)
    logs = instron.read(log)
    if len(logs) != 1:
        raise UserError(f"{log}: holds {len(logs)} specimens; give the log of the film alone")
    return Way(log=started(logs[0]), start=begins)


def _speed(text: str) -> float:
    try:
        value = metres(text.removesuffix("/s"))
    except ValueError:
        value = 0.0
    if not value > 0:
        raise UserError(f"--speed {text}: give a length a second, as 1mm/s")
    return value


def _every(text: str) -> tuple[float, str]:
    unit = "s" if text.endswith("s") else "m"
    try:
        value = float(text.removesuffix("s")) if unit == "s" else metres(text)
    except ValueError:
        value = 0.0
    if not value > 0:
        raise UserError(f"--every {text}: give a time, as 0.5s, or a length, as 1mm")
    return value, unit


def _seconds(text: str) -> float:
    try:
        return float(text.removesuffix("s"))
    except ValueError:
        raise UserError(f"--start {text}: give seconds, as 2.5s") from None
