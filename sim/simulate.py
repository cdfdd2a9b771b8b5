"""Run a scene from start to end and hand back what was recorded."""

from __future__ import annotations

import json
import logging
import math
import time
from collections.abc import Callable
from importlib import metadata
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from sim.checkpoint import freeze, thaw
from sim.compilation import compile_for
from sim.errors import Unstable
from sim.explicit import Explicit, explicit
from sim.journal import Journal, part_of, read
from sim.kernels.compiled import CACHE, source_digest
from sim.observers import columns, due, observers, snapshot
from sim.run import Run, dataset, open_run
from sim.scene import Scene

CHECKPOINT_EVERY = 30.0  # seconds of wall time: what a killed run loses at most
log = logging.getLogger("sim")


def simulate(
    scene: Scene,
    path: str | Path | None = None,
    *,
    progress: Callable[[float], None] | None = None,
    resume: bool = True,
    checkpoint_every: float = CHECKPOINT_EVERY,
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
        else begin anew over it.
    checkpoint_every : float
        Wall time between two states to go on from [s].

    Returns
    -------
    Run

    Raises
    ------
    SceneError
        The scene cannot be laid out or asks for an unstable time step; PATH.part holds a run of
        another scene or solver, or another process is writing to it.
    Unstable
        The motion left the range that the time step resolves. What was recorded up to then is in
        the NetCDF file that `Unstable.path` names.

    Notes
    -----
    Whether it goes on from somewhere, and that kernels are being compiled, is logged on the logger
    ``sim`` at level INFO.
    """
    if path is not None:
        return _simulate(scene, Path(path), progress, resume, checkpoint_every)
    with TemporaryDirectory(prefix="combing-") as folder:
        try:
            run = _simulate(scene, Path(folder) / "run.nc", progress, False, math.inf)
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
) -> Run:
    compile_for(scene)
    march = explicit(scene)
    journal = Journal(part_of(path), _about(march), resume=resume)
    try:
        if journal.checkpoint:
            thaw(march, journal.checkpoint)
            log.info("going on from t = %.4g s (%s)", march.time, journal.folder)
        _advance(march, journal, progress, checkpoint_every)
    except Unstable as error:
        error.path = path.with_suffix(".unstable.nc")
        _finish(march, journal, error.path, unstable=error.args[0])
        raise
    finally:
        journal.close()
    _finish(march, journal, path)
    return open_run(path)


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
    if done == 0:
        journal.snapshot(snapshot(march))
        _announce(march, windows * steps)
    saved = time.monotonic()
    for window in range(done + 1, windows + 1):
        march.advance(steps)
        journal.sample([value for observe in watching for value in observe(march, steps)])
        if window in instants:
            journal.snapshot(snapshot(march))
        if time.monotonic() - saved >= checkpoint_every:
            journal.save(freeze(march))
            saved = time.monotonic()
        if progress is not None:
            progress(window / windows)


def _announce(march: Explicit, steps: int) -> None:
    """Say what is ahead."""
    elements = sum(march.state.elements)
    log.info(
        "%d rods, %d elements: %d steps of %.3g s",
        len(march.state.first), elements, steps, march.dt,
    )  # fmt: skip


def _about(march: Explicit) -> dict[str, Any]:
    """Return what about.json says of a run."""
    scene = march.scene
    versions = {f"version_{name}": _version(name) for name in ("combing", "numpy", "numba")}
    return {
        "scene": json.loads(scene.model_dump_json()),
        "solver": f"{source_digest(Path(__file__).parent)}-{CACHE.name}",
        "windows": max(1, math.ceil(scene.duration * scene.output.sample_rate - 1e-9)),
        "window_steps": round(1 / (scene.output.sample_rate * march.dt)),
        "strands": [count + 1 for count in march.state.elements],
        "samples": columns(march),
        "attributes": {
            "title": scene.title,
            "march": "explicit position Verlet",
            "time_step_s": march.dt,
            "stability_limit_s": march.limit,
            "seed": scene.seed,
            **versions,
        },
    }


def _version(package: str) -> str:
    try:
        return metadata.version(package)
    except metadata.PackageNotFoundError:
        return "unknown"


def _finish(march: Explicit, journal: Journal, path: Path, **attributes: str) -> None:
    """Turn the journal into a NetCDF file, which appears whole, and remove it."""
    temporary = journal.folder / path.name
    data = dataset(read(journal.folder))
    data.attrs |= {"steps": march.steps, "wall_time_s": journal.wall_time(), **attributes}
    data.to_netcdf(temporary, engine="h5netcdf")
    del data  # some systems do not remove files that are still mapped
    temporary.replace(path)
    journal.remove()
