"""Where the tables of an export are: header, units row, columns of each specimen, first row."""

import re
from dataclasses import dataclass, replace

from instron.numerals import looks_numeric
from instron.words import (
    QUANTITIES,
    is_unit,
    lengthens,
    plain,
    quantity_of,
    rank,
    remembered,
    split_unit,
    symbol_of,
    unit_of,
    unknown_unit,
)

LONGEST_HEADER = 20_000  # characters; names of a hundred specimens side by side need 10 000
LONGEST_CELL = 20  # lines that a header with line breaks in its cells may have
DELIMITERS = ("\t", ";", ",", "|", "spaces")


@dataclass(frozen=True)
class Channel:
    """One column that is used: where it is, and how the file names it and its unit."""

    index: int
    name: str
    unit: str | None


Specimen = dict[str, Channel]


@dataclass(frozen=True)
class Header:
    """One header with what belongs to it. Lines count from 0."""

    line: int
    first_row: int
    width: int
    names: list[str]
    specimens: list[Specimen]
    choices: list[str]  # what else could have been taken

    def used(self) -> list[int]:
        """Return the indices of all used columns."""
        return sorted({c.index for specimen in self.specimens for c in specimen.values()})

    def first_unnamed(self) -> int:
        """Return the column right of the last name; numbers in it mean cells were torn apart."""
        return max(i for i, name in enumerate(self.names) if name or i in self.used()) + 1


def split_cells(line: str, delimiter: str) -> list[str]:
    """Split a line into cells, minding quotes."""
    if delimiter == "spaces":
        words = line.strip()
        gap = r" {2,}" if "  " in words and re.search(r"[^\W\d_]{2}", words) else r" +"
        return re.split(gap, words)
    if '"' not in line:
        return [cell.strip() for cell in line.split(delimiter)]
    mark = re.escape(delimiter)
    cells = re.findall(rf' *("(?:[^"]|"")*"|[^{mark}]*)(?:{mark}|$)', line)
    if not line.endswith(delimiter):
        cells = cells[:-1]
    return [cell.strip().strip('"').strip() for cell in cells]


def find_header(lines: list[str], delimiter: str, start: int = 0) -> Header | None:
    """Return the first header at or after line ``start`` that rows of numbers follow."""
    for number in range(start, len(lines)):
        if not re.search(r"[^\W\d_]", lines[number]):
            continue
        header = header_at(lines, number, delimiter)
        if header is not None:
            return header
    return None


def header_at(lines: list[str], number: int, delimiter: str) -> Header | None:
    """Return the header that line ``number`` is, with units row and first row, or None."""
    torn = delimiter == "spaces" and re.search(r"[\t;|]", lines[number])
    if torn or len(lines[number]) > LONGEST_HEADER:
        return None
    line, after = _closed_line(lines, number)
    names = split_cells(line, delimiter)
    if len(names) < 2 or sum(looks_numeric(name) for name in names) > len(names) // 2:
        return None
    units, following = _units_row(lines, after, delimiter)
    specimens, choices = find_specimens(names, units)
    if not specimens and units is None:
        specimens, choices = _from_units_alone(names)
    if not specimens or following >= len(lines):
        return None
    header = Header(number, following, 0, names, specimens, choices)
    cells = split_cells(lines[following], delimiter)
    shifted = delimiter == "spaces" and len(cells) != len(names)
    if shifted or not is_row(cells, header.used()):
        return None
    return replace(header, width=len(cells))


def _closed_line(lines: list[str], number: int) -> tuple[str, int]:
    """Return the line with those that its open quote runs into, and the number of the next."""
    line, after = lines[number], number + 1
    while line.count('"') % 2 and after < min(len(lines), number + LONGEST_CELL):
        line, after = f"{line} {lines[after]}", after + 1
    return line, after


def is_row(cells: list[str], used: list[int]) -> bool:
    """Tell whether all used cells that are not empty hold numbers, and at least two do."""
    filled = [cells[i] for i in used if i < len(cells) and cells[i]]
    return len(filled) >= 2 and all(looks_numeric(cell) for cell in filled)


def _units_row(lines: list[str], number: int, delimiter: str) -> tuple[list[str] | None, int]:
    """Return the cells of the units row, if there is one, and the line after it."""
    number = _skip_blank(lines, number)
    if number >= len(lines):
        return None, number
    cells = split_cells(lines[number], delimiter)
    filled = [cell for cell in cells if cell]
    known = sum(is_unit(cell) for cell in filled)
    bracketed = bool(filled) and all(cell[0] in "([<{" for cell in filled)
    known += bracketed and all(cell in ("()", "[]", "<>", "{}") for cell in filled)
    if known and (bracketed or 2 * known >= len(filled)) and not any(map(looks_numeric, filled)):
        return cells, _skip_blank(lines, number + 1)
    return None, number


def _skip_blank(lines: list[str], number: int) -> int:
    while number < len(lines) and not lines[number].strip(" \t,;|\"'"):
        number += 1
    return number


def find_specimens(names: list[str], units: list[str] | None) -> tuple[list[Specimen], list[str]]:
    """Return the columns of each specimen that a header names, and the choices made.

    Where the best force name repeats, specimens stand side by side, each with its own columns; a
    single time column serves them all.
    """
    found = _candidates(names, units)
    best = {q: _best(found[q]) for q in QUANTITIES}
    if not best["force"] or not best["displacement"]:
        return [], []
    count = len(best["force"])
    if len(best["displacement"]) != count or len(best["time"]) not in (0, 1, count):
        best = {q: channels[:1] for q, channels in best.items()}
        count = 1
    shared = {q: c if len(c) == count else c * count for q, c in best.items()}
    specimens = [{q: c[i] for q, c in shared.items() if c} for i in range(count)]
    return specimens, _choices(found, best)


def _candidates(names: list[str], units: list[str] | None) -> dict[str, list[Channel]]:
    found: dict[str, list[Channel]] = {q: [] for q in QUANTITIES}
    gauges: list[Channel] = []
    for index, cell in enumerate(names):
        name, unit = split_unit(cell)
        below = units[index] if units is not None and index < len(units) else ""
        unit = unit or below.strip("()[]<>{} ") or None
        if unit is None and units is None:
            unit = unknown_unit(name)
        quantity = quantity_of(name) or symbol_of(name, unit)
        if quantity and _fits(quantity, unit):
            found[quantity].append(Channel(index, name or cell, unit))
        elif lengthens(name) and unit and (unit_of(unit) or "")[:1] == ("displacement",):
            gauges.append(Channel(index, name, unit))
    found["displacement"] = found["displacement"] or gauges
    return found


def _fits(quantity: str, unit: str | None) -> bool:
    """Return False for a stated unit of another quantity: ``Extension (%)`` is no length."""
    if unit is None:
        return True
    known = unit_of(unit)
    return known[0] == quantity if known else not is_unit(unit)


@remembered
def _bare(name: str) -> str:
    return re.sub(r"[\d.]+", "", plain(name)).strip()


def _best(channels: list[Channel]) -> list[Channel]:
    """Return the channels that share the name of the lowest rank, the plainest first."""
    if not channels:
        return []
    first = min(channels, key=lambda c: (rank(c.name), len(_bare(c.name).split())))
    alike = (_bare(first.name), rank(first.name))
    return [c for c in channels if (_bare(c.name), rank(c.name)) == alike]


def _choices(found: dict[str, list[Channel]], best: dict[str, list[Channel]]) -> list[str]:
    notes = []
    for quantity in QUANTITIES:
        left = [c.name for c in found[quantity] if c not in best[quantity]]
        if left:
            taken = best[quantity][0].name
            notes.append(f"{quantity} is '{taken}'; not taken: {', '.join(map(repr, left))}")
    return notes


def _from_units_alone(names: list[str]) -> tuple[list[Specimen], list[str]]:
    """Return the columns of a header that holds nothing but one unit of each quantity."""
    known = [unit_of(name) for name in names]
    specimen: Specimen = {}
    for index, unit in enumerate(known):
        if unit is None and names[index] and not is_unit(names[index]):
            return [], []
        if unit and unit[0] in specimen:
            return [], []
        if unit:
            specimen[unit[0]] = Channel(
                index, names[index].strip("()[]"), names[index].strip("()[]")
            )
    if {"force", "displacement"} <= specimen.keys():
        return [specimen], ["no column names: columns taken by their units"]
    return [], []
