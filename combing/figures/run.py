"""One simulated run at a glance: strands as the tine passes, force, link density."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from combing.figures.style import BAND, SIMULATION, STRANDS, WIDTH, paper_style

if TYPE_CHECKING:
    from combing.bands import Bands
    from sim import Run

METRE_TO_MM = 1e3
VIEWS = 7  # strands drawn side by side
CURVES = 5  # link densities drawn over one another


def draw_run(
    run: Run, log: pd.DataFrame | None, links: pd.DataFrame | None, bands: Bands | None = None
) -> Figure:
    """Draw the strands, and the force and link density where the scene has them.

    Parameters
    ----------
    run : Run
        What was simulated.
    log : DataFrame or None
        Force log of the tine.
    links : DataFrame or None
        Columns snapshot, displacement, s, link.
    bands : Bands, optional
        Drawn about the force, and about the link density, which is then averaged over a pitch.
    """
    with paper_style():
        below = [panel for panel in (log, links) if panel is not None]
        figure = Figure(figsize=(WIDTH, 4.6 if below else 2.6), layout="constrained")
        top, *rest = figure.subfigures(1 + bool(below), 1, height_ratios=[5, 4][: 1 + bool(below)],
                                       squeeze=False).ravel()  # fmt: skip
        _draw_strands(top.subplots(), run)
        if below:
            panels = list(rest[0].subplots(1, len(below), squeeze=False).ravel())
            if log is not None:
                _draw_force(panels.pop(0), log, bands)
            if links is not None:
                _draw_links(panels.pop(0), links if bands is None else _averaged(bands))
        figure.suptitle(run.data.attrs["title"], fontsize=9)
    return figure


def _draw_strands(panel: Axes, run: Run) -> None:
    chosen = np.unique(np.linspace(0, len(run.times) - 1, VIEWS).round().astype(int))
    views = [[METRE_TO_MM * strand for strand in run.strands(i)] for i in chosen]
    gap = 0.3 * max(np.ptp(np.concatenate(view)[:, 2]) for view in views)
    left = 0.0
    for snapshot, view in zip(chosen, views, strict=True):
        low, high = np.concatenate(view)[:, 0].min(), np.concatenate(view)[:, 0].max()
        for number, strand in enumerate(view):
            x = strand[:, 0] - low + left
            panel.plot(x, strand[:, 2], color=STRANDS[number % len(STRANDS)], lw=0.7)
        label = f"{METRE_TO_MM * run.displacements[snapshot]:.0f} mm" if run.scene.tines else (
            f"{run.times[snapshot]:.2g} s"
        )  # fmt: skip
        panel.annotate(label, (left + 0.5 * (high - low), 1.02), xycoords=("data", "axes fraction"),
                       ha="center", va="bottom", fontsize=7)  # fmt: skip
        left += high - low + gap
    panel.set_aspect("equal")
    panel.set_xticks([])
    panel.set_ylabel("z (mm)")


def _draw_force(panel: Axes, log: pd.DataFrame, bands: Bands | None) -> None:
    panel.plot(METRE_TO_MM * log["displacement"], log["force"], color=SIMULATION,
               lw=0.6 if bands is None else 0.3)  # fmt: skip
    if bands is not None:
        _draw_band(panel, bands)
    panel.axhline(0, color="0.7", lw=0.6)
    panel.set_xlabel("tine displacement $d$ (mm)")
    panel.set_ylabel("force $F$ (N)")


def _draw_band(panel: Axes, bands: Bands) -> None:
    """Draw the averaged force with its band: of the mesh, then of one more member."""
    table, newton = bands.force, bands.about["newton"]
    d, level = METRE_TO_MM * table["d"], f"{100 * bands.about['level']:g} %"
    for kind, colour, label in (
        ("mesh", "#f0b7a8", "mesh"),
        ("spread", BAND, f"one more specimen ({bands.about['members']} members)"),
    ):
        inside = (table["kind"] == kind).to_numpy()
        panel.fill_between(d, newton * table["low"], newton * table["high"], where=inside, lw=0,
                           color=colour, label=f"{label}, {level}")  # fmt: skip
    panel.plot(d, newton * table["value"], color=SIMULATION, lw=1)
    seen = table[["value", "low", "high"]].to_numpy()
    room = 0.05 * newton * np.nanmax(seen)
    panel.set_ylim(max(newton * np.nanmin(seen), -6 * room) - room, newton * np.nanmax(seen) + room)
    panel.legend(fontsize=7)


def _averaged(bands: Bands) -> pd.DataFrame:
    return bands.link.rename(columns={"value": "link"})


def _draw_links(panel: Axes, links: pd.DataFrame) -> None:
    snapshots = links["snapshot"].unique()
    for number, i in enumerate(np.linspace(0, len(snapshots) - 1, CURVES).round().astype(int)):
        table = links[links["snapshot"] == snapshots[i]]
        label = f"{METRE_TO_MM * table['displacement'].iloc[0]:.0f} mm"
        shade = 0.15 + 0.7 * number / CURVES
        colour = (shade, 0.3, 1 - shade)
        if "low" in table:
            panel.fill_between(METRE_TO_MM * table["s"], table["low"], table["high"], color=colour,
                               alpha=0.25, lw=0)  # fmt: skip
        panel.plot(METRE_TO_MM * table["s"], table["link"], color=colour, lw=0.8, label=label)
    panel.set_xlabel("arclength of the pair $s$ (mm)")
    panel.set_ylabel(r"link density $\lambda$ (1/m)")
    panel.legend(title="$d$", fontsize=7)
