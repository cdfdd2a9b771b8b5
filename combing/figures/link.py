"""Link density lambda(s) at several places of the tine: experiment over simulation."""

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from combing.figures.style import (
    BAND,
    CAMERA,
    EXPERIMENT,
    SIMULATION,
    legend_above,
    mark_synthetic,
    new_figure,
    paper_style,
    plain,
)

METRE_TO_MM = 1e3
COLUMNS = 2


def draw_link(table: pd.DataFrame, *, synthetic: bool) -> Figure:
    """Draw one panel for each photograph of the link table.

    Parameters
    ----------
    table : DataFrame
        Columns set, photo, source (experiment, simulation, camera), d, tine, s, link, sd,
        reference.
    synthetic : bool
        Whether the experiment comes from the virtual lab.
    """
    keys = table[["set", "d", "photo"]].drop_duplicates().sort_values(["set", "d"])
    groups = [
        table[(table["set"] == name) & (table["photo"] == photo)]
        for name, photo in keys[["set", "photo"]].to_numpy()
    ]
    with paper_style():
        figure, panels = new_figure(-(-len(groups) // COLUMNS), COLUMNS, 1.25, share=True)
        limits = _limits(table)
        for panel, rows in zip(panels, groups, strict=False):
            _draw_position(panel, rows)
            place = f"$d$ = {rows['d'].iloc[0] * METRE_TO_MM:.0f} mm"
            panel.set_title(f"{plain(rows['set'].iloc[0])}, {place}", loc="left", pad=3)
            panel.set_ylim(limits)
        _label_outer(panels, len(groups))
        legend_above(figure, panels[0], 3)
        mark_synthetic(figure, synthetic)
    return figure


def _draw_position(panel: Axes, rows: pd.DataFrame) -> None:
    panel.axhline(rows["reference"].iloc[0], color="0.6", lw=0.8, dashes=(1, 2))
    panel.axvline(rows["tine"].iloc[0] * METRE_TO_MM, color="0.6", lw=0.8)
    seen = rows[rows["source"] == "experiment"]
    low, high = seen["link"] - seen["sd"], seen["link"] + seen["sd"]
    panel.fill_between(seen["s"] * METRE_TO_MM, low, high, color=BAND, lw=0)
    panel.plot(seen["s"] * METRE_TO_MM, seen["link"], color=EXPERIMENT, label="experiment ± sd")
    for source, colour, label in (
        ("camera", CAMERA, "simulation, photographed"),
        ("simulation", SIMULATION, "simulation"),
    ):
        curve = rows[rows["source"] == source]
        if len(curve):
            panel.plot(curve["s"] * METRE_TO_MM, curve["link"], color=colour, lw=1, label=label)


def _limits(table: pd.DataFrame) -> tuple[float, float]:
    """Keep the ends' spikes from flattening every panel."""
    low, high = np.nanpercentile(table["link"], [0.5, 99.5])
    room = 0.25 * (high - low)
    return float(min(low - room, 0)), float(high + room)


def _label_outer(panels: list[Axes], used: int) -> None:
    """Label the left and bottom panels; where the last row is not full, the one above it too."""
    for number, panel in enumerate(panels[:used]):
        if number % COLUMNS == 0:
            panel.set_ylabel(r"$\lambda$ (m$^{-1}$)")
        if number + COLUMNS >= used:
            panel.set_xlabel(r"$s$ (mm)")
            panel.tick_params(labelbottom=True)
    for panel in panels[used:]:
        panel.remove()
