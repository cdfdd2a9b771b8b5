"""A fit: the joint posterior with its ridge, the best curve over the lab's, what is off by what."""

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from combing.figures.style import (
    BAND,
    EXPERIMENT,
    SIMULATION,
    THEORY,
    WIDTH,
    mark_synthetic,
    paper_style,
    plain,
)

REGIONS = (0.5, 0.95)
SHADES = ("#e6b0a8", "#c8321e")


def draw_fit(fit: Any, *, synthetic: bool) -> Figure:
    """Draw the joint posterior, F over x, and every summary's distance.

    Parameters
    ----------
    fit : combing.fit.Fit
    synthetic : bool
        Whether the experiment comes from the virtual lab.
    """
    with paper_style():
        figure = Figure(figsize=(WIDTH, 5.8), layout="constrained")
        FigureCanvasAgg(figure)
        grid = figure.add_gridspec(2, 2, width_ratios=(1.15, 1), height_ratios=(1.2, 1))
        _draw_posterior(figure.add_subplot(grid[0, 0]), fit)
        _draw_curve(figure.add_subplot(grid[0, 1]), fit)
        _draw_residuals(figure.add_subplot(grid[1, :]), fit)
        figure.suptitle(plain(fit.facts["title"]))
        mark_synthetic(figure, synthetic)
    return figure


def _draw_posterior(panel: Axes, fit: Any) -> None:
    found = fit.posterior
    friction, factor = found.axes
    panel.contourf(friction, factor, found.content.T, [0, *REGIONS], colors=SHADES[::-1])
    panel.contour(
        friction, factor, fit.level_alone.content.T, [REGIONS[1]], colors=THEORY, linestyles="--"
    )
    ridge = found.ridge()
    panel.plot(*ridge.T, color="black", lw=0.8)
    panel.plot(*found.best, "+", color="black", ms=8)
    panel.set(yscale="log", **_limits(fit))
    panel.set(xlabel=r"friction $\mu$", ylabel="rigidity over the rig's")
    said: list[tuple[str, dict[str, Any]]] = [
        ("50 and 95 % of the posterior", {"color": SHADES[1], "lw": 5}),
        ("95 %, mean and highest force alone", {"color": THEORY, "ls": "--"}),
        ("ridge; + most likely", {"color": "black", "lw": 0.8}),
    ]
    for label, look in said:
        panel.plot([], [], label=label, **look)
    panel.legend(loc="upper right", fontsize=7)


def _limits(fit: Any) -> dict[str, tuple[float, float]]:
    """Show where either posterior is, not all that was possible."""
    axes = [np.array([one.axes[k][[0, -1]] for one in (fit.posterior, fit.level_alone)])
            for k in (0, 1)]  # fmt: skip
    (a, b), (c, d) = ((float(one.min()), float(one.max())) for one in axes)
    room = 0.1 * (b - a), (d / c) ** 0.1
    low, high = fit.posterior.friction
    return {
        "xlim": (max(a - room[0], low), min(b + room[0], high)),
        "ylim": (c / room[1], d * room[1]),
    }


def _draw_curve(panel: Axes, fit: Any) -> None:
    table, n = fit.curve, fit.facts["specimens"]
    if table["lab_sd"].notna().any():
        low, high = table["lab"] - table["lab_sd"], table["lab"] + table["lab_sd"]
        panel.fill_between(table["x"], low, high, color=BAND, lw=0, label="logs, mean ± sd")
    panel.plot(table["x"], table["lab"], color=EXPERIMENT, label=f"logs, mean of {n}")
    panel.fill_between(
        table["x"], table["low"], table["high"], color=SIMULATION, alpha=0.2, lw=0,
        label="model, 95 % of specimens",
    )  # fmt: skip
    panel.plot(table["x"], table["best"], color=SIMULATION, label="model, most likely")
    panel.set(xlim=(0, 1), xlabel="$x = d/D$", ylabel="$F$ (N)")
    panel.set_ylim(min(0.0, float(table["low"].min())), None)
    panel.legend(loc="best", fontsize=7)


def _draw_residuals(panel: Axes, fit: Any) -> None:
    table = fit.residuals
    at = np.arange(len(table))
    panel.axhspan(-1.96, 1.96, color=BAND, lw=0, alpha=0.6)
    panel.axhline(0, color="0.4", lw=0.8)
    panel.plot(at, table["apart"], "o", ms=4, color=EXPERIMENT)
    panel.set_xticks(at, [plain(str(name)) for name in table["summary"]], rotation=35, ha="right")
    panel.tick_params(axis="x", labelsize=7)
    reach = max(3.0, 1.1 * float(table["apart"].abs().max()))
    panel.set(ylabel="lab - model (sd)", ylim=(-reach, reach))
