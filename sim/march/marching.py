"""A scene at one instant as plain data: what march, guards, energy and diagnosis read and write."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from sim.kernels.contact import Contact, Friction
from sim.kernels.march import Effects
from sim.kernels.tine import Tines
from sim.march import effects, timestep
from sim.march.softness import soften, softness
from sim.march.state import State, build
from sim.scene import Scene

Pairs = NDArray[np.int64]


def no_pairs() -> Pairs:
    """Return an empty list of pairs of elements, (0, 2)."""
    return np.zeros((0, 2), np.int64)


@dataclass
class Marching:
    """A scene on its way through time.

    Attributes
    ----------
    scene : Scene
        What was asked for.
    state : State
        Rods as they are now.
    effects : Effects
        What acts on them, for the kernels.
    limit : float
        Stability limit of the time step [s].
    dt : float
        Time step [s].
    steps, ticks, parts : int
        Steps taken since the start, and parts of the present one: where the motion needs it, each
        is taken in 2, 4, 8, ... `parts`.
    finest, calm : int
        Most parts that there were so far, and since how many marks nothing went wrong.
    deep, tight : (m, 2) int64
        Pairs of elements on their way through each other, other rods and one rod bent, when the
        guards last looked.
    soft : float
        What the rigidities of stretch and shear are multiplied by, see `sim.march.softness`.
    """

    scene: Scene
    state: State
    effects: Effects
    limit: float
    dt: float
    steps: int = 0
    ticks: int = 0
    parts: int = 1
    finest: int = 1
    calm: int = 0
    deep: Pairs = field(default_factory=no_pairs)
    tight: Pairs = field(default_factory=no_pairs)
    soft: float = 1.0

    @property
    def time(self) -> float:
        """Time since the start [s]."""
        return (self.steps + self.ticks / self.parts) * self.dt

    @property
    def step(self) -> float:
        """The time step as it is taken now, a part of `dt` [s]."""
        return self.dt / self.parts

    @property
    def inserted(self) -> int:
        """After how many steps all tines are inserted."""
        return math.ceil(max((t.insertion for t in self.scene.tines), default=0.0) / self.dt - 1e-9)

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
        """Return the force on each tine [N] summed over steps `dt`, (m, 3), and start a new sum."""
        return self.take("tines") if self.tines is not None else np.zeros((0, 3))

    def take(self, name: str) -> np.ndarray:
        """Return one of `sums` over steps `dt`, and start a new sum."""
        total = self.sums()[name]
        found = total / self.parts
        total[:] = 0
        return found

    def sums(self) -> dict[str, np.ndarray]:
        """Return what is summed over the parts of steps: forces on tines, strands and holders."""
        tines, held, driven = self.tines, self.effects.held, self.effects.driven
        found = {
            "tines": None if tines is None else tines.load,
            "strands": None if tines is None else tines.strands,
            "held": None if held is None else held.net,
            "driven": None if driven is None else driven.reaction,
        }
        return {name: total for name, total in found.items() if total is not None}


def begin(scene: Scene, dt: float | None = None) -> Marching:
    """Return a scene at its start, its neighbour list still empty.

    Parameters
    ----------
    scene : Scene
    dt : float, optional
        Take this time step [s], unchecked; else `timestep.choose_step`.

    Raises
    ------
    SceneError
        The scene cannot be laid out, or asks for an unstable time step.
    """
    state = build(scene)
    soft = softness(scene, state)
    soften(state, soft)
    limit = timestep.stable_step(
        state, effects.stiffness(scene), effects.viscous(scene), effects.touch_viscous(scene)
    )
    step = timestep.choose_step(scene, limit) if dt is None else dt
    return Marching(scene, state, effects.all_effects(scene, state, step), limit, step, soft=soft)
