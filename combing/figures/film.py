"""A film of a combing: force, link on both sides of the tine and lambda(s), over one axis of d."""

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from combing.figures.style import EXPERIMENT, SIMULATION, THEORY, WIDTH, paper_style
from imaging.helix.sequence import HelixSequence, kymograph

MM = 1e3


def draw_film(
    table: pd.DataFrame, sequence: HelixSequence, log: pd.DataFrame | None, unit: str
) -> Figure:
    """Draw a measured film.

    Parameters
    ----------
    table : DataFrame
        From `combing.film.film_table`.
    sequence : HelixSequence
        From `combing.film.film_sequence`; positions are displacements [m].
    log : DataFrame or None
        Force log from the start of motion on (`combing.film.started`).
    unit : str
        Of lengths along the helix, "m" or "px".
    """
    with paper_style():
        figure = Figure(figsize=(WIDTH, 5.2 if log is not None else 4.0), layout="constrained")
        FigureCanvasAgg(figure)
        heights = [1.0] * (log is not None) + [1.0, 1.6]
        panels = list(figure.subplots(len(heights), 1, sharex=True, height_ratios=heights))
        if log is not None:
            inside = log[log["displacement"] <= table["d"].max()]
            panels[0].plot(MM * inside["displacement"], inside["force"], color=EXPERIMENT, lw=0.8)
            panels[0].set_ylabel("$F$ (N)")
        _sides(panels[-2], table)
        _kymograph(figure, panels[-1], table, sequence, unit)
        panels[-1].set_xlabel("displacement $d$ of the tine (mm)")
        if table["d"].max() > 0:
            panels[-1].set_xlim(0, 1.02 * MM * table["d"].max())
    return figure


def _sides(panel: Axes, table: pd.DataFrame) -> None:
    """Draw the means over a pitch behind and ahead of the tine over lambda_0, with their sd."""
    panel.axhline(1, color="0.6", lw=0.8, dashes=(1, 2))
    for side, colour in (("behind", THEORY), ("ahead", SIMULATION)):
        value, sd = (table[name] / table["lambda_0"] for name in (side, f"{side}_sd"))
        panel.errorbar(
            MM * table["d"], value, sd, fmt="o", ms=2.5, lw=0.8, color=colour, label=side
        )
    panel.set_ylabel(r"$\lambda/\lambda_0$")
    panel.legend(frameon=False)


def _kymograph(
    figure: Figure, panel: Axes, table: pd.DataFrame, sequence: HelixSequence, unit: str
) -> None:
    d, s, change = kymograph(sequence)
    factor = MM if unit == "m" else 1.0
    most = float(np.nanpercentile(np.abs(change), 98)) if np.isfinite(change).any() else 1.0
    picture = panel.pcolormesh(
        MM * d, factor * s, change.T, cmap="RdBu_r", vmin=-most, vmax=most, shading="nearest"
    )
    panel.plot(MM * table["d"], factor * table["tine"], "k-", lw=0.8)
    panel.set_facecolor("0.85")
    panel.set_ylabel(f"$s$ ({'mm' if unit == 'm' else unit}); line: tine")
    figure.colorbar(picture, ax=panel, label=r"$\Delta\lambda/\lambda_0$; grey: not resolved")
