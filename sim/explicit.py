"""The explicit march from Python: time step, neighbour list, windows of steps."""

from __future__ import annotations

import numpy as np

from sim import guards, marching
from sim.errors import SceneError
from sim.kernels import march as march_kernel
from sim.marching import Marching
from sim.neighbours import rebuild
from sim.scene import Scene


class Explicit(Marching):
    """A scene on its way through time with position Verlet."""

    def __init__(self, scene: Scene, dt: float | None = None) -> None:
        super().__init__(**vars(marching.begin(scene, dt)))
        rebuild(self)
        guards.start(self)
        self.fastest = guards.fastest(self) ** 2

    def advance(self, steps: int) -> None:
        """Take this many steps.

        Raises
        ------
        Unstable
            The speed of some node left the range that the time step resolves, an element turned by
            nearly half a turn against its neighbour, or strands began to pass through each other.
        """
        left = steps
        while left > 0:
            taken, status = march_kernel.march(
                self.state.buf, self.state.n, self.time, self.dt, left, self.fastest, self.effects
            )  # fmt: skip
            self.steps += taken
            left -= taken
            if (cause := guards.check(self, status)) is not None:
                raise cause
            if status == march_kernel.STALE:
                rebuild(self)
            if taken > 0 and status != march_kernel.DEEP:
                self.deep = marching.no_pairs()


def explicit(scene: Scene) -> Explicit:
    """Return the march of a scene, its time step fitted to the sampling window.

    Raises
    ------
    SceneError
        The scene cannot be laid out, or asks for an unstable time step.
    """
    longest = marching.begin(scene).dt  # gone again before the next: two would be twice the memory
    window = 1 / scene.output.sample_rate
    if window < longest:
        raise SceneError(
            f"output.sample_rate = {scene.output.sample_rate:g} 1/s: one sample is shorter than a "
            f"time step of {longest:.3g} s; ask for at most {1 / longest:.3g} 1/s"
        )
    return Explicit(scene, dt=window / np.ceil(window / longest))
