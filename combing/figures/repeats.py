"""The figure of ``combing force``: every repeat, their mean, jams, and where combing ends."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

import instron
from combing.figures.style import BAND, EXPERIMENT, THEORY, paper_style, write_pictures

BEYOND = 1.08  # x up to which curves are shown
POINTS = 800
LONGEST = 32  # characters of a name in the legend


def draw_repeats(
    curves: Sequence[pd.DataFrame],
    result: instron.Repeats | None,
    theory: pd.DataFrame | None,
    stem: Path,
) -> None:
    """Draw the averaged force of all logs thin, mean +- sd as a band, one in black, theory dashed.

    Writes ``stem`` as PNG and SVG. Logs in which combing did not end are dotted: they are in no
    mean. Triangles are jams; the dotted line is the end of combing, with D and the number of logs.
    """
    with paper_style():
        figure = Figure(figsize=(5.4, 4.2), layout="constrained")
        FigureCanvasAgg(figure)
        axes = figure.subplots()
        shown = curves[result.used[result.representative] if result else 0]
        others = [curve for curve in curves if curve is not shown]
        if result is not None:
            _draw_mean(axes, result)
        for ended, line in ((True, "-"), (False, ":")):
            some = [curve for curve in others if curve.attrs["ended"] is ended]
            said = "others" if ended else "combing did not end: in no mean"
            for number, curve in enumerate(some):
                axes.plot(*_averaged(curve), line, color="0.45", lw=0.5,
                          label=None if number else f"{said} (n = {len(some)})")  # fmt: skip
        axes.plot(*_averaged(shown), color=EXPERIMENT, lw=1.0, label=_short(shown))
        _mark_jams(axes, shown, others)
        _mark_end(axes, [c for c in curves if c.attrs["ended"]])
        if theory is not None:
            axes.plot(theory["x"], theory["f"], "--", color=THEORY, lw=1,
                      label="one helix stretched (Love)")  # fmt: skip
        axes.set(xlabel="$x = d/D$", ylabel="$f = l_0^2 F/B$", xlim=(0, BEYOND))
        axes.set_ylim(bottom=min(0.0, axes.get_ylim()[0]))
        figure.legend(loc="outside lower center", ncols=2)
        write_pictures(figure, stem, dpi=200)


def _averaged(curve: pd.DataFrame) -> tuple[np.ndarray, np.ndarray]:
    """Return x and f averaged over the curve's own length, as far as the log goes."""
    x = np.linspace(max(0.0, curve["x"].min()), min(BEYOND, curve["x"].max()), POINTS)
    return x, instron.on_grid(curve, x)


def _draw_mean(axes: Axes, result: instron.Repeats) -> None:
    grid, n = result.grid, len(result.used)
    axes.fill_between(grid["x"], grid["mean"] - grid["sd"], grid["mean"] + grid["sd"],
                      color=BAND, lw=0, alpha=0.6, label=f"mean ± sd (n = {n})")  # fmt: skip
    axes.plot(grid["x"], grid["mean"], color="0.3", lw=1.8, label=f"mean (n = {n})")


def _mark_jams(axes: Axes, shown: pd.DataFrame, others: Sequence[pd.DataFrame]) -> None:
    """Mark jams: filled those of the curve in black, hollow those of the others."""
    label: str | None = "jams"
    for curve, fill in ((shown, EXPERIMENT), *((other, "none") for other in others)):
        found = instron.events(curve)
        jams = found[found["kind"] == "jam"]
        if len(jams):
            axes.plot(
                jams["x"], jams["f"], "v", ms=4, mfc=fill, mec=EXPERIMENT, mew=0.6, label=label
            )
            label = None


def _mark_end(axes: Axes, ended: Sequence[pd.DataFrame]) -> None:
    """Mark x = 1 and say what D is there."""
    if not ended:
        return
    D = np.array([curve.attrs["D"] for curve in ended]) * 1e3
    said = f"D = {D[0]:.4g} mm" if len(D) == 1 else f"D = {D.mean():.4g} ± {D.std(ddof=1):.2g} mm"
    axes.axvline(1, color="0.4", lw=0.8, ls=(0, (1, 2)), label=f"end of combing, {said}")


def _short(curve: pd.DataFrame) -> str:
    name = str(curve.attrs.get("specimen", ""))
    half = LONGEST // 2
    return name if len(name) <= LONGEST else f"{name[: half - 1]}…{name[-half:]}"
