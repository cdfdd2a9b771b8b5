"""``combing paper``: the paper's force curves, costs and claims."""

from pathlib import Path

import click

from combing.commands.compare import exit_with
from combing.spoken import said_aloud


@click.command()
@click.option("-o", "--output", type=click.Path(path_type=Path, file_okay=False),
              default=Path("combing-paper"), show_default=True,
              help="Folder for study.toml, report.html, figures, tables and runs.")  # fmt: skip
@click.option("--quick", is_flag=True, help="Shorter helices and one run a value.")
@click.option("--jobs", type=click.IntRange(min=1), help="Simulations at once.  [default: cores]")
@click.option("--quiet", is_flag=True, help="Show no progress.")
def command(output: Path, quick: bool, jobs: int | None, quiet: bool) -> None:
    """Make the paper's figures of force: 2c, 2d, 3c, 3d, 4a to 4c, tine radius, friction; claims.

    The experiment is the virtual lab's (synthetic): specimens with friction and imperfections,
    combed on a machine with noise. A lab puts its own files into OUTPUT/study.toml and goes on with
    combing compare. Figures 1b, 1d, 2e, 3a, 3b and 3e are in the report of combing demo. Stopped,
    the same command goes on.

    \b
    Example:
      combing paper --quick -o paper/
    """
    from combing.paper import make_paper

    with said_aloud("combing", quiet=quiet):
        result = make_paper(output, quick=quick, jobs=jobs, quiet=quiet)
    click.echo(f"report: {result.report}")
    exit_with(result.left_out)
