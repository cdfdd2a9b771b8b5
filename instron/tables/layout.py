"""Where the tables of an export are: header, units row, columns of each specimen, first row."""

import re
from dataclasses import dataclass, field
from functools import partial

from instron.headings.columns import (
    FIRST,
    Sample,
    Specimen,
    Told,
    choose,
    from_units_alone,
    might_be,
)
from instron.headings.grammar import read_heading
from instron.headings.units import is_unit
from instron.headings.words import UNIT, plain, word_set
from instron.numbers.numerals import looks_numeric
from instron.tables.names import fitted

LONGEST_HEADER = 20_000  # characters; names of a hundred specimens side by side need 10 000
LONGEST_CELL = 20  # lines that a header with line breaks in its cells may have
SAMPLE = 2000  # rows by whose contents columns are told apart
COMMENTED = re.compile(r"^\s*(?:[#%]+|//)\s*(?=[^\W\d_(\[])")
COMMENT = re.compile(r"^\s*(?:[#%]+|//)\s+")  # before the names of a table made by a program
COMMENTS = 2  # lines of words that may stand between a header and its first row
DESCRIBED = 8  # lines that may describe the channels between a header and its first row
ABOVE = 12  # lines above a header among which one may state the units
BESIDE = 5  # first rows that all fill a column without a name: somebody's own
UNIT_LABELS = UNIT | {"y unit label"}
FACTORS = word_set("factor coef coefficient gain scale multiplier offset faktor koeffizient"
                   " 校正係数 オフセット 係数 系数")  # fmt: skip
ATTRIBUTES = (
    FACTORS
    | UNIT
    | word_set(
        "range channel ch no number nr sensor calibration zero balance filter rate type"
        " bereich kanal kanalname messbereich"
        " レンシ フィルタ"  # as plain() leaves them
    )
)
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
    beside: int = 0  # columns right of the last name that every row fills
    unit_cells: dict[int, str] = field(default_factory=dict)  # see names.Names

    def used(self) -> list[int]:
        """Return the indices of all used columns."""
        return sorted({c.index for specimen in self.specimens for c in specimen.values()})

    def first_unnamed(self) -> int:
        """Return the column right of the last name; numbers in it mean cells were torn apart."""
        last = max(i for i, name in enumerate(self.names) if name or i in self.used())
        return last + 1 + self.beside


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
    names = split_cells(COMMENT.sub("", line) if delimiter == "spaces" else line, delimiter)
    if len(names) < 2 or sum(looks_numeric(name) for name in names) > len(names) // 2:
        return None
    names = _with_dimension(lines, number, delimiter, names)
    units, place, described, above = _between(lines, after, delimiter, names)
    units = units or _units_above(lines, number, delimiter)
    following = _first_row(lines, above, delimiter, len(names))
    if following >= len(lines) or not _promises(names, units, told):
        return None
    first = split_cells(lines[following], delimiter)
    if sum(map(looks_numeric, first)) < 2:
        return None
    below = lines[following : following + SAMPLE]
    split = partial(split_cells, delimiter=delimiter)
    fit = fitted(names, units, below[:FIRST], split)
    names, units = fit.names, fit.units
    choice = choose(names, units, Sample(below, split), told)
    if not choice.specimens and units is None and not _named_above(lines, number, delimiter):
        choice = from_units_alone(names)
    doubts = [*choice.doubts, *fit.doubts, *_digits_passed_over(lines, above, following),
              *_factors(lines, described, delimiter)]  # fmt: skip
    beside = _filled_beside(below, delimiter, names)
    if beside:
        doubts.append(f"cells in each row that have no name above: {beside}, taken for notes on the"
                      " right")  # fmt: skip
    header = Header(number, following, len(first), names, choice.specimens, choice.notes,
                    choice.question, place, doubts,
                    beside, fit.unit_cells)  # fmt: skip
    shifted = delimiter == "spaces" and len(first) != len(names)
    if not choice.specimens or shifted or not is_row(first, header.used()):
        return None
    return header


def _between(
    lines: list[str], after: int, delimiter: str, names: list[str]
) -> tuple[list[str] | None, int | None, list[int], int]:
    """Return what stands between names and rows.

    Cells and line of the units row, lines that describe channels, and the line after them.
    """
    units, place, following = _units_row(lines, after, delimiter, names)
    described = _descriptions(lines, following, delimiter, names[0])
    for number in described if units is None else []:
        units, place, _ = _units_row(lines, number, delimiter, names)
        if units is not None:
            break
    return (
        units,
        place,
        described,
        _skip_blank(lines, described[-1] + 1) if described else following,
    )


def _descriptions(lines: list[str], start: int, delimiter: str, name: str) -> list[int]:
    """Return the lines that describe channels: a word first, where all rows have a number.

    In a column of time, force or length, or before any number, it has to be a channel's: others are
    damaged rows.
    """
    found: list[int] = []
    needed = read_heading(name).quantity is not None
    for number in range(start, min(len(lines), start + 2 * DESCRIBED)):
        cells = split_cells(lines[number], delimiter)
        if not any(cells):
            continue
        if looks_numeric(cells[0]):
            firsts = [split_cells(line, delimiter)[0] for line in lines[number : number + 3]]
            return found if all(looks_numeric(cell) for cell in firsts if cell) else []
        words = re.search(r"[^\W\d_]{2}", cells[0])
        known = ATTRIBUTES.issuperset(plain(cells[0]).split())
        damaged = needed or any(map(looks_numeric, cells[1:]))
        if not words or len(found) == DESCRIBED or (damaged and not known):
            return []
        if _promises(cells, None, Told()):
            return []
        found.append(number)
    return []


def _factors(lines: list[str], described: list[int], delimiter: str) -> list[str]:
    """Name the factors and offsets that the rows may or may not have been through."""
    found = []
    for number in described:
        name, *cells = split_cells(lines[number], delimiter)
        if FACTORS & set(plain(name).split()) and {c for c in cells if c} - {"0", "1"}:
            found.append(f"line {number + 1}: '{lines[number].strip()[:40]}': rows are taken as"
                         " they stand")  # fmt: skip
    return found


def _units_above(lines: list[str], number: int, delimiter: str) -> list[str] | None:
    """Return the cells of a line above a header that states the units of its columns."""
    for line in reversed(lines[max(0, number - ABOVE) : number]):
        name, *cells = split_cells(line, delimiter)
        if plain(name) in UNIT_LABELS and sum(map(is_unit, cells)) > 1:
            return ["", *cells]
    return None


def _with_dimension(lines: list[str], number: int, delimiter: str, names: list[str]) -> list[str]:
    """Return names in which LabVIEW's ``X_Value`` is what a line ``X_Dimension`` above says."""
    if names[0] != "X_Value":
        return names
    above = (split_cells(line, delimiter) for line in lines[max(0, number - ABOVE) : number])
    said = [cells[1] for cells in above if cells[0] == "X_Dimension" and len(cells) > 1]
    return ["Time (s)", *names[1:]] if said == ["Time"] else names


def _filled_beside(rows: list[str], delimiter: str, names: list[str]) -> int:
    """Count the columns right of the last name that each of the first rows fills.

    Where the delimiter is no mark of numbers, such a column is somebody's own calculation.
    """
    first = max((i for i, name in enumerate(names) if name), default=-1) + 1
    if delimiter in (",", "spaces") or len(rows) < BESIDE:
        return 0
    right = [split_cells(row, delimiter)[first:] for row in rows[:BESIDE]]
    columns = zip(*right, strict=False)
    return next((k for k, cells in enumerate(columns) if not all(map(looks_numeric, cells))),
                min(map(len, right)))  # fmt: skip


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
    return forces and ("displacement" in quantities or lengths)


def _named_above(lines: list[str], number: int, delimiter: str) -> bool:
    """Tell whether the line above a row of units names its columns."""
    above = next((line for line in reversed(lines[:number]) if not is_blank(line)), "")
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


def is_blank(line: str) -> bool:
    """Tell whether nothing stands in a line but delimiters and quotes."""
    return not line.strip(" \t,;|\"'")


def is_row(cells: list[str], used: list[int]) -> bool:
    """Tell whether all used cells that are not empty hold numbers, and at least two do."""
    filled = [cells[i] for i in used if i < len(cells) and cells[i]]
    return len(filled) >= 2 and all(looks_numeric(cell) for cell in filled)


def _units_row(
    lines: list[str], number: int, delimiter: str, names: list[str]
) -> tuple[list[str] | None, int | None, int]:
    """Return the cells and the line of the units row, if there is one, and the line after it."""
    number = _skip_blank(lines, number)
    if number >= len(lines):
        return None, None, number
    cells = split_cells(COMMENTED.sub("", lines[number]), delimiter)
    named = names if delimiter != "spaces" else cells  # notes stand right of the last name
    filled = [cell for cell, name in zip(cells, named, strict=False) if cell and name]
    if len(named) > 2 and _labels_a_value(cells):
        return None, None, number
    known = sum(is_unit(cell) for cell in filled)
    bracketed = bool(filled) and all(cell[0] in "([<{" for cell in filled)
    known += bracketed and all(cell in ("()", "[]", "<>", "{}") for cell in filled)
    if known and (bracketed or 2 * known >= len(filled)) and not any(map(looks_numeric, filled)):
        return cells, number, _skip_blank(lines, number + 1)
    return None, None, number


def _labels_a_value(cells: list[str]) -> bool:
    """Tell whether a line is a word and what it is: of ``Sample,a`` the a is no ampere."""
    word, *values = cells
    alone = values[:1] != [""] and not any(values[1:]) and len(values) > 0
    says = re.search(r"[^\W\d_]{3}", word) and not is_unit(word)
    return alone and bool(says) and plain(word) not in UNIT_LABELS


def _skip_blank(lines: list[str], number: int) -> int:
    while number < len(lines) and is_blank(lines[number]):
        number += 1
    return number
