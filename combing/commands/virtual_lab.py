"""``combing virtual-lab``: make the synthetic data set."""

import os
from pathlib import Path

import click


@click.command()
@click.option(
    "-o",
    "--output",
    type=click.Path(path_type=Path, file_okay=False),
    required=True,
    help="Folder of the data set.",
)
@click.option(
    "--runs",
    type=click.Path(path_type=Path, file_okay=False),
    help="Folder that keeps the specimens' runs.  [default: OUTPUT-runs]",
)
@click.option("--jobs", type=click.IntRange(min=1), help="Simulations at once.  [default: cores]")
@click.option("--quiet", is_flag=True, help="Show no progress.")
def command(output: Path, runs: Path | None, jobs: int | None, quiet: bool) -> None:
    """Make a small synthetic data set with its truth: photographs, machine exports, scenes.

    Nine specimens are simulated, combed and photographed; this takes about 15 minutes on two
    cores. Called again, it goes on where it stopped. Needs pip install "combing[render]".

    \b
    Example:
      combing virtual-lab -o lab/
      combing compare lab/study.toml -o out/
    """
    from combing.virtual_lab.lab import make

    if not quiet:
        click.echo(f"9 specimens on {jobs or os.cpu_count()} cores; about 15 minutes on two cores")
    make(output, runs or output.with_name(f"{output.name}-runs"), jobs=jobs, quiet=quiet)
    click.echo(f"data set: {output}")
