"""The study in a few lines of text."""

from __future__ import annotations

import math
import platform
from collections.abc import Iterator
from importlib import metadata

import pandas as pd

from combing.accuracy.teeth import Parting
from combing.power_law import slope


def summary(table: pd.DataFrame, peaks: pd.DataFrame, parting: Parting) -> list[str]:
    """Return the lines of the summary.

    Parameters
    ----------
    table : DataFrame
        As `study.table` returns it.
    peaks : DataFrame
        As `teeth.peaks` returns it.
    parting : Parting
        How far unperturbed runs part.
    """
    return [about_machine(), "", *_knobs(table), "", *_teeth(peaks, parting)]


def about_machine() -> str:
    """Say what computed the numbers."""
    versions = ", ".join(f"{name} {metadata.version(name)}" for name in ("numba", "numpy"))
    return f"{platform.machine()}, Python {platform.python_version()}, {versions}"


def _knobs(table: pd.DataFrame) -> Iterator[str]:
    yield "largest and smallest error of each knob turned alone; slope of error over knob:"
    for (case, knob), rows in table.groupby(["case", "knob"], sort=False):
        yield (
            f"  {case:18s} {knob:10s} {rows['value'].min():g} to {rows['value'].max():g}: error "
            f"{_percent(rows['error'].abs().max())} to {_percent(rows['error'].abs().min())}, "
            f"{_law(rows)}, time x {rows['relative_time'].max():.1f}{_unstable(rows)}"
        )


def _law(rows: pd.DataFrame) -> str:
    found = slope(rows)
    return "no power law" if math.isnan(found) else f"slope {found:z.1f}"


def _unstable(rows: pd.DataFrame) -> str:
    lost = rows.loc[rows["quantity"].isna(), "value"]
    return f"; nothing at {', '.join(f'{value:g}' for value in lost)}" if len(lost) else ""


def _teeth(peaks: pd.DataFrame, parting: Parting) -> Iterator[str]:
    yield (
        "the same combing on two meshes and at two speeds, RMS difference over mean f: "
        f"{_percent(parting.before)} up to the first jam, {_percent(parting.after)} after it"
    )
    seeds = peaks[peaks["run"].str.startswith("seed")]
    for name, column in (("first jam", "first"), ("highest later tooth", "later")):
        yield (
            f"ensemble of {len(seeds)}: {name} f {_spread(seeds[column])}, at d = "
            f"{_spread(1e3 * seeds[f'{column}_place'])} mm"
        )
    yield f"ensemble of {len(seeds)}: f_max {_spread(seeds['f_max'])}"


def _spread(values: pd.Series) -> str:
    return f"{values.mean():.2f} ± {values.std():.2f} ({values.min():.2f} to {values.max():.2f})"


def _percent(value: float) -> str:
    return "-" if math.isnan(value) else f"{100 * value:.2g} %"
