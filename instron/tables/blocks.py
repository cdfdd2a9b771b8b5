"""Blocks of rows: under one header that comes again and again, or after a mark without one."""

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from instron.headings.words import SPECIMEN, plain
from instron.numbers.numerals import Unclear, decimal_mark, looks_numeric, to_numbers
from instron.source.files import NEWLINE, RETURN, Source
from instron.tables.footer import OUT_OF_RANGE, is_statistic
from instron.tables.layout import Header, is_blank, is_row, split_cells

# What starts a line that is no row: a word, or a bracket around one.
WORDY = re.compile(r"[\s\"']*[^\W\d_]|[\s\"']*[(\[<#*]")
_LETTER = np.zeros(256, dtype=bool)
_LETTER[[*b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz([<#*"]] = True
_LETTER[128:] = True
_BEFORE = np.zeros(256, dtype=bool)
_BEFORE[[*b" \t\"'"]] = True
LONE_WORD = re.compile(r"[^\W\d_]{3,}( [^\W\d_]+)*[.:!]?")
NEAR = 0.05  # of its span: how near to its beginning a time or displacement begins again
FEW = 0.05  # of all lines are words, where blocks repeat


@dataclass(frozen=True)
class Blocks:
    """Where the rows of each table stand, in bytes and in lines counted from 0."""

    bytes: list[tuple[int, int]]
    lines: list[tuple[int, int]]


def repeated_blocks(source: Source, header: Header) -> Blocks | None:
    """Return the blocks of rows if every line of words belongs to one and the same header."""
    text = np.frombuffer(source.data, dtype=np.uint8)
    starts = np.concatenate([[0], np.flatnonzero(text == NEWLINE) + 1])
    starts = starts[starts < len(text)]
    begins = starts.copy()
    for _ in range(40):
        blank = _BEFORE[text[begins]] & (begins + 1 < len(text))
        if not blank.any():
            break
        begins += blank
    words = _LETTER[text[begins]]
    words[: header.first_row] = True
    empty = (text[begins] == NEWLINE) | (text[begins] == RETURN)
    if words.mean() > FEW or not words[header.first_row :].any():
        return None
    edges = np.diff(np.concatenate([[True], words | empty, [True]]).astype(np.int8))
    firsts, stops = np.flatnonzero(edges == -1), np.flatnonzero(edges == 1)
    ends = np.append(starts, len(text))
    head = source.data[starts[header.line] : starts[header.first_row]]
    for first in firsts[1:]:
        if source.data[ends[first] - len(head) : ends[first]] != head:
            return None
    if stops[-1] < len(starts) and not empty[stops[-1] :].all():
        return None  # words after the last rows
    return Blocks(
        [(int(ends[a]), int(ends[b])) for a, b in zip(firsts, stops, strict=True)],
        [(int(a), int(b)) for a, b in zip(firsts, stops, strict=True)],
    )


def is_other_heading(cells: Sequence[str], below: Sequence[str]) -> bool:
    """Tell whether a line names the columns of another table: a word for each cell below it."""
    filled = [cell for cell in cells if cell]
    named = {cell for cell in filled if re.search(r"[^\W\d_]{2}", cell)}
    rows = [cell for cell in below if cell]
    return 1 < len(named) == len(filled) == len(rows) and not any(map(looks_numeric, filled))


def marks_above(source: Source, header: Header, delimiter: str) -> set[str]:
    """Return how the lines right above a header begin, which may come again between its blocks."""
    above = source.lines[max(0, header.line - 3) : header.line]
    firsts = {split_cells(line, delimiter)[0] for line in above}
    words = (cell for cell in firsts if re.search(r"[^\W\d_]{2}", cell))
    return {cell for cell in words if SPECIMEN.isdisjoint(plain(cell).split())}


def goes_on(source: Source, number: int, used: list[int], delimiter: str) -> bool:
    """Tell whether rows follow a mark between two blocks at once."""
    line = next((line for line in source.lines[number : number + 2] if line.strip()), "")
    return is_row(split_cells(line, delimiter), used)


def group_below(
    source: Source, header: Header, rows: Sequence[int], number: int, delimiter: str
) -> Header | None:
    """Return a header for rows that go on below a name, under the same columns, from the start.

    Its line is that of its first row. What time, or else displacement, does tells a test of its
    own from a remark and from a row that was damaged.
    """
    first = next(
        (n for n in range(number + 1, len(source.lines)) if not is_blank(source.lines[n])), None
    )
    if not rows or first is None or not _is_name(split_cells(source.lines[number], delimiter)):
        return None
    lines = [split_cells(source.lines[n], delimiter) for n in (rows[0], rows[-1], first)]
    if len(lines[2]) != len(lines[0]) or not is_row(lines[2], header.used()):
        return None
    for specimen in header.specimens:
        index = specimen.get("time", specimen["displacement"]).index
        try:
            texts = [cells[index] for cells in lines]
            begin, end, again = to_numbers(texts, decimal_mark(texts))[0]
        except Unclear:
            return None
        if abs(again - begin) > NEAR * abs(end - begin) or end == begin:
            return None
    return replace(header, line=first, first_row=first, units=None, doubts=[])


def _is_name(cells: Sequence[str]) -> bool:
    """Tell whether a line is a word or two, as ``Specimen 2`` and ``Sample,B``."""
    filled = [cell for cell in cells if cell]
    return (
        0 < len(filled) <= 2
        and bool(re.search(r"[^\W\d_]", filled[0]))
        and not is_statistic(filled)
    )


def group_name(source: Source, header: Header, delimiter: str) -> str:
    """Return the name that stands right above the first row of a group, below its columns."""
    line = header.first_row - 1
    while line >= 0 and is_blank(source.lines[line]):
        line -= 1
    cells = split_cells(source.lines[line], delimiter)
    if header.line == line or line == header.units or not _is_name(cells):
        return ""
    return [cell for cell in cells if cell][-1].rpartition(":")[2].strip("[]<># ")


def is_word_between(
    source: Source, number: int, rows: Sequence[int], header: Header, delimiter: str
) -> bool:
    """Tell whether a line is a lone word, ``Hold`` or ``eoh``, between two rows of a timed table.

    A row that it had replaced, or another test, would show in the time.
    """
    words = [cell for cell in split_cells(source.lines[number], delimiter) if cell]
    if len(words) != 1 or LONE_WORD.fullmatch(words[0]) is None:
        return False
    known = SPECIMEN | OUT_OF_RANGE
    if rows[-1:] != [number - 1] or not known.isdisjoint(plain(words[0]).split()):
        return False
    return all(
        "time" in specimen and _no_row_lacks(source, number, specimen["time"].index, delimiter)
        for specimen in header.specimens
    )


def _no_row_lacks(source: Source, number: int, time: int, delimiter: str) -> bool:
    """Tell whether the time across a line makes no more than a step and a half."""
    cells = [split_cells(line, delimiter) for line in source.lines[number - 1 : number + 3]]
    try:
        before, _, after, then = (
            float(row[time].replace(",", ".")) if k != 1 else 0.0 for k, row in enumerate(cells)
        )
    except (IndexError, ValueError):
        return False
    return 0 < after - before <= 1.5 * (then - after)
