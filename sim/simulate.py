"""Run a scene from start to end and hand back what was recorded."""

from __future__ import annotations

import time
from collections.abc import Callable
from importlib import metadata
from pathlib import Path

import numpy as np

from sim.errors import Unstable
from sim.explicit import Explicit, explicit
from sim.observers import ForceRecorder, SnapshotRecorder
from sim.run import Run
from sim.scene import Scene


def simulate(
    scene: Scene,
    path: str | Path | None = None,
    *,
    progress: Callable[[float], None] | None = None,
) -> Run:
    """Simulate a scene with the explicit march.

    Parameters
    ----------
    scene : Scene
        From `double_helix`, `curl`, `load_scene` or made by hand.
    path : path, optional
        Where to write the run as NetCDF; it appears whole, when the run has ended. A run that
        becomes unstable leaves what it recorded up to then.
    progress : callable, optional
        Called with the fraction done after every sampling window.

    Returns
    -------
    Run

    Raises
    ------
    SceneError
        The scene cannot be laid out or asks for an unstable time step.
    Unstable
        The motion left the range that the time step resolves.
    """
    began = time.perf_counter()
    march = explicit(scene)
    steps = round(1 / (scene.output.sample_rate * march.dt))
    windows = max(1, int(np.ceil(scene.duration * scene.output.sample_rate - 1e-9)))
    forces = ForceRecorder(scene) if scene.tines else None
    snapshots = SnapshotRecorder(scene.output.snapshots, windows)
    snapshots.observe(march, 0)
    try:
        for window in range(1, windows + 1):
            march.advance(steps)
            if forces is not None:
                forces.observe(march, steps)
            snapshots.observe(march, window)
            if progress is not None:
                progress(window / windows)
    except Unstable:
        if path is not None:
            _collect(scene, march, forces, snapshots, began).save(path)
        raise
    run = _collect(scene, march, forces, snapshots, began)
    if path is not None:
        run.save(path)
        run.data.attrs["path"] = str(path)
    return run


def _collect(
    scene: Scene,
    march: Explicit,
    forces: ForceRecorder | None,
    snapshots: SnapshotRecorder,
    began: float,
) -> Run:
    import xarray

    rod = np.repeat(np.arange(len(scene.rods)), np.array(march.state.elements) + 1)
    variables = {
        "position": (("snapshot", "node", "axis"), np.array(snapshots.position), {"units": "m"}),
        "snapshot_time": ("snapshot", snapshots.time, {"units": "s"}),
        "snapshot_displacement": ("snapshot", snapshots.displacement, {"units": "m"}),
        "rod": ("node", rod, {"long_name": "rod that the node belongs to"}),
        "radius": ("strand", [each.radius for each in scene.rods], {"units": "m"}),
    }
    if forces is not None:
        variables["time"] = ("sample", forces.time, {"units": "s"})
        variables["displacement"] = ("sample", forces.displacement, {"units": "m"})
        variables["force"] = (
            "sample",
            forces.force,
            {"units": "N", "long_name": "force on the tine, positive when it resists"},
        )
    attributes = {
        "title": scene.title,
        "scene": scene.model_dump_json(),
        "march": "explicit position Verlet",
        "time_step_s": march.dt,
        "stability_limit_s": march.limit,
        "steps": march.steps,
        "wall_time_s": time.perf_counter() - began,
        "seed": scene.seed,
        **{f"version_{name}": _version(name) for name in ("combing", "numpy", "numba")},
    }
    return Run(xarray.Dataset(variables, coords={"axis": ["x", "y", "z"]}, attrs=attributes))


def _version(package: str) -> str:
    try:
        return metadata.version(package)
    except metadata.PackageNotFoundError:
        return "unknown"
