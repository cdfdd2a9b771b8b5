"""Run a scene from start to end and hand back what was recorded."""

from __future__ import annotations

import json
import logging
import math
import time
from collections.abc import Callable
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from sim.about import about
from sim.compilation import compile_for
from sim.cost import cost, refuse_absurd
from sim.errors import SceneError, Unstable
from sim.explicit import Explicit, explicit
from sim.guards.insertion import inserted, link
from sim.march.checkpoint import freeze, thaw
from sim.records.journal import CHECKPOINT, Journal, damaged, differing, part_of, read
from sim.records.observers import due, observers, snapshot
from sim.records.run import NOT_REACHED, Run, dataset, open_run
from sim.rest import worst
from sim.scene import Scene
from sim.statics.settling import come_to_rest

CHECKPOINT_EVERY = 30.0  # seconds of wall time: what a killed run loses at most
log = logging.getLogger("sim")


def simulate(
    scene: Scene,
    path: str | Path | None = None,
    *,
    progress: Callable[[float], None] | None = None,
    resume: bool = True,
    checkpoint_every: float = CHECKPOINT_EVERY,
    any_cost: bool = False,
) -> Run:
    """Simulate a scene with the explicit march.

    Parameters
    ----------
    scene : Scene
        From `double_helix`, `curl`, `load_scene` or made by hand.
    path : path, optional
        Where to write the run as NetCDF; it appears whole, when the run has ended. On the way there
        everything recorded stands in the folder PATH.part, which `open_run` reads too and which
        outlives the process.
    progress : callable, optional
        Called with the fraction done after every sampling window.
    resume : bool
        Go on with the run that PATH.part holds, to the same last bit as if it had never stopped;
        else begin anew over it, and over a finished run of another scene.
    checkpoint_every : float
        Wall time between two states to go on from [s].
    any_cost : bool
        Begin also what would take more than a week or more room than the disk has.

    Returns
    -------
    Run

    Raises
    ------
    SceneError
        The scene cannot be laid out, asks for an unstable time step or for too much; PATH or
        PATH.part holds something else than a run of this scene and solver, is damaged, or
        another process is writing to it.
    Unstable
        The motion left the range that the time step resolves. What was recorded up to then is in
        the NetCDF file that `Unstable.path` names.

    Notes
    -----
    What it will cost, whether it goes on from somewhere, that kernels are being compiled and that
    it takes shorter steps is logged on the logger ``sim`` at level INFO; what a user should know
    of the result, at level WARNING, and kept in the run's attribute ``notes``.
    """
    if path is not None:
        if resume:
            _refuse_to_replace(Path(path), scene)
        return _simulate(scene, Path(path), progress, resume, checkpoint_every, any_cost)
    with TemporaryDirectory(prefix="combing-") as folder:
        try:
            run = _simulate(scene, Path(folder) / "run.nc", progress, False, math.inf, any_cost)
        except Unstable as error:
            error.path = None
            raise
    del run.data.attrs["path"]
    return run


def _simulate(
    scene: Scene,
    path: Path,
    progress: Callable[[float], None] | None,
    resume: bool,
    checkpoint_every: float,
    any_cost: bool,
) -> Run:
    compile_for(scene)
    march = explicit(scene)
    of_run = about(march)
    _announce(march, of_run, None if any_cost else path)
    journal = Journal(part_of(path), of_run, resume=resume)
    try:
        if journal.checkpoint:
            _go_on(march, journal)
        _advance(march, journal, progress, checkpoint_every)
    except Unstable as error:
        error.path = path.with_suffix(".unstable.nc")
        _finish(march, journal, error.path, unstable=error.args[0])
        raise
    finally:
        journal.close()
    _finish(march, journal, path)
    run = open_run(path)
    if scene.until == "rest" and (unrest := run.unrest()):
        log.warning(f"{unrest}; give it a longer duration than {scene.duration:g} s")
    return run


def _advance(
    march: Explicit,
    journal: Journal,
    progress: Callable[[float], None] | None,
    checkpoint_every: float,
) -> None:
    """March to the end, window by window, and write down what is seen."""
    windows, steps = journal.about["windows"], journal.about["window_steps"]
    watching = observers(march)
    instants = due(march.scene.output.snapshots, windows)
    done = march.steps // steps
    pair = len(march.scene.rods) == 2 and any(tine.travel > 0 for tine in march.scene.tines)
    if done == 0:
        journal.snapshot(snapshot(march, start=True))
        if pair:
            journal.amend(link_drawn=link(march))
        if _rests(march, journal, 0):
            journal.snapshot(snapshot(march))
            return
    saved = time.monotonic()
    for window in range(done + 1, windows + 1):
        march.advance(steps)
        journal.sample([value for observe in watching for value in observe(march, steps)])
        rests = _rests(march, journal, window)
        if window in instants or rests:
            journal.snapshot(snapshot(march))
        if pair and march.steps - steps < march.inserted <= march.steps:
            journal.amend(**inserted(march, journal.about["attributes"]["link_drawn"]))
            if "insertion" in journal.about["attributes"]:
                log.warning(journal.about["attributes"]["insertion"])
        if time.monotonic() - saved >= checkpoint_every:
            journal.save(freeze(march))
            saved = time.monotonic()
        if progress is not None:
            progress(1.0 if rests else window / windows)
        if rests:
            return
    if march.scene.until == "rest":
        journal.amend(rest=NOT_REACHED, worst_rod=worst(march))


def _rests(march: Explicit, journal: Journal, window: int) -> bool:
    """Tell whether a scene that ends at rest has come there, and write down how."""
    if march.scene.until != "rest":
        return False
    way = come_to_rest(march, window)
    if way is not None:
        journal.amend(rest=way)
        log.info("at rest: %s", way)
    return way is not None


def _go_on(march: Explicit, journal: Journal) -> None:
    """Take up the march where its checkpoint was written."""
    try:
        thaw(march, journal.state())
    except ValueError as error:
        raise damaged(journal.folder / CHECKPOINT, str(error)) from None
    log.info("going on from t = %.4g s (%s)", march.time, journal.folder)


def _announce(march: Explicit, of_run: dict[str, Any], path: Path | None) -> None:
    """Say what is ahead, and refuse what is absurd to write to this path."""
    ahead = cost(march, of_run)
    elements = sum(march.state.elements)
    log.info("%d rods, %d elements: %s", len(march.state.first), elements, ahead)
    if "notes" in of_run["attributes"]:
        log.warning(of_run["attributes"]["notes"])
    if path is not None:
        refuse_absurd(ahead, path)


def _refuse_to_replace(path: Path, scene: Scene) -> None:
    """See that no finished run of another scene, nor anything else, is written over."""
    if not path.exists():
        return
    try:
        there = json.loads(open_run(path).data.attrs["scene"])
    except SceneError as error:
        raise SceneError(f"{error}; it would be written over: remove it, or --fresh") from None
    if keys := differing(there, json.loads(scene.model_dump_json())):
        raise SceneError(
            f"{path}: a finished run of another scene (it differs in {', '.join(keys)}); write to "
            "another place, or over it (resume=False, --fresh)"
        )


def _finish(march: Explicit, journal: Journal, path: Path, **attributes: str) -> None:
    """Turn the journal into a NetCDF file, which appears whole, and remove it."""
    temporary = journal.folder / path.name
    data = dataset(read(journal.folder))
    finest = march.dt / march.finest
    data.attrs |= {"steps": march.steps, "shortest_step_s": finest, **attributes}
    data.attrs["wall_time_s"] = journal.wall_time()
    data.to_netcdf(temporary, engine="h5netcdf")
    del data  # some systems do not remove files that are still mapped
    temporary.replace(path)
    journal.remove()
