"""Figures of the interactions: histogram of one photograph, kymograph of a sequence."""

import numpy as np
import pandas as pd
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator


def histogram(densities: pd.DataFrame, unit: str) -> Figure:
    """Draw N-body densities with their intervals (the paper's Fig. 1d).

    Parameters
    ----------
    densities : DataFrame
        From `imaging.densities`.
    unit : str
        Of the density's length: "m" or "px".
    """
    shown = densities[densities["N"] <= max(densities["N"][densities["count"] > 0].max(), 5)]
    figure = Figure(figsize=(4.2, 3.2))
    axes = figure.add_axes((0.2, 0.16, 0.77, 0.74))  # fixed: a layout engine takes longer to draw
    error = np.stack([shown["density"] - shown["low"], shown["high"] - shown["density"]])
    axes.bar(shown["N"], shown["density"], color="#4878a8", width=0.7)
    axes.errorbar(shown["N"], shown["density"], error, fmt="none", ecolor="black", capsize=3)
    axes.set_xlabel("strands in one interaction, N")
    axes.set_ylabel(rf"$\rho_N$ (1/{unit})")
    axes.set_xticks(shown["N"])
    axes.set_title(f"{densities.attrs['n_sec']} sections, 95 % Poisson intervals", fontsize=9)
    return figure


def kymograph(found: pd.DataFrame) -> Figure:
    """Draw, section by section, how many strands interact in each photograph of a sequence.

    Parameters
    ----------
    found : DataFrame
        Columns ``photo``, ``section``, ``N``, ``count``; photographs in the order of the sequence.
    """
    weighted = found.assign(strands=found["N"] * found["count"])
    table = weighted.pivot_table(
        index="section", columns="photo", values="strands", aggfunc="sum", sort=False
    ).sort_index()
    figure = Figure(figsize=(min(2.5 + 0.25 * table.shape[1], 9), 3.4), layout="constrained")
    axes = figure.add_subplot()
    picture = axes.imshow(table, aspect="auto", cmap="cividis", interpolation="nearest", vmin=0)
    axes.set_yticks([0, len(table) - 1], [str(table.index[0]), str(table.index[-1])])
    axes.set_ylabel("section, from the roots")
    few = np.unique(np.linspace(0, table.shape[1] - 1, 12).round().astype(int))
    axes.set_xticks(few, [table.columns[i] for i in few], rotation=60, ha="right", fontsize=7)
    axes.set_title("strands in interactions", fontsize=9)
    figure.colorbar(picture, ax=axes, ticks=MaxNLocator(integer=True))
    return figure
