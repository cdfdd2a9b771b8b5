"""``combing entangle``: how entangled the strands of a run are."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from combing.errors import UserError

if TYPE_CHECKING:
    from combing.compare.entanglement import Tangle
    from sim import Run

NEAR = 1.05  # diameters between centrelines that touch: loads press strands together, meshes cut


@click.command()
@click.argument("path", metavar="RUN", type=click.Path(path_type=Path))
@click.option("-o", "--output", type=click.Path(path_type=Path, file_okay=False),
              default=Path("combing-entangle"), show_default=True,
              help="Folder of the tables and the figure.")  # fmt: skip
@click.option("--snapshot", type=int, default=-1, show_default=True,
              help="Which moment; -1 is the last, 0 the first.")  # fmt: skip
@click.option("--distance", type=click.FloatRange(min=0, min_open=True),
              help="Between centrelines that counts as a contact (m).  "
              "[default: 1.05 diameters]")  # fmt: skip
@click.option("--cell", type=click.FloatRange(min=0, min_open=True), default=5e-3,
              show_default=True, help="Edge of the cubes of the field (m).")  # fmt: skip
def command(path: Path, output: Path, snapshot: int, distance: float | None, cell: float) -> None:
    """Measure how the strands of RUN are entangled.

    Link and average crossing number of every pair, exact and as pictures from six sides show them;
    both along every strand and in space; contacts, and the clusters that they join strands to.

    \b
    Example:
      combing entangle curl/run.nc -o curl/entangled/
      combing entangle curl/run.nc --snapshot 0 -o curl/before/
    """
    import sim
    from combing.compare.entanglement import tangle_of

    run = sim.open_run(path)
    strands = _moment(run, path, snapshot)
    reach = distance or NEAR * 2 * max(rod.radius for rod in run.scene.rods)
    found = tangle_of(strands, reach, cell)
    _write(
        output, found, f"{path.parent.name}/{path.name}, snapshot {snapshot}", len(strands), reach
    )
    for line in said(found):
        click.echo(line)
    click.echo(f"tables and figure: {output}")


def _moment(run: Run, path: Path, snapshot: int) -> list:
    """Return the strands of a snapshot, at least two of them."""
    count = len(run.times)
    if not -count <= snapshot < count:
        raise UserError(f"--snapshot {snapshot}: {path} has {count}, 0 to {count - 1}")
    strands = run.strands(snapshot)
    if len(strands) < 2:
        raise UserError(f"{path}: one strand alone is not entangled; needs two or more")
    return strands


def _write(output: Path, found: Tangle, what: str, n: int, reach: float) -> None:
    import numpy as np

    from combing.figures.entanglement import draw_entanglement
    from combing.figures.style import write_pictures
    from combing.tables import write_table

    tables = {
        "pairs": (found.pairs, "link, crossings in a mean direction, mean seen from six sides"),
        "views": (found.views, "crossings seen; degrees about the vertical, 0 looks along y"),
        "strands": (found.strands, "crossings with all others, own: with itself"),
        "along": (found.along, "m; crossings and link in 1/m"),
        "contacts": (found.contacts, f"m; nearer than {reach:.4g} m between centrelines"),
        "field": (found.field, "middles of cubes in m; crossings in 1/m^3, length in 1/m^2"),
    }
    for name, (table, about) in tables.items():
        write_table(output / f"{name}.csv", table, [what, about])
    crossings = np.zeros((n, n))
    at = found.pairs["strand_a"] - 1, found.pairs["strand_b"] - 1
    crossings[at] = found.pairs["crossings"]
    figure = draw_entanglement(found.along, crossings + crossings.T, found.views, what)
    write_pictures(figure, output / "entanglement")


def said(found: Tangle) -> list[str]:
    """Return the summary, line by line."""
    exact, seen = found.pairs["crossings"], found.views.groupby("degrees")["seen"].sum()
    clusters = found.strands["cluster"].value_counts()
    of_views = found.views.join(
        found.pairs.set_index(["strand_a", "strand_b"])["crossings"], on=["strand_a", "strand_b"]
    )
    single, mean = of_views["seen"].corr(of_views["crossings"]), found.pairs["seen"].corr(exact)
    return [
        f"{len(found.strands)} strands: {exact.sum():.4g} crossings between them in a mean "
        f"direction, {found.strands['own'].sum():.3g} of strands with themselves; "
        f"{exact.sum() * 2 / len(found.strands):.3g} a strand",
        f"pictures from {len(seen)} sides show {seen.min():.0f} to {seen.max():.0f}, on average "
        f"{seen.mean():.4g} ({seen.mean() / exact.sum():.0%}); pair by pair one picture correlates "
        f"with the exact value by {single:.2f}, the mean of all by {mean:.2f}",
        f"link between pairs: {found.pairs['link'].abs().sum():.3g} in all, "
        f"{found.pairs['link'].abs().max():.2g} at most",
        f"{len(found.contacts)} contacts, {found.strands['contacts'].mean():.3g} a strand; "
        f"{len(clusters)} clusters, the largest of {clusters.max()} strands",
    ]
