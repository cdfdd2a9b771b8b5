"""Figures, tables and the report of a comparison, written into one folder."""

import json
from collections.abc import Callable, Mapping
from datetime import UTC, datetime
from pathlib import Path

import pandas as pd
from matplotlib.figure import Figure

from combing import __version__
from combing.compare.change_pages import change_sections
from combing.compare.comparison import Comparison, Findings, all_errors
from combing.compare.curl_pages import curl_sections
from combing.compare.first_page import closing_section, found_section
from combing.compare.provenance import provenance
from combing.compare.provenance import tables as provenance_tables
from combing.compare.sweep_pages import outcome_sections, sweep_sections
from combing.figures.composite import draw_composite
from combing.figures.errors import draw_errors
from combing.figures.force import draw_force
from combing.figures.interactions import draw_interactions
from combing.figures.link import draw_link
from combing.figures.photographs import draw_photographs
from combing.figures.style import save
from combing.report import Section, write_report
from combing.runs import model_version
from combing.study import Study, tine_positions
from combing.tables import write_table

TEXT = {
    "force": (
        "Force of combing",
        "f = l0² F/B over x = d/D, both scaled by the same rules; D is where combing ends. "
        "Love's curve is the force that stretches one of the helices by the same displacement.",
        "Grey: mean ± standard deviation over repeats; black: the repeat nearest to all others; "
        "red: simulation; dashed: Love's single helix.",
    ),
    "link": (
        "Link density along the helix",
        "λ(s) is the link per length along the centreline of the pair, from the clamp. "
        "Photographs are measured by their strands' edges, the simulation by the topology of its "
        "strands in space, averaged over the length that the photograph resolves.",
        "Black: photograph ± standard deviation; red: simulation; vertical line: the tine; "
        "dotted: λ before the tine was inserted. Gaps are not resolved.",
    ),
    "interactions": (
        "N-body interactions in a curl",
        "The axis of the curl is cut into {n_sec} sections; strands that cross in a section are "
        "joined, and every group of N strands is one N-body interaction. The simulated strands "
        "are projected and counted by the same rule. The densities depend on the number of "
        "sections.",
        "Grey: photographs; red: simulation; dots: single curls; bars: standard deviation over "
        "curls, of one curl alone the 95 % interval over its sections.",
    ),
}
GLANCE = "The first set of every kind, experiment over simulation. Colours and bands as below."


def write_pages(study: Study, findings: Findings, folder: Path) -> None:
    """Write ``report.html``, ``summary.json``, and PNG, SVG and CSV of every figure."""
    comparisons = findings.comparisons
    sections = [
        section
        for kind, found in comparisons.items()
        for section in (
            sweep_sections(study, found, folder)
            if kind == "sweep"
            else [
                _section(study, kind, found, folder),
                *change_sections(found, folder),
                *curl_sections(study, found, folder),
            ]
        )
    ]
    sections += outcome_sections(comparisons, folder)
    synthetic = any(found.synthetic for found in comparisons.values())
    sections = [*found_section(comparisons), *_composite(comparisons, folder, synthetic), *sections]
    if findings.left_out:
        sections.insert(0, Section("Left out", findings.left_out))
    errors = all_errors(comparisons)
    if len(errors):
        sections.append(_error_section(errors, folder))
    if study.link or study.curl:
        sections.append(_photographs(study, folder, synthetic))
    origin = provenance(study)
    sections.append(_origin(findings, origin))
    sections.append(closing_section(comparisons, study.n_sec, model_version()))
    write_report(
        folder / "report.html",
        study.title,
        sections,
        about=f"combing {__version__}, {datetime.now(UTC):%Y-%m-%d %H:%M} UTC",
        footer="Every plotted number is in the CSV files beside this page.",
        synthetic=synthetic,
    )
    summary = _summary(study, findings, errors, synthetic) | {"provenance": origin}
    text = json.dumps(summary, indent=1, ensure_ascii=False)
    (folder / "summary.json").write_text(text, encoding="utf-8")


def _section(study: Study, kind: str, found: Comparison, folder: Path) -> Section:
    title, text, caption = TEXT[kind]
    figure = _drawers(study)[kind](found)
    png, _ = save(figure, folder, kind, synthetic=found.synthetic)
    origin = "synthetic experiment (virtual lab)" if found.synthetic else "measured experiment"
    write_table(folder / f"{kind}.csv", found.plotted, [f"{title}; {origin}; SI units"])
    paragraphs = [text.format(n_sec=study.n_sec)]
    data = f"{kind}.csv"
    return Section(title, paragraphs, png, caption, data, found.numbers, notes=found.notes)


def _composite(
    comparisons: Mapping[str, Comparison], folder: Path, synthetic: bool
) -> list[Section]:
    """Draw the first set of each of several kinds; of one kind its own figure is enough."""
    tables = {
        "change" if kind == "link" else kind: found.change if kind == "link" else found.plotted
        for kind, found in comparisons.items()
    }
    tables = {kind: table for kind, table in tables.items() if len(table)}
    if len(tables) < 2:
        return []
    png, _ = save(draw_composite(tables, synthetic=synthetic), folder, "composite",
                  synthetic=synthetic)  # fmt: skip
    return [Section("At a glance", (), png, GLANCE)]


def _drawers(study: Study) -> dict[str, Callable[[Comparison], Figure]]:
    return {
        "force": lambda one: draw_force(one.plotted, synthetic=one.synthetic),
        "link": lambda one: draw_link(one.plotted, synthetic=one.synthetic),
        "interactions": lambda one: draw_interactions(
            one.plotted, n_sec=study.n_sec, synthetic=one.synthetic
        ),
    }


def _error_section(errors: pd.DataFrame, folder: Path) -> Section:
    write_table(
        folder / "errors.csv",
        errors,
        ["measured beside true values; synthetic experiment (virtual lab); SI units"],
    )
    png, _ = save(draw_errors(errors), folder, "errors", synthetic=True)
    text = (
        "The experiment of this study is synthetic, so the truth behind every file is known. "
        "This is what the pipelines measured of it."
    )
    caption = "Measured over true values; the line is equality."
    return Section(
        "Errors against truth", [text], png, caption, "errors.csv", _error_tables(errors)
    )


def _error_tables(errors: pd.DataFrame) -> list[tuple[str, pd.DataFrame]]:
    columns = ["item", "quantity", "measured", "truth", "error", "unit"]
    return [
        (TEXT[kind][0], errors.loc[errors["kind"] == kind, columns])
        for kind in TEXT
        if (errors["kind"] == kind).any()
    ]


def _photographs(study: Study, folder: Path, synthetic: bool) -> Section:
    photos = {}
    for link in study.link:
        if link.before is not None:
            photos["before the tine"] = link.before
        places = zip(link.photos, tine_positions(link), strict=True)
        photos |= {f"{path.stem}\n$d$ = {d * 1e3:.0f} mm": path for path, d in places}
    photos |= {path.stem: path for curl in study.curl for path in curl.photos}
    figure = draw_photographs(photos, synthetic=synthetic)
    png, _ = save(figure, folder, "photographs", synthetic=synthetic)
    return Section("Photographs", (), png, "What was measured, scaled down.")


def _origin(findings: Findings, origin: dict) -> Section:
    rows = [
        {
            "scene": name,
            "rods": len(run.scene.rods),
            "steps": int(run.data.attrs["steps"]),
            "time step (s)": float(run.data.attrs["time_step_s"]),
            "wall time (s)": float(run.data.attrs["wall_time_s"]),
            "seed": run.scene.seed,
        }
        for name, run in findings.runs.items()
    ]
    tables = [("What each set holds", findings.holdings), ("Runs", pd.DataFrame(rows))]
    tables += provenance_tables(origin)
    return Section("Where the numbers come from", (), tables=tables, notes=findings.notes)


def _summary(study: Study, findings: Findings, errors: pd.DataFrame, synthetic: bool) -> dict:
    comparisons = findings.comparisons
    tables = {
        kind: {caption: _records(table) for caption, table in found.numbers}
        for kind, found in comparisons.items()
    }
    notes = [note for found in comparisons.values() for note in found.notes]
    return {
        "title": study.title,
        "synthetic": synthetic,
        "n_sec": study.n_sec,
        "solver": model_version(),
        "sets": _records(findings.holdings),
        "left_out": findings.left_out,
        "tables": tables,
        "errors": _records(errors),
        "notes": notes + findings.notes,
    }


def _records(table: pd.DataFrame) -> list[dict]:
    """Rows as plain data; what is not a number becomes null, for JSON knows no NaN."""
    return json.loads(table.to_json(orient="records"))
