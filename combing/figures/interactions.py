"""Histogram of N-body interactions per metre of curl: experiment beside simulation."""

import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from combing.figures.style import BAND, SIMULATION, mark_synthetic, new_figure, paper_style, plain

LOOKS = {"experiment": (BAND, -0.2), "simulation": (SIMULATION, 0.2)}
BAR = 0.38


def draw_interactions(table: pd.DataFrame, *, n_sec: int, synthetic: bool) -> Figure:
    """Draw one panel for each set of the interaction table.

    Parameters
    ----------
    table : DataFrame
        Columns set, source (experiment, simulation), sample (one curl), N, density, low, high:
        with its 95 % interval over the curl's sections [1/m].
    n_sec : int
        Sections each curl was cut into; stated in the figure, for the densities depend on it.
    synthetic : bool
        Whether the experiment comes from the virtual lab.
    """
    sets = table["set"].unique()
    with paper_style():
        figure, panels = new_figure(-(-len(sets) // 2), min(2, len(sets)), 2.5)
        for panel, name in zip(panels, sets, strict=False):
            draw_bars(panel, table[table["set"] == name])
            panel.set(title=plain(name), xlabel="strands in an interaction, $N$")
            panel.set_ylabel(r"$\rho_N$ (m$^{-1}$)")
            panel.annotate(f"{n_sec} sections", (0.97, 0.72), xycoords="axes fraction", ha="right")
        for panel in panels[len(sets) :]:
            panel.remove()
        panels[0].legend(loc="upper right")
        mark_synthetic(figure, synthetic)
    return figure


def draw_bars(panel: Axes, rows: pd.DataFrame) -> None:
    """Draw mean densities of one set with their sd over curls, and single curls as dots.

    Of one curl alone the bars are its own interval, over its sections or, of a simulation that
    carries bands, of one more specimen. One source alone stands above N.
    """
    alone = rows["source"].nunique() == 1
    for source, (colour, shift) in LOOKS.items():
        own = rows[rows["source"] == source]
        if own.empty:
            continue
        density = own.pivot(index="N", columns="sample", values="density")
        density.index = density.index + (0.0 if alone else shift)
        samples, mean = density.shape[1], density.mean(axis=1)
        label = f"{source}, {samples} curl{'s' if samples > 1 else ''}"
        panel.bar(density.index, mean, BAR, color=colour, label=label)
        middle, half = mean, density.std(axis=1, ddof=1)
        if samples == 1:
            low, high = own.groupby("N")[["low", "high"]].first().to_numpy().T
            middle, half = (low + high) / 2, (high - low) / 2
        panel.errorbar(density.index, middle, half, fmt="none", ecolor="black", capsize=2)
        for sample in density:
            panel.plot(density.index, density[sample], ".", ms=3, color="black", alpha=0.5)
    panel.set_ylim(bottom=0)
    panel.set_xticks(sorted(rows["N"].unique()))
