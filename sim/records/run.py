"""A finished simulation: one labelled data set, in memory and as a NetCDF file."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd

from sim.errors import SceneError
from sim.records import journal
from sim.records.files import replacing
from sim.records.journal import part_of
from sim.scene import Scene

if TYPE_CHECKING:
    import xarray

NOT_REACHED = "not reached"  # what `attrs["rest"]` says of a scene that ran out of time
IMBALANCE = {
    "units": "1",
    "long_name": "largest net force on a node over its weight; over the largest inner force "
    "without gravity",
}
COMBING = 0.01  # of the work: contacts that do less are no combing


class Run:
    """What a simulation recorded.

    Attributes
    ----------
    data : xarray.Dataset
        Dimensions `sample` (force log), `snapshot`, `node` (all rods, one after another), `axis`;
        every variable has units; the attributes hold the scene, versions and the time step.
    """

    def __init__(self, data: xarray.Dataset) -> None:
        self.data = data

    @property
    def scene(self) -> Scene:
        """The scene that was simulated."""
        return Scene.model_validate_json(self.data.attrs["scene"])

    @property
    def times(self) -> np.ndarray:
        """Time of every snapshot [s]."""
        return np.asarray(self.data["snapshot_time"])

    @property
    def displacements(self) -> np.ndarray:
        """Travel of the first tine at every snapshot [m]."""
        return np.asarray(self.data["snapshot_displacement"])

    def strands(self, snapshot: int = -1) -> list[np.ndarray]:
        """Return the centreline of every rod in a snapshot, (n, 3) [m], root to tip."""
        positions = np.asarray(self.data["position"][snapshot])
        rod = np.asarray(self.data["rod"])
        return [positions[rod == number] for number in range(int(rod.max()) + 1)]

    def frames(self, snapshot: int = -1) -> list[np.ndarray]:
        """Return the directors of every rod's elements in a snapshot, (n - 1, 3, 3): d1, d2, d3.

        Raises
        ------
        SceneError
            The scene did not ask for them.
        """
        if "directors" not in self.data:
            raise SceneError(
                f"{self.data.attrs['title']}: no frames in this run; ask for output.frames = true"
            )
        directors = np.asarray(self.data["directors"][snapshot])
        _, nodes = np.unique(np.asarray(self.data["rod"]), return_counts=True)
        return np.split(directors, np.cumsum(nodes - 1)[:-1])

    def force_log(self) -> pd.DataFrame:
        """Return `time` [s], `displacement` [m] and `force` [N] on the tine, as an export gives it.

        Each force is the mean over its sampling window, positive when it resists combing.

        Raises
        ------
        SceneError
            The scene has no tine.
        """
        if "force" not in self.data:
            raise SceneError(
                f"{self.data.attrs['title']}: no tine in this scene, hence no force log"
            )
        log = pd.DataFrame(
            {name: np.asarray(self.data[name]) for name in ("time", "displacement", "force")}
        )
        log.attrs = {
            "source": self.data.attrs.get("path", "simulation"),
            "specimen": self.data.attrs["title"],
            "kind": "simulation",
            "E": self.scene.rods[0].material.E,
            "r": self.scene.rods[0].radius,
        }
        return log

    def contact_lost(self) -> float:
        """Return where the tine lost the strands [m]: its travel at the end of the last contact.

        In a sampling window whose force is zero nothing touched the tine. A contact, from one such
        window to the next, that does less than COMBING of the work is a freed strand that flaps.
        NaN where the tine still combs at the end of the run.

        Raises
        ------
        SceneError
            The scene has no tine.
        """
        log = self.force_log()
        d, force = log["displacement"].to_numpy(), log["force"].to_numpy()
        edges = np.flatnonzero(np.diff(np.concatenate([[False], force != 0, [False]])))
        work = np.gradient(d) * force
        done = [float(work[a:b].sum()) for a, b in edges.reshape(-1, 2)]
        combing = [end for end, one in zip(edges[1::2], done, strict=True)
                   if one > COMBING * sum(done)]  # fmt: skip
        if not combing or combing[-1] == len(d):
            return np.nan
        return float(d[combing[-1] - 1] + d[combing[-1]]) / 2

    def unrest(self) -> str:
        """Return in words how far the last snapshot is from rest, nothing where it is at rest.

        At rest is what the scene's `rest_tolerance` says; a scene that should have ended at rest
        and ran out of time is not, though its last snapshot may happen to be in balance.
        """
        if "snapshot_imbalance" not in self.data:
            return "whether it is at rest is not recorded in this run of an earlier version"
        force, speed = (float(self.data[f"snapshot_{of}"][-1]) for of in ("imbalance", "speed"))
        scene = self.scene
        fastest, weighs = np.inf, scene.gravity is not None and any(scene.gravity)
        if weighs:
            longest = max(np.linalg.norm(np.diff(x, axis=0), axis=1).sum() for x in self.strands())
            fastest = scene.rest_tolerance * np.sqrt(np.linalg.norm(scene.gravity or 0) * longest)
        gave_up = self.data.attrs.get("rest") == NOT_REACHED
        if force <= scene.rest_tolerance and speed <= fastest and not gave_up:
            return ""
        of = "its weight" if weighs else "the largest inner force"
        rod = self.data.attrs.get("worst_rod")
        where = "" if rod is None else f" of rod {rod}"
        return (
            f"not at rest at t = {self.times[-1]:.4g} s: a node{where} is out of balance by "
            f"{force:.2g} of {of}, one moves at {speed:.2g} m/s"
        )

    def save(self, path: str | Path) -> None:
        """Write the run as NetCDF; the file appears whole or not at all."""
        with replacing(Path(path)) as temporary:
            self.data.to_netcdf(temporary, engine="h5netcdf")


def open_run(path: str | Path) -> Run:
    """Read a run from its NetCDF file, or from the folder of a run that has not ended.

    Raises
    ------
    SceneError
        The file is missing or is not a run.
    """
    path = Path(path)
    data = _unfinished(path) if path.is_dir() else _finished(path)
    data.attrs["path"] = str(path)
    return Run(data)


def _finished(path: Path) -> xarray.Dataset:
    import xarray

    if not path.exists():
        part = part_of(path)
        if part.exists():
            raise SceneError(f"{path}: this run has not ended; what there is so far is in {part}")
        raise SceneError(f"{path}: no such file; expected a run (.nc) of `combing simulate`")
    try:
        data = xarray.load_dataset(path, engine="h5netcdf")
    except (OSError, ValueError) as error:
        raise SceneError(f"{path}: not a run of `combing simulate`: {error}") from None
    if "scene" not in data.attrs or "position" not in data:
        raise SceneError(f"{path}: a NetCDF file, but not a run of `combing simulate`")
    return data


def _unfinished(folder: Path) -> xarray.Dataset:
    recorded = journal.read(folder)
    if not len(recorded.snapshots):
        raise SceneError(f"{folder}: nothing is recorded yet")
    data = dataset(recorded).copy(deep=True)  # out of files that grow and go
    data.attrs["unfinished"] = f"{len(recorded.samples)} of {recorded.about['windows']} windows"
    return data


def dataset(recorded: journal.Recorded) -> xarray.Dataset:
    """Return what a journal holds as one labelled data set, its arrays still in the files."""
    import xarray

    about, samples, snapshots = recorded
    scene = about["scene"]
    nodes = sum(about["strands"])
    positions = snapshots[:, journal.HEAD : journal.HEAD + 3 * nodes].reshape(len(snapshots), -1, 3)
    rod = np.repeat(np.arange(len(about["strands"])), about["strands"])
    variables = {
        "position": (("snapshot", "node", "axis"), positions, {"units": "m"}),
        "snapshot_time": ("snapshot", snapshots[:, 0], {"units": "s"}),
        "snapshot_displacement": ("snapshot", snapshots[:, 1], {"units": "m"}),
        "snapshot_imbalance": ("snapshot", snapshots[:, 2], IMBALANCE),
        "snapshot_speed": ("snapshot", snapshots[:, 3], {"units": "m/s", "long_name": "largest"}),
        "rod": ("node", rod, {"long_name": "rod that the node belongs to"}),
        "radius": ("strand", [rod["radius"] for rod in scene["rods"]], {"units": "m"}),
    }
    if about.get("frames"):
        directors = snapshots[:, journal.HEAD + 3 * nodes :].reshape(len(snapshots), -1, 3, 3)
        axes = ("snapshot", "element", "director", "axis")
        variables["directors"] = (axes, directors, {"long_name": "d1, d2, d3 of every element"})
    variables |= _sampled(about["samples"], samples)
    coords: dict[str, Any] = {"axis": ["x", "y", "z"]}
    if "reaction_force" in variables:
        coords["end"] = _held_ends(scene)
    attributes = about["attributes"] | {"scene": json.dumps(scene)}
    return xarray.Dataset(variables, coords=coords, attrs=attributes)


def _sampled(columns: dict[str, Any], samples: np.ndarray) -> dict[str, Any]:
    """Return every column of the samples, (sample,), or (sample, body, axis) if it is of bodies."""
    found: dict[str, Any] = {}
    first = 0
    for name, column in columns.items():
        about = {key: value for key, value in column.items() if key not in ("of", "count")}
        if "of" not in column:
            found[name], first = ("sample", samples[:, first], about), first + 1
            continue
        past = first + 3 * column["count"]
        vectors = samples[:, first:past].reshape(len(samples), column["count"], 3)
        found[name], first = (("sample", column["of"], "axis"), vectors, about), past
    return found


def _held_ends(scene: dict[str, Any]) -> list[str]:
    """Return the names of all held ends in the order in which reactions are recorded."""
    return [
        f"{number} {end}"
        for number, rod in enumerate(scene["rods"])
        for end in ("root", "tip")
        if rod[end]["hold"] != "free"
    ]
