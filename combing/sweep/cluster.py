"""Points of a sweep on the workers of a dask scheduler, which share the folder of the points."""

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import sim
from combing.errors import UserError
from combing.workers import Died

PATIENCE = "10s"  # for a scheduler to answer


def cluster(address: str) -> Callable[[Mapping[Path, sim.Scene]], "Cluster"]:
    """Return what starts scenes on the scheduler at `address`, such as tcp://node1:8786.

    Raises
    ------
    UserError
        If dask.distributed is not installed or nothing answers there.
    """
    try:
        from distributed import Client
    except ImportError:
        raise UserError('--scheduler needs dask: pip install "combing[cluster]"') from None
    try:
        client = Client(address, timeout=PATIENCE)
    except (OSError, ValueError) as error:
        raise UserError(f"--scheduler {address}: no dask scheduler answers: {error}") from None
    return lambda scenes: Cluster(client, scenes)


class Cluster:
    """Scenes on the workers of a dask scheduler; a worker that dies is replaced by another.

    A task has the name of its point, so a second driver of the same sweep waits for the first one's
    tasks instead of computing them again.

    Parameters
    ----------
    client : distributed.Client
    scenes : mapping
        Scenes by the path that their run is written to.
    """

    def __init__(self, client: Any, scenes: Mapping[Path, sim.Scene]) -> None:
        self._client, self._total, self._done = client, len(scenes), 0
        self._futures = {
            client.submit(simulate_once, scene, path.resolve(), key=path.name, pure=False): path
            for path, scene in scenes.items()
        }

    @property
    def fraction(self) -> float:
        """Share of the scenes that have ended."""
        return self._done / self._total

    def wait(
        self, look: Callable[[], None], ended: Callable[[Path, Exception | None], None]
    ) -> None:
        """Wait for all scenes, as `combing.workers.Crew.wait` does."""
        from distributed import as_completed
        from distributed.scheduler import KilledWorker

        for future in as_completed(list(self._futures)):
            error = future.exception()
            if isinstance(error, KilledWorker):
                error = Died(f"its workers died: {error}")
            self._done += 1
            ended(self._futures[future], error)
            look()

    def stop(self) -> None:
        """Cancel what has not begun; what has is finished by its worker and found the next time."""
        self._client.cancel(list(self._futures))
        self._client.close()

    def dismiss(self) -> None:
        """Leave the cluster."""
        self._client.close()


def simulate_once(scene: sim.Scene, path: Path) -> None:
    """Simulate a scene into its file unless an earlier driver's task has done so."""
    if not path.exists():
        sim.simulate(scene, path)
