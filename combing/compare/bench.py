"""The bench: measure everything a study names, compare it, draw it, and write it down."""

import logging
import shutil
import tempfile
from collections.abc import Callable, Hashable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, TypeVar

import pandas as pd
from tqdm import tqdm

import sim
from combing.bands import simulating_with_bands
from combing.compare.accurate import held_to
from combing.compare.comparison import Comparison, Findings, all_errors, joined
from combing.compare.holdings import holdings, overlooked, shared, spoken
from combing.compare.jobs import Job, all_jobs, label
from combing.compare.pages import write_pages
from combing.errors import UserError, is_users_fault
from combing.study import Study

T = TypeVar("T")
log = logging.getLogger("combing")


@dataclass(frozen=True)
class Result:
    """What a comparison leaves: where the report is, the comparisons by kind, what is missing."""

    report: Path
    comparisons: dict[str, Comparison]
    left_out: list[str] = field(default_factory=list)

    @property
    def errors(self) -> pd.DataFrame:
        """Every pipeline's error against truth, one row a quantity; empty without truth."""
        return all_errors(self.comparisons)


def compare(study: Study, out: Path, *, jobs: int | None = None, quiet: bool = False) -> Result:
    """Carry out a study and write figures, tables and the report into `out`.

    Strategy: the sets are checked, then the scenes are simulated in processes of their own while
    the photographs and logs are measured here. What is wrong with one set stops that set alone; the
    result says so. Runs are kept in ``out/runs`` and used again; everything else is written to a
    temporary folder and moved into place when all of it is done. What every set holds is logged on
    the logger ``combing``.

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
        Whatever an instrument says of an input that is at fault, when nothing is left to compare.
    """
    if out.exists() and not out.is_dir():
        raise UserError(f"{out}: is a file; -o wants a folder")
    runs = {path: sim.open_run(path) for path in study.simulations if path.suffix == ".nc"}
    scenes = {path: sim.load_scene(path) for path in study.simulations if path not in runs}
    with _tidy_after_failure(out):
        known = scenes | {path: run.scene for path, run in runs.items()}
        bench = _Bench(all_jobs(study, known))
        wanted = {key: scene for key, scene in bench.scenes.items() if key not in runs}
        banded = study.simulations if study.error_bars else ()
        folder, said = out / "runs", [*overlooked(study), *shared(study)]
        if study.tolerance is not None:
            how = {"jobs": jobs, "quiet": quiet}
            wanted, held = held_to(wanted, bench.alike, folder, study.tolerance, **how)
            said += held
        with simulating_with_bands(wanted, folder, banded, jobs=jobs, quiet=quiet) as wait:
            bench.measure(quiet)
            found = bench.compare(runs | wait(), said)
        return Result(_write(study, found, out), found.comparisons, found.left_out)


class _Bench:
    """The jobs that are still well, and what was found out about each."""

    def __init__(self, jobs: Sequence[Job]) -> None:
        self._left_out: list[str] = []
        self._first: Exception | None = None
        self._measured: dict[int, Any] = {}
        self._notes: dict[int, list[str]] = {}
        self._jobs = dict(enumerate(jobs))
        for number, job in list(self._jobs.items()):
            self._tried(number, self._notes, job.check)

    @property
    def scenes(self) -> dict[Hashable, sim.Scene]:
        """Scenes of the sets that are still well."""
        return {key: scene for job in self._jobs.values() for key, scene in job.scenes.items()}

    @property
    def alike(self) -> dict[Hashable, Hashable]:
        """What those of one ensemble have in common."""
        return {key: group for job in self._jobs.values() for key, group in job.alike.items()}

    def measure(self, quiet: bool) -> None:
        total = sum(job.photographs for job in self._jobs.values())
        label = "measuring photographs"
        with tqdm(total=total, desc=label, disable=quiet or not total) as bar:
            for number, job in list(self._jobs.items()):
                self._tried(number, self._measured, job.measure, bar.update)

    def compare(
        self, outcomes: Mapping[Any, sim.Run | Exception], notes: Sequence[str]
    ) -> Findings:
        runs = {key: run for key, run in outcomes.items() if isinstance(run, sim.Run)}
        found: dict[int, Comparison] = {}
        counts = []
        for number, job in list(self._jobs.items()):
            self._left_out += [
                f"{job.kind} {job.chosen.name!r}, {label(key)}: {outcomes[key]}"
                for key in job.scenes
                if key not in runs
            ]
            there = [key for key in job.scenes if key in runs]
            counted = job.count(self._measured[number]) | {"runs": len(there)}
            counts.append((job.kind, job.chosen.name, counted))
            log.info("%s", spoken(*counts[-1]))
            self._tried(number, found, job.compare, self._measured[number], there, runs)
            if number in found:
                found[number].notes.extend(self._notes[number])
        if not found:
            self._give_up()
        kinds = dict.fromkeys(self._jobs[number].kind for number in found)
        comparisons = {
            kind: joined(one for number, one in found.items() if self._jobs[number].kind == kind)
            for kind in kinds
        }
        used = {label(key): runs[key] for key in self.scenes if key in runs}
        return Findings(comparisons, used, holdings(counts), self._left_out, list(notes))

    def _tried(self, number: int, into: dict[int, T], step: Callable[..., T], *given: Any) -> None:
        """Do a step of a job; one that cannot be done ends the job."""
        job = self._jobs[number]
        try:
            into[number] = step(*given)
        except Exception as error:
            if not is_users_fault(error):
                raise
            self._first = self._first or error
            self._left_out.append(f"{job.kind} {job.chosen.name!r}: {error}")
            del self._jobs[number]
            if not self._jobs:
                self._give_up()

    def _give_up(self) -> None:
        """Raise what went wrong first: there is nothing to report."""
        assert self._first is not None  # noqa: S101
        if len(self._left_out) == 1:
            raise self._first
        others = "; ".join(self._left_out[1:])
        raise UserError(f"{self._first}; nothing is left to compare: {others}") from self._first


def _write(study: Study, found: Findings, out: Path) -> Path:
    """Write into a temporary folder beside the results, then move every file into place."""
    out.mkdir(parents=True, exist_ok=True)
    room = Path(tempfile.mkdtemp(prefix=".partial-", dir=out))
    try:
        write_pages(study, found, room)
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
