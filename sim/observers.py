"""What is watched while a scene runs: tine loads every window, strands every so often."""

from __future__ import annotations

import numpy as np

from sim.explicit import Explicit
from sim.scene import Scene


class ForceRecorder:
    """Force on the first tine, averaged over every sampling window.

    Time and displacement belong to the middle of the window; force is positive when it resists.
    """

    def __init__(self, scene: Scene) -> None:
        tine = scene.tines[0]
        self._along = np.array(tine.direction) / np.linalg.norm(tine.direction)
        self._travel = 0.0
        self.time: list[float] = []
        self.displacement: list[float] = []
        self.force: list[float] = []

    def observe(self, march: Explicit, steps: int) -> None:
        """Record the window of `steps` steps that has just ended."""
        travel = float(march.tine_travel()[0])
        self.time.append(march.time - 0.5 * steps * march.dt)
        self.displacement.append(0.5 * (travel + self._travel))
        self.force.append(-float(march.take_load()[0] @ self._along) / steps)
        self._travel = travel


class SnapshotRecorder:
    """Strands at evenly spaced instants, the start and the end included."""

    def __init__(self, wanted: int, windows: int) -> None:
        self._due = set(np.unique(np.linspace(0, windows, max(wanted, 2)).round().astype(int)))
        self.time: list[float] = []
        self.displacement: list[float] = []
        self.position: list[np.ndarray] = []

    def observe(self, march: Explicit, window: int) -> None:
        """Record the strands if a snapshot is due after this many windows."""
        if window not in self._due:
            return
        travel = march.tine_travel()
        self.time.append(march.time)
        self.displacement.append(float(travel[0]) if len(travel) else 0.0)
        self.position.append(np.concatenate(march.state.strands()))
