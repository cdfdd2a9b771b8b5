"""What one comparison hands to the figures and the report."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field

import pandas as pd

import sim


@dataclass(frozen=True)
class Comparison:
    """The result of comparing one or several sets of the same kind.

    Attributes
    ----------
    plotted : DataFrame
        Every plotted number, tidy, with columns set and source.
    numbers : list of (caption, DataFrame)
        Tables for the report.
    errors : DataFrame
        What each pipeline measured beside the truth: columns set, item, quantity, measured,
        truth, error, unit; empty where no truth is known.
    notes : list of str
        What was left out or is doubtful, and why.
    synthetic : bool
        Whether the experiment says of itself that it is synthetic.
    curves : DataFrame
        What claims are decided by: one row a curve (`combing.compare.sweep.every_curve`) or a curl.
    change : DataFrame
        Of link densities: their change over s and across the tine
        (`combing.compare.link_change.changes`).
    strands, sensitivity : DataFrame
        Of curls: the centrelines that were counted, and the densities in other sections and views
        (`combing.compare.curl_views`).
    """

    plotted: pd.DataFrame
    numbers: list[tuple[str, pd.DataFrame]] = field(default_factory=list)
    errors: pd.DataFrame = field(default_factory=pd.DataFrame)
    notes: list[str] = field(default_factory=list)
    synthetic: bool = False
    curves: pd.DataFrame = field(default_factory=pd.DataFrame)
    change: pd.DataFrame = field(default_factory=pd.DataFrame)
    strands: pd.DataFrame = field(default_factory=pd.DataFrame)
    sensitivity: pd.DataFrame = field(default_factory=pd.DataFrame)


@dataclass(frozen=True)
class Findings:
    """All that the report is made of.

    Attributes
    ----------
    comparisons : dict
        One a kind of figure: force, sweep, link, interactions.
    runs : dict
        Finished runs by what the study calls their scenes.
    holdings : DataFrame
        How many files, specimens, photographs and runs every set has.
    left_out : list of str
        Sets and simulations that could not be used, and why.
    notes : list of str
        What else a reader should know of the study as a whole.
    """

    comparisons: dict[str, Comparison]
    runs: dict[str, sim.Run]
    holdings: pd.DataFrame
    left_out: list[str] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)


def joined(parts: Iterable[Comparison]) -> Comparison:
    """Put the comparisons of several sets under each other; tables of one caption are joined."""
    parts = list(parts)
    captions = list(dict.fromkeys(caption for part in parts for caption, _ in part.numbers))
    tables = [
        (
            wanted,
            pd.concat([t for part in parts for caption, t in part.numbers if caption == wanted]),
        )
        for wanted in captions
    ]
    return Comparison(
        plotted=pd.concat([part.plotted for part in parts], ignore_index=True),
        numbers=tables,
        errors=stacked(part.errors for part in parts),
        notes=[note for part in parts for note in part.notes],
        synthetic=any(part.synthetic for part in parts),
        curves=stacked(part.curves for part in parts),
        change=stacked(part.change for part in parts),
        strands=stacked(part.strands for part in parts),
        sensitivity=stacked(part.sensitivity for part in parts),
    )


def stacked(tables: Iterable[pd.DataFrame]) -> pd.DataFrame:
    """Put tables under each other, leaving out the empty ones."""
    filled = [table for table in tables if len(table)]
    return pd.concat(filled, ignore_index=True) if filled else pd.DataFrame()


def all_errors(comparisons: Mapping[str, Comparison]) -> pd.DataFrame:
    """Put the errors of all kinds of comparison under each other, with a column kind."""
    return stacked(found.errors.assign(kind=kind) for kind, found in comparisons.items())


def says_synthetic(facts: dict) -> bool:
    """Tell whether the metadata of a file says that its content is synthetic."""
    return "synthetic" in " ".join(f"{key} {value}" for key, value in facts.items()).lower()


def error_row(
    name: str, item: str, quantity: str, measured: float, truth: float, unit: str
) -> dict[str, object]:
    """Return one line of the table of errors against truth."""
    return {
        "set": name,
        "item": item,
        "quantity": quantity,
        "measured": measured,
        "truth": truth,
        "error": measured - truth,
        "unit": unit,
    }
