"""What the pipelines measured beside the virtual lab's truth."""

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from combing.figures.style import EXPERIMENT, mark_synthetic, new_figure, paper_style

TITLES = {
    "force": ("force peak", "f_max", r"$f_{max}$"),
    "link": ("mean link density", "mean λ", r"$\lambda$ (m$^{-1}$)"),
    "interactions": ("N-body interactions", "count", "count"),
}


def draw_errors(errors: pd.DataFrame) -> Figure:
    """Draw measured over true values, one panel a pipeline, with the line of equality.

    Parameters
    ----------
    errors : DataFrame
        Columns kind (force, link, interactions), quantity, measured, truth.
    """
    kinds = [kind for kind in TITLES if kind in set(errors["kind"])]
    with paper_style():
        figure, panels = new_figure(1, len(kinds), 2.3)
        for panel, kind in zip(panels, kinds, strict=True):
            title, quantity, label = TITLES[kind]
            rows = errors[(errors["kind"] == kind) & errors["quantity"].str.startswith(quantity)]
            _draw(panel, rows)
            panel.set(title=title, xlabel=f"true {label}", ylabel=f"measured {label}")
        # Truth is known of synthetic data only.
        mark_synthetic(figure, True)
    return figure


def _draw(panel: Axes, rows: pd.DataFrame) -> None:
    values = rows[["truth", "measured"]].to_numpy(dtype=float)
    low, high = np.nanmin(values), np.nanmax(values)
    room = 0.08 * (high - low) + 1e-9
    panel.plot([low - room, high + room], [low - room, high + room], color="0.6", lw=0.8)
    panel.plot(values[:, 0], values[:, 1], "o", ms=4, mfc="none", color=EXPERIMENT)
    panel.set(xlim=(low - room, high + room), ylim=(low - room, high + room), aspect="equal")
