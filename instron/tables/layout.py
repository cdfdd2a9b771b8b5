"""Where the tables of an export are: header, units row, columns of each specimen, first row."""

import re
from dataclasses import dataclass, field
from functools import partial

from instron.headings.columns import Sample, Specimen, Told, choose, from_units_alone, might_be
from instron.headings.grammar import read_heading
from instron.headings.units import is_unit
from instron.numbers.numerals import looks_numeric

LONGEST_HEADER = 20_000  # characters; names of a hundred specimens side by side need 10 000
LONGEST_CELL = 20  # lines that a header with line breaks in its cells may have
SAMPLE = 2000  # rows by whose contents columns are told apart
COMMENTS = 2  # lines of words that may stand between a header and its first row
DELIMITERS = ("\t", ";", ",", "|", "spaces")


@dataclass(frozen=True)
class Header:
    """One header with what belongs to it. Lines count from 0."""

    line: int
    first_row: int
    width: int
    names: list[str]
    specimens: list[Specimen]
    choices: list[str]  # what else could have been taken
    question: str = ""  # what has to be asked before its numbers can be used
    units: int | None = None  # line of the units row
    doubts: list[str] = field(default_factory=list)  # what its logs are warned of

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


def quotes_are_torn(line: str, delimiter: str) -> bool:
    """Tell whether some quote neither opens nor closes a cell: ``0.1","0.05","5``."""
    if '"' not in line:
        return False
    mark = " " if delimiter == "spaces" else re.escape(delimiter)
    cell = rf'[ \t]*(?:"(?:[^"]|"")*"[ \t]*|[^"{mark}]*)'
    return re.fullmatch(rf"{cell}(?:{mark}{cell})*", line) is None


def find_header(
    lines: list[str], delimiter: str, start: int = 0, told: Told | None = None
) -> Header | None:
    """Return the first header at or after line ``start`` that rows of numbers follow."""
    for number in range(start, len(lines)):
        if not re.search(r"[^\W\d_]", lines[number]):
            continue
        header = header_at(lines, number, delimiter, told or Told())
        if header is not None:
            return header
    return None


def header_at(lines: list[str], number: int, delimiter: str, told: Told) -> Header | None:
    """Return the header that line ``number`` is, with units row and first row, or None."""
    torn = delimiter == "spaces" and re.search(r"[\t;|]", lines[number])
    if torn or len(lines[number]) > LONGEST_HEADER:
        return None
    line, after = _closed_line(lines, number)
    names = split_cells(line, delimiter)
    if len(names) < 2 or sum(looks_numeric(name) for name in names) > len(names) // 2:
        return None
    units, place, following = _units_row(lines, after, delimiter)
    above = following
    following = _first_row(lines, above, delimiter, len(names))
    if following >= len(lines) or not _promises(names, units, told):
        return None
    first = split_cells(lines[following], delimiter)
    if sum(map(looks_numeric, first)) < 2:
        return None
    below = lines[following : following + SAMPLE]
    choice = choose(names, units, Sample(below, partial(split_cells, delimiter=delimiter)), told)
    if not choice.specimens and units is None and not _named_above(lines, number, delimiter):
        choice = from_units_alone(names)
    doubts = [*choice.doubts, *_digits_passed_over(lines, above, following)]
    header = Header(number, following, len(first), names, choice.specimens, choice.notes,
                    choice.question, place, doubts)  # fmt: skip
    shifted = delimiter == "spaces" and len(first) != len(names)
    if not choice.specimens or shifted or not is_row(first, header.used()):
        return None
    return header


def _promises(names: list[str], units: list[str] | None, told: Told) -> bool:
    """Tell whether a line could be a header, before its rows are looked at."""
    if told.columns or (units is None and all(is_unit(name) for name in names if name)):
        return True
    found = [read_heading(name, units[i] if units and i < len(units) else "")
             for i, name in enumerate(names)]  # fmt: skip
    quantities = {h.quantity for h in found if h.fits and not h.role}
    forces, lengths = (any(might_be(h, q) for h in found) for q in ("force", "displacement"))
    if "force" in quantities:
        return "displacement" in quantities or lengths or any(h.lengthens for h in found)
    return "displacement" in quantities and forces


def _named_above(lines: list[str], number: int, delimiter: str) -> bool:
    """Tell whether the line above a row of units names its columns."""
    above = next((line for line in reversed(lines[:number]) if line.strip(" \t,;|\"'")), "")
    names = [cell for cell in split_cells(above, delimiter) if cell]
    units = [cell for cell in split_cells(lines[number], delimiter) if cell]
    return len(names) == len(units) and not any(map(looks_numeric, names))


def _first_row(lines: list[str], number: int, delimiter: str, width: int) -> int:
    """Return the line of the first numbers; a line or two of comments may come before."""
    first = number
    for _ in range(COMMENTS + 1):
        if first >= len(lines):
            return number
        cells = [cell for cell in split_cells(lines[first], delimiter) if cell]
        numbers = sum(map(looks_numeric, cells))
        if numbers > 1:
            return first
        digits_alone = re.search(r"\d", lines[first]) and not re.search(r"[^\W\d_]", lines[first])
        if numbers or digits_alone or len(cells) > width or _promises(cells, None, Told()):
            return number
        first = _skip_blank(lines, first + 1)
    return number


def _digits_passed_over(lines: list[str], start: int, stop: int) -> list[str]:
    """Name the lines taken for comments that could have been a row before they were damaged."""
    return [f"line {n + 1}: '{lines[n].strip()[:40]}' is taken for a comment"
            for n in range(start, stop) if re.search(r"\d", lines[n])]  # fmt: skip


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


def _units_row(
    lines: list[str], number: int, delimiter: str
) -> tuple[list[str] | None, int | None, int]:
    """Return the cells and the line of the units row, if there is one, and the line after it."""
    number = _skip_blank(lines, number)
    if number >= len(lines):
        return None, None, number
    cells = split_cells(lines[number], delimiter)
    filled = [cell for cell in cells if cell]
    known = sum(is_unit(cell) for cell in filled)
    bracketed = bool(filled) and all(cell[0] in "([<{" for cell in filled)
    known += bracketed and all(cell in ("()", "[]", "<>", "{}") for cell in filled)
    if known and (bracketed or 2 * known >= len(filled)) and not any(map(looks_numeric, filled)):
        return cells, number, _skip_blank(lines, number + 1)
    return None, None, number


def _skip_blank(lines: list[str], number: int) -> int:
    while number < len(lines) and not lines[number].strip(" \t,;|\"'"):
        number += 1
    return number
