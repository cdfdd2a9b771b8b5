"""What is watched while a scene runs: loads and energies every window, strands now and then."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from sim.energy import books
from sim.marching import Marching

Columns = dict[str, dict[str, str]]
Observer = Callable[[Marching, int], list[float]]

FORCE: Columns = {
    "time": {"units": "s"},
    "displacement": {"units": "m"},
    "force": {"units": "N", "long_name": "force on the moving tines, positive when it resists"},
}


def columns(march: Marching) -> Columns:
    """Return name and attributes of every value in a sample of this march's scene."""
    table: Columns = {}
    if march.scene.tines:
        table |= FORCE
    if march.scene.output.energy:
        about = {"units": "J", "long_name": "at the end of the window"}
        table["energy_time"] = {"units": "s", "long_name": "end of the window"}
        table |= {f"energy_{name}": about for name in books(march)}
    return table


def observers(march: Marching) -> list[Observer]:
    """Return what fills these columns: called with the steps of the window that has just ended."""
    found: list[Observer] = []
    if march.scene.tines:
        found.append(ForceRecorder(march))
    if march.scene.output.energy:
        found.append(energies)
    return found


class ForceRecorder:
    """Force on all moving tines along their motion, averaged over every sampling window.

    Time and displacement, that of the first moving tine, belong to the middle of the window. Where
    no tine moves, the force on all of them along their `direction` is recorded.
    """

    def __init__(self, march: Marching) -> None:
        directions = np.array([tine.direction for tine in march.scene.tines])
        moving = np.array([tine.travel > 0 for tine in march.scene.tines])
        self._first = int(np.argmax(moving))
        self._along = directions / np.linalg.norm(directions, axis=1, keepdims=True)
        self._along[~moving & moving.any()] = 0.0
        self._travel = self._now(march)

    def _now(self, march: Marching) -> float:
        return float(march.tine_travel()[self._first])

    def __call__(self, march: Marching, steps: int) -> list[float]:
        """Return a value for each column."""
        before, self._travel = self._travel, self._now(march)
        force = -float(np.sum(march.take_load() * self._along)) / steps
        return [march.time - 0.5 * steps * march.dt, 0.5 * (before + self._travel), force]


def energies(march: Marching, steps: int) -> list[float]:
    """Return the time and the ledger at the end of the window."""
    return [march.time, *books(march).values()]


def due(wanted: int, windows: int) -> set[int]:
    """Return after which windows a snapshot is due: evenly spread, start and end included."""
    wanted = min(max(wanted, 2), windows + 1)
    return set(np.linspace(0, windows, wanted).round().astype(int).tolist())


def snapshot(march: Marching) -> NDArray[np.float64]:
    """Return time [s], travel of the first tine [m] and x y z of every node [m], in one row."""
    travel = march.tine_travel()
    head = [march.time, float(travel[0]) if len(travel) else 0.0]
    return np.concatenate([head, *(strand.ravel() for strand in march.state.strands())])
