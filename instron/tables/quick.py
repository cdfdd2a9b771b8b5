"""The quick way: rows of a clean table by pandas' C reader, and only if nothing is in doubt."""

import csv
import warnings
from dataclasses import replace
from typing import Any, BinaryIO, Literal

import numpy as np
import pandas as pd

from instron.numbers.marks import marks_of
from instron.numbers.numerals import Unclear, to_numbers
from instron.numbers.quotes import enclosed_commas
from instron.source.files import Source
from instron.source.stream import Unquoted
from instron.tables.blocks import repeated_blocks
from instron.tables.body import Body
from instron.tables.layout import Header, split_cells


def one_table(
    source: Source, start: int, header: Header, delimiter: str, first: str
) -> Body | None:
    """Return the body if the source is one clean table from byte ``start`` on, else None."""
    enclosed = None
    if source.survey.quoted and source.data.find(b'"', start) >= 0:
        enclosed = enclosed_commas(source.data, start, delimiter)
        if enclosed is None:
            return None
    marks = marks_of(source.data, start, delimiter, enclosed)
    if marks is None:
        return None
    source.release()
    table = _pandas(source, header, delimiter, marks, start, enclosed)
    if table is None or not isinstance(table.index, pd.RangeIndex):
        return None  # pandas makes an index of the first column where a row is too wide
    if any(table[i].dtype.kind not in "fi" for i in header.used()):
        return None
    values = {i: table[i].to_numpy(dtype=float, copy=False) for i in header.used()}
    if header.first_unnamed() in table and _filled(table[header.first_unnamed()]):
        return None
    if enclosed is not None and len(table) != _lines_from(source, start):
        return None
    if not _first_row_agrees(first, delimiter, marks[0], values):
        return None
    lines = range(header.first_row, header.first_row + len(table))
    return Body(header, values, lines, marks[0], marks[1] is not None)


def repeated_tables(source: Source, header: Header, delimiter: str) -> list[Body] | None:
    """Return the tables of a file in which one header comes again and again, else None.

    The rows of all are handed to the C reader at once.
    """
    blocks = repeated_blocks(source, header)
    if blocks is None:
        return None
    rows = b"".join(source.data[a:b] for a, b in blocks.bytes)
    joined = replace(source, data=rows, on_disk=False)
    whole = one_table(joined, 0, header, delimiter, source.head[header.first_row])
    counts = [stop - first for first, stop in blocks.lines]
    if whole is None or len(whole.lines) != sum(counts):
        return None
    bodies, start, above = [], 0, 0
    for (first, stop), count in zip(blocks.lines, counts, strict=True):
        moved = first - header.first_row
        units = None if header.units is None else header.units + moved
        there = replace(header, line=header.line + moved, first_row=first, units=units)
        values = {i: v[start : start + count] for i, v in whole.values.items()}
        bodies.append(
            Body(there, values, range(first, stop), whole.decimal, whole.thousands, above)
        )
        start, above = start + count, stop
    return bodies


def _filled(column: pd.Series) -> bool:
    """Tell whether a column without a name holds anything: cells were torn apart."""
    return bool((column.notna() & (column.astype(str) != "")).any())


def _pandas(
    source: Source,
    header: Header,
    delimiter: str,
    marks: tuple[str, str | None],
    start: int,
    enclosed: list[np.ndarray] | None,
) -> pd.DataFrame | None:
    """Return the C reader's table, or None where it stumbles, as at an empty cell.

    Only specimens side by side may have some, where one is shorter.
    """
    form: dict[str, Any] = {"na_filter": False, "dtype": dict.fromkeys(header.used(), float)}
    if len(header.specimens) > 1:
        form = {}
    try:
        with warnings.catch_warnings(), source.opened(start) as file:
            warnings.simplefilter("ignore")
            body, thousands, quoting = _unquoted(file, delimiter, marks, enclosed)
            table: pd.DataFrame = pd.read_csv(
                body,
                sep=r"\s+" if delimiter == "spaces" else delimiter,
                header=None,
                names=range(max(header.width, len(header.names))),
                decimal=marks[0],
                thousands=thousands,
                encoding_errors="replace",  # digits are ASCII; latin-1 is twice as slow
                engine="c",
                quoting=quoting,
                **form,
            )
            return table
    except (pd.errors.ParserError, pd.errors.EmptyDataError, ValueError):
        return None


def _unquoted(
    file: BinaryIO,
    delimiter: str,
    marks: tuple[str, str | None],
    enclosed: list[np.ndarray] | None,
) -> tuple[Any, str | None, Literal[0, 3]]:
    """Return a body as the C reader takes it fastest, its thousands mark and how it is quoted.

    Not to look for quotes saves a fifth. They stay where commas divide cells and are decimal marks
    as well: there they tell one from the other.
    """
    decimal, thousands = marks
    if enclosed is None:
        return file, thousands, csv.QUOTE_NONE
    if delimiter == decimal == ",":
        return file, thousands, csv.QUOTE_MINIMAL
    if delimiter == thousands == ",":
        return Unquoted(file, enclosed), None, csv.QUOTE_NONE
    return Unquoted(file), thousands, csv.QUOTE_NONE


def _lines_from(source: Source, start: int) -> int:
    """Count the lines of a body, without blank ones at its end."""
    tail = source.data[-1000:]
    blank = max(tail[len(tail.rstrip(b"\r\n")) :].count(b"\n") - 1, 0)
    return source.count - source.data[:start].count(b"\n") - blank


def _first_row_agrees(line: str, delimiter: str, mark: str, values: dict[int, np.ndarray]) -> bool:
    """Guard against a reader that counts the lines of the preamble differently (quoted breaks)."""
    cells = split_cells(line, delimiter)
    filled = {i: cells[i] for i in values if i < len(cells) and cells[i]}
    try:
        numbers, _ = to_numbers(list(filled.values()), mark)
    except Unclear:
        return False
    first = [values[i][0] for i in filled]
    return bool(np.allclose(first, numbers, rtol=1e-12, atol=0))
