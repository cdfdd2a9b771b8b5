"""A run on its way, in plain files: what is recorded so far, and a checkpoint to go on from.

    run.nc.part/
        about.json      scene, solver, time step, windows, columns of the samples
        samples.f64     a row for every sampling window, raw float64
        snapshots.f64   a row for every snapshot: time, displacement, imbalance, speed, x y z of
                        every node, and the directors of every element if they are asked for
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
import zipfile
import zlib
from pathlib import Path
from typing import IO, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from sim.errors import SceneError
from sim.records.files import replacing

Arrays = dict[str, NDArray[Any]]
ABOUT, CHECKPOINT, LOCK = "about.json", "checkpoint.npz", "lock"
WALL_TIME, RUN = "wall_time", "run"
SAMPLES, SNAPSHOTS = "samples.f64", "snapshots.f64"
VALUE = 8  # bytes
HEAD = 4  # values of a snapshot before the nodes


def part_of(path: Path) -> Path:
    """Return the folder of a run that is on its way to `path`."""
    return path.with_name(f"{path.name}.part")


class Recorded(NamedTuple):
    """What a journal holds: its about.json, samples (m, values), snapshots (k, values).

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
        tables = {name: _table(folder / name, width) for name, width in widths(about).items()}
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise SceneError(
            f"{folder / ABOUT}: not an unfinished run of `combing simulate`: {error}"
        ) from None
    return Recorded(about, tables[SAMPLES], tables[SNAPSHOTS])


def widths(about: dict[str, Any]) -> dict[str, int]:
    """Return the number of values in a row of each table."""
    nodes, frames = sum(about["strands"]), about.get("frames", False)
    elements = nodes - len(about["strands"])
    return {
        SAMPLES: sum(3 * of["count"] if "of" in of else 1 for of in about["samples"].values()),
        SNAPSHOTS: HEAD + 3 * nodes + 9 * elements * frames,
    }


def _table(path: Path, width: int) -> NDArray[np.float64]:
    """Map the whole rows of a table."""
    rows = path.stat().st_size // (VALUE * width) if width else 0
    if rows == 0:
        return np.zeros((0, width))
    return np.memmap(path, np.float64, "r", shape=(rows, width))


def _checkpoint(folder: Path, about: dict[str, Any]) -> Arrays:
    """Read the checkpoint and see that what was recorded up to it is still there and its own.

    Raises
    ------
    SceneError
        A file was cut, emptied, changed or taken from another run.
    """
    path = folder / CHECKPOINT
    if not path.exists():
        return {}
    try:
        with path.open("rb") as stream, np.load(stream) as saved:
            arrays = dict(saved)
        counted = {name: tuple(arrays[name].tolist()) for name in (SAMPLES, SNAPSHOTS, RUN)}
    except (OSError, EOFError, ValueError, KeyError, zipfile.BadZipFile, zlib.error) as error:
        raise damaged(path, f"not a whole checkpoint: {error or type(error).__name__}") from None
    if counted.pop(RUN) != (_identity(about),):
        raise damaged(path, "the checkpoint of another run")
    for name, width in widths(about).items():
        rows, checksum = counted[name]
        there = (folder / name).stat().st_size if (folder / name).exists() else 0
        if there < VALUE * width * rows:
            raise damaged(
                folder / name,
                f"{there // (VALUE * max(width, 1))} rows where the checkpoint counts {rows}",
            )
        if _checksum(folder / name, VALUE * width * rows) != checksum:
            raise damaged(folder / name, "not what was recorded up to the checkpoint")
    return arrays


def damaged(path: Path, what: str) -> SceneError:
    """Return the error that says that a file of an unfinished run is not to be gone on from."""
    return SceneError(
        f"{path}: {what}; put the file back, or start anew over it (resume=False, --fresh)"
    )


def _identity(about: dict[str, Any]) -> int:
    """Return a number that tells runs of different scenes or solvers apart."""
    return zlib.crc32(json.dumps([about["scene"], about["solver"]], sort_keys=True).encode())


def _checksum(path: Path, size: int) -> int:
    """Return the checksum of the first bytes of a file."""
    result = 0
    with path.open("rb") as stream:
        while size > 0 and (piece := stream.read(min(size, 1 << 24))):
            result, size = zlib.crc32(piece, result), size - len(piece)
    return result


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
        Another process writes into the folder, what it holds is another run, or it is damaged.
    """

    def __init__(self, folder: Path, about: dict[str, Any], *, resume: bool) -> None:
        self.folder, self.about = folder, about
        self.checkpoint: Arrays = {}
        self._began = time.perf_counter()
        folder.mkdir(parents=True, exist_ok=True)
        self._lock = (folder / LOCK).open("ab")
        try:
            _hold(self._lock, folder)
            if resume and any((folder / name).exists() for name in (ABOUT, CHECKPOINT)):
                _same_run(folder, read(folder).about, about)
                self.checkpoint = _checkpoint(folder, about)
                about["attributes"] = read(folder).about["attributes"] | about["attributes"]
            else:
                (folder / CHECKPOINT).unlink(missing_ok=True)
        except BaseException:
            self._lock.close()
            raise
        self.amend()
        self._checksums: dict[str, int] = {}
        self._tables = {name: self._open(name, width) for name, width in widths(about).items()}

    def amend(self, **attributes: float | str) -> None:
        """Write about.json, with more of what the run says of itself."""
        self.about["attributes"] |= attributes
        with replacing(self.folder / ABOUT) as temporary:
            temporary.write_text(json.dumps(self.about, indent=1), encoding="utf-8")

    def _open(self, name: str, width: int) -> IO[bytes]:
        """Open a table and cut it off behind the checkpoint."""
        rows, self._checksums[name] = map(int, self.checkpoint.get(name, (0, 0)))
        table = (self.folder / name).open("ab")
        table.truncate(VALUE * width * rows)
        return table

    def sample(self, row: list[float]) -> None:
        """Append what was measured in a sampling window."""
        self._append(SAMPLES, np.array(row))

    def snapshot(self, row: NDArray[np.float64]) -> None:
        """Append the strands at one instant, see `observers.snapshot`."""
        self._append(SNAPSHOTS, row)

    def _append(self, name: str, row: NDArray[np.float64]) -> None:
        values = row.tobytes()
        self._checksums[name] = zlib.crc32(values, self._checksums[name])
        self._tables[name].write(values)
        self._tables[name].flush()

    def wall_time(self) -> float:
        """Return how long this run has taken, the parts before a checkpoint included [s]."""
        return float(self.checkpoint.get(WALL_TIME, 0.0)) + time.perf_counter() - self._began

    def save(self, frozen: Arrays) -> None:
        """Write the checkpoint that belongs to what has been appended so far."""
        rows = {WALL_TIME: np.array(self.wall_time()), RUN: np.array([_identity(self.about)])}
        for name, width in widths(self.about).items():
            file = self._tables[name].fileno()
            os.fsync(file)
            count = os.fstat(file).st_size // (VALUE * max(width, 1))
            rows[name] = np.array([count, self._checksums[name]])
        with replacing(self.folder / CHECKPOINT) as temporary, temporary.open("wb") as stream:
            np.savez(stream, **frozen, **rows)  # type: ignore[arg-type]
            stream.flush()
            os.fsync(stream.fileno())

    def state(self) -> Arrays:
        """Return the march's part of the checkpoint."""
        own = (WALL_TIME, RUN, SAMPLES, SNAPSHOTS)
        return {name: value for name, value in self.checkpoint.items() if name not in own}

    def close(self) -> None:
        """Let go of the files, which stay."""
        for stream in (*self._tables.values(), self._lock):
            stream.close()

    def remove(self) -> None:
        """Close and remove all files."""
        self.close()
        shutil.rmtree(self.folder)


def differing(there: dict[str, Any], here: dict[str, Any]) -> list[str]:
    """Return the keys in which two scenes differ, but for the title."""
    return [key for key in here if there.get(key, ...) != here[key] and key != "title"]


def _same_run(folder: Path, there: dict[str, Any], here: dict[str, Any]) -> None:
    if keys := differing(there["scene"], here["scene"]):
        what = f"another scene (it differs in {', '.join(keys)})"
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
