"""The rows under a header, as numbers: a quick way for clean tables, an exact way for the rest.

The quick way hands the file to pandas' C reader and accepts the answer only when every used column
came out numeric and complete. Everything else (several tables, thousands, damage) is walked line
by line, so that a refusal can name the line.
"""

import re
import warnings
from dataclasses import dataclass, field, replace
from itertools import pairwise
from typing import Any

import numpy as np
import pandas as pd

from instron.errors import Unreadable
from instron.headings.columns import Told
from instron.numbers.bits import at, bits, pieces
from instron.numbers.marks import QUOTE, TORN, marks_of
from instron.numbers.numerals import Unclear, decimal_mark, looks_numeric, to_numbers
from instron.source.files import Source, refuse_lone_returns
from instron.tables.blocks import (
    WORDY,
    goes_on,
    is_other_heading,
    is_word_between,
    marks_above,
    repeated_blocks,
)
from instron.tables.footer import (
    begins_otherwise,
    ends_oddly,
    ends_rows,
    is_short,
    is_statistic,
    is_trailer,
    starts_short,
)
from instron.tables.layout import (
    Header,
    find_header,
    is_blank,
    is_row,
    quotes_are_torn,
    split_cells,
)

BLOCK_HEAD = 8  # lines from the end of a block's rows to the names of the next
_PLAIN_ROW = re.compile(r"[\s\d.,;|+\-eE\"]*\d[\s\d.,;|+\-eE\"]*")
# Two quotes at a digit: an empty cell has marks on both sides, a doubled quote stands in words.
_QUOTED_WITHIN = re.compile(r'[\d.]""|""[-+\d.]')


@dataclass
class Body:
    """The numbers of the used columns (keyed by column index), and how they were written."""

    header: Header
    values: dict[int, np.ndarray]
    lines: range | list[int] | np.ndarray  # of the file, from 0, of every row
    decimal: str = "."
    thousands: bool = False
    above: int = 0  # line at which the text above the header starts
    cut: int | None = None  # line that the file's end cuts
    label: str = ""  # of its specimen, where a column tells
    parts: list["Body"] = field(default_factory=list)  # blocks that make up one test
    warnings: list[str] = field(default_factory=list)


def read_bodies(source: Source, header: Header, delimiter: str, told: Told) -> list[Body]:
    """Return the tables of a file: one per header that rows of numbers follow."""
    refuse_lone_returns(source, max(header.line, 0))
    whole = _last_line_is_whole(source, header, delimiter)
    whole = whole and not ends_oddly(source, source.line(header.first_row), delimiter)
    whole = whole and not starts_short(source, header.first_row, delimiter, header.used())
    if whole and not _words_within(source, header):
        start = source.offset(header.first_row)
        quick = _quick(source, start, header, delimiter, source.head[header.first_row])
        if quick is not None:
            return [quick]
    repeated = _repeated(source, header, delimiter) if whole else None
    if repeated is not None:
        return repeated
    bodies = []
    for block, rows, cut in _walk(source, header, delimiter, told):
        bodies.append(_exact(source, block, rows, delimiter))
        bodies[-1].warnings.extend(_lacking(source, rows, delimiter, block.used()))
        gaps = (source.lines[a + 1 : b] for a, b in pairwise(rows) if b - a > 1)
        marks = sum(not all(map(is_blank, gap)) for gap in gaps)
        if marks:
            note = f"{marks + 1} blocks without headings of their own read as one test"
            bodies[-1].warnings.append(note)
        bodies[-1].above = bodies[-2].lines[-1] + 1 if len(bodies) > 1 else 0
        if cut is not None:
            bodies[-1].cut = cut
            bodies[-1].warnings.append(
                f"line {cut + 1}: the file stops inside this row; 1 row lost, {len(rows)} kept"
            )
    return bodies


def _words_within(source: Source, header: Header) -> bool:
    """Tell whether the head shows lines of words among rows of numbers."""
    rows = source.head[header.first_row :]
    return not WORDY.match(rows[0]) and any(map(WORDY.match, rows))


def _repeated(source: Source, header: Header, delimiter: str) -> list[Body] | None:
    """Return the tables of a file in which one header comes again and again, else None.

    The rows of all are handed to the C reader at once.
    """
    blocks = repeated_blocks(source, header)
    if blocks is None:
        return None
    rows = b"".join(source.data[a:b] for a, b in blocks.bytes)
    joined = replace(source, data=rows, on_disk=False)
    whole = _quick(joined, 0, header, delimiter, source.head[header.first_row])
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


def _quick(source: Source, start: int, header: Header, delimiter: str, first: str) -> Body | None:
    """Return the body if the source is one clean table from byte ``start`` on, else None."""
    marks = marks_of(source.data, start, delimiter)
    if marks is None:
        return None
    source.release()
    table = _pandas(source, header, delimiter, marks, start)
    if table is None or not isinstance(table.index, pd.RangeIndex):
        return None  # pandas makes an index of the first column where a row is too wide
    if any(table[i].dtype.kind not in "fi" for i in header.used()):
        return None
    values = {i: table[i].to_numpy(dtype=float, copy=False) for i in header.used()}
    if header.first_unnamed() in table and _filled(table[header.first_unnamed()]):
        return None
    if not _quotes_are_whole(source, start, len(table), delimiter):
        return None
    if not _first_row_agrees(first, delimiter, marks[0], values):
        return None
    lines = range(header.first_row, header.first_row + len(table))
    return Body(header, values, lines, marks[0], marks[1] is not None)


def _filled(column: pd.Series) -> bool:
    """Tell whether a column without a name holds anything: cells were torn apart."""
    return bool((column.notna() & (column.astype(str) != "")).any())


def _pandas(
    source: Source, header: Header, delimiter: str, marks: tuple[str, str | None], start: int
) -> pd.DataFrame | None:
    """Return the C reader's table, or None where it stumbles, as at an empty cell.

    Only specimens side by side may have some, where one is shorter.
    """
    form: dict[str, Any] = {"na_filter": False, "dtype": dict.fromkeys(header.used(), float)}
    if len(header.specimens) > 1:
        form = {}
    try:
        with warnings.catch_warnings(), source.opened(start) as body:
            warnings.simplefilter("ignore")
            return pd.read_csv(
                body,
                sep=r"\s+" if delimiter == "spaces" else delimiter,
                header=None,
                names=range(max(header.width, len(header.names))),
                decimal=marks[0],
                thousands=marks[1],
                encoding_errors="replace",  # digits are ASCII; latin-1 is twice as slow
                engine="c",
                **form,
            )
    except (pd.errors.ParserError, pd.errors.EmptyDataError, ValueError):
        return None


def _lacking(source: Source, rows: list[int], delimiter: str, used: list[int]) -> list[str]:
    """Name a last or first row that lacks a cell which the others have: a statistic, a heading?"""
    ends = {"above": rows[-12:], "below": rows[11::-1]}
    return [
        f"line {some[-1] + 1}: lacks a cell that every row {where} has"
        for where, some in ends.items()
        if is_short([split_cells(source.lines[row], delimiter) for row in some], used)
    ]


def _last_line_is_whole(source: Source, header: Header, delimiter: str) -> bool:
    """Return False if the file stops inside a used cell of its last row, as far as one can tell."""
    if source.ends_in_newline():
        return True
    size = len(source.data)
    tail = source.data[max(0, size - 20000) :].decode(source.encoding, errors="replace")
    return not _is_cut(tail.split("\n")[-50:], header, delimiter)


def _is_cut(lines: list[str], header: Header, delimiter: str) -> bool:
    """Tell whether the last of these lines lacks its end.

    Only its last cell can be short. It is taken for cut when a column of constant decimals shows
    it, when cells are missing before it, or when a quote is left open.
    """
    cells = split_cells(lines[-1].rstrip("\r"), delimiter)
    if quotes_are_torn(lines[-1].rstrip("\r"), delimiter) or len(cells) <= max(header.used()):
        return bool(lines[-1].strip())
    last = len(cells) - 1
    if last not in header.used() or not cells[last]:
        return False
    before = [split_cells(line.rstrip("\r"), delimiter) for line in lines[-50:-1]]
    before = [row for row in before if is_row(row, header.used())]
    if before and min(map(len, before)) > len(cells):
        return True  # what no row lacks, be it unused
    decimals = [_decimals(c[last]) for c in before if len(c) == len(cells)]
    # Where zeros at the end are left out, as many decimals in all rows say nothing.
    fixed = any(text.endswith("0") or "e" in text.casefold() for text in decimals)
    digits = {len(text) for text in decimals}
    return fixed and len(digits) == 1 and len(_decimals(cells[last])) < digits.pop()


def _decimals(cell: str) -> str:
    return re.sub(r"^[^.,]*[.,]?", "", cell)


def _quotes_are_whole(source: Source, start: int, rows: int, delimiter: str) -> bool:
    """Return False if a quote stands within a cell, or a line break within quotes.

    Of ``"773.98"5.00"`` the C reader makes 773.985, and of two lines one.
    """
    if source.data.find(b'"', start) < 0:
        return True
    for piece in pieces(np.frombuffer(source.data, dtype=np.uint8), start):
        quote = bits(piece == QUOTE)
        # Comma, TAB and line ends come before "-"; other such characters make no number anyway.
        edge = bits(piece < ord("-")) & ~quote
        if delimiter in ";|":
            edge |= bits(piece == ord(delimiter))
        if (quote & ~(at(edge, -1) | at(edge, 1)))[1:-1].any():
            return False
    tail = source.data[-1000:]
    blank = max(tail[len(tail.rstrip(b"\r\n")) :].count(b"\n") - 1, 0)
    return rows == source.count - source.data[:start].count(b"\n") - blank


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


def _walk(
    source: Source, header: Header | None, delimiter: str, told: Told
) -> list[tuple[Header, list[int], int | None]]:
    """Return each table's header, the lines of its rows, and the line that the file's end cuts."""
    blocks = []
    while header is not None:
        rows, stop, cut = _rows(source, header, delimiter)
        following = _next_header(source, header, stop, delimiter, told)
        blocks.append((header, rows, cut))
        if following is None:
            _say_empty(source, header, stop, delimiter)
        header = following
    return blocks


def _say_empty(source: Source, header: Header, start: int, delimiter: str) -> None:
    """Say so where the heading of a table comes again and no whole row follows it."""
    for number in range(start, len(source.lines) - 1):
        if split_cells(source.lines[number], delimiter) == header.names:
            header.doubts.append(f"line {number + 1}: the heading comes again without a whole row")


def _rows(source: Source, header: Header, delimiter: str) -> tuple[list[int], int, int | None]:
    """Return the lines of the rows under a header and the line at which they stop."""
    lines, used = source.lines, header.used()
    rows: list[int] = []
    width, marks = header.first_unnamed(), marks_above(source, header, delimiter)
    for number in range(header.first_row, len(lines)):
        line = lines[number]
        if is_blank(line):
            continue
        cells = split_cells(line, delimiter)
        torn = _is_torn(source, number, cells, delimiter, used)
        digits = _PLAIN_ROW.fullmatch(line)
        if not digits and is_statistic(cells) and ends_rows(source, number, delimiter, used):
            header.choices.append(f"line {number + 1}: '{line[:40]}' is a statistic, no row")
            return rows, number, None
        if not torn and (digits or is_row(cells, used)):
            if len(cells) > width and cells[width]:
                _refuse_wide(source, number, len(cells), width)
            if rows and begins_otherwise(cells, split_cells(lines[rows[0]], delimiter)):
                header.doubts.append(
                    f"line {number + 1}: '{cells[0][:40]}' begins a row of numbers"
                )
            rows.append(number)
            continue
        if _is_last_and_open(source, number):
            break
        if cells[0] in marks and goes_on(source, number + 1, used, delimiter):
            continue
        if is_word_between(source, number, rows, header, delimiter):
            header.doubts.append(f"line {number + 1}: '{line.strip()[:40]}' is no row")
            continue
        if is_trailer(source, number, delimiter, used, rows):
            note = f"line {number + 1}: '{line.strip()[:40]}' below the rows is no row"
            header.doubts.append(note)
        elif not _is_block_head(source, header, number, delimiter):
            _refuse_damaged(source, number, cells, used)
        if rows and _is_like(cells, split_cells(lines[rows[-1]], delimiter)):
            header.doubts.append(f"line {number + 1}: '{line.strip()[:40]}' is no row")
        return rows, number, None
    return _without_cut_row(source, header, rows, delimiter)


def _is_torn(
    source: Source, number: int, cells: list[str], delimiter: str, used: list[int]
) -> bool:
    """Tell whether a quote of a row is not closed, which only the last of a cut file may be."""
    line = source.lines[number]
    if _QUOTED_WITHIN.search(line):
        raise Unreadable(f"{source.path}: line {number + 1}: quotes within a number")
    odd = line.count('"') % 2 == 1
    torn = quotes_are_torn(line, delimiter) and (odd or is_row(cells, used))
    if torn and not _is_last_and_open(source, number):
        raise Unreadable(f"{source.path}: line {number + 1}: a quote is not closed")
    return torn


def _is_block_head(source: Source, header: Header, number: int, delimiter: str) -> bool:
    """Tell whether the same names come again within a few lines of this one."""
    following = source.lines[number : number + BLOCK_HEAD]
    return any(split_cells(line, delimiter) == header.names for line in following)


def _is_last_and_open(source: Source, number: int) -> bool:
    return number == len(source.lines) - 1 and not source.ends_in_newline()


def _refuse_wide(source: Source, number: int, found: int, width: int) -> None:
    raise Unreadable(
        f"{source.path}: line {number + 1}: {found} cells under a header of {width}: a decimal or"
        " thousands comma without quotes?"
    )


def _refuse_damaged(source: Source, number: int, cells: list[str], used: list[int]) -> None:
    """Refuse a row in which some used cells are numbers and others are not; text may pass."""
    filled = [(i, cells[i]) for i in used if i < len(cells) and cells[i]]
    wrong = [(i, cell) for i, cell in filled if not looks_numeric(cell)]
    if wrong and len(wrong) < len(filled):
        index, cell = wrong[0]
        raise Unreadable(
            f"{source.path}: line {number + 1}: column {index + 1} holds '{cell[:40]}', not a"
            " number (a fill value or a damaged row?)"
        )


def _is_like(cells: list[str], row: list[str]) -> bool:
    """Tell whether a line holds about as many cells and numbers as a row, or begins like one."""
    if looks_numeric(cells[0]) and looks_numeric(row[0]) and any(cells[1:]):
        return True
    numbers, usual = (sum(map(looks_numeric, line)) for line in (cells, row))
    return 2 * numbers > usual > 1 and abs(len(cells) - len(row)) < 2


def _without_cut_row(
    source: Source, header: Header, rows: list[int], delimiter: str
) -> tuple[list[int], int, int | None]:
    """Return the rows without a last one that the file's end cuts, and that one's line."""
    last = len(source.lines) - 1
    tail = source.lines[max(header.first_row, last - 50) :]
    cut = not source.ends_in_newline() and _is_cut(tail, header, delimiter)
    whole = [row for row in rows if row != last] if cut else rows
    lost = cut or (whole[-1:] != [last] and not source.ends_in_newline())
    return whole, last + 1, last if lost and source.lines[last].strip() else None


def _next_header(
    source: Source, header: Header, stop: int, delimiter: str, told: Told
) -> Header | None:
    """Return the next header; refuse rows that go on after a text line without one."""
    following = find_header(source.lines, delimiter, stop, told)
    end = following.line if following else len(source.lines)
    for number in range(stop, end):
        cells = split_cells(source.lines[number], delimiter)
        if is_statistic(cells):
            continue
        if number + 1 < end and is_other_heading(
            cells, split_cells(source.lines[number + 1], delimiter)
        ):
            break  # a table of something else: the ledger names it
        if len(cells) >= header.width and is_row(cells, header.used()):
            raise Unreadable(
                f"{source.path}: line {stop + 1}: text within the data"
                f" ('{source.lines[stop][:40]}'); rows go on at line {number + 1} without a header"
            )
    return following


def _refuse_torn_decimals(source: Source, rows: list[int], delimiter: str) -> None:
    """Refuse ``0,1,0,05`` under names enough for four whole numbers."""
    lines = [source.lines[number] for number in rows]
    if delimiter != "," or any("." in line for line in lines):
        return
    for number, line in zip(rows, lines, strict=True):
        if TORN.search(re.sub(r'"[^"]*"', "", line).encode()):
            raise Unreadable(
                f"{source.path}: line {number + 1}: no decimal point anywhere, and whole numbers"
                " that start with 0: decimal commas without quotes?"
            )


def _exact(source: Source, header: Header, rows: list[int], delimiter: str) -> Body:
    """Convert the used cells of the rows, every cell checked."""
    if not rows:
        raise Unreadable(f"{source.path}: line {header.line + 1}: a header without complete rows")
    _refuse_torn_decimals(source, rows, delimiter)
    cells = [split_cells(source.lines[number], delimiter) for number in rows]
    texts = {i: [row[i] if i < len(row) else "" for row in cells] for i in header.used()}
    body = Body(header, {}, rows)
    try:
        body.decimal = decimal_mark([text for column in texts.values() for text in column])
    except Unclear as error:
        line = rows[error.position % len(rows)] + 1
        raise Unreadable(f"{source.path}: line {line}: {error}") from None
    for index, column in texts.items():
        try:
            body.values[index], grouped = to_numbers(column, body.decimal)
        except Unclear as error:
            line = rows[error.position] + 1
            raise Unreadable(f"{source.path}: line {line}: {error}") from None
        body.thousands |= grouped
    return body
