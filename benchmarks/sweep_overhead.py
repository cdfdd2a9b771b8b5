"""What a sweep adds to its simulations, how two workers share them, what the store costs a point.

    PYTHONPATH=. python benchmarks/sweep_overhead.py [points]

The same points are simulated by hand one after another, by `combing sweep` on one worker, and on
two. The start of a worker (imports, compiled kernels from the cache) is measured by a sweep of one
point and counted apart. The store is measured on points that are described but never simulated.
"""

import contextlib
import sys
import tempfile
import time
from pathlib import Path

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


def timed(work) -> float:
    began = time.perf_counter()
    work()
    return time.perf_counter() - began


def by_hand(chosen: list[Member]) -> float:
    """Return the time of simulating, writing and measuring the points in this process [s]."""
    with tempfile.TemporaryDirectory() as folder:
        paths = [Path(folder) / run_name(one.scene) for one in chosen]

        def work() -> None:
            for one, path in zip(chosen, paths, strict=True):
                sim.simulate(one.scene, path=path)
                measured(sim.open_run(path))

        return timed(work)


def by_sweep(chosen: list[Member], jobs: int) -> float:
    """Return the time of `combing sweep` [s]."""
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
        return {name: timed(work) / count for name, work in works.items()}


def main() -> None:
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 16
    chosen = drawn(count)
    with contextlib.suppress(sim.Unstable):
        by_hand(chosen[:1])  # compiles
    hand = by_hand(chosen)
    start = by_sweep(chosen[:1], 1) - hand / count
    one, two = by_sweep(chosen, 1), by_sweep(chosen, 2)
    extra = (one - start - hand) / count
    print(f"{count} points of {hand / count:.2f} s; seconds of wall time")
    print(f"start of a worker            {start:8.2f} s, once")
    print(f"added a point, one worker    {extra:8.3f} s, {extra / (hand / count):.1%} of it")
    print(f"efficiency of two workers    {(one - start) / (2 * (two - start)):8.1%}")
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
