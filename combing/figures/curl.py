"""Curls as they were counted: strands in colour, in the picture's plane and in space."""

from pathlib import Path

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from mpl_toolkits.mplot3d import Axes3D
from numpy.typing import NDArray

from combing.figures.photographs import smaller
from combing.figures.style import (
    EXPERIMENT,
    SIMULATION,
    STRANDS,
    WIDTH,
    legend_above,
    mark_synthetic,
    paper_style,
    plain,
)  # fmt: skip

Array = NDArray[np.float64]
METRE_TO_MM = 1e3
PHOTO_HEIGHT = 900  # px
COLOURS = {"experiment": EXPERIMENT, "simulation": SIMULATION}
TITLES = {"photo": "photograph", "space": "simulation, in space"}
LABELS = {"sections": "sections", "view": "direction of view (degrees)"}


def draw_curls(table: pd.DataFrame, photo: Path | None, *, synthetic: bool) -> Figure:
    """Draw the first curl of either source: photograph, its strands, the simulated ones, in space.

    Parameters
    ----------
    table : DataFrame
        Columns set, source, sample, strand, x, y, z [m], as
        `combing.compare.curl_views.strand_table` makes it, of one set.
    photo : Path, optional
        The photograph of the first curl.
    synthetic : bool
        Whether the experiment comes from the virtual lab.
    """
    curls = {source: first_curl(table, source) for source in table["source"].unique()}
    kinds = [*(["photo"] if photo else []), *curls, *(["space"] if "simulation" in curls else [])]
    with paper_style():
        figure = Figure(figsize=(1.8 * len(kinds), 3.6), layout="constrained")
        FigureCanvasAgg(figure)
        for number, kind in enumerate(kinds, start=1):
            solid = {"projection": "3d"} if kind == "space" else {}
            panel = figure.add_subplot(1, len(kinds), number, **solid)
            if kind == "photo":
                draw_photo(panel, photo)
            elif kind == "space":
                draw_in_space(panel, curls["simulation"])
            else:
                draw_strands(panel, curls[kind])
            panel.set_title(TITLES.get(kind, kind), y=1.15 if kind == "space" else 1.0)
        mark_synthetic(figure, synthetic)
    return figure


def first_curl(table: pd.DataFrame, source: str) -> pd.DataFrame:
    """Return the strands of the first curl of a source."""
    rows = table[table["source"] == source]
    return rows[rows["sample"] == rows["sample"].iloc[0]]


def draw_photo(panel: Axes, photo: Path | None) -> None:
    """Show a photograph, scaled down."""
    if photo is not None:
        panel.imshow(smaller(photo, PHOTO_HEIGHT))
    panel.set_axis_off()


def draw_strands(panel: Axes, curl: pd.DataFrame) -> None:
    """Draw the strands of one curl in the plane of the picture, a bar of 20 mm beside them.

    A simulated curl is seen along y, as it is counted.
    """
    for number, (across, down) in enumerate(_flat(curl)):
        panel.plot(across, down, color=STRANDS[number % len(STRANDS)], lw=0.8)
    panel.invert_yaxis()
    panel.set_aspect("equal")
    bar, low = panel.get_xlim()[0], panel.get_ylim()[0]
    panel.plot([bar, bar + 20], [low, low], color="black", lw=2)
    panel.annotate("20 mm", (bar, low), xytext=(0, 3), textcoords="offset points", fontsize=7)
    panel.set_axis_off()


def _flat(curl: pd.DataFrame) -> list[Array]:
    """Return across and down [mm] of every strand; in space x is to the left, z up."""
    signs, axes = ((-1, -1), ["x", "z"]) if curl["z"].notna().all() else ((1, 1), ["x", "y"])
    return [METRE_TO_MM * (one[axes].to_numpy() * signs).T for _, one in curl.groupby("strand")]


def draw_in_space(panel: Axes3D, curl: pd.DataFrame) -> None:
    """Draw the strands of a simulated curl in three dimensions, all axes alike."""
    for number, (_, one) in enumerate(curl.groupby("strand")):
        x, y, z = (one[axis] * METRE_TO_MM for axis in "xyz")
        panel.plot(x, y, z, color=STRANDS[number % len(STRANDS)], lw=0.8)
    size = [max(np.ptp(curl[axis]), 1e-6) for axis in "xyz"]
    panel.set_box_aspect(size, zoom=1.25)
    panel.locator_params(nbins=4)
    panel.tick_params(labelsize=5, pad=-2)


def draw_sensitivity(table: pd.DataFrame, *, synthetic: bool) -> Figure:
    """Draw rho_N over the number of sections, and of simulated curls over the direction of view.

    Parameters
    ----------
    table : DataFrame
        Columns set, source, sample, what (sections, view), value, N, density [1/m]
        (`combing.compare.curl_views`), of one set.
    synthetic : bool
        Whether the experiment comes from the virtual lab.
    """
    whats = [one for one in LABELS if (table["what"] == one).any()]
    with paper_style():
        figure = Figure(figsize=(WIDTH, 2.8), layout="constrained")
        FigureCanvasAgg(figure)
        for panel, what in zip(
            figure.subplots(1, len(whats), squeeze=False)[0], whats, strict=True
        ):
            _over(panel, table[table["what"] == what])
            panel.set(xlabel=LABELS[what], ylabel=r"mean $\rho_N$ (m$^{-1}$)", ylim=(0, None))
        legend_above(figure, figure.axes[0], 3)
        figure.axes[0].set_title(plain(str(table["set"].iloc[0])), loc="left")
        mark_synthetic(figure, synthetic)
    return figure


def _over(panel: Axes, rows: pd.DataFrame) -> None:
    """Draw the means over curls of N = 2, 3, 4, a line style each."""
    for source, colour in COLOURS.items():
        for n, dashes in ((2, (1, 0)), (3, (4, 2)), (4, (1, 2))):
            own = rows[(rows["source"] == source) & (rows["N"] == n)]
            mean = own.groupby("value")["density"].mean()
            if len(mean):
                panel.plot(mean.index, mean, "o-", ms=3, color=colour, dashes=dashes, lw=1,
                           label=f"{source}, N = {n}")  # fmt: skip
