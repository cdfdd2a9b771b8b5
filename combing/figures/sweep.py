"""Combings that differ in one parameter: curves in colour by value, f_max over it beside them."""

from collections.abc import Callable

import matplotlib as mpl
import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import Normalize
from matplotlib.figure import Figure

from combing.figures.style import EXPERIMENT, WIDTH, mark_synthetic, paper_style, plain

SYMBOLS = {
    "pi1": "$P/r$", "pi2": "$R/r$", "pi3": "$t/r$", "q": "$q$", "friction": r"$\mu$",
}  # fmt: skip
SOURCES = ("experiment", "simulation")
ROOM = 1.12  # height of the panels over the highest mean or band
Colour = Callable[[float], tuple[float, ...]]


def draw_sweep(table: pd.DataFrame, *, synthetic: bool) -> Figure:
    """Draw one set: a row for the experiment, one for the simulation, with the same axes.

    Parameters
    ----------
    table : DataFrame
        Columns set, over, source, value, curve, x, f, low, high, black, as
        `combing.compare.sweep.compare_sweep` makes it, of one set.
    synthetic : bool
        Whether the experiment comes from the virtual lab.
    """
    sources = [one for one in SOURCES if (table["source"] == one).any()]
    with paper_style():
        figure = Figure(figsize=(WIDTH, 2.5 * len(sources) + 0.5), layout="constrained")
        FigureCanvasAgg(figure)
        grid = figure.subplots(
            len(sources), 2, squeeze=False, sharex="col", sharey=True, width_ratios=[2, 1]
        )
        colour = colours_of(table)
        for (left, right), source in zip(grid, sources, strict=True):
            draw_curves(left, table, source, colour)
            _peaks(right, table[table["source"] == source], colour)
            limit_curves(left, table)
            left.set_ylabel(r"$f = l_0^2 F/B$")
            left.set_title(source, loc="left")
        symbol = symbol_of(table)
        grid[-1][0].set_xlabel(r"$x = d/D$")
        grid[-1][1].set_xlabel(symbol)
        grid[0][1].set_title(r"$f_{max}$, 95 % interval", loc="left")
        legend_of_values(figure, grid[0][0], symbol)
        figure.suptitle(plain(str(table["set"].iloc[0])), fontsize=9)
        mark_synthetic(figure, synthetic)
    return figure


def colours_of(table: pd.DataFrame) -> Colour:
    """Return the colour of every value of a set."""
    values = table["value"]
    norm = Normalize(values.min(), values.max() if values.nunique() > 1 else values.min() + 1)
    shades = mpl.colormaps["viridis"]
    return lambda value: shades(0.92 * float(norm(value)))


def symbol_of(table: pd.DataFrame) -> str:
    """Return what stands for the parameter of a set."""
    over = str(table["over"].iloc[0])
    return SYMBOLS.get(over, plain(over.replace("_", " ")))


def limit_curves(panel: Axes, table: pd.DataFrame) -> None:
    """Show all bands and intervals of experiment and simulation, of Love's curves what fits."""
    seen = table[table["source"].isin(SOURCES)]
    top = float(np.nanmax(seen[["f", "high"]].to_numpy()))
    panel.set(xlim=(0, 1.1), ylim=(-0.04 * top, ROOM * top))


def draw_curves(panel: Axes, table: pd.DataFrame, source: str, colour: Colour) -> None:
    """Draw mean and band of every value of one source, one curve in black, Love's dashed."""
    for value in table["value"].unique():
        one = table[table["value"] == value]
        mean = one[(one["source"] == source) & (one["curve"] == "mean")]
        panel.fill_between(
            mean["x"], mean["low"], mean["high"], color=colour(value), alpha=0.25, lw=0
        )
        panel.plot(mean["x"], mean["f"], color=colour(value), label=f"{value:g}")
        love = one[one["source"] == "theory"]
        panel.plot(love["x"], love["f"], color=colour(value), lw=0.9, dashes=(4, 2))
    chosen = table[(table["source"] == source) & (table["curve"] == "representative")]
    chosen = chosen[chosen["value"] == chosen["black"]]
    panel.plot(chosen["x"], chosen["f"], color=EXPERIMENT, lw=0.8)


def _peaks(panel: Axes, rows: pd.DataFrame, colour: Colour) -> None:
    peaks = rows[rows["curve"] == "f_max"].sort_values("x")
    panel.plot(peaks["x"], peaks["f"], color="0.6", lw=0.8)
    for _, row in peaks.iterrows():
        error = [[row["f"] - row["low"]], [row["high"] - row["f"]]]
        panel.errorbar(row["x"], row["f"], error, fmt="o", ms=4, capsize=2,
                       color=colour(row["value"]))  # fmt: skip


def legend_of_values(figure: Figure, panel: Axes, symbol: str) -> None:
    """Say which colour is which value, beside the panels."""
    handles, labels = panel.get_legend_handles_labels()
    handles = [*handles, *panel.plot([], [], color=EXPERIMENT, lw=0.8)]
    handles += panel.plot([], [], color="0.4", lw=0.9, dashes=(4, 2))
    labels = [*labels, "one curve", "single helix (Love)"]
    figure.legend(handles, labels, title=f"{symbol}; mean ± sd", loc="outside right upper")
