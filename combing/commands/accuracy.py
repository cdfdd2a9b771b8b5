"""``combing accuracy``: what a smaller error costs, knob by knob."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure

HELP_OUTPUT = "Folder for accuracy.csv, curves.csv, ensemble.csv, peaks.csv, summary.txt, pictures."


@click.command()
@click.option("--quick", is_flag=True, help="Fewer and cheaper points: minutes instead of an hour.")
@click.option("-o", "--output", type=click.Path(path_type=Path), default=Path("combing-accuracy"),
              show_default=True, help=HELP_OUTPUT)  # fmt: skip
@click.option("--quiet", is_flag=True, help="No progress bar and no summary.")
def command(quick: bool, output: Path, quiet: bool) -> None:
    """Measure error against time for a cantilever, a capstan and the first jam of a double helix.

    Elements, step fraction, speed and contact stiffness are varied, each alone. Every point is
    kept in OUTPUT/points: called again, only what is missing is computed. docs/accuracy.md says
    what the numbers mean and which knob to turn.

    \b
    Example:
      combing accuracy --quick -o accuracy/
    """
    from combing.accuracy import study, teeth
    from combing.accuracy.points import measure_all
    from combing.accuracy.summary import summary

    series, longer = study.all_series(quick), study.all_teeth(quick)
    problems = [point for each in series for point in each.points] + list(longer.runs.values())
    results = measure_all(problems, output / "points", quiet=quiet)
    table = study.table(series, results)
    tables = {
        "curves": teeth.curves(longer, results),
        "ensemble": teeth.ensemble(longer, results),
        "peaks": teeth.peaks(longer, results),
    }
    lines = summary(table, tables["peaks"], teeth.parting(longer, results))
    _write(output, table, tables, lines)
    if not quiet:
        click.echo("\n".join([*lines, f"written to {output}"]))


def _write(
    output: Path, table: pd.DataFrame, tables: dict[str, pd.DataFrame], lines: list[str]
) -> None:
    from combing.accuracy import teeth
    from combing.accuracy.summary import about_machine
    from combing.figures.accuracy import draw_case, draw_front, draw_teeth
    from combing.tables import write_table
    from combing.tolerance import PRESETS, load_front, pareto
    from sim.records.files import replacing

    write_table(
        output / "accuracy.csv",
        table,
        [about_machine(), "seconds of processor time of one core; error relative; place [m]"],
    )
    for name, about in (
        ("curves", teeth.about()[1:]),
        ("ensemble", teeth.about()),
        (
            "peaks",
            ["f and place d [m] of the first jam and the highest tooth after it; highest f"],
        ),
    ):
        write_table(output / f"{name}.csv", tables[name], about)
    with replacing(output / "summary.txt") as temporary:
        temporary.write_text("\n".join(lines) + "\n", encoding="utf-8")
    _save(draw_case(table, "cantilever", "error of the deflection"), output / "cantilever.png")
    _save(draw_case(table, "capstan", "error of $T_2/T_1$"), output / "capstan.png")
    _save(draw_case(table, "first jam", "difference of $f$"), output / "jam.png")
    _save(draw_front(load_front(), pareto(load_front()), PRESETS), output / "front.png")
    _save(draw_teeth(tables["curves"], tables["ensemble"], tables["peaks"]), output / "teeth.png")


def _save(figure: Figure, path: Path) -> None:
    from combing.figures.style import paper_style
    from sim.records.files import replacing

    with replacing(path) as temporary, paper_style():
        figure.savefig(temporary, format="png", metadata={"Title": path.stem})
