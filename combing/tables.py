"""Tidy CSV tables with ``#`` lines on top that say what the table is."""

import io
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Literal

import pandas as pd

from combing.errors import UserError


def read_table(path: Path, columns: Iterable[str]) -> pd.DataFrame:
    """Read a CSV table; lines that begin with ``#`` are comments, a ``#`` within a line is not.

    Raises
    ------
    UserError
        If the file is not a table or lacks one of `columns`.
    """
    try:
        lines = path.read_text(encoding="utf-8-sig").splitlines(keepends=True)
        text = "".join(line for line in lines if not line.startswith("#"))
        table = pd.read_csv(io.StringIO(text))
    except (pd.errors.ParserError, pd.errors.EmptyDataError, UnicodeDecodeError) as error:
        raise UserError(f"{path}: not a comma-separated table: {error}") from error
    missing = [column for column in columns if column not in table.columns]
    if missing:
        raise UserError(
            f"{path}: needs the column {missing[0]!r}; has {', '.join(map(str, table.columns))}"
        )
    return table


def write_table(path: Path, table: pd.DataFrame, about: Sequence[str] = ()) -> None:
    """Write a CSV table below comment lines, to a temporary name and then into place.

    Where a text holds ``#``, every cell is quoted: readers that know ``#`` as the beginning of a
    comment leave quoted ones alone.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    partial = path.with_name(f".{path.name}.partial")
    quoting: Literal[0, 1] = 1 if _holds_hash(table) else 0  # csv.QUOTE_ALL, csv.QUOTE_MINIMAL
    with partial.open("w", encoding="utf-8", newline="\n") as file:
        file.writelines(f"# {' '.join(line.split())}\n" for line in about)
        table.to_csv(file, index=False, float_format="%.7g", lineterminator="\n", quoting=quoting)
    partial.replace(path)


def _holds_hash(table: pd.DataFrame) -> bool:
    texts = [table[column] for column in table if not pd.api.types.is_numeric_dtype(table[column])]
    return any("#" in str(value) for column in texts for value in column.unique())
