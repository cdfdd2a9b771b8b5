"""The exact way: rows line by line and cell by cell, so that a refusal can name the line."""

import re

from instron.errors import Unreadable
from instron.headings.columns import Told
from instron.numbers.marks import TORN
from instron.numbers.numerals import Unclear, decimal_mark, looks_numeric, to_numbers
from instron.source.files import Source
from instron.tables.blocks import (
    goes_on,
    group_below,
    is_other_heading,
    is_word_between,
    marks_above,
)
from instron.tables.body import Body
from instron.tables.footer import begins_otherwise, ends_rows, is_statistic, is_trailer
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


def walk(
    source: Source, header: Header | None, delimiter: str, told: Told
) -> list[tuple[Header, list[int], int | None]]:
    """Return each table's header, the lines of its rows, and the line that the file's end cuts."""
    blocks = []
    while header is not None:
        rows, stop, cut = _rows(source, header, delimiter)
        group = stop < len(source.lines) and group_below(source, header, rows, stop, delimiter)
        following = group or _next_header(source, header, stop, delimiter, told)
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
    cut = not source.ends_in_newline() and is_cut(tail, header, delimiter)
    whole = [row for row in rows if row != last] if cut else rows
    lost = cut or (whole[-1:] != [last] and not source.ends_in_newline())
    return whole, last + 1, last if lost and source.lines[last].strip() else None


def is_cut(lines: list[str], header: Header, delimiter: str) -> bool:
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


def exact(source: Source, header: Header, rows: list[int], delimiter: str) -> Body:
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
