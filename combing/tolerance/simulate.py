"""Simulate a combing to a tolerance: choose a setting, run it, verify it, refine if need be."""

import hashlib
import json
import logging
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import sim
from combing.errors import UserError
from combing.runs import simulating
from combing.tolerance.errors import Apart, apart
from combing.tolerance.front import PRESETS, cheapest, is_of_this_solver, predicted_seconds
from combing.tolerance.setting import Setting, as_row, with_setting

REFINEMENTS = 3  # after which a tolerance is given up
SNAPSHOTS = 129  # at least
DOUBLE = 2.0  # errors of the second resolution over those of the first
STEP = (2.0, 8.0)  # least and most by which a refinement divides every error
log = logging.getLogger("combing")


@dataclass(frozen=True)
class Try:
    """A setting that was run: what was predicted of it and what was found."""

    setting: Setting
    predicted: float
    found: Apart
    seconds: float


def as_tolerance(text: str | float) -> float:
    """Understand 2%, 0.02, draft, standard, fine.

    Raises
    ------
    UserError
        It is none of these, or not between 0 and 1.
    """
    said = str(text).strip()
    try:
        value = PRESETS.get(said) or (float(said[:-1]) / 100 if said.endswith("%") else float(said))
    except ValueError:
        value = 0.0
    if not 0 < value < 1:
        names = ", ".join(PRESETS)
        raise UserError(f"tolerance = {said}: expected a share such as 2% or 0.02, or {names}")
    return value


def simulate_to_tolerance(
    scene: sim.Scene,
    path: str | Path,
    tolerance: float,
    *,
    jobs: int | None = None,
    fresh: bool = False,
    quiet: bool = True,
    any_cost: bool = False,
) -> sim.Run:
    """Simulate a combing so that f and lambda(s) up to the first release are within a tolerance.

    Parameters
    ----------
    scene : Scene
        Helices that one tine combs. Elements, step, speed of the tine and stiffness of contact are
        chosen anew: the result is nearer to slow tines and hard strands than the scene asks for. At
        least 129 snapshots are recorded.
    path : path
        Where the run is written; all runs are kept in the folder `runs` beside it, and used again.
    tolerance : float
        Largest error of f over the highest f, and of lambda, averaged over a pitch, over 1/P.
    jobs, fresh, quiet, any_cost
        As in `combing.bands.simulate_with_bands`.

    Returns
    -------
    Run
        `read_tolerance` returns what was found.

    Raises
    ------
    UserError
        The scene is none that the front is for, or PATH holds something else than its run.
    sim.SceneError, sim.Unstable
        A scene is at fault, or its motion unstable.
    """
    path = Path(path)
    if path.exists() and not fresh:
        _refuse_to_replace(path, scene)
    folder = path.parent / "runs"
    run, record = settle(scene, folder, tolerance, jobs=jobs, quiet=quiet, any_cost=any_cost)
    with_record(run, record).save(path)
    return sim.open_run(path)


def settle(
    scene: sim.Scene, folder: Path, tolerance: float, **how: Any
) -> tuple[sim.Run, dict[str, Any]]:
    """Return the run of a combing that holds a tolerance, and what was found on the way.

    Strategy: the measured front names the cheapest setting. It is run beside a second one whose
    every error is twice as large, so that their difference is the error of the first. Where that
    exceeds the tolerance the setting is refined, and the run before serves as the second one, until
    it is held, a refinement makes it no better, or four settings have been run.

    Parameters
    ----------
    scene, tolerance
        As of `simulate_to_tolerance`.
    folder : Path
        Where all runs are kept.
    how
        jobs, quiet and any_cost of `combing.runs.simulating`.

    Returns
    -------
    (Run, dict)
        The dict as of `read_tolerance`.
    """
    asked, scene = scene, often(scene)
    setting, predicted = cheapest(scene, tolerance)
    chosen = with_setting(scene, setting)
    if not is_of_this_solver():
        log.warning("the front of accuracy was measured with another solver: verification decides")
    second = with_setting(scene, setting.scaled(DOUBLE))
    log.info(
        "%s: predicted error %.2g %%, about %.2g s of processor time and %.2g s to verify it",
        setting, 100 * predicted, predicted_seconds(chosen), predicted_seconds(second),
    )  # fmt: skip
    with simulating({0: chosen, 1: second}, folder, **how) as wait:
        runs = wait()
    run = runs[0]
    tries = [Try(setting, predicted, _error(run, runs[1], DOUBLE), _seconds(runs.values()))]
    while _goes_on(tries, tolerance):
        factor = min(max(1.25 * tries[-1].found.worst / tolerance, STEP[0]), STEP[1])
        setting, before = setting.scaled(1 / factor), run
        wanted = {0: with_setting(scene, setting)}
        _say_failed(tries[-1], tolerance, predicted_seconds(wanted[0]))
        with simulating(wanted, folder, **how) as wait:
            run = wait()[0]
        found = _error(run, before, factor)
        tries.append(Try(setting, tries[-1].found.worst / factor, found, _seconds([run])))
    return run, _record(scene, tolerance, tries) | {"asked": _digest(asked)}


def often(scene: sim.Scene) -> sim.Scene:
    """Return the scene with at least SNAPSHOTS: lambda is compared between them."""
    output = scene.output
    often = output.model_copy(update={"snapshots": max(output.snapshots, SNAPSHOTS)})
    return scene.model_copy(update={"output": often})


def _error(run: sim.Run, second: sim.Run, factor: float) -> Apart:
    """Return the error of a run from one whose every error is `factor` times as large."""
    found = apart(second, run)
    return Apart(found.force / (factor - 1), found.link / (factor - 1))


def _seconds(runs: Any) -> float:
    return float(sum(run.data.attrs["wall_time_s"] for run in runs))


def _goes_on(tries: list[Try], tolerance: float) -> bool:
    """Tell whether a finer setting is tried: not where the last one did not help."""
    errors = [one.found.worst for one in tries]
    helped = len(errors) == 1 or errors[-1] < errors[-2]
    return errors[-1] > tolerance and helped and len(errors) <= REFINEMENTS


def _say_failed(last: Try, tolerance: float, seconds: float) -> None:
    log.info(
        "not within %s: f is off by %s, lambda by %s; refining, about %.2g s of processor time",
        *map(_percent, (tolerance, *last.found)), seconds,
    )  # fmt: skip


def _record(scene: sim.Scene, tolerance: float, tries: list[Try]) -> dict[str, Any]:
    last = tries[-1]
    half = last.setting.scaled(min(1.0, tolerance / 2 / last.found.worst))
    if len(tries) == 1:  # the front was right about this scene
        half = cheapest(scene, tolerance / 2)[0]
    now, then = (predicted_seconds(with_setting(scene, one)) for one in (last.setting, half))
    return {
        "tolerance": tolerance,
        "held": last.found.worst <= tolerance,
        "force": last.found.force,
        "link": last.found.link,
        "setting": as_row(last.setting),
        "said": str(last.setting),
        "seconds": sum(one.seconds for one in tries),
        "next_half": max(then / now, 1.0) * last.seconds,
        "tries": len(tries),
        "front_of_this_solver": is_of_this_solver(),
    }


def _refuse_to_replace(path: Path, scene: sim.Scene) -> None:
    """Raise UserError where a path holds anything but what this scene gave to a tolerance."""
    there = read_tolerance(sim.open_run(path)) or {}
    if there.get("asked") != _digest(scene):
        raise UserError(
            f"{path}: a finished run of another scene; write to another place, or over it (--fresh)"
        )


def _digest(scene: sim.Scene) -> str:
    return hashlib.sha256(scene.model_dump_json().encode()).hexdigest()[:16]


def with_record(run: sim.Run, record: dict[str, Any]) -> sim.Run:
    """Return a run that carries what was asked of it and found."""
    data = run.data.copy()
    data.attrs = {key: value for key, value in run.data.attrs.items() if key != "path"}
    data.attrs["tolerance"] = json.dumps(record)
    return sim.Run(data)


def read_tolerance(run: sim.Run) -> dict[str, Any] | None:
    """Return what was asked of a run and found, None where nothing was.

    Returns
    -------
    dict
        tolerance, held, errors `force` and `link`, `setting`, `seconds` in all, `next_half`: what
        half the tolerance would cost [s], `tries`, `front_of_this_solver`.
    """
    said = run.data.attrs.get("tolerance")
    return None if said is None else json.loads(said)


def in_words(record: dict[str, Any]) -> dict[str, str]:
    """Return what a user is told of a tolerance."""
    held = "held" if record["held"] else f"NOT HELD after {record['tries']} settings"
    link = f"lambda within {_percent(record['link'])}"
    if record["link"] != record["link"]:
        link = "lambda not verified (no pair, or no snapshot before the release)"
    more = "" if record["front_of_this_solver"] else "; the front is of another solver"
    return {
        f"within {_percent(record['tolerance'])} up to the first release": (
            f"{held}: f within {_percent(record['force'])}, {link}, by a second resolution"
        ),
        "setting": record["said"] + more,
        "cost": f"{record['seconds']:.3g} s with its verification; a run of half the error would "
        f"take about {record['next_half']:.3g} s",
    }


def _percent(value: float) -> str:
    return f"{100 * value:.2g} %"
