"""The tables of a file: a quick way for clean ones, an exact way for the rest.

The quick way hands the file to pandas' C reader and accepts the answer only when every used column
came out numeric and complete. Everything else (several tables, thousands, damage) is walked line
by line.
"""

from itertools import pairwise

from instron.headings.columns import Told
from instron.source.files import Source, refuse_lone_returns
from instron.tables.blocks import WORDY, group_name
from instron.tables.body import Body
from instron.tables.footer import ends_oddly, is_short, starts_short
from instron.tables.layout import Header, is_blank, split_cells
from instron.tables.quick import one_table, repeated_tables
from instron.tables.walk import exact, is_cut, walk


def read_bodies(source: Source, header: Header, delimiter: str, told: Told) -> list[Body]:
    """Return the tables of a file: one per header that rows of numbers follow."""
    refuse_lone_returns(source, max(header.line, 0))
    whole = _last_line_is_whole(source, header, delimiter)
    whole = whole and not ends_oddly(source, source.line(header.first_row), delimiter)
    whole = whole and not starts_short(source, header.first_row, delimiter, header.used())
    if whole and not _words_within(source, header):
        start = source.offset(header.first_row)
        quick = one_table(source, start, header, delimiter, source.head[header.first_row])
        if quick is not None:
            return [quick]
    repeated = repeated_tables(source, header, delimiter) if whole else None
    if repeated is not None:
        return repeated
    bodies = []
    blocks = walk(source, header, delimiter, told)
    grouped = any(block.line == block.first_row for block, _, _ in blocks)
    for block, rows, cut in blocks:
        bodies.append(exact(source, block, rows, delimiter))
        if grouped:
            _name(source, bodies[-1], delimiter)
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


def _name(source: Source, body: Body, delimiter: str) -> None:
    """Name a group of rows by the line above it, which then is no comment."""
    body.label = group_name(source, body.header, delimiter)
    comment = f"line {body.header.first_row}: "
    body.header.doubts[:] = [d for d in body.header.doubts if not d.startswith(comment)]


def _words_within(source: Source, header: Header) -> bool:
    """Tell whether the head shows lines of words among rows of numbers."""
    rows = source.head[header.first_row :]
    return not WORDY.match(rows[0]) and any(map(WORDY.match, rows))


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
    return not is_cut(tail.split("\n")[-50:], header, delimiter)
