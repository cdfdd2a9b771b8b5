"""The explicit march from Python: time step, neighbour list, windows of steps."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from sim import effects, timestep
from sim.diagnosis import unstable
from sim.errors import SceneError
from sim.kernels import march as march_kernel
from sim.kernels import neighbours
from sim.kernels.contact import Contact, Friction
from sim.kernels.runs import fill_runs
from sim.kernels.tine import Tines
from sim.passing import (
    NONE,
    bent_through,
    deep_pairs,
    newcomer,
    passing_through,
    tight_bends,
)
from sim.scene import Scene
from sim.state import build
from sim.winding import wound_up

SPEED_LIMIT = 0.2  # of an element's length per step; the stable march stays far below


class Explicit:
    """A scene on its way through time with position Verlet.

    Attributes
    ----------
    state : State
        Rods as they are now.
    dt : float
        Time step [s].
    time : float
        Time since the start [s].
    """

    def __init__(self, scene: Scene, dt: float | None = None) -> None:
        self.scene = scene
        self.state = build(scene)
        self.limit = timestep.stable_step(
            self.state,
            effects.stiffness(scene),
            effects.viscous(scene),
            effects.tine_viscous(scene),
        )
        self.dt = timestep.choose_step(scene, self.limit) if dt is None else dt
        self.steps = 0
        self.effects = effects.all_effects(scene, self.state, self.dt)
        lengths = self.state.row("LENGTH")
        self._fastest = (SPEED_LIMIT * lengths[lengths > 0].min() / self.dt) ** 2
        if self.effects.contact is not None:
            size = 1 << int(np.ceil(np.log2(2 * self.state.n)))
            self._heads = np.zeros(size, np.int64)
            self._following = np.zeros(self.state.n, np.int64)
            self._rebuild()
        # Strands may start in each other.
        self._deep, self._tight = deep_pairs(self), tight_bends(self)

    @property
    def time(self) -> float:
        """Time since the start [s]."""
        return self.steps * self.dt

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
                self.state.buf, self.state.n, self.time, self.dt, left, self._fastest, self.effects
            )  # fmt: skip
            self.steps += taken
            left -= taken
            if status == march_kernel.STALE:
                self._look_at_bends()
                self._rebuild()
            elif status == march_kernel.UNSTABLE:
                raise unstable(self)
            elif status == march_kernel.WOUND:
                raise wound_up(self)
            elif status == march_kernel.DEEP:
                self._look()
            if taken > 0 and status != march_kernel.DEEP:
                self._deep = NONE

    def _look(self) -> None:
        """See that no strand passes through another that it was apart from."""
        before, self._deep = self._deep, deep_pairs(self)
        if (pair := newcomer(self._deep, before)) is not None:
            raise passing_through(self, *pair)

    def _look_at_bends(self) -> None:
        """See that no strand passes through itself where it is bent."""
        before, self._tight = self._tight, tight_bends(self)
        if (pair := newcomer(self._tight, before)) is not None:
            raise bent_through(self, *pair)

    def _rebuild(self) -> None:
        """List the pairs that may touch, and hand their slip on."""
        old = self.effects.contact
        assert old is not None
        pairs = self._pairs(old)
        count = pairs.shape[1]
        listed, runs = np.zeros((2, 4, count + 1), np.int64)
        fill_runs(pairs, listed)
        contact = old._replace(pairs=pairs, listed=listed, runs=runs)
        if self.effects.friction is not None:
            contact = contact._replace(slip=self._slip(old, pairs))
        self.effects = self.effects._replace(contact=contact)

    def _pairs(self, contact: Contact) -> NDArray[np.int64]:
        """Return the pairs that may touch, (2, m), in the order that makes the longest runs."""
        pairs = np.zeros((2, 8 * self.state.n), np.int64)
        count = self._list(contact, pairs)
        if count > pairs.shape[1]:
            pairs = np.zeros((2, count), np.int64)
            self._list(contact, pairs)
        a, b = pairs[:, :count]
        order = np.lexsort((a, b - a, contact.rod[b], contact.rod[a]))
        return np.take(pairs, order, axis=1)

    def _list(self, contact: Contact, pairs: NDArray[np.int64]) -> int:
        return neighbours.build_list(
            self.state.buf, self.state.n, contact, self._heads, self._following, pairs
        )

    def _slip(self, old: Contact, pairs: NDArray[np.int64]) -> NDArray[np.float64]:
        """Return the elastic slip of the pairs: what it was where they were listed before."""
        before, now = (self.state.n * each[0] + each[1] for each in (old.pairs, pairs))
        _, then, here = np.intersect1d(before, now, assume_unique=True, return_indices=True)
        slip = np.zeros((3, pairs.shape[1]))
        slip[:, here] = old.slip[:, then]
        return slip

    @property
    def contact(self) -> Contact | None:
        """Contact between rods with its neighbour list, if the scene has it."""
        return self.effects.contact

    @property
    def tines(self) -> Tines | None:
        """The tines as they are now, if there are any."""
        return self.effects.tines

    @property
    def friction(self) -> Friction | None:
        """Friction between rods, if the scene has it."""
        return self.effects.friction

    def tine_travel(self) -> np.ndarray:
        """Return how far every tine has moved [m], (m,)."""
        return self.tines.now[:, 0].copy() if self.tines is not None else np.zeros(0)

    def take_load(self) -> np.ndarray:
        """Return the sum over steps of the force on each tine [N], (m, 3), and start a new sum."""
        if self.tines is None:
            return np.zeros((0, 3))
        load = self.tines.load.copy()
        self.tines.load[:] = 0
        return load


def explicit(scene: Scene) -> Explicit:
    """Return the march of a scene, its time step fitted to the sampling window.

    Raises
    ------
    SceneError
        The scene cannot be laid out, or asks for an unstable time step.
    """
    longest = Explicit(scene).dt  # gone again before the next: two would be twice the memory
    window = 1 / scene.output.sample_rate
    if window < longest:
        raise SceneError(
            f"output.sample_rate = {scene.output.sample_rate:g} 1/s: one sample is shorter than a "
            f"time step of {longest:.3g} s; ask for at most {1 / longest:.3g} 1/s"
        )
    return Explicit(scene, dt=window / np.ceil(window / longest))
