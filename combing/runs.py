"""Simulate scenes side by side, once each: a run that is on disk already is not run again."""

import hashlib
import json
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from typing import TypeVar, cast

import numpy as np
import pandas as pd

import instron
import sim
from combing.errors import UserError
from combing.progress import Bar
from combing.workers import Crew, cores

Key = TypeVar("Key")

LOOKING = {"tangle.py", "network.py"}  # of `sim`: they look at what has run


@cache
def model_version() -> str:
    """Hash of the solver's sources: a changed solver does not reuse runs of the old one."""
    root = Path(sim.__file__).parent
    content = hashlib.sha256()
    for path in sorted(root.rglob("*.py")):
        if path.name in LOOKING:
            continue
        content.update(path.relative_to(root).as_posix().encode() + path.read_bytes())
    return content.hexdigest()[:12]


def run_name(scene: sim.Scene) -> str:
    """File name of a scene's run: a hash of every parameter and of the solver."""
    content = f"{model_version()} {scene.model_dump_json()}"
    return hashlib.sha256(content.encode()).hexdigest()[:16] + ".nc"


@contextmanager
def trying(
    scenes: Mapping[Key, sim.Scene],
    folder: Path,
    *,
    jobs: int | None = None,
    quiet: bool = False,
    any_cost: bool = False,
) -> Iterator[Callable[[], dict[Key, sim.Run | Exception]]]:
    """Simulate scenes in processes of their own while the block does something else.

    Parameters
    ----------
    scenes : mapping
        Scenes by any key; the same scene under two keys is run once. The longest should be first.
    folder : Path
        Where the runs are kept, one NetCDF file each, named by `run_name`.
    jobs : int, optional
        Processes at once; as many as there are cores when absent.
    quiet : bool
        Show no progress.
    any_cost : bool
        Simulate also what would take more than a week.

    Yields
    ------
    callable
        Waits for the runs, showing progress, and returns them by the keys of `scenes`; in place of
        a run what its scene raised (sim.SceneError, sim.Unstable). Finished runs stay on disk, and
        those that were on their way go on from there the next time.
    """
    paths = {key: folder / run_name(scene) for key, scene in scenes.items()}
    missing = {paths[key]: scene for key, scene in scenes.items() if not paths[key].exists()}
    failed: dict[Path, Exception] = {}

    def opened() -> dict[Key, sim.Run | Exception]:
        return {key: failed.get(path) or sim.open_run(path) for key, path in paths.items()}

    if not missing:
        yield opened
        return
    crew = Crew(missing, min(len(missing), jobs or cores()), any_cost=any_cost)

    def finished() -> dict[Key, sim.Run | Exception]:
        _watch(crew, len(missing), failed, quiet)
        return opened()

    try:
        yield finished
    except BaseException:
        crew.stop()
        raise
    crew.dismiss()


@contextmanager
def simulating(
    scenes: Mapping[Key, sim.Scene],
    folder: Path,
    *,
    jobs: int | None = None,
    quiet: bool = False,
    any_cost: bool = False,
) -> Iterator[Callable[[], dict[Key, sim.Run]]]:
    """As `trying`, but what a scene raises is raised when all have ended."""
    with trying(scenes, folder, jobs=jobs, quiet=quiet, any_cost=any_cost) as wait:

        def finished() -> dict[Key, sim.Run]:
            found = wait()
            for outcome in found.values():
                if isinstance(outcome, Exception):
                    raise outcome
            return cast(dict[Key, sim.Run], found)

        yield finished


def _watch(crew: Crew, total: int, failed: dict[Path, Exception], quiet: bool) -> None:
    name = f"simulating {total} scene{'s' if total > 1 else ''}"
    with Bar(total=100.0, desc=name, mininterval=1, disable=quiet) as bar:

        def ended(path: Path, error: Exception | None) -> None:
            if error is not None:
                failed[path] = error

        def look() -> None:
            bar.update(100 * crew.fraction - bar.n)

        crew.wait(look, ended)


def refuse_to_replace(path: Path, scene: sim.Scene) -> None:
    """Raise UserError where a path holds a finished run of another scene."""
    if json.loads(sim.open_run(path).data.attrs["scene"]) != json.loads(scene.model_dump_json()):
        raise UserError(
            f"{path}: a finished run of another scene; write to another place, or over it (--fresh)"
        )


def scaled(run: sim.Run) -> pd.DataFrame:
    """Return the force log of a combing scaled by `instron.scale` with its own r and E."""
    log = run.force_log()
    own = {key: log.attrs[key] for key in ("r", "E")}
    return instron.scale(log, instron.Rig.model_validate(own | {"zero": "none"}))


def tine_at(run: sim.Run, d: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the middle of a run's first tine after a travel d [m], and its unit axis."""
    tine = run.scene.tines[0]
    way, axis = (np.array(v) / np.linalg.norm(v) for v in (tine.direction, tine.axis))
    return np.array(tine.position) + d * way, axis
