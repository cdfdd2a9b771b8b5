"""A run on its way, in plain files: what is recorded so far, and a checkpoint to go on from.

    run.nc.part/
        about.json      scene, solver, time step, windows, columns of the samples
        samples.f64     a row for every sampling window, raw float64
        snapshots.f64   a row for every snapshot: time, displacement, x y z of every node
        checkpoint.npz  all that the march held at the end of some window
        lock            held by the process that writes

Whatever ends the process, these stay. What was written after the checkpoint is cut off when the
run goes on, and written again.
"""

from __future__ import annotations

import json
import os
import shutil
import sys
import time
from pathlib import Path
from typing import IO, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from sim.errors import SceneError
from sim.files import replacing

Arrays = dict[str, NDArray[Any]]
ABOUT, CHECKPOINT, LOCK = "about.json", "checkpoint.npz", "lock"
WALL_TIME = "wall_time"
SAMPLES, SNAPSHOTS = "samples.f64", "snapshots.f64"
VALUE = 8  # bytes


def part_of(path: Path) -> Path:
    """Return the folder of a run that is on its way to `path`."""
    return path.with_name(f"{path.name}.part")


class Recorded(NamedTuple):
    """What a journal holds: its about.json, samples (m, columns), snapshots (k, 2 + 3 nodes).

    The arrays are maps of the files.
    """

    about: dict[str, Any]
    samples: NDArray[np.float64]
    snapshots: NDArray[np.float64]


def read(folder: Path) -> Recorded:
    """Read the journal in a folder, also while it is being written.

    Raises
    ------
    SceneError
        The folder holds no journal.
    """
    try:
        about = json.loads((folder / ABOUT).read_text(encoding="utf-8"))
        tables = {name: _table(folder / name, width) for name, width in _widths(about).items()}
    except (OSError, ValueError, KeyError) as error:
        raise SceneError(
            f"{folder}: not an unfinished run of `combing simulate`: {error}"
        ) from None
    return Recorded(about, tables[SAMPLES], tables[SNAPSHOTS])


def _widths(about: dict[str, Any]) -> dict[str, int]:
    """Return the number of values in a row of each table."""
    return {SAMPLES: len(about["samples"]), SNAPSHOTS: 2 + 3 * sum(about["strands"])}


def _table(path: Path, width: int) -> NDArray[np.float64]:
    """Map the whole rows of a table."""
    rows = path.stat().st_size // (VALUE * width) if width else 0
    if rows == 0:
        return np.zeros((0, width))
    return np.memmap(path, np.float64, "r", shape=(rows, width))


def _checkpoint(folder: Path) -> Arrays:
    if not (folder / CHECKPOINT).exists():
        return {}
    with np.load(folder / CHECKPOINT) as saved:
        return dict(saved)


class Journal:
    """The files of one run, open for appending by this process alone.

    Parameters
    ----------
    folder : Path
        Made if it is not there.
    about : dict
        What about.json says; `scene` and `solver` tell this run from another.
    resume : bool
        Go on from the checkpoint in the folder, if there is one; else begin anew.

    Attributes
    ----------
    checkpoint : dict of arrays
        What to go on from; empty at the beginning.

    Raises
    ------
    SceneError
        Another process writes into the folder, or what it holds is another run.
    """

    def __init__(self, folder: Path, about: dict[str, Any], *, resume: bool) -> None:
        self.folder, self.about = folder, about
        self.checkpoint: Arrays = {}
        self._began = time.perf_counter()
        folder.mkdir(parents=True, exist_ok=True)
        self._lock = (folder / LOCK).open("ab")
        try:
            _hold(self._lock, folder)
            if resume and (folder / ABOUT).exists():
                _same_run(folder, read(folder).about, about)
                self.checkpoint = _checkpoint(folder)
            else:
                (folder / CHECKPOINT).unlink(missing_ok=True)
        except BaseException:
            self._lock.close()
            raise
        with replacing(folder / ABOUT) as temporary:
            temporary.write_text(json.dumps(about, indent=1), encoding="utf-8")
        self._tables = {name: self._open(name, width) for name, width in _widths(about).items()}

    def _open(self, name: str, width: int) -> IO[bytes]:
        """Open a table and cut it off behind the checkpoint."""
        rows = int(self.checkpoint.get(name, 0))
        table = (self.folder / name).open("ab")
        table.truncate(VALUE * width * rows)
        return table

    def sample(self, row: list[float]) -> None:
        """Append what was measured in a sampling window."""
        self._append(SAMPLES, np.array(row))

    def snapshot(self, row: NDArray[np.float64]) -> None:
        """Append the strands at one instant, (2 + 3 nodes,)."""
        self._append(SNAPSHOTS, row)

    def _append(self, name: str, row: NDArray[np.float64]) -> None:
        self._tables[name].write(row.tobytes())
        self._tables[name].flush()

    def wall_time(self) -> float:
        """Return how long this run has taken, the parts before a checkpoint included [s]."""
        return float(self.checkpoint.get(WALL_TIME, 0.0)) + time.perf_counter() - self._began

    def save(self, frozen: Arrays) -> None:
        """Write the checkpoint that belongs to what has been appended so far."""
        rows = {WALL_TIME: np.array(self.wall_time())}
        for name, width in _widths(self.about).items():
            file = self._tables[name].fileno()
            os.fsync(file)
            rows[name] = np.array(os.fstat(file).st_size // (VALUE * max(width, 1)))
        with replacing(self.folder / CHECKPOINT) as temporary, temporary.open("wb") as stream:
            np.savez(stream, **frozen, **rows)  # type: ignore[arg-type]
            stream.flush()
            os.fsync(stream.fileno())

    def close(self) -> None:
        """Let go of the files, which stay."""
        for stream in (*self._tables.values(), self._lock):
            stream.close()

    def remove(self) -> None:
        """Close and remove all files."""
        self.close()
        shutil.rmtree(self.folder)


def _same_run(folder: Path, there: dict[str, Any], here: dict[str, Any]) -> None:
    differing = [
        key
        for key in here["scene"]
        if there.get("scene", {}).get(key, ...) != here["scene"][key] and key != "title"
    ]
    if differing:
        what = f"another scene (it differs in {', '.join(differing)})"
    elif there.get("solver") != here["solver"]:
        what = "another version of the solver"
    else:
        return
    raise SceneError(
        f"{folder}: an unfinished run of {what}; finish or remove it, write to another place, or "
        "start anew over it (resume=False, --fresh)"
    )


def _hold(stream: IO[bytes], folder: Path) -> None:
    """Lock the folder until this process ends, however it ends."""
    try:
        if sys.platform == "win32":
            import msvcrt

            msvcrt.locking(stream.fileno(), msvcrt.LK_NBLCK, 1)
        else:
            import fcntl

            fcntl.flock(stream, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except (BlockingIOError, PermissionError):
        raise SceneError(
            f"{folder}: another process is writing this run; wait for it or write to another place"
        ) from None
    except OSError:
        pass  # a file system without locks
