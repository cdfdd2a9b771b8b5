"""Simulate scenes side by side, once each: a run that is on disk already is not run again."""

import hashlib
import os
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import FIRST_EXCEPTION, Future, ProcessPoolExecutor, wait
from contextlib import contextmanager
from functools import cache, partial
from multiprocessing import get_context
from pathlib import Path
from typing import Any, TypeVar

from tqdm import tqdm

import sim

Key = TypeVar("Key")
POLL = 0.2  # seconds between two looks at the progress of the runs
_fractions: Any = None


@cache
def model_version() -> str:
    """Hash of the solver's sources: a changed solver does not reuse runs of the old one."""
    root = Path(sim.__file__).parent
    content = hashlib.sha256()
    for path in sorted(root.rglob("*.py")):
        content.update(path.relative_to(root).as_posix().encode() + path.read_bytes())
    return content.hexdigest()[:12]


def run_name(scene: sim.Scene) -> str:
    """File name of a scene's run: a hash of every parameter and of the solver."""
    content = f"{model_version()} {scene.model_dump_json()}"
    return hashlib.sha256(content.encode()).hexdigest()[:16] + ".nc"


@contextmanager
def simulating(
    scenes: Mapping[Key, sim.Scene], folder: Path, *, jobs: int | None = None, quiet: bool = False
) -> Iterator[Callable[[], dict[Key, sim.Run]]]:
    """Simulate scenes in processes of their own while the block does something else.

    Parameters
    ----------
    scenes : mapping
        Scenes by any key; the same scene under two keys is run once. The longest should be first.
    folder : Path
        Where the runs are kept, one NetCDF file each, named by `run_name`.
    jobs : int, optional
        Processes at once; as many as there are cores when absent.
    quiet : bool
        Show no progress.

    Yields
    ------
    callable
        Waits for the runs, showing progress, and returns them by the keys of `scenes`. It raises
        what a scene raises (sim.SceneError, sim.Unstable); finished runs stay on disk, and those
        that were on their way go on from there the next time.
    """
    paths = {key: folder / run_name(scene) for key, scene in scenes.items()}
    missing = {paths[key]: scene for key, scene in scenes.items() if not paths[key].exists()}

    def opened() -> dict[Key, sim.Run]:
        return {key: sim.open_run(path) for key, path in paths.items()}

    if not missing:
        yield opened
        return
    context = get_context("spawn")
    fractions = context.Array("d", len(missing))
    workers = min(len(missing), jobs or os.cpu_count() or 1)
    with ProcessPoolExecutor(workers, context, _adopt, (fractions,)) as pool:
        futures = [
            pool.submit(_simulate, number, scene, path)
            for number, (path, scene) in enumerate(missing.items())
        ]

        def finished() -> dict[Key, sim.Run]:
            _watch(futures, fractions, quiet)
            return opened()

        try:
            yield finished
        except BaseException:
            _stop(pool)
            raise


def _stop(pool: ProcessPoolExecutor) -> None:
    """Stop simulations in mid-run: what they would find is not wanted any more."""
    processes = list(pool._processes.values())
    for process in processes:
        process.kill()
    for process in processes:
        process.join()
    pool.shutdown(wait=False, cancel_futures=True)


def _watch(futures: list[Future], fractions: Any, quiet: bool) -> None:
    total = len(futures)
    layout = "{desc}: {percentage:3.0f}%|{bar}| {elapsed}<{remaining}"
    name = f"simulating {total} scene{'s' if total > 1 else ''}"
    with tqdm(total=100.0, desc=name, bar_format=layout, mininterval=1, disable=quiet) as bar:
        running = set(futures)
        while running:
            done, running = wait(running, timeout=POLL, return_when=FIRST_EXCEPTION)
            for future in done:
                future.result()
            bar.update(100 * sum(fractions) / total - bar.n)


def _adopt(fractions: Any) -> None:
    global _fractions
    _fractions = fractions


def _simulate(number: int, scene: sim.Scene, path: Path) -> None:
    sim.simulate(scene, path, progress=partial(_report, number))


def _report(number: int, fraction: float) -> None:
    _fractions[number] = fraction
