"""f(x) of combings that differ in one parameter: experiment over simulation, and f_max beside."""

from collections.abc import Mapping, Sequence

import numpy as np
import pandas as pd

import instron
import sim
from combing.compare.comparison import Comparison, says_synthetic
from combing.compare.force import GRID, ROOM, scale_run
from combing.study import SweepSet
from combing.unlinking import link_facts, link_history

LEVEL = 0.95
PEAKS_OVER = "Force peak over "  # title of the table of numbers, before the parameter
SUDDEN = 0.05  # of D: a jam's force falls steepest within this; a smooth hump's does not
STRETCHED = 10.0  # times f_max: Love's helix is nearly straight
Curves = Mapping[float, Sequence[pd.DataFrame]]


def rig_of(chosen: SweepSet, value: float) -> instron.Rig:
    """Return the rig of a value; one for all takes the helix's shape from the parameters."""
    helix = chosen.helix(value)
    shape = {
        "pitch": helix.pitch,
        "helix_radius": helix.pi2 * helix.r,
        "turns": helix.extent / helix.pitch,
    }
    if chosen.rig is None:
        return instron.Rig.model_validate(
            {"r": helix.r, "E": helix.E, "poisson": helix.nu, "zero": "none"} | shape
        )
    rig = instron.load_rig(chosen.rig[value])
    return rig.model_copy(update=shape) if chosen.rig_for_all else rig


def measure_sweep(chosen: SweepSet) -> Curves:
    """Scale the force logs of every value.

    Raises
    ------
    instron.RigError, instron.Unreadable, instron.Unscalable
        If a rig or a log is at fault.
    """
    return {
        value: [
            instron.scale(log, rig_of(chosen, value))
            for path in paths
            for log in instron.read(path)
        ]
        for value, paths in (chosen.logs or {}).items()
    }


def compare_sweep(
    chosen: SweepSet, measured: Curves, runs: Mapping[tuple[float, int], sim.Run]
) -> Comparison:
    """Put experiment, simulation and Love's curves of all values into one table.

    Parameters
    ----------
    chosen : SweepSet
        From the study.
    measured : mapping
        From `measure_sweep`.
    runs : mapping
        Finished runs by value and seed.

    Returns
    -------
    Comparison
        Its table has columns set, over, source (experiment, simulation, theory), value, curve
        (mean, representative, free, f_max), x, f, low, high. Bands are mean +- sd; rows of f_max
        have the value for x and the interval of the mean at 95 % for low and high.
    """
    simulated: dict[float, list[pd.DataFrame]] = {}
    for (value, _), run in runs.items():
        simulated.setdefault(value, []).append(scale_run(run, rig_of(chosen, value)))
        simulated[value][-1].attrs["history"] = link_history(run)
    parts, rows = [], []
    for source, curves in (("experiment", measured), ("simulation", simulated)):
        for value, some in curves.items():
            parts += [table.assign(source=source, value=value) for table in _drawn(value, some)]
            rows.append({"set": chosen.name, "source": source, chosen.over: value, **_facts(some)})
    parts += [_love(chosen, value, measured, simulated) for value in chosen.values]
    plotted = pd.concat(parts, ignore_index=True).assign(set=chosen.name, over=chosen.over)
    return Comparison(
        plotted=plotted.assign(black=chosen.black),
        numbers=[(PEAKS_OVER + chosen.over, pd.DataFrame(rows))],
        notes=_doubts(chosen, "experiment", measured) + _doubts(chosen, "simulation", simulated),
        synthetic=any(
            says_synthetic(curve.attrs.get("metadata", {}))
            for some in measured.values()
            for curve in some
        ),
        curves=pd.concat(
            every_curve(chosen, source, some)
            for source, some in (("experiment", measured), ("simulation", simulated))
        ),
    )


def every_curve(chosen: SweepSet, source: str, curves: Curves) -> pd.DataFrame:
    """Return one row a curve.

    Returns
    -------
    DataFrame
        Columns set, over, source, value, f_max, w, D (m), jams (peaks that are released within
        5 % of D), plateaus, love_diverges (whether Love's single helix needs STRETCHED times f_max
        within the stroke), and of simulations those of `combing.unlinking.link_facts`.
    """
    rows = []
    for value, some in curves.items():
        for curve in some:
            found = instron.events(curve)
            sudden = (found["kind"] == "jam") & (found["release_x"] - found["x"] < SUDDEN)
            rows.append(
                {
                    "set": chosen.name,
                    "over": chosen.over,
                    "source": source,
                    "value": value,
                    **{key: float(curve.attrs[key]) for key in ("f_max", "w")},
                    "D (m)": float(curve.attrs["D"]),
                    "jams": int(sudden.sum()),
                    "plateaus": int((found["kind"] == "plateau").sum()),
                    "love_diverges": _love_diverges(chosen, value, curve),
                    **_link(curve, found.loc[sudden, "x"]),
                }
            )
    return pd.DataFrame(rows)


def _link(curve: pd.DataFrame, jams: pd.Series) -> dict[str, float]:
    history = curve.attrs.get("history")
    return {} if history is None else link_facts(history, list(jams))


def _love_diverges(chosen: SweepSet, value: float, curve: pd.DataFrame) -> float:
    """Return 1 where Love's helix needs STRETCHED times f_max before combing ends, else 0."""
    rig, top = rig_of(chosen, value), STRETCHED * _f_max(curve)
    if rig.pitch is None or rig.helix_radius is None or rig.turns is None:
        return np.nan
    height = rig.pitch * rig.turns
    drawn = instron.theory_curve(rig, height, float(curve.attrs["D"]), ends="free", f_limit=top)
    inside = drawn[drawn["x"] <= 1]
    return float(inside["f"].max() >= 0.99 * top)


def _drawn(value: float, curves: Sequence[pd.DataFrame]) -> list[pd.DataFrame]:
    """Return mean with band, representative, and f_max with its interval."""
    f = np.array([instron.on_grid(curve, GRID) for curve in curves])
    if len(curves) > 1:
        found = instron.repeats(curves, level=LEVEL)
        sd, one = f.std(axis=0, ddof=1), f[found.representative]
        peak = found.summary.loc["f_max", ["mean", "low", "high"]].to_numpy(dtype=float)
    else:
        sd, one = np.full(len(GRID), np.nan), f[0]
        peak = np.array([_f_max(curves[0]), np.nan, np.nan])
    mean = f.mean(axis=0)
    return [
        _rows("mean", GRID, mean, mean - sd, mean + sd),
        _rows("representative", GRID, one, np.nan, np.nan),
        _rows("f_max", np.array([value]), peak[:1], peak[1], peak[2]),
    ]


def _rows(
    curve: str, x: np.ndarray, f: np.ndarray, low: np.ndarray | float, high: np.ndarray | float
) -> pd.DataFrame:
    return pd.DataFrame({"curve": curve, "x": x, "f": f, "low": low, "high": high})


def _f_max(curve: pd.DataFrame) -> float:
    return float(curve.attrs["f_max"])


def _facts(curves: Sequence[pd.DataFrame]) -> dict[str, float | int]:
    """Return the row of a value: how many, f_max with interval, D, jams."""
    peaks = np.array([_f_max(curve) for curve in curves])
    _, _, peak = _drawn(0.0, curves)
    jams = [int((instron.events(curve)["kind"] == "jam").sum()) for curve in curves]
    return {
        "curves": len(curves),
        "f_max": float(peaks.mean()),
        "low": float(peak["low"].iloc[0]),
        "high": float(peak["high"].iloc[0]),
        "D (m)": float(np.mean([curve.attrs["D"] for curve in curves])),
        "jams, mean": float(np.mean(jams)),
    }


def _love(
    chosen: SweepSet, value: float, *sources: Mapping[float, Sequence[pd.DataFrame]]
) -> pd.DataFrame:
    """Return Love's curve of one helix over the mean D: of the experiment, else of the runs."""
    curves = next((some[value] for some in sources if some.get(value)), [])
    rig = rig_of(chosen, value)
    if not curves or rig.pitch is None or rig.helix_radius is None or rig.turns is None:
        return pd.DataFrame()
    D = float(np.mean([curve.attrs["D"] for curve in curves]))
    top = ROOM * max(map(_f_max, curves))
    drawn = instron.theory_curve(rig, rig.pitch * rig.turns, D, ends="free", f_limit=top)
    rows = _rows("free", drawn["x"].to_numpy(), drawn["f"].to_numpy(), np.nan, np.nan)
    return rows.assign(source="theory", value=value)


def _doubts(chosen: SweepSet, source: str, curves: Curves) -> list[str]:
    """Return the warnings of all curves, those of several curves once with their number."""
    counted: dict[tuple[float, str], int] = {}
    for value, some in curves.items():
        for warning in (said for curve in some for said in curve.attrs["warnings"]):
            counted[value, warning] = counted.get((value, warning), 0) + 1
    return [
        f"{chosen.name}, {source}, {chosen.over} = {value:g}: {warning}"
        + (f" ({count} of {len(curves[value])} curves)" if count > 1 else "")
        for (value, warning), count in counted.items()
    ]
