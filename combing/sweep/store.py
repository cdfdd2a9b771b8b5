"""Points of a sweep on disk: the file system is the truth, whichever engine fills it.

    OUT/runs/NAME.nc           a finished run; NAME is a hash of every parameter and of the solver
    OUT/runs/NAME.nc.part/     a run on its way, to go on from
    OUT/runs/NAME.json         what the point is: preset, parameters, seed, solver; and what it gave
    OUT/runs/NAME.failed.json  why there is no run

Each file is written to another name and then renamed, so whatever ends a sweep leaves whole points.
"""

import json
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any, TypeVar

import pandas as pd

import sim
from combing.ensemble import Member
from combing.errors import UserError, is_users_fault
from combing.runs import model_version, run_name
from combing.writing import write_text

T = TypeVar("T")
LASTING = (sim.Unstable,)  # failures that the same scene has again; others may pass


class Store:
    """The points in a folder.

    Parameters
    ----------
    folder : Path
        OUT of the sweep.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder / "runs"

    def prepare(self) -> None:
        """Make the folder; raise UserError, before any work, if it cannot be written to."""
        try:
            self.folder.mkdir(parents=True, exist_ok=True)
            _write(self.folder / "writable", {})
            (self.folder / "writable").unlink()
        except OSError as error:
            raise UserError(f"{self.folder}: cannot be written to: {error.strerror}") from error

    def path(self, member: Member) -> Path:
        """Return where a member's run is."""
        return self.folder / run_name(member.scene)

    def failure(self, member: Member) -> str | None:
        """Return why a point has no run, None where it is not known to fail."""
        found = _read(_failed(self.path(member)))
        return found["reason"] if found else None

    def missing(self, members: Iterable[Member], *, retry: bool = False) -> dict[Path, Member]:
        """Return what is still to be simulated, by path.

        Points whose motion became unstable would become so again; they are left out unless `retry`.
        What failed for another reason (a full disk, a killed process) is tried again.
        """
        found = {}
        for member in members:
            path = self.path(member)
            lasting = (_read(_failed(path)) or {}).get("lasting", False)
            if not path.exists() and (retry or not lasting):
                found[path] = member
        return found

    def describe(self, member: Member) -> None:
        """Write what a point is, beside its run to be."""
        path = self.path(member).with_suffix(".json")
        if not path.exists():
            _write(path, statepoint(member))

    def fail(self, member: Member, error: Exception) -> None:
        """Record why a point has no run."""
        reason = " ".join(str(error).split()) or type(error).__name__
        if not is_users_fault(error):
            reason = (
                f"a defect of this program ({type(error).__name__}: {reason}); please report it"
            )
        kept = {"reason": reason, "lasting": isinstance(error, LASTING)}
        _write(_failed(self.path(member)), statepoint(member) | kept)

    def succeed(self, member: Member, results: Mapping[str, float]) -> None:
        """Write what a finished run gave; an earlier failure is forgotten."""
        path = self.path(member)
        _failed(path).unlink(missing_ok=True)
        _write(path.with_suffix(".json"), statepoint(member) | {"results": dict(results)})

    def results(self, member: Member) -> dict[str, float] | None:
        """Return what a finished run gave, None where that is not on disk."""
        found = _read(self.path(member).with_suffix(".json")) or {}
        return found.get("results") if self.path(member).exists() else None

    def table(self, members: Sequence[Member], varied: Sequence[str]) -> pd.DataFrame:
        """Return one row a point: its parameters, seed, state, results, reason, and file."""
        return pd.DataFrame([self._row(member, varied) for member in members])

    def _row(self, member: Member, varied: Sequence[str]) -> dict[str, Any]:
        path = self.path(member)
        reason = "" if path.exists() else self.failure(member)
        state = "done" if path.exists() else "missing" if reason is None else "failed"
        row = {name: member.parameters[name] for name in varied}
        row |= {"seed": member.seed, "state": state, **(self.results(member) or {})}
        return row | {"reason": reason or "", "file": f"runs/{path.name}"}


def statepoint(member: Member) -> dict[str, Any]:
    """Return what a point is, in plain values."""
    found = {
        "preset": member.preset,
        "parameters": dict(member.parameters),
        "seed": member.seed,
        "solver": model_version(),
    }
    return found | ({"setting": dict(member.setting)} if member.setting else {})


def part_of_points(points: Sequence[T], part: tuple[int, int]) -> list[T]:
    """Return every n-th of the points, beginning with the i-th: the share of part (i, n)."""
    first, parts = part
    return list(points[first - 1 :: parts])


def _failed(path: Path) -> Path:
    return path.with_suffix(".failed.json")


def _read(path: Path) -> dict[str, Any] | None:
    try:
        return json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return None


def _write(path: Path, content: Mapping[str, Any]) -> None:
    write_text(path, json.dumps(content, indent=1) + "\n")
