"""``combing demo``: the main job on the packaged synthetic data set."""

from collections.abc import Iterator
from pathlib import Path

import click
import pandas as pd

from combing.commands.compare import exit_with
from combing.spoken import said_aloud
from combing.study import load_study
from combing.virtual_lab.packaged import data_folder


@click.command()
@click.option(
    "-o",
    "--output",
    type=click.Path(path_type=Path),
    default=Path("combing-demo"),
    show_default=True,
    help="Folder for report.html, figures, tables and runs.",
)
@click.option("--jobs", type=click.IntRange(min=1), help="Simulations at once.  [default: cores]")
@click.option("--quiet", is_flag=True, help="Show no progress.")
def command(output: Path, jobs: int | None, quiet: bool) -> None:
    """Compare the virtual lab's photographs and force logs with simulations run here and now.

    Takes about three minutes on two cores, a good part of it compilation and simulation; prints
    how far every pipeline is from the truth, which is known because the data are synthetic.

    \b
    Example:
      combing demo -o demo/
    """
    study = load_study(data_folder() / "study.toml")
    from combing.compare import compare

    with said_aloud("combing", quiet=quiet):
        result = compare(study, output, jobs=jobs, quiet=quiet)
    for line in error_lines(result.errors):
        click.echo(line)
    click.echo(f"report: {result.report.resolve()}")
    exit_with(result.left_out)


def error_lines(errors: pd.DataFrame) -> Iterator[str]:
    """Say for every pipeline how far it is from the truth, one line each."""
    yield "against the virtual lab's truth (synthetic data):"
    peaks = errors[errors["quantity"] == "f_max"]
    relative = peaks["error"] / peaks["truth"]
    yield (
        f"  force peak f_max: {peaks['measured'].mean():.2f} measured, {peaks['truth'].mean():.2f} "
        f"true (means of {len(peaks)}); largest error {relative.abs().max():.2%}"
    )
    spread = errors.loc[errors["quantity"] == "λ(s), RMS", "error"].to_numpy(dtype=float)
    level = errors.loc[errors["item"].str.endswith("before"), "truth"].max()
    yield (
        f"  λ(s): RMS error {spread[0]:.2f} 1/m before the tine ({spread[0] / level:.2%} of λ), "
        f"{', '.join(f'{one:.1f}' for one in spread[1:])} 1/m ahead of the tine on its way"
    )
    behind = errors.loc[errors["quantity"].str.contains("behind the tine"), "error"] / level
    yield f"    over a pitch behind it {', '.join(f'{one:.1%}' for one in behind)} of λ before it"
    counts = errors[errors["quantity"].str.startswith("count")]
    total = counts[["measured", "truth"]].groupby(counts["quantity"], sort=False).sum()
    found = [
        f"{str(quantity).removeprefix('count, ')}: {row['measured']:.0f}/{row['truth']:.0f}"
        for quantity, row in total.sort_index(key=_by_number).iterrows()
    ]
    yield f"  N-body interactions, counted/true: {', '.join(found)}"


def _by_number(quantities: pd.Index) -> pd.Index:
    return quantities.str.extract(r"(\d+)", expand=False).astype(int)
