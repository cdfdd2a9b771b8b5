"""Compile the kernels of a scene's effects once, in a process of its own.

The process that compiles is not the one to simulate. It holds every kernel twice, optimised alone
and again inside its caller, and runs some of the first kind; a process that finds the kernels in
the cache runs only the second. The two round differently in the last bit, and a run that is
repeated or resumed later would no longer be the same.
"""

from __future__ import annotations

import contextlib
import logging
import math
import subprocess
import sys
from pathlib import Path

import llvmlite.binding  # type: ignore[import-untyped]

from sim.errors import Unstable
from sim.explicit import explicit
from sim.kernels.compiled import CACHE
from sim.march.effects import all_effects
from sim.march.softness import obstacle
from sim.march.state import build
from sim.records.observers import columns
from sim.scene import Scene
from sim.statics.newton import settle

CHILD = (
    "import sys; sys.path[:] = {path!r}; from sim.compilation import compile_here; "
    "compile_here(sys.stdin.read())"
)
log = logging.getLogger("sim")


def compile_for(scene: Scene) -> None:
    """See to it that the kernels which this scene needs are in the cache.

    Raises
    ------
    SceneError
        The scene cannot be laid out.
    """
    mark = _mark(scene)
    if mark.exists():
        return
    log.info("compiling for these effects, once: up to a minute")
    command = [sys.executable, "-c", CHILD.format(path=sys.path)]
    try:
        subprocess.run(command, input=scene.model_dump_json(), text=True, check=True,
                       stderr=subprocess.DEVNULL)  # fmt: skip
    except (OSError, subprocess.CalledProcessError):
        return  # this process compiles, at its first step
    mark.touch()


def compile_here(scene: str) -> None:
    """Compile what a scene, given as JSON, needs; called in a process of its own."""
    march = explicit(Scene.model_validate_json(scene))
    columns(march)
    with contextlib.suppress(Unstable):
        march.advance(1)
    if march.scene.until == "rest" and obstacle(march.scene) is None:
        settle(march, math.inf)


def _mark(scene: Scene) -> Path:
    """Return the file that tells whether these effects have been compiled for this processor."""
    effects = all_effects(scene, build(scene), dt=1.0)._asdict()
    present = [name for name, value in effects.items() if value is not None]
    bodies = effects["tines"] or effects["planes"]
    if bodies is not None and bodies.viscous is not None:
        present.append("damped")
    if effects["tines"] is not None and effects["tines"].strands is not None:
        present.append("strands")
    if scene.until == "rest" and obstacle(scene) is None:
        present.append("rest")
    return CACHE / "-".join(["compiled", llvmlite.binding.get_host_cpu_name(), *present])
