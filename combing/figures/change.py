"""Change of link density over s, colour by the tine's place, and its jump over x beside it."""

import matplotlib as mpl
import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.figure import Figure

from combing.figures.style import EXPERIMENT, SIMULATION, WIDTH, mark_synthetic, paper_style, plain

METRE_TO_MM = 1e3
SOURCES = ("experiment", "simulation")
COLOURS = {"experiment": EXPERIMENT, "simulation": SIMULATION}


def draw_change(table: pd.DataFrame, *, synthetic: bool) -> Figure:
    """Draw one set: experiment over simulation, on the same axes.

    Parameters
    ----------
    table : DataFrame
        Columns set, source, curve (profile, jump), d, x, s, change, sd, as
        `combing.compare.link_change.changes` makes it, of one set.
    synthetic : bool
        Whether the experiment comes from the virtual lab.
    """
    sources = [one for one in SOURCES if (table["source"] == one).any()]
    table, name, end = placed(table)
    with paper_style():
        figure = Figure(figsize=(WIDTH, 2.1 * len(sources) + 0.5), layout="constrained")
        FigureCanvasAgg(figure)
        grid = figure.subplots(
            len(sources), 2, squeeze=False, sharex="col", sharey="col", width_ratios=[1.5, 1]
        )
        for (left, right), source in zip(grid, sources, strict=True):
            draw_profiles(left, table, source, end)
            _jumps(right, table[(table["curve"] == "jump") & (table["source"] == source)], source)
            left.set_title(source, loc="left")
            right.set_xlim(0, 1.02 * end)
        limit_profiles(grid[0][0], table)
        grid[-1][0].set_xlabel("$s$ (mm)")
        grid[-1][1].set_xlabel(name)
        grid[0][1].set_title("jump across the tine", loc="left")
        bar_of_places(figure, grid[:, 0].tolist(), name, end)
        figure.suptitle(plain(str(table["set"].iloc[0])), fontsize=9)
        mark_synthetic(figure, synthetic)
    return figure


def placed(table: pd.DataFrame) -> tuple[pd.DataFrame, str, float]:
    """Return the table with a column place, what that is, and where it ends: x, or d [mm]."""
    if table["x"].notna().all():
        return table.assign(place=table["x"]), "$x = d/D$", 1.0
    table = table.assign(place=table["d"] * METRE_TO_MM)
    return table, "$d$ (mm)", float(table["place"].max())


def bar_of_places(figure: Figure, panels: list[Axes], name: str, end: float) -> None:
    """Put a bar beside the panels that says which colour is which place of the tine."""
    shades = mpl.colors.ListedColormap(mpl.colormaps["viridis"](np.linspace(0, 0.92, 256)))
    bar = ScalarMappable(Normalize(0, end), shades)
    figure.colorbar(bar, ax=panels, label=f"tine at {name}", pad=0.02)


def draw_profiles(panel: Axes, table: pd.DataFrame, source: str, end: float) -> None:
    """Draw a source's change over s with its sd at every place of the tine.

    `table` and `end` are those of `placed`.
    """
    rows = table[(table["curve"] != "jump") & (table["source"] == source)]
    shades, norm = mpl.colormaps["viridis"], Normalize(0, end)
    panel.axhline(0, color="0.6", lw=0.8, dashes=(1, 2))
    for place, one in rows.groupby("place"):
        s, shade = one["s"] * METRE_TO_MM, shades(0.92 * float(norm(float(str(place)))))
        low, high = one["change"] - one["sd"], one["change"] + one["sd"]
        panel.fill_between(s, low, high, color=shade, alpha=0.25, lw=0)
        panel.plot(s, one["change"], color=shade, lw=1)
    panel.set_ylabel(r"$\Delta\lambda/\lambda_0$")


def _jumps(panel: Axes, rows: pd.DataFrame, source: str) -> None:
    panel.axhline(0, color="0.6", lw=0.8, dashes=(1, 2))
    rows = rows.sort_values("place")
    look = {"fmt": "o", "ms": 4, "capsize": 2} if rows["sd"].gt(0).any() else {"lw": 1}
    panel.errorbar(rows["place"], rows["change"], rows["sd"] if "fmt" in look else None,
                   color=COLOURS[source], **look)  # fmt: skip


def limit_profiles(panel: Axes, table: pd.DataFrame) -> None:
    """Keep the ends' spikes from flattening every curve."""
    profiles = table[table["curve"] == "profile"]
    low, high = np.nanpercentile(profiles["change"], [1, 99])
    room = 0.15 * (high - low) + 0.05
    panel.set_ylim(min(low - room, -0.1), max(high + room, 0.1))
