"""What is watched while a scene runs: loads and energies every window, strands now and then."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sim import rest
from sim.energy import books
from sim.kernels.ends import Held
from sim.march.marching import Marching

Columns = dict[str, dict[str, Any]]
Observer = Callable[[Marching, int], list[float]]

TIME: Columns = {"time": {"units": "s"}}
FORCE: Columns = {
    "displacement": {"units": "m"},
    "force": {"units": "N", "long_name": "force on the moving tines, positive when it resists"},
}


def columns(march: Marching) -> Columns:
    """Return name and attributes of every value in a sample of this march's scene."""
    table: Columns = {}
    if march.scene.tines or march.effects.held is not None:
        table |= TIME
    if march.scene.tines:
        table |= FORCE
    table |= _vectors(march)
    if march.scene.output.energy:
        about = {"units": "J", "long_name": "at the end of the window"}
        table["energy_time"] = {"units": "s", "long_name": "end of the window"}
        table |= {f"energy_{name}": about for name in books(march)}
    return table


def _vectors(march: Marching) -> Columns:
    """Return what is a vector for each of several bodies, `of` which there are so many."""
    tines, rods = len(march.scene.tines), len(march.scene.rods)
    table: Columns = {}
    if "strands" in march.sums():
        table["tine_force"] = {"units": "N", "long_name": "of the strands on each tine"}
        table["strand_force"] = {"units": "N", "long_name": "of all tines on each strand"}
        table["tine_force"] |= {"of": "tine", "count": tines}
        table["strand_force"] |= {"of": "strand", "count": rods}
    if march.effects.held is not None:
        of = {"of": "end", "count": len(march.effects.held.node)}
        about = "of the holder on the rod at each held end"
        table["reaction_force"] = {"units": "N", "long_name": about} | of
        table["reaction_moment"] = {"units": "N m", "long_name": f"{about}, about its node"} | of
    return table


def observers(march: Marching) -> list[Observer]:
    """Return what fills these columns: called with the steps of the window that has just ended."""
    found: list[Observer] = []
    if march.scene.tines or march.effects.held is not None:
        found.append(middle)
    if march.scene.tines:
        found.append(ForceRecorder(march))
    if march.effects.held is not None:
        found.append(ReactionRecorder(march, march.effects.held))
    if march.scene.output.energy:
        found.append(energies)
    return found


class ForceRecorder:
    """Force on all moving tines along their motion, averaged over every sampling window.

    The displacement, that of the first moving tine, belongs to the middle of the window. Where
    no tine moves, the force on all of them along their `direction` is recorded. With
    `output.forces` also the vector on each tine, and that of all tines on each strand.
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
        load = march.take_load()
        force = -float(np.sum(load * self._along)) / steps
        row = [0.5 * (before + self._travel), force]
        if "strands" in march.sums():
            row += [*(load / steps).flat, *(march.take("strands") / steps).flat]
        return row


class ReactionRecorder:
    """Force and moment of the holder on the rod at every held end, means over a sampling window.

    Where the holder moves, what speeds up the mass of the end's own node is part of its force.
    """

    def __init__(self, march: Marching, held: Held) -> None:
        self._node, self._slide = held.node, held.slide
        self._mass = march.state.row("MASS")[held.node].reshape(-1, 1)
        self._velocity = self._now(march)

    def _now(self, march: Marching) -> NDArray[np.float64]:
        return np.asarray(march.state.rows("V0 V1 V2").T[self._node])

    def __call__(self, march: Marching, steps: int) -> list[float]:
        """Return a value for each column."""
        before, self._velocity = self._velocity, self._now(march)
        gained = self._mass * (self._velocity - before)
        gained -= np.sum(gained * self._slide, axis=1, keepdims=True) * self._slide
        net = march.take("held") / steps
        force = gained / (steps * march.dt) - net[:, :3]
        return [*force.flat, *(-net[:, 3:]).flat]


def middle(march: Marching, steps: int) -> list[float]:
    """Return the time in the middle of the window."""
    return [march.time - 0.5 * steps * march.dt]


def energies(march: Marching, steps: int) -> list[float]:
    """Return the time and the ledger at the end of the window."""
    return [march.time, *books(march).values()]


def due(wanted: int, windows: int) -> set[int]:
    """Return after which windows a snapshot is due: evenly spread, start and end included."""
    wanted = min(max(wanted, 2), windows + 1)
    return set(np.linspace(0, windows, wanted).round().astype(int).tolist())


def snapshot(march: Marching, *, start: bool = False) -> NDArray[np.float64]:
    """Return time [s], travel of the first tine [m], forces out of balance, the largest speed [m/s]
    and x y z of every node [m], in one row.

    With `output.frames` the directors of every element follow, d1, d2, d3 of the first and so on.
    At the `start` no forces are known.
    """
    travel = march.tine_travel()
    head = [march.time, float(travel[0]) if len(travel) else 0.0]
    head += [np.nan if start else float(rest.imbalance(march).max()), rest.speed(march)]
    row = [np.array(head), *(strand.ravel() for strand in march.state.strands())]
    if march.scene.output.frames:
        row += [frames.ravel() for frames in march.state.frames()]
    return np.concatenate(row)
