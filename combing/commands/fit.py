"""``combing fit``: friction and bending rigidity from a lab's own logs."""

import json
from pathlib import Path
from typing import Any

import click

from combing.spoken import said_aloud


@click.command()
@click.argument("fit", type=click.Path(path_type=Path))
@click.option("-o", "--output", type=click.Path(path_type=Path, file_okay=False),
              default=Path("combing-fit"), show_default=True,
              help="Folder for fit.json, tables, the figure and runs/.")  # fmt: skip
@click.option("--jobs", type=click.IntRange(min=1), help="Simulations at once.  [default: cores]")
@click.option("--dry-run", is_flag=True, help="Only say what it would cost.")
@click.option("--json", "as_json", is_flag=True, help="Print what was found as JSON.")
@click.option("--quiet", is_flag=True, help="No progress and no summary.")
def command(
    fit: Path, output: Path, jobs: int | None, dry_run: bool, as_json: bool, quiet: bool
) -> None:
    """Estimate the friction coefficient and the bending rigidity from the logs that FIT names.

    FIT is a TOML file. Forces are fitted in newtons: f hides the rigidity, for it is scaled by it.

    \b
    Example:
      combing fit fit.toml -o fit/
    where fit.toml holds, say:
      logs = "pi18_*.csv"
      rig = "rig.toml"                # r and E; the factor multiplies its rigidity
      friction = [0.0, 0.4]           # range; evenly likely before
      factor = [0.02, 2.0]            # range; every ratio evenly likely before
      points = 48                     # simulated pairs of both ...
      seeds = 2                       # ... and specimens with imperfections at each
      [fixed]                         # the helix that was combed (combing simulate --help)
      pi1 = 18
      height = 0.15
      [link]                          # photographs, if there are: keys of a study's [[link]]
      photos = "photos/pi18_*.jpg"
      positions = [0.01, 0.03]
      marker_side = 0.008

    What it costs is said before it starts; whatever stops it, the same command goes on. The result
    is the joint posterior with its ridge: what the data do not tell is said. Needs scikit-learn
    (pip install "combing[fit]"). docs/fit.md has more.
    """
    from combing.fit import load_fit, make_fit
    from combing.fit.emulator import needs_sklearn
    from combing.fit.make import say_cost
    from combing.sweep import Store

    needs_sklearn()
    plan = load_fit(fit)
    with said_aloud("combing", quiet=quiet or as_json):
        if dry_run:
            say_cost(plan, Store(output), jobs)
            return
        found = make_fit(plan, output, jobs=jobs, quiet=quiet or as_json)
    if as_json:
        click.echo(json.dumps(found.facts, indent=1))
    elif not quiet:
        click.echo("\n".join([*spoken(found.facts), f"written to: {output}"]))


def spoken(facts: dict[str, Any]) -> list[str]:
    """Say what was found, a line each."""
    lines = [f"{facts['specimens']} specimens, {facts['photographs']} photographs"]
    for name in ("friction", "factor"):
        one = facts[name]
        lines.append(f"{name}: {one['value']:.3g} ({one['low']:.3g} to {one['high']:.3g}, 95 %)")
    lines.append(
        f"together: correlation {facts['correlation']:.2f}, 95 % region "
        f"{facts['region_share_of_prior']:.1%} of the prior, most likely at friction "
        f"{facts['best']['friction']:.3g}, factor {facts['best']['factor']:.3g}"
    )
    return lines + [f"note: {note}" for note in facts["notes"]]
