"""The paper's figures by their numbers, each drawn from what a study has compared."""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import pandas as pd
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from combing.compare.comparison import Comparison
from combing.cost import cost_of_strokes
from combing.figures.change import bar_of_places, draw_profiles, limit_profiles, placed
from combing.figures.cost import draw_cost
from combing.figures.curl import draw_in_space, draw_photo, draw_strands, first_curl
from combing.figures.interactions import draw_bars
from combing.figures.style import mark_synthetic, new_figure, paper_style, save
from combing.figures.sweep import (
    colours_of,
    draw_curves,
    legend_of_values,
    limit_curves,
    symbol_of,
)
from combing.report import Section
from combing.tables import write_table

SWEPT = {"pi1": ("2c", "3c"), "pi2": ("2d", "3d"), "q": ("4a", "4b")}
SOURCES = ("experiment", "simulation")
LOGS = {"experiment": "logs", "simulation": "simulations"}
LIKE = {"experiment": "photographs", "simulation": "simulations"}


@dataclass(frozen=True)
class Numbered:
    """One figure of the paper.

    Attributes
    ----------
    number : str
        Its number there.
    says : str
        What it shows.
    rows : DataFrame
        What is drawn, with a column source.
    draw : callable
        Draws it.
    """

    number: str
    says: str
    rows: pd.DataFrame
    draw: Callable[[], Figure]


def write_figures(
    found: Mapping[str, Comparison], photo: Path | None, folder: Path
) -> list[Section]:
    """Write PNG, SVG and CSV of every figure of the paper that these comparisons hold.

    Parameters
    ----------
    found : mapping
        Comparisons by kind: sweep, link, interactions.
    photo : Path, optional
        Photograph of the first curl.
    folder : Path
        Where to.

    Returns
    -------
    list of Section
        One a figure, in the paper's order, for a report.
    """
    folder.mkdir(parents=True, exist_ok=True)
    every = [*_curls(found, photo), *_sweeps(found), *_changes(found), *_costs(found)]
    synthetic = any(one.synthetic for one in found.values())
    sections = []
    for one in sorted(every, key=lambda each: each.number):
        seen = synthetic and (one.rows["source"] == "experiment").any()
        with paper_style():
            figure = one.draw()
            mark_synthetic(figure, bool(seen))
        stem = f"figure_{one.number}"
        png, _ = save(figure, folder, stem, synthetic=bool(seen))
        write_table(folder / f"{stem}.csv", one.rows, [f"Fig. {one.number}: {one.says}; SI units"])
        sections.append(Section(f"Figure {one.number}", (), png, one.says, f"{stem}.csv"))
    return sections


def _sweeps(found: Mapping[str, Comparison]) -> Iterator[Numbered]:
    plotted = found["sweep"].plotted if "sweep" in found else pd.DataFrame({"over": []})
    for over, numbers in SWEPT.items():
        of_all = plotted[plotted["over"] == over]
        for source, number in zip(SOURCES, numbers, strict=True):
            table = of_all[of_all["set"] == of_all["set"].iloc[0]] if len(of_all) else of_all
            rows = table[table["source"].isin([source, "theory"])] if len(table) else table
            if len(rows) and (rows["source"] == source).any():
                says = f"f over x of {LOGS[source]}, colour by {over}; dashed: Love's helix."
                yield Numbered(number, says, rows, partial(_curves, table, source))


def _curves(table: pd.DataFrame, source: str) -> Figure:
    figure, (panel,) = new_figure(1, 1, 2.6)
    draw_curves(panel, table, source, colours_of(table))
    limit_curves(panel, table)
    panel.set(xlabel="$x = d/D$", ylabel=r"$f = l_0^2 F/B$")
    legend_of_values(figure, panel, symbol_of(table))
    return figure


def _changes(found: Mapping[str, Comparison]) -> Iterator[Numbered]:
    change = found["link"].change if "link" in found else pd.DataFrame()
    table = change[change["set"] == change["set"].iloc[0]] if len(change) else change
    for source, number in zip(SOURCES, ("2e", "3e"), strict=True):
        rows = table[table["source"] == source] if len(table) else table
        if len(rows):
            says = f"change of link density over s in {LIKE[source]}, colour by the tine's place."
            yield Numbered(number, says, rows, partial(_profiles, table, source))


def _profiles(table: pd.DataFrame, source: str) -> Figure:
    table, name, end = placed(table)
    figure, (panel,) = new_figure(1, 1, 2.6)
    draw_profiles(panel, table, source, end)
    limit_profiles(panel, table)
    panel.set_xlabel("$s$ (mm)")
    bar_of_places(figure, [panel], name, end)
    return figure


def _curls(found: Mapping[str, Comparison], photo: Path | None) -> Iterator[Numbered]:
    if "interactions" not in found or found["interactions"].strands.empty:
        return
    strands, bars = found["interactions"].strands, found["interactions"].plotted
    strands = strands[strands["set"] == strands["set"].iloc[0]]
    bars = bars[bars["set"] == strands["set"].iloc[0]]
    for source, (seen, counted) in zip(SOURCES, (("1b", "1d"), ("3a", "3b")), strict=True):
        rows, drawn = (table[table["source"] == source] for table in (bars, strands))
        if len(rows):
            curl, beside = first_curl(drawn, source), photo if source == "experiment" else None
            says = f"a curl of the {LIKE[source]}, its strands in colour."
            yield Numbered(seen, says, curl, partial(_curl, curl, beside))
            says = f"density of N-body interactions in {LIKE[source]}."
            yield Numbered(counted, says, rows, partial(_bars, bars, source))


def _curl(curl: pd.DataFrame, photo: Path | None) -> Figure:
    space = bool(curl["z"].notna().all())
    figure = Figure(figsize=(4.2, 4.2), layout="constrained")
    FigureCanvasAgg(figure)
    panels = 1 + (space or photo is not None)
    if photo is not None:
        draw_photo(figure.add_subplot(1, panels, 1), photo)
    draw_strands(figure.add_subplot(1, panels, 1 if space else panels), curl)
    if space:
        draw_in_space(figure.add_subplot(1, panels, 2, projection="3d"), curl)
    return figure


def _bars(table: pd.DataFrame, source: str) -> Figure:
    figure, (panel,) = new_figure(1, 1, 2.6)
    draw_bars(panel, table[table["source"] == source])
    _same_height(panel, table)
    panel.set(xlabel="strands in an interaction, $N$", ylabel=r"$\rho_N$ (m$^{-1}$)")
    panel.legend(loc="upper right")
    return figure


def _same_height(panel: Axes, table: pd.DataFrame) -> None:
    """Give experiment and simulation the same axes."""
    alone = table.groupby("source")["sample"].nunique().max() == 1
    panel.set_ylim(0, 1.05 * float(table["high" if alone else "density"].max()))
    panel.set_xticks(sorted(table["N"].unique()))


def _costs(found: Mapping[str, Comparison]) -> Iterator[Numbered]:
    table = cost_of_strokes(found["sweep"].curves) if "sweep" in found else pd.DataFrame()
    if len(table):
        says = "cost of combing over pitches below the tine; rings: the best of each weight."
        yield Numbered("4c", says, table, partial(draw_cost, table, synthetic=False))
