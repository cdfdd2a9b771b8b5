"""Cost of combing over the length of a stroke, for several weights of pain against time."""

import matplotlib as mpl
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from combing.figures.style import legend_above, mark_synthetic, new_figure, paper_style, plain


def draw_cost(table: pd.DataFrame, *, synthetic: bool) -> Figure:
    """Draw one panel a source: C(q) of every gamma with its interval, a ring at the optimum.

    Parameters
    ----------
    table : DataFrame
        Columns set, source, gamma, q, cost, low, high, best (`combing.cost.cost_table`).
    synthetic : bool
        Whether the experiment comes from the virtual lab.
    """
    groups = list(table.groupby(["set", "source"], sort=False))
    with paper_style():
        figure, panels = new_figure(-(-len(groups) // 2), min(2, len(groups)), 2.6)
        for panel, ((name, source), rows) in zip(panels, groups, strict=False):
            _draw(panel, rows)
            panel.set_title(f"{plain(str(name))}, {source}", loc="left")
            panel.set(xlabel="pitches below the tine, $q$", ylabel="cost $C$")
        for panel in panels[len(groups) :]:
            panel.remove()
        legend_above(figure, panels[0], 5)
        mark_synthetic(figure, synthetic)
    return figure


def _draw(panel: Axes, rows: pd.DataFrame) -> None:
    shades = mpl.colormaps["plasma"]
    for gamma in rows["gamma"].unique():
        one, colour = rows[rows["gamma"] == gamma], shades(0.85 * float(gamma))
        panel.fill_between(one["q"], one["low"], one["high"], color=colour, alpha=0.2, lw=0)
        panel.plot(one["q"], one["cost"], ".-", color=colour, label=rf"$\gamma$ = {gamma:g}")
        best = one[one["q"] == one["best"]]
        panel.plot(best["q"], best["cost"], "o", ms=8, mfc="none", color=colour)
    panel.set_ylim(bottom=0)
