"""A tangle: where its strands cross, who with whom, and how much of it a picture tells."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator
from numpy.typing import NDArray

from combing.figures.style import EXPERIMENT, SIMULATION, new_figure, paper_style, plain

if TYPE_CHECKING:
    import pandas as pd

METRE_TO_MM = 1e3


def draw_entanglement(
    along: pd.DataFrame, crossings: NDArray[np.float64], views: pd.DataFrame, title: str
) -> Figure:
    """Draw a tangle from the side, its matrix, its profile, and what pictures of it tell.

    Parameters
    ----------
    along : DataFrame
        Every segment: strand, x, y, z [m], length [m], crossings [1/m].
    crossings : (n, n) array
        Average crossing numbers of the pairs.
    views : DataFrame
        Columns strand_a, strand_b, degrees, seen.
    title : str
        What is shown.
    """
    with paper_style():
        figure, panels = new_figure(2, 2, 2.9)
        _side(figure, panels[0], along)
        _matrix(figure, panels[1], crossings)
        _profile(panels[2], along)
        _seen(panels[3], crossings, views)
        panels[0].set_title(plain(title), loc="left")
    return figure


def _side(figure: Figure, panel: Axes, along: pd.DataFrame) -> None:
    """Draw every segment in the colour of its density, the densest on top."""
    lines, colours = [], []
    for _, one in along.groupby("strand"):
        place = METRE_TO_MM * np.column_stack([-one["x"], one["z"]])
        lines += list(np.stack([place[:-1], place[1:]], axis=1))
        colours += list(one["crossings"].to_numpy()[1:] / METRE_TO_MM)
    order = np.argsort(colours)
    drawn = LineCollection([lines[k] for k in order], cmap="viridis", linewidths=0.9)
    drawn.set_array(np.array(colours)[order])
    drawn.set_clim(0, float(np.percentile(colours, 98)))
    panel.add_collection(drawn)
    panel.autoscale()
    panel.set_aspect("equal", adjustable="datalim")
    panel.set(xlabel="mm", ylabel="z (mm)")
    figure.colorbar(drawn, ax=panel, label="crossings (1/mm)", extend="max")


def _matrix(figure: Figure, panel: Axes, crossings: NDArray[np.float64]) -> None:
    n = len(crossings)
    shown = panel.imshow(
        np.where(np.eye(n, dtype=bool), np.nan, crossings),
        extent=(0.5, n + 0.5, n + 0.5, 0.5),
        cmap="viridis",
        vmin=0,
    )
    panel.set(xlabel="strand", ylabel="strand", title="average crossing number")
    for axis in (panel.xaxis, panel.yaxis):
        axis.set_major_locator(MaxNLocator(6, integer=True))
    figure.colorbar(shown, ax=panel)


def _profile(panel: Axes, along: pd.DataFrame) -> None:
    """Draw the crossings of all strands at a height, in 30 layers."""
    edges = np.linspace(along["z"].min(), along["z"].max(), 31)
    amount = np.histogram(along["z"], edges, weights=along["crossings"] * along["length"])[0]
    density, heights = amount / np.diff(edges) / METRE_TO_MM, METRE_TO_MM * edges
    panel.stairs(density, heights, orientation="horizontal", color=SIMULATION)
    panel.set(xlabel="crossings per mm of height", ylabel="z (mm)", xlim=(0, None))


def _seen(panel: Axes, crossings: NDArray[np.float64], views: pd.DataFrame) -> None:
    """Draw what pictures from several sides show of every pair, over its exact value."""
    a, b = views["strand_a"].to_numpy() - 1, views["strand_b"].to_numpy() - 1
    panel.plot(crossings[a, b], views["seen"], ".", color="0.75", ms=3, label="one view")
    mean = views.groupby(["strand_a", "strand_b"])["seen"].mean()
    first, second = (mean.index.get_level_values(k).to_numpy() - 1 for k in (0, 1))
    panel.plot(crossings[first, second], mean, ".", color=EXPERIMENT, ms=4, label="mean of views")
    most = float(max(crossings[a, b].max(), views["seen"].max(), 1))
    panel.plot([0, most], [0, most], "--", color="0.4", lw=0.8)
    panel.set(xlabel="average crossing number of a pair", ylabel="crossings seen")
    panel.legend(loc="upper left")
