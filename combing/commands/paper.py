"""``combing paper``: the paper's figures by their numbers, costs and claims."""

from pathlib import Path

import click

from combing.commands.compare import exit_with
from combing.spoken import said_aloud


@click.command()
@click.option("-o", "--output", type=click.Path(path_type=Path, file_okay=False),
              default=Path("combing-paper"), show_default=True,
              help="Folder for study.toml, figures, report.html, tables and runs.")  # fmt: skip
@click.option("--quick", is_flag=True,
              help="Shorter helices, one run a value, few photographs.")  # fmt: skip
@click.option("--jobs", type=click.IntRange(min=1), help="Simulations at once.  [default: cores]")
@click.option("--quiet", is_flag=True, help="Show no progress.")
def command(output: Path, quick: bool, jobs: int | None, quiet: bool) -> None:
    """Make the paper's figures: 1b, 1d, 2c to 2e, 3a to 3e, 4a to 4c; and hold its claims.

    Each is a PNG, an SVG and a CSV in OUTPUT/figures; OUTPUT/paper.html shows them all,
    OUTPUT/report.html has tables, claims and notes. The experiment is the virtual lab's
    (synthetic): specimens with friction and imperfections, combed on a machine with noise, and the
    packaged photographs. A lab puts its own files into OUTPUT/study.toml and calls the command
    again. Stopped, the same command goes on.

    \b
    Example:
      combing paper --quick -o paper/
    """
    from combing.paper import make_paper

    with said_aloud("combing", quiet=quiet):
        result = make_paper(output, quick=quick, jobs=jobs, quiet=quiet)
    click.echo(f"figures: {output / 'paper.html'}")
    click.echo(f"report: {result.report}")
    exit_with(result.left_out)
