"""Sections of the report on sets of several values: curves, what strokes cost, claims."""

from collections.abc import Mapping
from pathlib import Path

from combing.claims import judge
from combing.compare.comparison import Comparison, stacked
from combing.cost import cost_of_strokes
from combing.ensemble import IMPERFECTION
from combing.figures.cost import draw_cost
from combing.figures.style import save
from combing.figures.sweep import draw_sweep
from combing.report import Section
from combing.study import Study, SweepSet
from combing.tables import write_table

CURVES = (
    "f = l0² F/B over x = d/D, colour by the value. Bands are mean ± standard deviation over "
    "repeats or over an ensemble of simulations: pitch, phase of the second strand and "
    "intrinsic curvature off by draws of {size} (of itself, of half a turn, of the helix's "
    "own). Beside them the mean of the highest forces with its 95 % interval over curves."
)
CURVES_CAPTION = (
    "Black: the one curve nearest to all others of its value; dashed: Love's single helix."
)
COST = (
    "C(q) = γ f_max + (1 − γ) q0/q with q0 = 25: the highest force against the number of strokes, "
    "for strokes that begin q pitches from the free end. Intervals at 95 % are Student's, over the "
    "curves of each q."
)
COST_CAPTION = "Rings: the best q of each γ."
CLAIMS = (
    "Each claim is decided by a quantity and a threshold that were stated before (combing/claims). "
    "It holds where the whole 95 % interval is on its side of the threshold, does not hold where "
    "all of it is on the other, and else one cannot tell."
)


def sweep_sections(study: Study, found: Comparison, folder: Path) -> list[Section]:
    """Write figure and table of every set of several values; return a section for each."""
    return [
        _one(one, f"sweep_{number}", found, folder)
        for number, one in enumerate(study.sweep, start=1)
        if (found.plotted["set"] == one.name).any()
    ]


def _one(one: SweepSet, stem: str, found: Comparison, folder: Path) -> Section:
    plotted = found.plotted[found.plotted["set"] == one.name]
    figure = draw_sweep(plotted, synthetic=found.synthetic)
    png, _ = save(figure, folder, stem, synthetic=found.synthetic)
    write_table(folder / f"{stem}.csv", plotted, [f"{one.name}, over {one.over}; SI units"])
    numbers = [
        (label, table[table["set"] == one.name].dropna(axis=1, how="all"))
        for label, table in found.numbers
        if (table["set"] == one.name).any()
    ]
    notes = [note for note in found.notes if note.startswith(f"{one.name}, ")]
    text = CURVES.format(size=f"{one.fixed.get('imperfection', IMPERFECTION):.0%}")
    return Section(one.name, [text], png, CURVES_CAPTION, f"{stem}.csv", numbers, notes=notes)


def outcome_sections(comparisons: Mapping[str, Comparison], folder: Path) -> list[Section]:
    """Write ``curves.csv``, ``claims.csv`` and the cost; return their sections."""
    curves = stacked(found.curves for found in comparisons.values())
    if curves.empty:
        return []
    about = "one row a curve or a curl; f_max and w scaled, D in m, link over lambda_0"
    write_table(folder / "curves.csv", curves, [about])
    verdicts = judge(curves)
    write_table(folder / "claims.csv", verdicts, ["the paper's claims; intervals at 95 %"])
    table = [("Verdicts", verdicts.drop(columns=["claim", "where"]))]
    cost = _cost(comparisons["sweep"], folder) if "sweep" in comparisons else []
    return [*cost, Section("Claims of the paper", [CLAIMS], tables=table)]


def _cost(found: Comparison, folder: Path) -> list[Section]:
    plotted = cost_of_strokes(found.curves)
    if plotted.empty:
        return []
    write_table(folder / "cost.csv", plotted, ["cost of combing; intervals at 95 % over curves"])
    figure = draw_cost(plotted, synthetic=found.synthetic)
    png, _ = save(figure, folder, "cost", synthetic=found.synthetic)
    best = plotted.drop_duplicates(["set", "source", "gamma"])
    best = best[["set", "source", "gamma", "best", "best_low", "best_high"]]
    shown = [("Best length of a stroke (pitches)", best)]
    return [Section("Cost of combing", [COST], png, COST_CAPTION, "cost.csv", shown)]
