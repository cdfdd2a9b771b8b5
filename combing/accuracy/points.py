"""Measure many problems, once each: a point that is on disk already is not measured again."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from dataclasses import asdict
from pathlib import Path

from combing.accuracy.measurement import Measurement, Problem
from combing.errors import UserError
from combing.progress import Bar
from combing.runs import model_version
from sim import Unstable
from sim.compilation import compile_for
from sim.explicit import Explicit
from sim.kernels.compiled import CACHE
from sim.records.files import replacing


def point_name(problem: Problem) -> str:
    """File name of a point: a hash of every parameter, of the solver and of its compiler."""
    content = f"{model_version()} {CACHE.name} {problem!r} {problem.scene().model_dump_json()}"
    return hashlib.sha256(content.encode()).hexdigest()[:16] + ".json"


def measure_all(
    problems: Iterable[Problem], folder: Path, *, quiet: bool = False
) -> dict[Problem, Measurement]:
    """Measure every problem that `folder` does not hold yet; return them all.

    Parameters
    ----------
    problems : iterable of Problem
        The same problem twice is measured once.
    folder : Path
        Where the points are kept, one JSON file each, written as soon as it is known.
    quiet : bool
        Show no progress.

    Raises
    ------
    UserError
        The folder cannot be written to.
    """
    _check_writable(folder)
    paths = {problem: folder / point_name(problem) for problem in problems}
    known = {problem: found for problem, path in paths.items() if (found := load(path))}
    missing = [problem for problem in paths if problem not in known]
    with _progress(missing, quiet) as done:
        for problem in missing:
            known[problem] = measured(problem)
            save(known[problem], paths[problem])
            done(problem)
    return {problem: known[problem] for problem in paths}


def measured(problem: Problem) -> Measurement:
    """Return a problem's measurement, without a quantity if its run became unstable."""
    try:
        scene = problem.scene()
        compile_for(scene)
        Explicit(scene).advance(1)  # loads the kernels, which is no part of the cost
        return problem.measure()
    except Unstable:
        return Measurement(quantity=None)


def load(path: Path) -> Measurement | None:
    """Return the point in a file, None if there is none that can be read."""
    try:
        return Measurement(**json.loads(path.read_text(encoding="utf-8")))
    except (FileNotFoundError, ValueError, TypeError):
        return None


def save(point: Measurement, path: Path) -> None:
    """Write a point; the file appears whole or not at all."""
    with replacing(path) as temporary:
        temporary.write_text(json.dumps(asdict(point)), encoding="utf-8")


def _check_writable(folder: Path) -> None:
    """Say before minutes of computing that their result could not be kept."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with replacing(folder / "writable") as temporary:
            temporary.touch()
        (folder / "writable").unlink()
    except OSError as error:
        raise UserError(f"{folder}: cannot be written to: {error.strerror}") from error


@contextmanager
def _progress(problems: list[Problem], quiet: bool) -> Iterator[Callable[[Problem], None]]:
    """Show on stderr how much of the work is done, by steps times nodes."""
    work = {problem: _work(problem) for problem in problems}
    with Bar(total=sum(work.values()), desc=f"{len(problems)} points", disable=quiet) as bar:

        def done(problem: Problem) -> None:
            bar.update(work[problem])

        yield done


def _work(problem: Problem) -> float:
    scene = problem.scene()
    march = Explicit(scene)
    return scene.duration / march.dt * march.state.n
