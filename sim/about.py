"""What a run says of itself beside its numbers: scene, solver, windows, versions, notes."""

from __future__ import annotations

import json
import math
from importlib import metadata
from pathlib import Path
from typing import Any

from sim.explicit import Explicit
from sim.guards.start import notes
from sim.kernels.compiled import SOURCES, source_digest
from sim.records.observers import columns
from sim.scene import Scene


def about(march: Explicit) -> dict[str, Any]:
    """Return what about.json says of the run of a march."""
    scene = march.scene
    window_steps = max(1, round(1 / (scene.output.sample_rate * march.dt)))
    windows = max(1, math.ceil(scene.duration / (window_steps * march.dt) - 1e-9))
    versions = {f"version_{name}": _version(name) for name in ("combing", "numpy", "numba")}
    return {
        "scene": json.loads(scene.model_dump_json()),
        "solver": f"{source_digest(Path(__file__).parent)}-{SOURCES}",
        "windows": windows,
        "window_steps": window_steps,
        "strands": [count + 1 for count in march.state.elements],
        "frames": scene.output.frames,
        "samples": columns(march),
        "attributes": {
            "title": scene.title,
            "march": "explicit position Verlet",
            "time_step_s": march.dt,
            "stability_limit_s": march.limit,
            "seed": scene.seed,
            **_notes(scene, windows, window_steps * march.dt),
            **versions,
        },
    }


def _notes(scene: Scene, windows: int, window: float) -> dict[str, str]:
    """Return what a user should know of this run, if there is anything."""
    output, found = scene.output, notes(scene)
    if window * output.sample_rate > 1.01:
        found.append(
            f"one sample a time step, {1 / window:.4g} 1/s, where {output.sample_rate:g} were asked"
        )
    if "snapshots" in output.model_fields_set and output.snapshots > windows + 1:
        found.append(f"{windows + 1} snapshots, one a sample, where {output.snapshots} were asked")
    return {"notes": "; ".join(found)} if found else {}


def _version(package: str) -> str:
    try:
        return metadata.version(package)
    except metadata.PackageNotFoundError:
        return "unknown"
