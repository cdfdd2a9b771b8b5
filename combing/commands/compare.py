"""``combing compare``: photographs, force logs and simulations of a study side by side."""

import json
from collections.abc import Sequence
from pathlib import Path

import click

from combing.errors import SOME_LEFT_OUT
from combing.spoken import said_aloud
from combing.study import load_study


@click.command()
@click.argument("study", type=click.Path(path_type=Path))
@click.option(
    "-o",
    "--output",
    type=click.Path(path_type=Path),
    default=Path("out"),
    show_default=True,
    help="Folder for report.html, figures, tables and runs.",
)
@click.option("--jobs", type=click.IntRange(min=1), help="Simulations at once.  [default: cores]")
@click.option("--json", "as_json", is_flag=True, help="Print the summary as JSON.")
@click.option("--quiet", is_flag=True, help="Show no progress.")
def command(study: Path, output: Path, jobs: int | None, as_json: bool, quiet: bool) -> None:
    """Carry out STUDY: measure its photographs and logs, simulate its scenes, compare, draw.

    STUDY is a TOML file that names the files (docs/study.md); scenes that were simulated before
    into the same folder are not simulated again. A set that cannot be measured is left out, said
    and in the report; the others go on, and the exit code is 3.

    \b
    Example:
      combing compare study.toml -o out/
    where study.toml holds, say:
      title = "Nylon, P/r = 18"
      [[force]]
      name = "P/r = 18"
      logs = "instron/*.csv"
      rig = "rig.toml"
      simulation = "double_helix.toml"
    """
    chosen = load_study(study)
    from combing.compare import compare

    with said_aloud("combing", quiet=quiet or as_json):
        result = compare(chosen, output, jobs=jobs, quiet=quiet or as_json)
    if as_json:
        summary = json.loads((output / "summary.json").read_text(encoding="utf-8"))
        click.echo(json.dumps(summary | {"report": str(result.report)}, ensure_ascii=False))
    else:
        click.echo(f"report: {result.report}")
    exit_with(result.left_out)


def exit_with(left_out: Sequence[str]) -> None:
    """Say what was left out and why, and let the exit code tell."""
    for reason in left_out:
        click.echo(f"combing: left out: {reason}", err=True)
    if left_out:
        click.get_current_context().exit(SOME_LEFT_OUT)
