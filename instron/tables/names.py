"""Names of columns that do not stand one above each: what the rows below a header tell of them."""

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from itertools import pairwise

from instron.headings.units import is_unit
from instron.headings.words import UNIT, plain
from instron.numbers.numerals import is_count, looks_numeric

FEWEST = 3  # rows that tell
Split = Callable[[str], list[str]]
QUOTED = re.compile(r'\s*"[^"]*"\s*[^\s"]')  # a name in quotes, then a number without


@dataclass(frozen=True)
class Names:
    """A header's names and units, one a column, and what was concluded to get there."""

    names: list[str]
    units: list[str] | None
    doubts: list[str] = field(default_factory=list)
    unit_cells: dict[int, str] = field(default_factory=dict)  # by column: the unit in every row


def fitted(names: list[str], units: list[str] | None, lines: Sequence[str], split: Split) -> Names:
    """Return names and units as they belong to the columns.

    Parameters
    ----------
    names, units
        Cells of the header and of a row of units.
    lines
        The first rows, among which others may stand.
    split
        How a line becomes cells.
    """
    rows, lines = _alike(lines, split)
    widths = {len(row) for row in rows}
    between = _units_between(names, widths) if units is None else None
    if between:
        return between
    numbered = _row_names(names, rows, lines)
    if numbered:
        return Names(["", *names], units and ["", *units], numbered)
    cells = _unit_cells(names, rows)
    if not cells:
        return Names(names, units)
    found = list(units or [])
    found += [""] * (max(cells) + 1 - len(found))
    for index, text in cells.items():
        left = max((i for i in range(index) if i not in cells), default=index)
        found[left] = found[left] or text
    return Names(names, found, unit_cells=cells)


def _alike(lines: Sequence[str], split: Split) -> tuple[list[list[str]], list[str]]:
    """Return the rows that have numbers in the columns in which the first row has them."""
    cells = [split(line) for line in lines]
    patterns = [[looks_numeric(cell) for cell in row] for row in cells]
    same = [i for i, pattern in enumerate(patterns) if pattern == patterns[0]]
    return [cells[i] for i in same], [lines[i] for i in same]


def _units_between(names: list[str], widths: set[int]) -> Names | None:
    """Take ``Time, s, Force, N`` apart, which stands over two columns."""
    between, before = names[1::2], names[::2]
    if {2 * width for width in widths} != {len(names)}:
        return None
    if not all(map(is_unit, between)) or any(map(is_unit, before)):
        return None
    return Names(before, between)


def _row_names(names: list[str], rows: Sequence[list[str]], lines: Sequence[str]) -> list[str]:
    """Say so where every row begins with its name or number, which has no heading.

    R writes tables so: one name less than columns.
    """
    if len(rows) < FEWEST or {len(row) for row in rows} != {len(names) + 1} or not all(names):
        return []
    if not all(row[-1] for row in rows):
        return []
    if all(map(QUOTED.match, lines)):
        return ["the first column has no name: a name or number of each row"]
    if _counts([row[0] for row in rows]):
        return ["there is a column more than names: the first, which counts, is taken for the rows'"
                " numbers"]  # fmt: skip
    return []


def _counts(cells: Sequence[str]) -> bool:
    """Tell whether cells count rows, of which some may have been left out."""
    if not all(is_count(cell) for cell in cells):
        return False
    steps = [int(after) - int(before) for before, after in pairwise(cells)]
    return min(steps) > 0 and sorted(steps)[len(steps) // 2] == 1


def _unit_cells(names: list[str], rows: Sequence[list[str]]) -> dict[int, str]:
    """Return the columns that hold the unit of the column before them in every row, and it."""
    found = {}
    for index, name in enumerate(names):
        if index == 0 or (name and not UNIT.issuperset(re.sub(r"\d", "", plain(name)).split())):
            continue
        texts = dict.fromkeys(row[index] for row in rows if index < len(row) and row[index])
        if texts and all(map(is_unit, texts)) and not any(map(looks_numeric, texts)):
            found[index] = " or ".join(texts)
    return found
