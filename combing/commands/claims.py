"""``combing claims``: what the paper says, held against a study that was carried out."""

import json
from pathlib import Path

import click
import pandas as pd

from combing.errors import UserError
from combing.tables import read_table


@click.command()
@click.argument("folder", type=click.Path(path_type=Path))
@click.option("--json", "as_json", is_flag=True, help="Print the table as JSON.")
def command(folder: Path, as_json: bool) -> None:
    """Hold the paper's claims against FOLDER, which `combing compare` wrote.

    What decides a claim and its threshold stand in combing/claims, one module each; the study
    needs [[sweep]] sets over what the claims are about (pi1, pi2, pi3, q, friction). A claim that
    the curves neither bear out nor contradict at 95 % is answered with "cannot tell".

    \b
    Example:
      combing claims out/
    after
      combing compare study.toml -o out/
    """
    from combing.claims import judge

    path = folder / "curves.csv"
    if not path.is_file():
        raise UserError(
            f"{path}: there is no such file; `combing compare` writes it for a study with [[sweep]]"
        )
    found = judge(read_table(path, ["set", "over", "source", "value", "f_max"]))
    if as_json:
        click.echo(json.dumps(json.loads(found.to_json(orient="records")), indent=1))
        return
    for _, row in found.iterrows():
        click.echo(spoken(row))


def spoken(row: pd.Series) -> str:
    """Say what became of a claim in two lines."""
    numbers = ""
    if pd.notna(row["value"]):
        interval = f" ({row['low']:.3g} to {row['high']:.3g})" if pd.notna(row["low"]) else ""
        numbers = f"; {row['quantity']}: {row['value']:.3g}{interval}, threshold {row['threshold']}"
    source = f", {row['source']}" if isinstance(row["source"], str) else ""
    return f"{str(row['verdict']).upper()}: {row['sentence']}\n  {row['set']}{source}{numbers}"
