"""A film of a combing: frames every so often, each measured once, beside the force."""

import json
from collections.abc import Callable, Iterator
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from dataclasses import dataclass
from functools import partial
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pandas as pd
from tqdm import tqdm

from combing import __version__
from combing.errors import UserError, is_users_fault
from combing.view import View, measure_pair
from combing.writing import write_text
from imaging.helix.measurement import HelixMeasurement
from imaging.helix.sequence import HelixSequence, first_link, sequence_of
from imaging.photo import Photo
from imaging.photo.film import Frame, Motion, frame_count, frames

Link = tuple[float, float]


@dataclass(frozen=True)
class Way:
    """Where the tine is while a film runs.

    Attributes
    ----------
    speed : float, optional
        Of the tine [m/s].
    log : DataFrame, optional
        Force log from the start of motion on (`started`), instead of a speed.
    start : float, optional
        When the tine starts in the film [s]; seen by its motion where not told.
    """

    speed: float | None = None
    log: pd.DataFrame | None = None
    start: float | None = None

    def at(self, since: float) -> Link:
        """Displacement [m] and force [N] so many seconds after the start; NaN beyond the log."""
        if self.log is None:
            return float(since * (self.speed or 0.0)), float("nan")
        d, force = (
            np.interp(since, self.log["time"], self.log[name], right=np.nan)
            for name in ("displacement", "force")
        )
        return float(d), float(force)


def started(log: pd.DataFrame) -> pd.DataFrame:
    """Count time and displacement of a force log from where its displacement begins to grow.

    Raises
    ------
    UserError
        If the log has no times.
    """
    if log["time"].isna().any():
        raise UserError(f"{log.attrs.get('source', 'log')}: has no times; give --speed instead")
    moved = log["displacement"] - log["displacement"].iloc[0]
    first = max(int(np.argmax(moved.abs() > 1e-3 * moved.abs().max())) - 1, 0)
    rest = log.iloc[first:].assign(displacement=moved)
    return rest.assign(time=rest["time"] - rest["time"].iloc[0])


@dataclass(frozen=True)
class Asked:
    """What is asked of a film."""

    path: Path
    view: View
    root: str
    pair: int
    way: Way
    every: tuple[float, str]  # seconds ("s") or metres ("m")


def chosen(asked: Asked) -> Iterator[tuple[Frame, float, float]]:
    """Yield the frames to measure, each with displacement [m] and force [N], in one pass.

    The first of the film is one of them, at displacement 0.

    Raises
    ------
    UserError
        If the start is to be seen and nothing moves.
    """
    motion, due = Motion(asked.way.start), 0.0
    step, unit = asked.every
    for frame in frames(asked.path):
        start = motion.seen(frame)
        since = -1.0 if start is None else frame.time - start
        d, force = asked.way.at(max(since, 0.0))
        if np.isnan(d):
            return
        done = since if unit == "s" else d
        if frame.number == 0 or (since >= 0 and done >= due):
            due = 0.0 if frame.number == 0 else (done // step + 1) * step
            yield frame, d, force
    if motion.start is None:
        raise UserError(f"{asked.path}: nothing is seen to begin to move; say when, --start 2.5")


def measure_film(
    asked: Asked, folder: Path, before: Link | None, *, jobs: int = 1, quiet: bool = False
) -> list[dict[str, Any]]:
    """Measure a film's frames, one file each in `folder`; what is done already stays.

    Parameters
    ----------
    asked : Asked
    folder : Path
    before : (float, float), optional
        lambda_0 and its sd; that of the first frame when left out.
    jobs : int
        Processes.
    quiet : bool
        No progress.

    Returns
    -------
    list of dict
        A record a frame: ``frame, time, d, force, refused``, and what was measured.

    Raises
    ------
    UserError
        If the first frame cannot be measured and lambda_0 is not given.
    """
    folder.mkdir(parents=True, exist_ok=True)
    records: list[Path] = []
    bar = tqdm(total=frame_count(asked.path) or None, unit="frame", disable=quiet)
    with ProcessPoolExecutor(jobs, get_context("spawn")) as pool, bar:
        running: set[Future] = set()
        for frame, d, force in chosen(asked):
            facts = {"frame": frame.number, "time": frame.time, "d": d, "force": force}
            record = folder / f"frame_{frame.number:06d}.json"
            key = json.loads(json.dumps(_fingerprint(asked, before) | facts))
            if not _done(record, key):
                picture = record.with_suffix(".png")
                cv2.imwrite(str(picture), frame.pixels)
                ask = partial(measure_pair, view=asked.view, root=asked.root, pair=asked.pair)
                task = partial(_measure, picture, record, key, ask, before)
                if before is None:
                    task()
                else:
                    running.add(pool.submit(task))
            if before is None:
                before = _first(record)
            records.append(record)
            while len(running) > 2 * jobs:
                running = _finished(running)
            bar.update(frame.number + 1 - bar.n)
        while running:
            running = _finished(running)
    return [json.loads(record.read_text(encoding="utf-8")) for record in records]


def _finished(running: set[Future]) -> set[Future]:
    done, running = wait(running, return_when=FIRST_COMPLETED)
    for future in done:
        future.result()
    return running


def _fingerprint(asked: Asked, before: Link | None) -> dict[str, Any]:
    """Return what a record depends on but for its frame."""
    about = asked.path.stat()
    return {
        "film": asked.path.name, "bytes": about.st_size, "changed": about.st_mtime_ns,
        "view": repr(asked.view), "root": asked.root, "pair": asked.pair, "before": before,
        "version": __version__,
    }  # fmt: skip


def _done(record: Path, key: dict[str, Any]) -> bool:
    try:
        return bool(repr(json.loads(record.read_text(encoding="utf-8"))["key"]) == repr(key))
    except (OSError, ValueError, KeyError):
        return False


def _first(record: Path) -> Link:
    """lambda_0 of the film's first frame."""
    found = json.loads(record.read_text(encoding="utf-8"))
    if found["refused"]:
        raise UserError(
            f"the film's first frame, before combing, is not measured ({found['refused']}); "
            "give --before, a photograph"
        )
    return found["first"][0], found["first"][1]


def _measure(
    picture: Path,
    record: Path,
    key: dict[str, Any],
    ask: Callable[[Path], tuple[Photo, HelixMeasurement]],
    before: Link | None,
) -> None:
    """Measure one frame and write its record; the picture is thrown away."""
    found: dict[str, Any] = {name: key[name] for name in ("frame", "time", "d", "force")}
    try:
        one = ask(picture)[1]
        sequence = sequence_of([one], [key["d"]], before or first_link(one))
        found |= {
            "refused": "", "first": first_link(one), "unit": one.unit,
            "warnings": one.warnings, "jump": sequence.jumps.iloc[0].to_dict(),
            "profile": sequence.profiles.drop(columns=["frame", "x"]).to_dict("list"),
        }  # fmt: skip
    except Exception as error:
        if not is_users_fault(error):
            raise
        found |= {"refused": str(error)}
    write_text(record, json.dumps(found | {"key": key}))
    picture.unlink(missing_ok=True)


def film_table(records: list[dict[str, Any]]) -> pd.DataFrame:
    """Tabulate a film: ``frame, time, d, force``, the jump and the link of every frame."""
    rows = [
        {name: one[name] for name in ("frame", "time", "d", "force", "refused")}
        | {k: v for k, v in one.get("jump", {}).items() if k not in ("frame", "x")}
        for one in records
    ]
    return pd.DataFrame(rows)


def film_sequence(records: list[dict[str, Any]]) -> HelixSequence:
    """Put the measured frames together; positions are displacements [m].

    Raises
    ------
    UserError
        If there is none.
    """
    seen = [one for one in records if not one["refused"]]
    if not seen:
        raise UserError(f"none of {len(records)} frames is measured: {records[0]['refused']}")
    profiles = [pd.DataFrame(one["profile"]).assign(frame=one["frame"], x=one["d"]) for one in seen]
    jumps = pd.DataFrame([one["jump"] | {"frame": one["frame"], "x": one["d"]} for one in seen])
    return HelixSequence(pd.concat(profiles, ignore_index=True), jumps, ())
