"""What accuracy costs: error over each knob and over time, and force curves that part."""

from collections.abc import Mapping

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, NullFormatter

from combing.figures.style import (
    BAND,
    EXPERIMENT,
    SIMULATION,
    STRANDS,
    THEORY,
    legend_above,
    new_figure,
    paper_style,
)
from combing.power_law import slope

METRE_TO_MM = 1e3
COLOURS = {"elements": SIMULATION, "safety": THEORY, "speed": "#3b8a3e", "stiffness": "#7a4b9a"}
LABELS = {
    "elements": "elements",
    "safety": "fraction of the stable step",
    "speed": "speed (m/s)",
    "stiffness": "contact stiffness / $E$",
}
UNITS = {"cantilever": "", "capstan": " per radian", "first jam": " per pitch"}


def draw_case(table: pd.DataFrame, case: str, error: str) -> Figure:
    """Draw the error over every knob of a case, and over processor time for all knobs at once.

    Parameters
    ----------
    table : DataFrame
        Columns case, knob, value, error, seconds (`combing.accuracy.study.table`).
    case : str
        cantilever, capstan or first jam.
    error : str
        What the error is of, for the axis.
    """
    rows = table[table["case"] == case]
    knobs = list(rows["knob"].unique())
    with paper_style():
        columns = 3
        count = len(knobs) + 1
        figure, panels = new_figure(-(-count // columns), min(columns, count), 2.2)
        for panel, knob in zip(panels, knobs, strict=False):
            _over_knob(panel, rows[rows["knob"] == knob], LABELS[knob], UNITS[case])
        _over_time(panels[len(knobs)], rows)
        legend_above(figure, panels[len(knobs)], len(knobs))
        for panel in panels[count:]:
            panel.remove()
        for panel in panels[:count:columns]:
            panel.set_ylabel(error)
    return figure


def draw_front(table: pd.DataFrame, front: pd.DataFrame, presets: Mapping[str, float]) -> Figure:
    """Draw the errors of every measured setting over its time, and the front of the best.

    Parameters
    ----------
    table : DataFrame
        Columns elements, speed, force, link, error, seconds (`combing.tolerance.load_front`).
    front : DataFrame
        Its rows to which no other is both cheaper and more accurate, the cheapest first.
    presets : mapping
        Tolerances by name, drawn as lines.
    """
    with paper_style():
        figure, panels = new_figure(1, 2, 2.9)
        for panel, column, error in (
            (panels[0], "force", "error of $f$, over its highest"),
            (panels[1], "link", r"error of $\lambda$, over $1/P$"),
        ):
            for number, (elements, rows) in enumerate(table.groupby("elements")):
                colour = STRANDS[number % len(STRANDS)]
                label = f"{elements:g} a pitch"
                panel.loglog(rows["seconds"], rows[column], "o", ms=4, label=label, color=colour)
            panel.plot(front["seconds"], front[column], color="0.4", lw=0.8, zorder=0)
            panel.set(xlabel="processor time (s)", ylabel=error)
            panel.xaxis.set_major_locator(LogLocator(subs=(1, 2, 3, 5)))
            panel.xaxis.set_major_formatter("{x:g}")
            panel.xaxis.set_minor_formatter(NullFormatter())
            for name, tolerance in presets.items():
                panel.axhline(tolerance, color="0.8", lw=0.6, zorder=0)
                panel.annotate(name, (0.99, tolerance), xycoords=("axes fraction", "data"),
                               ha="right", va="bottom", fontsize=7, color="0.4")  # fmt: skip
        legend_above(figure, panels[0], table["elements"].nunique())
    return figure


def _over_knob(panel: Axes, rows: pd.DataFrame, label: str, unit: str) -> None:
    knob = rows["knob"].iloc[0]
    seen = rows[rows["error"].abs() > 0]
    panel.loglog(seen["value"], seen["error"].abs(), "o-", ms=4, color=COLOURS[knob])
    panel.set_xlabel(label + (unit if knob == "elements" else ""))
    if not np.isnan(slope(rows)):
        panel.set_title(f"slope {slope(rows):z.1f}", loc="right", pad=3)
    _widen(panel, seen["error"].abs())
    _plain_ticks(panel, seen["value"])


def _over_time(panel: Axes, rows: pd.DataFrame) -> None:
    for knob in rows["knob"].unique():
        one = rows[(rows["knob"] == knob) & (rows["error"].abs() > 0)].sort_values("seconds")
        panel.loglog(one["seconds"], one["error"].abs(), "o-", ms=3, lw=0.8, color=COLOURS[knob],
                     label=knob)  # fmt: skip
    panel.set_xlabel("processor time (s)")
    panel.xaxis.set_major_locator(LogLocator(subs=(1, 3)))
    panel.xaxis.set_major_formatter("{x:g}")
    panel.xaxis.set_minor_formatter(NullFormatter())
    _widen(panel, rows.loc[rows["error"].abs() > 0, "error"].abs())


def _widen(panel: Axes, values: pd.Series) -> None:
    """Show at least a decade, so that an error that does not depend on a knob looks level."""
    middle = np.sqrt(values.min() * values.max())
    low, high = min(values.min() / 1.5, middle / 4), max(values.max() * 1.5, middle * 4)
    panel.set_ylim(low, high)


def _plain_ticks(panel: Axes, values: pd.Series) -> None:
    labels = [f"{value:g}" for value in values]
    turn = 30 if max(map(len, labels)) > 5 else 0
    panel.set_xticks(values.to_numpy(), labels, fontsize=8, rotation=turn)
    panel.set_xticks([], minor=True)


def draw_teeth(curves: pd.DataFrame, ensemble: pd.DataFrame, peaks: pd.DataFrame) -> Figure:
    """Draw combings that should agree, the ensemble's band, and the distribution of its peaks.

    Parameters
    ----------
    curves : DataFrame
        Columns run, d, f.
    ensemble : DataFrame
        Columns d, mean, low, high.
    peaks : DataFrame
        Columns run, first, later.
    """
    with paper_style():
        figure, panels = new_figure(1, 3, 2.6)
        meshes = [run for run in curves["run"].unique() if not run.startswith("seed")]
        for run, colour in zip(meshes, (EXPERIMENT, SIMULATION, THEORY), strict=True):
            rows = curves[curves["run"] == run]
            panels[0].plot(METRE_TO_MM * rows["d"], rows["f"], lw=0.8, color=colour, label=run)
        panels[0].legend(fontsize=7)
        panels[0].set(title="one scene, three runs", ylabel="$f = l_0^2 F/B$")
        _band(panels[1], curves, ensemble)
        _distribution(panels[2], peaks[peaks["run"].str.startswith("seed")])
        for panel in panels[:2]:
            panel.set(xlabel="tine displacement $d$ (mm)", ylim=(0, 1.35 * curves["f"].max()))
    return figure


def _band(panel: Axes, curves: pd.DataFrame, ensemble: pd.DataFrame) -> None:
    d = METRE_TO_MM * ensemble["d"]
    panel.fill_between(d, ensemble["low"], ensemble["high"], color=BAND, lw=0, label="extremes")
    panel.plot(d, ensemble["mean"], color=SIMULATION, label="mean")
    count = curves.loc[curves["run"].str.startswith("seed"), "run"].nunique()
    panel.set_title(f"{count} perturbed runs")
    panel.legend(fontsize=7)


def _distribution(panel: Axes, peaks: pd.DataFrame) -> None:
    share = (np.arange(len(peaks)) + 1) / len(peaks)
    for column, colour, label in (("first", THEORY, "first jam"), ("later", SIMULATION, "later")):
        panel.step(np.sort(peaks[column]), share, "o-", where="post", ms=3, color=colour,
                   label=label)  # fmt: skip
    panel.set(title="their peaks", xlabel="$f$", ylabel="share of runs below", ylim=(0, 1.3))
    panel.legend(fontsize=7, loc="upper left")
