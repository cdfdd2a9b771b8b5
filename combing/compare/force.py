"""f(x) of the experiment over the simulation's over Love's: one operator for all force logs."""

from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pandas as pd

import instron
import sim
from combing.bands import read_bands
from combing.compare.comparison import Comparison, error_row, says_synthetic
from combing.errors import UserError
from combing.metrics import compare_curves
from combing.study import ForceSet
from combing.tables import read_table

GRID = np.linspace(0, 1, 501)
AGREE = 0.01  # relative: what D and the loss of contact may differ by in silence
ROOM = 1.3  # Love's curve is followed to this multiple of the largest measured force


def measure_force(chosen: ForceSet) -> list[pd.DataFrame]:
    """Scale every force log of a set.

    Raises
    ------
    instron.RigError, instron.Unreadable, instron.Unscalable
        If the rig or a log is at fault.
    """
    rig = instron.load_rig(chosen.rig)
    return [instron.scale(log, rig) for path in chosen.logs for log in instron.read(path)]


def compare_force(
    chosen: ForceSet, curves: list[pd.DataFrame], runs: Mapping[Path, sim.Run]
) -> Comparison:
    """Compare a set's scaled curves with its simulation and with Love's curve.

    Parameters
    ----------
    chosen : ForceSet
        From the study.
    curves : list of DataFrame
        From `measure_force`.
    runs : mapping
        Finished runs by the path that names them in the study.
    """
    rig = instron.load_rig(chosen.rig)
    experiment, numbers = _experiment(chosen.name, curves)
    parts, apart = [experiment], []
    notes = [
        f"{chosen.name}, {_label(curve)}: {warning}"
        for curve in curves
        for warning in curve.attrs.get("warnings", [])
    ]
    if chosen.simulation is not None:
        simulated = scale_run(runs[chosen.simulation], rig)
        parts.append(_simulated(chosen.name, runs[chosen.simulation], simulated))
        numbers.append(_facts(chosen.name, "simulation", simulated))
        notes += [f"{chosen.name}, simulation: {said}" for said in simulated.attrs["warnings"]]
        apart = _distances(chosen.name, curves, simulated)
    theory, remark = _theory(chosen, rig, curves)
    return Comparison(
        plotted=pd.concat([*parts, *theory], ignore_index=True),
        numbers=[
            ("Force peak, work and distance", pd.DataFrame(numbers)),
            ("Simulation against every repeat", pd.DataFrame(apart)),
        ],
        errors=_errors(chosen, curves, rig),
        notes=notes + remark,
        synthetic=any(says_synthetic(curve.attrs.get("metadata", {})) for curve in curves),
    )


def scale_run(run: sim.Run, rig: instron.Rig) -> pd.DataFrame:
    """Scale a simulation's force log by the rules of the rig and the rigidity of its own rods."""
    log = run.force_log()
    own = rig.model_copy(
        update={"r": log.attrs["r"], "E": log.attrs["E"], "B": None, "zero": "none"}
    )
    curve = instron.scale(log, own)
    curve.attrs["contact_lost"] = run.contact_lost()
    curve.attrs["warnings"] += _contact(curve)
    return curve


def _contact(curve: pd.DataFrame) -> list[str]:
    """Say so where the end that the force shows is not where the tine lost the strands."""
    D, lost = curve.attrs["D"], curve.attrs["contact_lost"]
    if curve.attrs["ended"] and abs(D - lost) <= AGREE * lost:
        return []
    if np.isnan(lost):
        return ["the tine still combs at the end of the run"] if curve.attrs["ended"] else []
    return [f"by its force combing ends at {D:.4g} m, the tine loses the strands at {lost:.4g} m"]


def _experiment(name: str, curves: list[pd.DataFrame]) -> tuple[pd.DataFrame, list[dict]]:
    """Return what is drawn of the repeats and a row of numbers for each.

    A repeat that was aborted has a row that says so; it is drawn only where there is no other.
    """
    ended = [curve for curve in curves if curve.attrs["ended"]] or curves[:1]
    if len(ended) == 1:
        f = instron.on_grid(ended[0], GRID)
        mean, representative = (f, np.full_like(f, np.nan)), f
    else:
        found = instron.repeats(ended)
        mean = (found.grid["mean"].to_numpy(), found.grid["sd"].to_numpy())
        representative = found.curves[found.representative]
    table = [_facts(name, f"experiment, {_label(curve)}", curve) for curve in curves]
    if len(ended) > 1:
        table.append(_average(name, [_facts(name, "", curve) for curve in ended]))
    rows = [
        _rows(name, "experiment", "mean", GRID, *mean),
        _rows(name, "experiment", "representative", GRID, representative),
    ]
    return pd.concat(rows), table


def _rows(
    name: str, source: str, curve: str, x: np.ndarray, f: np.ndarray, sd: np.ndarray | None = None
) -> pd.DataFrame:
    spread = np.nan if sd is None else sd
    return pd.DataFrame(
        {"set": name, "source": source, "curve": curve, "x": x, "f": f}
        | {"low": f - spread, "high": f + spread}
    )


def _simulated(name: str, run: sim.Run, curve: pd.DataFrame) -> pd.DataFrame:
    """Return the simulation's curve, with the band that its run was stored with, if any."""
    rows = _rows(name, "simulation", "run", GRID, instron.on_grid(curve, GRID))
    if (bands := read_bands(run)) is None:
        return rows
    x = bands.force["x"]
    ends = {end: np.interp(GRID, x, bands.force[end]) for end in ("low", "high")}
    return rows.assign(**ends)


def _label(curve: pd.DataFrame) -> str:
    name = Path(str(curve.attrs.get("source", "log"))).stem
    return name if curve.attrs["ended"] else f"{name} (did not end)"


def _facts(name: str, what: str, curve: pd.DataFrame) -> dict:
    keys = {"f_max": "f_max", "w": "w", "D (m)": "D", "sd of F (N)": "noise"}
    found = instron.summary(curve)
    return {
        "set": name,
        "curve": what,
        **{shown: float(curve.attrs[key]) for shown, key in keys.items()},
        "x of f_max": found["x_max"],
        "jams and peaks": found["peaks"],
    }


def _average(name: str, rows: list[dict]) -> dict:
    table = pd.DataFrame(rows).drop(columns=["set", "curve"])
    mean = {column: float(value) for column, value in table.mean().items()}
    return {"set": name, "curve": f"experiment, mean of {len(rows)}", **mean}


def _distances(name: str, curves: list[pd.DataFrame], simulated: pd.DataFrame) -> list[dict]:
    """Metrics of the simulation against every repeat: no metric is read off the mean curve."""
    rows: list[dict] = [
        {"set": name, "experiment": _label(curve)} | compare_curves(curve, simulated, iso=False)
        for curve in curves
    ]
    if len(rows) > 1:
        mean = pd.DataFrame(rows).drop(columns=["set", "experiment"]).mean()
        rows.append(
            {"set": name, "experiment": "mean"} | {str(k): float(v) for k, v in mean.items()}
        )
    return rows


def _theory(
    chosen: ForceSet, rig: instron.Rig, curves: list[pd.DataFrame]
) -> tuple[list[pd.DataFrame], list[str]]:
    """Love's curves over the mean D of the experiment, or the reason why there are none."""
    length = chosen.active_length
    if length is None and rig.pitch is not None and rig.turns is not None:
        length = rig.pitch * rig.turns
    if length is None or rig.pitch is None or rig.helix_radius is None:
        return [], [f"{chosen.name}: no theory curve: the rig does not give the helix's shape"]
    D = float(np.mean([curve.attrs["D"] for curve in curves]))
    top = ROOM * max(curve.attrs["f_max"] for curve in curves)
    drawn = [
        instron.theory_curve(rig, length, D, ends=ends, f_limit=top).assign(curve=ends)
        for ends in ("free", "blocked")
    ]
    parts = [
        _rows(chosen.name, "theory", c["curve"].iloc[0], c["x"].to_numpy(), c["f"].to_numpy())
        for c in drawn
    ]
    return parts, []


def _errors(chosen: ForceSet, curves: list[pd.DataFrame], rig: instron.Rig) -> pd.DataFrame:
    if chosen.truth is None:
        return pd.DataFrame()
    truth = read_table(chosen.truth, ["log", "time", "displacement", "force"])
    exact = rig.model_copy(update={"zero": "none"})
    rows = []
    for curve in curves:
        label = Path(str(curve.attrs["source"])).stem
        log = truth[truth["log"] == label]
        if log.empty:
            raise UserError(f"{chosen.truth}: holds no rows with log = {label}")
        true = instron.scale(log.reset_index(drop=True), exact)
        facts = (("f_max", "f_max", ""), ("w", "w", ""), ("D", "D", "m"))
        rows += [
            error_row(chosen.name, label, shown, curve.attrs[key], true.attrs[key], unit)
            for shown, key, unit in facts
        ]
    return pd.DataFrame(rows)
