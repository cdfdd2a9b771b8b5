"""How every figure looks: experiment black on a grey band, simulation in colour, theory dashed."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import matplotlib as mpl
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

EXPERIMENT = "black"
BAND = "0.78"
SIMULATION = "#c8321e"
CAMERA = "#e8a33d"
THEORY = "#1f5fa8"
STRANDS = ["#c8321e", "#1f5fa8", "#3b8a3e", "#e8a33d", "#7a4b9a", "#666666"]  # one after another
WIDTH = 7.2  # inches: both columns of a journal page

STYLE: dict[Any, Any] = {
    "font.size": 9,
    "axes.titlesize": 9,
    "axes.labelsize": 10,
    "legend.fontsize": 8,
    "legend.frameon": False,
    "axes.linewidth": 0.8,
    "lines.linewidth": 1.2,
    "xtick.direction": "in",
    "ytick.direction": "in",
    "xtick.top": True,
    "ytick.right": True,
    "svg.fonttype": "none",
    "svg.hashsalt": "combing",
    "savefig.dpi": 200,
}


@contextmanager
def paper_style() -> Iterator[None]:
    """Draw inside with the house's settings; those outside stay as they were."""
    with mpl.rc_context(STYLE):
        yield


def new_figure(
    rows: int, columns: int, height: float, *, share: bool = False
) -> tuple[Figure, list[Axes]]:
    """Make a grid of panels, `height` inches a row; one panel alone is narrower."""
    width = WIDTH if columns > 1 else 0.7 * WIDTH
    figure = Figure(figsize=(width, height * rows + 0.5), layout="constrained")
    FigureCanvasAgg(figure)
    grid = figure.subplots(rows, columns, squeeze=False, sharex=share, sharey=share)
    return figure, list(grid.ravel())


def legend_above(figure: Figure, panel: Axes, columns: int) -> None:
    """Put the panel's legend above all panels, where it hides nothing."""
    figure.legend(*panel.get_legend_handles_labels(), loc="outside upper center", ncols=columns)


def plain(text: str) -> str:
    """Return a user's text so that nothing in it is taken for a formula, nor hidden in a legend."""
    return text.replace("$", r"\$").lstrip("_") or text


def mark_synthetic(figure: Figure, synthetic: bool) -> None:
    """Say in the figure itself that its experiment comes from the virtual lab."""
    if synthetic:
        text = "experiment: synthetic data (virtual lab)"
        figure.supxlabel(text, x=0.995, ha="right", fontsize=7, color="0.35", style="italic")


def write_pictures(figure: Figure, stem: Path, dpi: int = 150) -> None:
    """Write ``stem.png`` and ``stem.svg``; the same figure gives the same files."""
    figure.savefig(stem.with_suffix(".png"), dpi=dpi)
    figure.savefig(stem.with_suffix(".svg"), metadata={"Date": None})


def save(figure: Figure, folder: Path, name: str, *, synthetic: bool) -> list[Path]:
    """Write ``name.png`` and ``name.svg``, with the origin of the data in their metadata."""
    origin = "synthetic data (virtual lab)" if synthetic else "measured data"
    paths = [folder / f"{name}.png", folder / f"{name}.svg"]
    with paper_style():
        figure.savefig(paths[0], metadata={"Title": name, "Description": origin})
        # A fixed date keeps the file of the same numbers the same.
        figure.savefig(paths[1], metadata={"Title": name, "Description": origin, "Date": None})
    return paths
