"""All that a study compares in one figure: a row for the experiment, one for the simulation."""

from collections.abc import Callable, Mapping

import pandas as pd
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from combing.figures.change import draw_profiles, placed
from combing.figures.force import draw_source
from combing.figures.interactions import draw_bars
from combing.figures.style import WIDTH, mark_synthetic, paper_style, plain
from combing.figures.sweep import SOURCES, colours_of, draw_curves, limit_curves

FORCE = ("$x = d/D$", r"$f = l_0^2 F/B$")
LABELS = {
    "force": FORCE,
    "sweep": FORCE,
    "change": ("$s$ (mm)", r"$\Delta\lambda/\lambda_0$"),
    "interactions": ("$N$", r"$\rho_N$ (m$^{-1}$)"),
}


def draw_composite(tables: Mapping[str, pd.DataFrame], *, synthetic: bool) -> Figure:
    """Draw the first set of every kind, a column each, experiment over simulation, on like axes.

    Parameters
    ----------
    tables : mapping
        By kind (force, sweep, change, interactions) the table that its own figure draws, not empty.
    synthetic : bool
        Whether the experiment comes from the virtual lab.
    """
    chosen = {kind: table[table["set"] == table["set"].iloc[0]] for kind, table in tables.items()}
    sources = [
        one for one in SOURCES if any((table["source"] == one).any() for table in chosen.values())
    ]
    with paper_style():
        figure = Figure(figsize=(WIDTH, 1.9 * len(sources) + 0.5), layout="constrained")
        FigureCanvasAgg(figure)
        grid = figure.subplots(len(sources), len(chosen), squeeze=False, sharex="col", sharey="col")
        for column, (kind, table) in zip(grid.T, chosen.items(), strict=True):
            for panel, source in zip(column, sources, strict=True):
                DRAWERS[kind](panel, table, source)
                panel.set_ylabel(LABELS[kind][1])
            column[0].set_title(plain(str(table["set"].iloc[0])), loc="left")
            column[-1].set_xlabel(LABELS[kind][0])
        for row, source in zip(grid, sources, strict=True):
            row[0].set_ylabel(f"{source}\n{row[0].get_ylabel()}")
        mark_synthetic(figure, synthetic)
    return figure


def _force(panel: Axes, table: pd.DataFrame, source: str) -> None:
    draw_source(panel, table, source)
    panel.set_xlim(0, 1.1)


def _sweep(panel: Axes, table: pd.DataFrame, source: str) -> None:
    draw_curves(panel, table, source, colours_of(table))
    limit_curves(panel, table)


def _change(panel: Axes, table: pd.DataFrame, source: str) -> None:
    table, _, end = placed(table)
    draw_profiles(panel, table, source, end)


def _interactions(panel: Axes, table: pd.DataFrame, source: str) -> None:
    draw_bars(panel, table[table["source"] == source])
    sizes = sorted(table["N"].unique())
    panel.set_xticks(sizes[:: 1 + len(sizes) // 7])


DRAWERS: dict[str, Callable[[Axes, pd.DataFrame, str], None]] = {
    "force": _force, "sweep": _sweep, "change": _change, "interactions": _interactions,
}  # fmt: skip
