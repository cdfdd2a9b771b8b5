"""Processes that simulate scenes, one file a scene, and that never outlive who asked for them."""

import os
import threading
from collections.abc import Callable, Mapping
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from functools import partial
from multiprocessing import connection, get_context, parent_process
from pathlib import Path
from typing import Any

import sim

POLL = 0.2  # seconds between two looks at the progress of the runs
LIVES = 3  # times that a scene may be under way when a process dies before it is given up
_fractions: Any = None


class Died(RuntimeError):
    """The process that simulated a scene came to its end without a word (killed, out of memory)."""

    users_fault = True


class Crew:
    """Simulate scenes in processes of their own from now on.

    Parameters
    ----------
    scenes : mapping
        Scenes by the path that their run is written to; started in this order.
    workers : int
        Processes at once.
    any_cost : bool
        Simulate also what would take more than a week.
    """

    def __init__(
        self, scenes: Mapping[Path, sim.Scene], workers: int, *, any_cost: bool = False
    ) -> None:
        self._scenes, self._any_cost = dict(scenes), any_cost
        self._numbers = {path: number for number, path in enumerate(self._scenes)}
        self._lives = dict.fromkeys(self._scenes, LIVES)
        self._workers = workers
        self._fractions = get_context("spawn").Array("d", len(self._scenes))
        self._start(list(self._scenes))

    def _start(self, paths: list[Path]) -> None:
        context = get_context("spawn")
        self._pool = ProcessPoolExecutor(self._workers, context, _adopt, (self._fractions,))
        self._futures: dict[Future, Path] = {
            self._pool.submit(
                _simulate, self._numbers[path], self._scenes[path], path, self._any_cost
            ): path
            for path in paths
        }

    @property
    def fraction(self) -> float:
        """How much of the work is done, from 0 to 1."""
        return sum(self._fractions[:]) / len(self._scenes)

    def wait(
        self,
        look: Callable[[], None],
        ended: Callable[[Path, Exception | None], None],
    ) -> None:
        """Wait for all scenes.

        Parameters
        ----------
        look : callable
            Called every `POLL` seconds.
        ended : callable
            Called with the path of each scene whose run has ended, and what it raised if it did.
        """
        running = set(self._futures)
        while running:
            done, running = wait(running, timeout=POLL, return_when=FIRST_COMPLETED)
            if any(isinstance(future.exception(), BrokenProcessPool) for future in done):
                running = self._again(done | running, ended)
                continue
            for future in done:
                self._end(self._futures[future], future.exception(), ended)
            look()

    def _again(self, futures: set[Future], ended: Callable) -> set[Future]:
        """Go on with new processes after one has died; a pool loses all that it was to do."""
        left = []
        for future in sorted(futures, key=lambda one: self._numbers[self._futures[one]]):
            path, error = self._futures[future], future.exception()
            if not isinstance(error, BrokenProcessPool):
                self._end(path, error, ended)
                continue
            self._lives[path] -= self._fractions[self._numbers[path]] > 0
            self._fractions[self._numbers[path]] = 0.0
            if self._lives[path] > 0:
                left.append(path)
            else:
                self._end(path, Died(f"its process died {LIVES} times; out of memory?"), ended)
        self._pool.shutdown(wait=False, cancel_futures=True)
        self._start(left)
        return set(self._futures)

    def _end(self, path: Path, error: BaseException | None, ended: Callable) -> None:
        if error is not None and not isinstance(error, Exception):
            raise error
        self._fractions[self._numbers[path]] = 1.0
        ended(path, error)

    def stop(self) -> None:
        """Stop simulations in mid-run: what they would find is not wanted any more."""
        processes = list((self._pool._processes or {}).values())
        for process in processes:
            process.kill()
        for process in processes:
            process.join()
        self._pool.shutdown(wait=False, cancel_futures=True)

    def dismiss(self) -> None:
        """Send the processes home after the last run."""
        self._pool.shutdown()


def cores() -> int:
    """Return how many cores this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def end_with_parent() -> None:
    """End this process as soon as the one that started it is gone, however that ended.

    A pool's processes wait for work on a pipe that they hold open themselves, so a parent that was
    killed leaves them waiting, or simulating, for ever.
    """
    parent = parent_process()
    if parent is not None:
        threading.Thread(target=_follow, args=(parent.sentinel,), daemon=True).start()


def _follow(sentinel: int) -> None:
    connection.wait([sentinel])
    os._exit(1)


def _adopt(fractions: Any) -> None:
    global _fractions
    _fractions = fractions
    end_with_parent()


def _simulate(number: int, scene: sim.Scene, path: Path, any_cost: bool) -> None:
    _report(number, 1e-9)  # under way: should the process die, this scene may be why
    sim.simulate(scene, path, progress=partial(_report, number), any_cost=any_cost)


def _report(number: int, fraction: float) -> None:
    _fractions[number] = fraction
