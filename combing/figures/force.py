"""Scaled force f over scaled displacement x: experiment over simulation over Love's curve."""

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from combing.figures.style import (
    BAND,
    EXPERIMENT,
    SIMULATION,
    THEORY,
    legend_above,
    mark_synthetic,
    new_figure,
    paper_style,
    plain,
)

ROOM = 1.25  # height of the panel over the highest measured force


def draw_force(table: pd.DataFrame, *, synthetic: bool) -> Figure:
    """Draw one panel for each set of the force table.

    Parameters
    ----------
    table : DataFrame
        Columns set, source (experiment, simulation, theory), curve, x, f, low, high.
    synthetic : bool
        Whether the experiment comes from the virtual lab.
    """
    sets = table["set"].unique()
    with paper_style():
        figure, panels = new_figure(-(-len(sets) // 2), min(2, len(sets)), 2.6)
        for panel, name in zip(panels, sets, strict=False):
            _draw_set(panel, table[table["set"] == name])
            panel.set(title=plain(name), xlabel=r"$x = d/D$", ylabel=r"$f = l_0^2 F/B$")
        for panel in panels[len(sets) :]:
            panel.remove()
        legend_above(figure, panels[0], 3 if len(sets) > 1 else 2)
        mark_synthetic(figure, synthetic)
    return figure


def draw_source(panel: Axes, rows: pd.DataFrame, source: str) -> None:
    """Draw mean, band and one repeat of the experiment, or the simulation."""
    if source == "experiment":
        mean, one = (_curve(rows, source, curve) for curve in ("mean", "representative"))
        panel.fill_between(
            mean["x"], mean["low"], mean["high"], color=BAND, lw=0, label="experiment, mean ± sd"
        )
        panel.plot(mean["x"], mean["f"], color="0.5", lw=1)
        panel.plot(one["x"], one["f"], color=EXPERIMENT, lw=0.9, label="experiment, one repeat")
    run = _curve(rows, "simulation", "run")
    if source == "simulation" and len(run):
        if run["low"].notna().any():
            panel.fill_between(run["x"], run["low"], run["high"], color=SIMULATION, alpha=0.2, lw=0,
                               label="simulation, 95 % band")  # fmt: skip
        panel.plot(run["x"], run["f"], color=SIMULATION, label="simulation")


def _draw_set(panel: Axes, rows: pd.DataFrame) -> None:
    draw_source(panel, rows, "experiment")
    draw_source(panel, rows, "simulation")
    for kind, dashes in (("free", (4, 2)), ("blocked", (1, 1.5))):
        love = _curve(rows, "theory", kind)
        if len(love):
            panel.plot(
                love["x"],
                love["f"],
                color=THEORY,
                dashes=dashes,
                label=f"single helix, {kind} ends",
            )
    top = np.nanmax(rows.loc[rows["source"] != "theory", ["f", "high"]].to_numpy())
    panel.set(xlim=(0, 1.1), ylim=(-0.05 * top, ROOM * top))


def _curve(rows: pd.DataFrame, source: str, curve: str) -> pd.DataFrame:
    return rows[(rows["source"] == source) & (rows["curve"] == curve)]
