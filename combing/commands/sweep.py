"""``combing sweep``: many simulations from one file."""

import json
import re
from pathlib import Path

import click
import pandas as pd

from combing.errors import SOME_LEFT_OUT

STATES = ("done", "failed", "missing")


class Part(click.ParamType):
    """A share of the work as i/n, from 1/n to n/n."""

    name = "i/n"

    def convert(
        self, value: object, param: click.Parameter | None, ctx: click.Context | None
    ) -> tuple[int, int]:
        """Return (i, n)."""
        found = re.fullmatch(r"(\d+)/(\d+)", str(value))
        if not found or not 1 <= int(found[1]) <= int(found[2]):
            self.fail(f"{value!r}: expected i/n with i from 1 to n, for example 3/20", param, ctx)
        return int(found[1]), int(found[2])


@click.command()
@click.argument("sweep", type=click.Path(path_type=Path))
@click.option("-o", "--output", type=click.Path(path_type=Path, file_okay=False),
              default=Path("combing-sweep"), show_default=True,
              help="Folder for points.csv and runs/.")  # fmt: skip
@click.option("--part", type=Part(), default="1/1",
              help="Simulate this share of the points, e.g. 3/20 in a job array.")  # fmt: skip
@click.option("--jobs", type=click.IntRange(min=1), help="Simulations at once.  [default: cores]")
@click.option("--scheduler", metavar="ADDRESS",
              help="A dask scheduler, tcp://HOST:PORT, to simulate on its workers.")  # fmt: skip
@click.option("--retry", is_flag=True, help="Also simulate points again that became unstable.")
@click.option("--dry-run", is_flag=True, help="Only list the points and their state.")
@click.option("--json", "as_json", is_flag=True, help="Print the table as JSON.")
@click.option("--quiet", is_flag=True, help="No progress and no summary.")
def command(
    sweep: Path,
    output: Path,
    part: tuple[int, int],
    jobs: int | None,
    scheduler: str | None,
    retry: bool,
    dry_run: bool,
    as_json: bool,
    quiet: bool,
) -> None:
    """Simulate every point of SWEEP, a TOML file, that OUTPUT does not hold yet.

    \b
    Example:
      combing sweep sweep.toml -o pitch/
    where sweep.toml holds, say:
      preset = "double_helix"
      seeds = 5                       # five of each, with imperfections; left out: one, as drawn
      [fixed]
      height = 0.06                   # m
      [grid]                          # every combination
      pi1 = [14, 18, 24, 36, 48]
      friction = [0.0, 0.2]

    \b
    [list] takes values side by side, the first with the first. [latin] takes points of a Latin
    hypercube:
      [latin]
      points = 50
      pi1 = [14, 48]                  # lowest, highest
      friction = [0.0, 0.3]

    tolerance = "3%" chooses mesh, step, speed and stiffness of every point, and verifies its first
    member by a second run.

    Every point is one file, named by a hash of its parameters and of the solver, and written when
    it is whole: whatever stops the command, the same command goes on. A point that fails is
    recorded with its reason, the others go on, and the exit code is 3. docs/sweep.md has more.
    """
    from combing.study.load import load_sweep
    from combing.sweep import Store, run_sweep

    chosen = load_sweep(sweep)
    if dry_run:
        table = Store(output).table(chosen.members(), chosen.varied)
    else:
        start = None
        if scheduler is not None:
            from combing.sweep.cluster import cluster

            start = cluster(scheduler)
        table = run_sweep(
            chosen, output, part=part, jobs=jobs, retry=retry, quiet=quiet or as_json, start=start
        )
    _say(table, output, as_json, quiet)
    if (table["state"] == "failed").any():
        click.get_current_context().exit(SOME_LEFT_OUT)


def _say(table: pd.DataFrame, output: Path, as_json: bool, quiet: bool) -> None:
    if as_json:
        click.echo(json.dumps(json.loads(table.to_json(orient="records")), indent=1))
        return
    for _, row in table[table["state"] == "failed"].iterrows():
        click.echo(f"combing: {row['file']} failed: {row['reason']}", err=True)
    if not quiet:
        if "held" in table and (off := (table["held"] == "no").sum()):
            click.echo(f"{off} points exceed the tolerance: force_error, link_error in the table")
        count = table["state"].value_counts()
        parts = [
            f"{count[state]} {state}" for state in ("done", "failed", "missing") if state in count
        ]
        click.echo(f"{len(table)} points: {', '.join(parts)}; in {output}")
