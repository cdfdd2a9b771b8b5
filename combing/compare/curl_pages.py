"""Sections of the report on curls: what was counted, and what the densities hang on."""

from pathlib import Path

from combing.compare.comparison import Comparison
from combing.compare.curl_views import shares
from combing.figures.curl import draw_curls, draw_sensitivity
from combing.figures.style import save
from combing.report import Section
from combing.study import CurlSet, Study
from combing.tables import write_table

SEEN = (
    "The first photograph and the first simulation of the set, strands as they were counted; the "
    "simulated ones as a distant camera sees them, and in space."
)
SENSITIVE = (
    "The densities of the same curls cut into other numbers of sections, and of the simulated ones "
    "seen from other sides, the camera going round the vertical: how much of a difference between "
    "two curls is how they were cut or looked at. Means over curls."
)


def curl_sections(study: Study, found: Comparison, folder: Path) -> list[Section]:
    """Write figures and tables of every set of curls; return their sections."""
    return [
        section
        for number, one in enumerate(study.curl, start=1)
        if len(found.strands) and (found.strands["set"] == one.name).any()
        for section in (_seen(one, number, found, folder), _sensitive(one, number, found, folder))
    ]


def _seen(one: CurlSet, number: int, found: Comparison, folder: Path) -> Section:
    table, stem = found.strands[found.strands["set"] == one.name], f"curls_{number}"
    figure = draw_curls(table, first_photo(one, found), synthetic=found.synthetic)
    png, _ = save(figure, folder, stem, synthetic=found.synthetic)
    write_table(folder / f"{stem}.csv", table, [f"{one.name}: centrelines of strands; m"])
    return Section(f"Curls: {one.name}", [SEEN], png, "", f"{stem}.csv")


def _sensitive(one: CurlSet, number: int, found: Comparison, folder: Path) -> Section:
    table = found.sensitivity[found.sensitivity["set"] == one.name]
    stem = f"sensitivity_{number}"
    png, _ = save(draw_sensitivity(table, synthetic=found.synthetic), folder, stem,
                  synthetic=found.synthetic)  # fmt: skip
    write_table(folder / f"{stem}.csv", table, [f"{one.name}: density over sections and view; 1/m"])
    text = [SENSITIVE, *shares(table)]
    return Section(f"What densities hang on: {one.name}", text, png, "", f"{stem}.csv")


def first_photo(one: CurlSet, found: Comparison) -> Path | None:
    """Return the photograph of the first curl of a set that was measured, if any was."""
    strands = found.strands
    own = strands[(strands["set"] == one.name) & (strands["source"] == "experiment")]
    return next((path for path in one.photos if path.stem in set(own["sample"])), None)
