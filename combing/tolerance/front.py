"""The measured front: which error which setting leaves, and what it costs."""

from functools import cache
from importlib import resources
from io import StringIO

import numpy as np
import pandas as pd

import sim
from combing.runs import model_version
from combing.tolerance.setting import Setting, with_setting, work

PRESETS = {"draft": 0.10, "standard": 0.03, "fine": 0.015}  # tolerances by name
AIM = 0.8  # of a tolerance: the rest is for scenes unlike those that were measured
KNOBS = ["elements", "safety", "speed", "stiffness"]
SOLVER = "# solver "


@cache
def load_front() -> pd.DataFrame:
    """Return the front that the package holds.

    Returns
    -------
    DataFrame
        A row a setting: elements (to a pitch), safety, speed [m/s], stiffness (over E), `force` and
        `link`, the largest errors over the scenes that were measured, `error`, the larger of them,
        `seconds` of processor time and `work`, steps times elements, of a scene. ``attrs``: the
        hash of the `solver` that was measured.
    """
    text = resources.files("combing.tolerance").joinpath("front.csv").read_text(encoding="utf-8")
    table = pd.read_csv(StringIO(text), comment="#")
    table["error"] = table[["force", "link"]].max(axis=1)
    solver = next(line for line in text.splitlines() if line.startswith(SOLVER))
    table.attrs["solver"] = solver.removeprefix(SOLVER).strip()
    return table


def is_of_this_solver() -> bool:
    """Whether the front was measured with the solver that is installed."""
    return bool(load_front().attrs["solver"] == model_version())


def pareto(table: pd.DataFrame, cost: str = "seconds") -> pd.DataFrame:
    """Return the rows to which no other is both cheaper and more accurate, the cheapest first."""
    ordered = table.sort_values([cost, "error"])
    return ordered[ordered["error"] < ordered["error"].cummin().shift(fill_value=float("inf"))]


def cheapest(scene: sim.Scene, tolerance: float) -> tuple[Setting, float]:
    """Return the cheapest setting that is predicted to hold a tolerance, and its error.

    Where no measured one does, the most accurate is scaled by the orders of its errors.

    Raises
    ------
    UserError
        The scene is none that the front is for.
    """
    table = load_front()
    aim = AIM * tolerance
    good = table[table["error"] <= aim]
    if good.empty:
        best = table.sort_values("error").iloc[0]
        return _setting(best).scaled(aim / best["error"]), aim
    found = [(_setting(row), float(row["error"])) for _, row in pareto(good).iterrows()]
    return min(found, key=lambda one: work(with_setting(scene, one[0])))


def predicted_seconds(scene: sim.Scene) -> float:
    """Return the processor time of a scene, by a line through the front's times over work [s]."""
    table = load_front()
    slope, first = np.polyfit(table["work"], table["seconds"], 1)
    return float(max(first, 0.0) + slope * work(scene))


def _setting(row: pd.Series) -> Setting:
    return Setting(**{knob: float(row[knob]) for knob in KNOBS})
