"""What stands before the data: metadata, specimen names, and results the file itself states."""

import re
from collections.abc import Mapping
from dataclasses import dataclass

from instron.headings.grammar import quantity_of, split_unit
from instron.headings.units import Unit, read_unit
from instron.headings.words import UNIT, plain, word_set
from instron.numbers.numerals import Unclear, decimal_mark, looks_numeric, to_numbers
from instron.tables.footer import is_statistic
from instron.tables.layout import Header, split_cells

MAXIMUM = word_set(
    "max maximum maximal maximale maxima maximo peak hochst ultimate massimo fmax hochstkraft"
    " maximalkraft"
)
LOAD = word_set("load force kraft last carga charge forza carico fmax hochstkraft maximalkraft")
# What may stand beside those two without making it another quantity or another place.
BESIDE = word_set("tensile compressive compression flexure flexural standard test value the of")
LONGEST_TABLE = 60  # lines
_WORDS = re.compile(r"[^\W\d_]{3}")
LABEL = re.compile(r"specimen (label|name|id)|sample (name|id|label)|^specimen$|^sample$|probe\b")

LONE_LABEL = re.compile(
    r"(?i)((?:specimen|sample|probe|probeta|éprouvette|provino) \S+"
    r"|(?:test run|test|run|versuch|essai|ensayo|prova)(?: no\.| nr\.)? \d+)(?: raw data)?"
)


@dataclass(frozen=True)
class StatedMaximum:
    """A maximum load that the file states about itself."""

    value: float
    unit: str | None
    line: int
    text: str


def metadata(lines: list[str], delimiter: str) -> dict[str, str]:
    """Return ``key: value [unit]`` of the lines before a header."""
    found: dict[str, str] = {}
    for number, line in enumerate(lines):
        cells = [cell for cell in split_cells(line.lstrip("\ufeff"), delimiter) if cell]
        if len(cells) == 1 and (mark := re.search(r"[:=]", cells[0])):
            cells = [part.strip() for part in cells[0].split(mark[0], 1)]
        if cells and cells[0]:
            key = cells[0].rstrip(": ")
            key = key if key not in found else f"{key} (line {number + 1})"
            found[key] = " ".join(cells[1:])
    return found


def stated_units(facts: Mapping[str, str]) -> dict[str, Unit]:
    """Return the units that lines such as ``Force unit: kgf`` or ``Unit, N`` state, by quantity."""
    found: dict[str, list[Unit]] = {}
    for fact, rest in facts.items():
        key, _, value = f"{fact} : {rest}".partition(":")
        key = re.sub(r"(?<=[a-z])(?=[A-Z])", " ", key)
        words = [word for word in plain(key).split() if word not in UNIT | {"of", "der"}]
        units = list(filter(None, map(read_unit, re.split(r"[\s,;:/]+", value))))
        if len(words) == len(plain(key).split()) or len(words) > 2:
            continue
        for unit in units:
            if unit.quantity != "other" and (not words or quantity_of(key) == unit.quantity):
                found.setdefault(unit.quantity, []).append(unit)
    return {q: units[0] for q, units in found.items() if all(map(units[0].agrees, units))}


def specimen_label(lines: list[str], delimiter: str) -> str | None:
    """Return the name that ``Specimen label, A1`` or ``[Specimen 1]`` gives, or None."""
    for line in lines:
        cells = [cell.strip("[]() ") for cell in split_cells(line, delimiter) if cell]
        if len(cells) == 1 and (alone := LONE_LABEL.fullmatch(cells[0])):
            return alone[1]
        for key, value in metadata([line], delimiter).items():
            if value and LABEL.search(plain(key)) and not _heads_table(line, delimiter):
                return value
    return None


def _heads_table(line: str, delimiter: str) -> bool:
    """Tell whether a line names columns, and is no name with its value and perhaps a unit."""
    cells = [cell for cell in split_cells(line, delimiter) if cell]
    return len(cells) > 3 or (len(cells) == 3 and read_unit(cells[2]) is None)


def listed_labels(lines: Mapping[int, str], delimiter: str) -> list[str]:
    """Return the specimens' names of a table of results, a row each, or none."""
    for number, line in lines.items():
        cells = split_cells(line, delimiter)
        column = next((i for i, cell in enumerate(cells) if LABEL.search(plain(cell))), None)
        if column is None or not _heads_table(line, delimiter):
            continue
        rows = _until_blank(lines, number, delimiter)
        rows = [row for row in rows if any(map(looks_numeric, row)) and not is_statistic(row)]
        return [row[column] if column < len(row) else "" for row in rows]
    return []


def _until_blank(lines: Mapping[int, str], number: int, delimiter: str) -> list[list[str]]:
    """Return the cells of the lines below one, up to a blank one."""
    found = []
    for below in range(number + 1, number + LONGEST_TABLE):
        cells = split_cells(lines.get(below, ""), delimiter)
        if not any(cells):
            break
        found.append(cells)
    return found


def labels_above(lines: list[str], header: Header, delimiter: str) -> list[str]:
    """Return the specimen names of the row above side-by-side headers, as many as there are."""
    firsts = [min(c.index for c in specimen.values()) for specimen in header.specimens]
    for line in reversed(lines[max(0, header.line - 3) : header.line]):
        cells = split_cells(line, delimiter)
        bounds = [*firsts[1:], len(cells)]
        names = [
            next((cell for cell in cells[max(0, a - (k == 0)) : b] if cell and _is_name(cell)), "")
            for k, (a, b) in enumerate(zip(firsts, bounds, strict=True))
        ]
        if all(names):
            return names
    return []


def _is_name(cell: str) -> bool:
    return plain(cell) not in {"name", "specimen", "sample", "unit", "title"}


def stated_maxima(lines: Mapping[int, str], delimiter: str) -> list[StatedMaximum]:
    """Return every maximum load stated in these lines, in key-value or table form."""
    found = []
    for number, line in lines.items():
        if not _WORDS.search(line):
            continue
        cells = split_cells(line, delimiter)
        for index, cell in enumerate(cells):
            if _is_maximum_load(cell):
                found += _beside(cells, index, number) or _below(lines, number, index, delimiter)
    return found


def _is_maximum_load(cell: str) -> bool:
    """Tell whether the cell names a maximum load, and not what was reached there.

    Of ``Maximum Load : Extension at Maximum Load`` the last part counts, and every word of it.
    """
    words = set(plain(split_unit(cell.rpartition(" : ")[2])[0]).split())
    return bool(words & MAXIMUM and words & LOAD) and words <= MAXIMUM | LOAD | BESIDE


def _beside(cells: list[str], index: int, number: int) -> list[StatedMaximum]:
    """Read ``Maximum load, 1442.21, N``."""
    if index + 1 >= len(cells) or index > 1 or not looks_numeric(cells[index + 1]):
        return []
    value = _number(cells[index + 1])
    unit = cells[index + 2] if index + 2 < len(cells) and read_unit(cells[index + 2]) else None
    unit = unit or split_unit(cells[index])[1]
    return [] if value is None else [StatedMaximum(value, unit, number, cells[index])]


def _below(
    lines: Mapping[int, str], number: int, index: int, delimiter: str
) -> list[StatedMaximum]:
    """Read a results table: the column under ``Maximum Load``, its unit in the cell or a row."""
    unit, found = split_unit(split_cells(lines[number], delimiter)[index])[1], []
    for offset in range(1, LONGEST_TABLE):
        line = lines.get(number + offset, "")
        cells = split_cells(line, delimiter)
        cell = cells[index] if index < len(cells) else ""
        if offset == 1 and read_unit(cell):
            unit = cell
        elif looks_numeric(cell) and not re.match(
            r"(?i)\s*\"?(mean|sd|std|stand|cv|min|max)", line
        ):
            value = _number(cell)
            if value is not None:
                found.append(StatedMaximum(value, unit, number + offset, "maximum load"))
        elif found or offset > 2:
            break
    return found


def _number(cell: str) -> float | None:
    """Return a lone number; one that allows two readings is no check."""
    try:
        mark = decimal_mark([cell])
        return float(to_numbers([cell], mark)[0][0])
    except Unclear:
        return None
