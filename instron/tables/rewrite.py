"""Tables in which no header is found as they stand, written so that it is.

``12.3 N`` in every cell, or a quantity a row. What is rewritten is read like any other export.
"""

import re
from collections.abc import Callable, Sequence
from dataclasses import replace
from itertools import zip_longest

from instron.errors import Unreadable
from instron.headings.grammar import read_heading
from instron.headings.units import Unit, is_unit, read_unit
from instron.headings.words import QUANTITIES
from instron.numbers.numerals import looks_numeric
from instron.source.files import Source
from instron.tables.layout import DELIMITERS, is_blank, split_cells

FEWEST = 5  # numbers beside a name that make it the name of a row
MOST = 400  # lines among which a table begins, or that may hold a quantity each
MOSTLY = 0.8  # of the cells of such a row
_WITH_UNIT = re.compile(r"([^A-Za-z%\u00b5\u03bc]*\d[\d.,]*(?:[eE][-+]?\d+)?)\s*([^\d\s].*)")

Rewritten = tuple[Source, str]  # and how it has been rewritten


def units_apart(source: Source) -> Rewritten | None:
    """Write the units that stand beside every number into the heading, if there are any.

    Raises
    ------
    Unreadable
        Where the unit of a column changes, is missing, or is not the one its heading states.
    """
    lines = source.lines
    for delimiter in DELIMITERS[:-1]:
        for number in range(1, min(len(lines), MOST)):
            units = {i: value[1] for i, cell in enumerate(split_cells(lines[number], delimiter))
                     if (value := _with_unit(cell))}  # fmt: skip
            if len(units) > 1 and _names_a_log(split_cells(lines[number - 1], delimiter)):
                found = _Units(source, delimiter, number, units)
                text = [
                    *lines[: number - 1],
                    found.heading(),
                    *map(found.row, range(number, len(lines))),
                ]
                end = "\n" if source.ends_in_newline() else ""
                return _as_source(source, text, end), "every number had its unit beside it"
    return None


def _with_unit(cell: str) -> tuple[str, Unit] | None:
    """Return number and unit of a cell that is both, in a unit of time, length or force."""
    found = _WITH_UNIT.fullmatch(cell)
    unit = read_unit(found[2]) if found and looks_numeric(found[1]) else None
    return (found[1].strip(), unit) if found and unit and unit.quantity in QUANTITIES else None


def _names_a_log(cells: Sequence[str]) -> bool:
    return {"displacement", "force"} <= {read_heading(cell).quantity for cell in cells}


class _Units:
    """The units beside the numbers of a table, by column, from its first row on."""

    def __init__(self, source: Source, delimiter: str, first: int, units: dict[int, Unit]) -> None:
        self.source, self.delimiter, self.first, self.units = source, delimiter, first, units

    def heading(self) -> str:
        """Return the line of names, with the units."""
        cells = split_cells(self.source.lines[self.first - 1], self.delimiter)
        for index, unit in self.units.items():
            stated = read_heading(cells[index]).unit if index < len(cells) else None
            if stated and not stated.agrees(unit):
                raise Unreadable(
                    f"{self.source.path}: line {self.first}: the heading of column {index + 1} says"
                    f" '{stated.text}', the numbers below it '{unit.text}'"
                )
            if not stated and index < len(cells):
                cells[index] += f" ({unit.text})"
        return _line(cells, self.delimiter)

    def row(self, number: int) -> str:
        """Return a line without the units; one that holds none is left as it is."""
        line = self.source.lines[number]
        cells = split_cells(line, self.delimiter)
        values = {i: _with_unit(cells[i]) for i in self.units if i < len(cells)}
        if not any(values.values()):
            return line
        last = number == len(self.source.lines) - 1 and not self.source.ends_in_newline()
        for index, value in values.items():
            if last and value is None:
                return _line(cells[:index], self.delimiter)  # the file stops inside this cell
            if cells[index] and (value is None or not value[1].agrees(self.units[index])):
                raise Unreadable(
                    f"{self.source.path}: line {number + 1}: column {index + 1} holds"
                    f" '{cells[index][:40]}', in the first rows its unit is"
                    f" '{self.units[index].text}'"
                )
            cells[index] = value[0] if value else ""
        return _line(cells, self.delimiter)


def upright(source: Source) -> Rewritten | None:
    """Turn tables that hold a quantity a row, if there are any."""
    for delimiter in DELIMITERS[:-1] if len(source.lines) <= MOST else ():
        cells = [split_cells(line, delimiter) for line in source.lines]
        text: list[str] = []
        turned = 0
        for first, stop in _stretches(source.lines):
            block = cells[first:stop]
            lying = [i for i, row in enumerate(block) if _lies(row)]
            if not lying or not _names_a_log([block[i][0] for i in lying]):
                text += source.lines[first:stop]
                continue
            width = max(len(block[i]) for i in lying)
            top = next(i for i, row in enumerate(block) if i in lying or len(row) >= width - 1)
            text += source.lines[first : first + top]
            text += [_line(column, delimiter)
                     for column in zip_longest(*block[top:], fillvalue="")]  # fmt: skip
            turned += 1
        if turned:
            place = source.path.with_name(f"{source.path.name} [turned upright]")
            note = "the table lies on its side, a quantity a row: its columns are counted as lines"
            return replace(_as_source(source, text, "\n"), path=place), note
    return None


def _stretches(lines: Sequence[str]) -> list[tuple[int, int]]:
    """Return first line and stop of every run of lines, blank ones a run each."""
    edges = [i for i in range(len(lines)) if is_blank(lines[i]) or (i and is_blank(lines[i - 1]))]
    bounds = sorted({0, *edges, len(lines)})
    return list(zip(bounds[:-1], bounds[1:], strict=True))


def _lies(row: Sequence[str]) -> bool:
    """Tell whether a row is a name, perhaps a unit, and numbers."""
    start = 2 if len(row) > 1 and is_unit(row[1]) and not looks_numeric(row[1]) else 1
    cells = [cell for cell in row[start:] if cell]
    numbers = sum(map(looks_numeric, cells))
    named = bool(re.search(r"[^\W\d_]", row[0]))
    return named and numbers >= FEWEST and numbers >= MOSTLY * len(cells)


def _line(cells: Sequence[str], delimiter: str) -> str:
    return delimiter.join(f'"{cell}"' if delimiter in cell else cell for cell in cells)


def _as_source(source: Source, lines: Sequence[str], end: str) -> Source:
    data = ("\n".join(lines) + end).encode()
    return Source(source.path, data, "utf-8", source.written, source.newline, on_disk=False)


REWRITERS: tuple[Callable[[Source], Rewritten | None], ...] = (units_apart, upright)
