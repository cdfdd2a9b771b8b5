"""Simulate a scene with what its bands need, on all cores, and keep the bands with the run."""

import logging
from collections.abc import Callable, Collection, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import TypeVar

import sim
from combing.bands.bands import Bands, make_bands
from combing.bands.scenes import scenes_of_bands
from combing.bands.store import with_bands
from combing.ensemble import IMPERFECTION
from combing.errors import UserError
from combing.runs import refuse_to_replace, trying

Key = TypeVar("Key")
MEMBERS = 5
FEWEST = 2  # from which a spread is known at all
log = logging.getLogger("combing")


def simulate_with_bands(
    scene: sim.Scene,
    path: str | Path,
    *,
    members: int = MEMBERS,
    size: float = IMPERFECTION,
    jobs: int | None = None,
    fresh: bool = False,
    quiet: bool = True,
    any_cost: bool = False,
) -> sim.Run:
    """Simulate a scene, the same on a coarser mesh, and an ensemble; keep the bands with the run.

    Parameters
    ----------
    scene : Scene
    path : path
        Where the run is written, with its bands. The runs behind them are in the folder `runs`
        beside it: what is there is not simulated again, what was on its way goes on.
    members : int
        Of the ensemble, at least 2.
    size : float
        Of each member's random intrinsic curvature, as a share of the strands' own curvature
        (`combing.ensemble.perturbed`).
    jobs : int, optional
        Simulations at once; as many as there are cores when absent.
    fresh : bool
        Write also over a finished run of another scene.
    quiet : bool
        Show no progress.
    any_cost : bool
        Simulate also what would take more than a week.

    Returns
    -------
    Run
        `read_bands` returns its bands.

    Raises
    ------
    UserError
        There are too few members, or PATH holds something else than a run of this scene.
    sim.SceneError, sim.Unstable
        The scene is at fault, or its motion, or too many members' motion, is unstable.
    """
    path = Path(path)
    if members < FEWEST:
        raise UserError(f"members = {members}: a spread needs at least {FEWEST}")
    if path.exists() and not fresh:
        refuse_to_replace(path, scene)
    scenes = scenes_of_bands(scene, members, size)
    folder = path.parent / "runs"
    with trying(scenes, folder, jobs=jobs, quiet=quiet, any_cost=any_cost) as wait:
        outcomes = wait()
    found = _banded(outcomes, size)
    if isinstance(found, Exception):
        raise found
    del found.data.attrs["path"]
    found.save(path)
    return sim.open_run(path)


@contextmanager
def simulating_with_bands(
    scenes: Mapping[Key, sim.Scene],
    folder: Path,
    banded: Collection[Key],
    *,
    jobs: int | None = None,
    quiet: bool = False,
) -> Iterator[Callable[[], dict[Key, sim.Run | Exception]]]:
    """As `combing.runs.trying`; the runs of those keys that are `banded` carry their bands."""
    parts = {
        key: scenes_of_bands(scene, MEMBERS, IMPERFECTION) if key in banded else {0: scene}
        for key, scene in scenes.items()
    }
    every = {(key, k): scene for key, part in parts.items() for k, scene in part.items()}
    with trying(every, folder, jobs=jobs, quiet=quiet) as wait:

        def finished() -> dict[Key, sim.Run | Exception]:
            found = wait()
            return {
                key: _banded({k: found[key, k] for k in part}, IMPERFECTION)
                if key in banded
                else found[key, 0]
                for key, part in parts.items()
            }

        yield finished


def _banded(outcomes: Mapping[int, sim.Run | Exception], size: float) -> sim.Run | Exception:
    """Return run 0 with the bands that the others give, or why there are none."""
    runs = {key: run for key, run in outcomes.items() if isinstance(run, sim.Run)}
    failed = {key: error for key, error in outcomes.items() if isinstance(error, Exception)}
    if 0 in failed or len([key for key in runs if key > 0]) < FEWEST:
        return next(iter(failed.values()))
    return with_bands(runs[0], _noted(make_bands(runs, size), failed, -1 in outcomes))


def _noted(bands: Bands, failed: dict[int, Exception], has_coarse: bool) -> Bands:
    """Say what is missing behind the bands."""
    notes = [
        f"{'the coarser mesh' if key < 0 else f'member {key}'} is left out of the bands: {error}"
        for key, error in failed.items()
    ]
    if not has_coarse:
        notes.append("this mesh cannot be coarser: what it leaves of error is not known")
    for note in notes:
        log.warning(note)
    return Bands(bands.force, bands.link, bands.numbers, bands.about | {"notes": notes})
