"""What a sweep adds to its simulations, how two workers share them, what the store costs a point.

    PYTHONPATH=. python benchmarks/sweep_overhead.py [points]

The same points are simulated by hand one after another, by `combing sweep` on one worker, and on
two. The start of a worker (imports, compiled kernels from the cache) is measured by a sweep of one
point and counted apart. The store is measured on points that are described but never simulated.
Processor time (of this process and those it started) is what a busy machine leaves untouched; the
efficiency of two workers is of wall time and means something on a quiet one alone.
"""

import contextlib
import os
import sys
import tempfile
import time
from pathlib import Path
from typing import NamedTuple

import sim
from combing.ensemble import Member, members
from combing.runs import run_name
from combing.sweep.run import measured, simulate_points
from combing.sweep.store import Store

TINY = {"pi1": 24.0, "height": 0.03, "snapshots": 11}
STORED = 2000
PLANNED, CORES, POINT = 100_000, 1000, 60.0  # points, cores, seconds of a full-height combing


def drawn(count: int) -> list[Member]:
    """Return that many combings of a few seconds each."""
    return members("double_helix", TINY, range(1, count + 1))


class Time(NamedTuple):
    """Seconds, of the clock and of processors."""

    wall: float
    cpu: float


def timed(work) -> Time:
    began, before = time.perf_counter(), sum(os.times()[:4])
    work()
    return Time(time.perf_counter() - began, sum(os.times()[:4]) - before)


def by_hand(chosen: list[Member]) -> Time:
    """Return the time of simulating, writing and measuring the points in this process."""
    with tempfile.TemporaryDirectory() as folder:
        paths = [Path(folder) / run_name(one.scene) for one in chosen]

        def work() -> None:
            for one, path in zip(chosen, paths, strict=True):
                sim.simulate(one.scene, path=path)
                measured(sim.open_run(path))

        return timed(work)


def by_sweep(chosen: list[Member], jobs: int) -> Time:
    """Return the time of `combing sweep`."""
    with tempfile.TemporaryDirectory() as folder:
        store = Store(Path(folder))
        return timed(lambda: simulate_points(chosen, store, jobs=jobs, quiet=True))


def of_store(count: int) -> dict[str, float]:
    """Return what a point costs the store [s]: to look for, to describe, to tabulate."""
    chosen = drawn(count)
    with tempfile.TemporaryDirectory() as folder:
        store = Store(Path(folder))
        store.prepare()
        works = {
            "look for": lambda: store.missing(chosen),
            "describe": lambda: [store.describe(one) for one in chosen],
            "tabulate": lambda: store.table(chosen, ["pi1"]),
        }
        return {name: timed(work).cpu / count for name, work in works.items()}


def main() -> None:
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 16
    chosen = drawn(count)
    with contextlib.suppress(sim.Unstable):
        by_hand(chosen[:1])  # compiles
    hand = by_hand(chosen)
    first = by_sweep(chosen[:1], 1)
    one, two = by_sweep(chosen, 1), by_sweep(chosen, 2)
    each_by_hand = hand.cpu / count
    start = first.cpu - each_by_hand
    extra = (one.cpu - start - hand.cpu) / count
    waits = first.wall - hand.wall / count
    print(f"{count} points of {each_by_hand:.2f} s of processor time")
    print(f"start of a worker            {start:8.2f} s of processor time, once")
    print(f"added a point, one worker    {extra:8.3f} s, {extra / each_by_hand:.1%} of it")
    efficiency = (one.wall - waits) / (2 * (two.wall - waits))
    print(f"efficiency of two workers    {efficiency:8.1%} by clock; load {os.getloadavg()[0]:.1f}")
    each = of_store(STORED)
    for name, cost in each.items():
        print(f"store, to {name:10s} a point  {1e3 * cost:7.3f} ms")
    work = PLANNED * POINT / CORES
    lost = start + PLANNED / CORES * extra
    index = PLANNED * (each["look for"] / CORES + each["tabulate"])
    print(
        f"{PLANNED} points of {POINT:g} s on {CORES} cores: {work / 3600:.2f} h of simulation, "
        f"{lost:.0f} s of overhead a core ({lost / work:.1%}), {index:.0f} s of tables"
    )


if __name__ == "__main__":
    main()
