"""Tidy CSV tables with ``#`` lines on top that say what the table is."""

from collections.abc import Iterable, Sequence
from pathlib import Path

import pandas as pd

from combing.errors import UserError


def read_table(path: Path, columns: Iterable[str]) -> pd.DataFrame:
    """Read a CSV table with ``#`` comments.

    Raises
    ------
    UserError
        If the file is not a table or lacks one of `columns`.
    """
    try:
        table = pd.read_csv(path, comment="#")
    except (pd.errors.ParserError, pd.errors.EmptyDataError, UnicodeDecodeError) as error:
        raise UserError(f"{path}: not a comma-separated table: {error}") from error
    missing = [column for column in columns if column not in table.columns]
    if missing:
        raise UserError(
            f"{path}: needs the column {missing[0]!r}; has {', '.join(map(str, table.columns))}"
        )
    return table


def write_table(path: Path, table: pd.DataFrame, about: Sequence[str] = ()) -> None:
    """Write a CSV table below comment lines, to a temporary name and then into place."""
    path.parent.mkdir(parents=True, exist_ok=True)
    partial = path.with_name(f".{path.name}.partial")
    with partial.open("w", encoding="utf-8", newline="\n") as file:
        file.writelines(f"# {line}\n" for line in about)
        table.to_csv(file, index=False, float_format="%.7g", lineterminator="\n")
    partial.replace(path)
