"""The explicit march from Python: time step, neighbour list, windows of steps."""

from __future__ import annotations

import logging

import numpy as np

from sim import guards
from sim.guards.start import refuse_start
from sim.kernels import march as kernel
from sim.march import checkpoint, effects, marching
from sim.march.marching import Marching
from sim.march.neighbours import rebuild
from sim.scene import Scene

MARK = 1024  # steps between two states to fall back on
SHORTEST = 64  # parts of a step: a motion that needs more is taken for unstable
CALM = 32  # marks without trouble after which longer steps are tried again
log = logging.getLogger("sim")


class Explicit(Marching):
    """A scene on its way through time with position Verlet.

    Where the motion is faster than the time step resolves, the march falls back to its last mark
    and goes on in halves of a step, as long as it must; `steps` and `time` go on counting whole
    ones. Marks are made where `advance` begins and every `MARK` steps from there.
    """

    def __init__(self, scene: Scene, dt: float | None = None) -> None:
        super().__init__(**vars(marching.begin(scene, dt)))
        rebuild(self)
        refuse_start(self)

    def advance(self, steps: int) -> None:
        """Take this many steps.

        Raises
        ------
        Unstable
            Even shorter steps do not resolve the motion of some node, an element turned by
            nearly half a turn against its neighbour, or strands began to pass through each other.
        """
        goal = self.steps + steps
        while self.steps < goal:
            mark = checkpoint.mark(self)
            end = min(goal, self.steps + MARK)
            while (cause := self.march_to(end)) is not None:
                if not cause.by_step or self.parts >= SHORTEST:
                    raise cause.error
                self._fall_back(mark, cause)
            self.calm += 1
            if self.calm == CALM and self.parts > 1:
                self._take(self.parts // 2)

    def march_to(self, end: int) -> guards.Cause | None:
        """March until so many steps are taken; return what stopped it on the way, if anything."""
        while self.steps < end:
            inserting = self.steps < self.inserted
            stop = min(end, self.inserted) if inserting else end
            left = (stop - self.steps) * self.parts - self.ticks
            keep = effects.damping(self.scene, self.step, inserting=inserting)
            self.effects = self.effects._replace(keep=keep)
            taken, status = kernel.march(
                self.state.buf, self.state.n, self.time, self.step, left, guards.resolved(self),
                self.effects,
            )  # fmt: skip
            whole, self.ticks = divmod(self.ticks + taken, self.parts)
            self.steps += whole
            if (cause := guards.check(self, status)) is not None:
                return cause
            if status == kernel.STALE:
                rebuild(self)
            if taken > 0 and status != kernel.DEEP:
                self.deep = marching.no_pairs()
        return None

    def _fall_back(self, mark: checkpoint.Arrays, cause: guards.Cause) -> None:
        """Go back to the mark, there to take shorter steps than those that failed."""
        parts = 2 * self.parts
        checkpoint.thaw(self, mark)
        self._take(parts)
        log.info(
            "from t = %.4g s on in steps of %.3g s: %s",
            self.time, self.step, str(cause.error).partition(";")[0],
        )  # fmt: skip

    def _take(self, parts: int) -> None:
        """Take every step in so many parts from now on; what sums over steps counts parts."""
        ratio, self.parts, self.calm = parts / self.parts, parts, 0
        self.finest = max(self.finest, parts)
        for total in self.sums().values():
            total *= ratio
        rebuild(self)


def explicit(scene: Scene) -> Explicit:
    """Return the march of a scene, its time step fitted to the sampling window.

    A window shorter than the longest step is made one step long.

    Raises
    ------
    SceneError
        The scene cannot be laid out, or asks for an unstable time step.
    """
    longest = marching.begin(scene).dt  # gone again before the next: two would be twice the memory
    window = max(1 / scene.output.sample_rate, longest)
    return Explicit(scene, dt=window / np.ceil(window / longest - 1e-9))
