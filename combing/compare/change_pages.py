"""Sections of the report on the change of link density while the tine combs."""

from pathlib import Path

from combing.compare.comparison import Comparison
from combing.figures.change import draw_change
from combing.figures.style import save
from combing.report import Section
from combing.tables import write_table

TEXT = (
    "Δλ/λ0 = λ(s)/λ0 − 1 at every place of the tine, and the jump of λ across the tine over λ0. "
    "λ0 is the mean link density before combing, but for a pitch at either end. The jump is that "
    "of the means over one pitch, 1/λ0, on either side of the tine, the nearest quarter of a pitch "
    "left out, in photographs and simulations alike. The simulation's λ is averaged over one pitch."
)
CAPTION = (
    "Colour: the tine's place. Gaps are not resolved; a photograph without a jump shows no tine."
)


def change_sections(found: Comparison, folder: Path) -> list[Section]:
    """Write figure and table of every set with link densities; return a section for each."""
    if found.change.empty:
        return []
    return [
        _one(found, name, f"change_{number}", folder)
        for number, name in enumerate(found.change["set"].unique(), start=1)
    ]


def _one(found: Comparison, name: str, stem: str, folder: Path) -> Section:
    table = found.change[found.change["set"] == name]
    png, _ = save(draw_change(table, synthetic=found.synthetic), folder, stem,
                  synthetic=found.synthetic)  # fmt: skip
    write_table(folder / f"{stem}.csv", table, [f"{name}: change of link density; SI units"])
    return Section(f"Change of link density: {name}", [TEXT], png, CAPTION, f"{stem}.csv")
