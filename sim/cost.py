"""What a run will cost, said before it starts, and too much of it refused."""

from __future__ import annotations

import shutil
import time
from pathlib import Path
from typing import Any, NamedTuple

from sim.errors import SceneError
from sim.explicit import Explicit
from sim.march import checkpoint
from sim.records.journal import SAMPLES, SNAPSHOTS, widths
from sim.records.observers import due

TRIAL = 0.05  # s of marching from which its speed is told
MOST = 7 * 86400.0  # s
BYTES = 1900  # of memory for an element, whatever is recorded (tests/sim/test_memory.py)


class Cost(NamedTuple):
    """Steps, and about how much memory [byte], file [byte] and time on this machine [s]."""

    steps: int
    memory: float
    file: float
    seconds: float

    def __str__(self) -> str:
        """Return it in words."""
        return (
            f"{self.steps:.3g} steps, {_in_words(self.seconds)}, {self.memory / 1e6:.3g} MB of "
            f"memory, a file of {self.file / 1e6:.3g} MB"
        )


def _in_words(seconds: float) -> str:
    for unit, size in (("days", 86400), ("hours", 3600), ("minutes", 60)):
        if seconds > 2 * size:
            return f"about {seconds / size:.2g} {unit}"
    return f"about {max(seconds, 1):.2g} seconds"


def cost(march: Explicit, about: dict[str, Any]) -> Cost:
    """Return what a run from where the march is will cost; the march is left as it was."""
    steps = about["windows"] * about["window_steps"]
    snapshots = len(due(march.scene.output.snapshots, min(about["windows"], 1 << 24)))
    nodes, width = sum(about["strands"]), widths(about)
    file = 8.0 * (snapshots * width[SNAPSHOTS] + about["windows"] * width[SAMPLES])
    return Cost(steps, BYTES * nodes, file, steps * _time_of_a_step(march))


def _time_of_a_step(march: Explicit) -> float:
    """March on a little and go back [s]; as fast as contact lets it now, not as it may become."""
    before = checkpoint.mark(march)
    steps, taken = 16, 0.0
    cause = march.march_to(march.steps + 1)  # loads the kernels
    while cause is None and taken < TRIAL and steps < 4096:
        steps *= 2
        began = time.perf_counter()
        cause = march.march_to(march.steps + steps)  # if it stops, the run itself will say so
        taken = time.perf_counter() - began
    checkpoint.thaw(march, before)
    return taken / steps


def refuse_absurd(cost: Cost, path: Path) -> None:
    """Refuse a run that this machine can hardly end, or not write to this path.

    Raises
    ------
    SceneError
        It would take more than a week, or more room than the disk has.
    """
    folder = next(each for each in path.resolve().parents if each.exists())
    free = shutil.disk_usage(folder).free
    if cost.file > free:
        what = f"{free / 1e6:.3g} MB are free in {folder}: record fewer snapshots or samples"
    elif cost.seconds > MOST:
        what = "more than a week: shorten what is simulated, or take fewer or longer elements"
    else:
        return
    raise SceneError(f"this run would take {cost}: {what}; or run it at any cost (--any-cost)")
