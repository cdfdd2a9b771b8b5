"""The bench: measure everything a study names, compare it, draw it, and write it down."""

import shutil
import tempfile
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

import pandas as pd
from tqdm import tqdm

import sim
from combing.compare.comparison import Comparison, all_errors, joined
from combing.compare.curl import compare_curl, measure_curl
from combing.compare.force import compare_force, measure_force
from combing.compare.link import compare_link, measure_link
from combing.compare.pages import write_pages
from combing.errors import UserError
from combing.photographs import Refused, tried
from combing.runs import simulating
from combing.study import Study

T = TypeVar("T")


@dataclass(frozen=True)
class Result:
    """What a comparison leaves: where the report is, and the comparisons by kind."""

    report: Path
    comparisons: dict[str, Comparison]

    @property
    def errors(self) -> pd.DataFrame:
        """Every pipeline's error against truth, one row a quantity; empty without truth."""
        return all_errors(self.comparisons)


def compare(study: Study, out: Path, *, jobs: int | None = None, quiet: bool = False) -> Result:
    """Carry out a study and write figures, tables and the report into `out`.

    Strategy: the scenes are simulated in processes of their own while the photographs and logs
    are measured here. Runs are kept in ``out/runs`` and used again; everything else is written
    to a temporary folder and moved into place when all of it is done.

    Parameters
    ----------
    study : Study
        From `load_study`.
    out : Path
        Folder for the results.
    jobs : int, optional
        Simulations at once; as many as there are cores when absent.
    quiet : bool
        Show no progress.

    Raises
    ------
    Exception
        Whatever an instrument says of an input that is at fault.
    """
    if out.exists() and not out.is_dir():
        raise UserError(f"{out}: is a file; -o wants a folder")
    scenes = {path: sim.load_scene(path) for path in study.simulations if path.suffix != ".nc"}
    runs = {path: sim.open_run(path) for path in study.simulations if path.suffix == ".nc"}
    with _tidy_after_failure(out), simulating(scenes, out / "runs", jobs=jobs, quiet=quiet) as wait:
        measured = _measure(study, quiet)
        runs |= wait()
        comparisons = _compare(study, measured, runs)
        return Result(_write(study, comparisons, runs, out), comparisons)


@dataclass(frozen=True)
class _Measured:
    """What was measured of the experiment, in the order of the study."""

    force: list[list[pd.DataFrame]]
    before: list[pd.DataFrame | Refused | None]
    link: list[list[pd.DataFrame | Refused]]
    curl: list[list[pd.DataFrame | Refused]]


def _measure(study: Study, quiet: bool) -> _Measured:
    force = [measure_force(one) for one in study.force]
    photos = sum(len(one.photos) + bool(one.before) for one in study.link)
    photos += sum(len(one.photos) for one in study.curl)
    with tqdm(total=photos, desc="measuring photographs", disable=quiet or not photos) as bar:

        def counted(function: Callable[..., T], *arguments: Any) -> T | Refused:
            result = tried(function, *arguments)
            bar.update()
            return result

        return _Measured(
            force,
            [counted(measure_link, one.before, one) if one.before else None for one in study.link],
            [[counted(measure_link, photo, one) for photo in one.photos] for one in study.link],
            [
                [counted(measure_curl, photo, one, study.n_sec) for photo in one.photos]
                for one in study.curl
            ],
        )


def _compare(
    study: Study, measured: _Measured, runs: Mapping[Path, sim.Run]
) -> dict[str, Comparison]:
    found = {}
    if study.force:
        pairs = zip(study.force, measured.force, strict=True)
        found["force"] = joined(compare_force(one, curves, runs) for one, curves in pairs)
    if study.link:
        rows = zip(study.link, measured.before, measured.link, strict=True)
        found["link"] = joined(compare_link(one, old, seen, runs) for one, old, seen in rows)
    if study.curl:
        photographed = zip(study.curl, measured.curl, strict=True)
        found["interactions"] = joined(
            compare_curl(one, seen, runs, study.n_sec) for one, seen in photographed
        )
    return found


def _write(
    study: Study,
    comparisons: Mapping[str, Comparison],
    runs: Mapping[Path, sim.Run],
    out: Path,
) -> Path:
    """Write into a temporary folder beside the results, then move every file into place."""
    out.mkdir(parents=True, exist_ok=True)
    room = Path(tempfile.mkdtemp(prefix=".partial-", dir=out))
    try:
        write_pages(study, comparisons, runs, room)
        for path in room.iterdir():
            path.replace(out / path.name)
    finally:
        shutil.rmtree(room, ignore_errors=True)
    return out / "report.html"


@contextmanager
def _tidy_after_failure(out: Path) -> Iterator[None]:
    """Remove the folders that a failure leaves empty."""
    try:
        yield
    except BaseException:
        for folder in (out / "runs", out):
            with suppress(OSError):
                folder.rmdir()
        raise
