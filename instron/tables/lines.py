"""The ledger of a file: every line has one role, and the sum comes out."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from instron.errors import Unreadable
from instron.numbers.numerals import looks_numeric
from instron.source.files import Source
from instron.tables.body import Body
from instron.tables.footer import is_statistic
from instron.tables.layout import Header, is_blank, split_cells

ROLES = ("blank", "metadata", "heading", "units", "block head", "data", "end mark", "lost")
BLANK, METADATA, HEADING, UNITS, BLOCK_HEAD, DATA, END_MARK, LOST = range(len(ROLES))
SOME = 20  # specimens that a table of results may count
FEW = 3  # rows of another table that a log need not be warned of


@dataclass(frozen=True)
class Ledger:
    """The role of every line, as a number into ``ROLES``."""

    roles: np.ndarray

    def counts(self) -> dict[str, int]:
        """Return how many lines have each role; their sum is the number of lines."""
        found = {role: int(np.count_nonzero(self.roles == k)) for k, role in enumerate(ROLES)}
        return {role: count for role, count in found.items() if count}

    def spans(self, role: int) -> list[tuple[int, int]]:
        """Return first and last line, from 1, of every run of lines with a role."""
        found = self.roles == role
        if not found.any():
            return []
        edges = np.diff(np.concatenate([[False], found, [False]]).astype(np.int8))
        firsts, stops = np.flatnonzero(edges == 1) + 1, np.flatnonzero(edges == -1)
        return [(int(a), int(b)) for a, b in zip(firsts, stops, strict=True)]


def ledger(
    source: Source,
    bodies: Sequence[Body],
    taken: Sequence[Body],
    odd: Mapping[int, int],
    delimiter: str,
) -> Ledger:
    """Return the role of every line of a file.

    Parameters
    ----------
    source
        The file.
    bodies, taken
        All tables of it, and those that became logs.
    odd
        Role of each line among the rows that is no data.
    delimiter
        What divides its cells.

    Raises
    ------
    Unreadable
        If a line has two roles or none, which would be a fault of the reader.
    """
    last = max(int(body.lines[-1]) for body in bodies)
    roles = np.full(source.count, BLANK, dtype=np.uint8)
    above = 0
    for body in bodies:
        for number in range(above, body.header.first_row):
            roles[number] = _role(source, body.header, number, above, delimiter)
        rows = body.lines
        if not isinstance(rows, range):
            for number in set(range(int(rows[0]), int(rows[-1]))).difference(map(int, rows)):
                roles[number] = BLANK if is_blank(source.line(number)) else BLOCK_HEAD
        roles[slice(rows.start, rows.stop) if isinstance(rows, range) else np.asarray(rows)] = (
            DATA if any(body is log for log in taken) else LOST
        )
        above = int(rows[-1]) + 1
    roles[_rows_above(source, bodies[0].header, delimiter)] = LOST
    for number in range(last + 1, len(roles)):
        roles[number] = _role(source, None, number, last, delimiter)
    for number, role in odd.items():
        roles[number] = role
    _check(source, roles, bodies)
    return Ledger(roles)


def _role(source: Source, header: Header | None, number: int, above: int, delimiter: str) -> int:
    """Return the role of a line that is no row of a table that was read."""
    line = source.line(number)
    if is_blank(line):
        return BLANK
    if header and header.line <= number < header.first_row:
        return UNITS if number == header.units else HEADING
    if not above:
        return METADATA
    cells = [cell for cell in split_cells(line, delimiter) if cell]
    if is_statistic(cells):
        return METADATA
    if 2 * sum(map(looks_numeric, cells)) > len(cells) > 1:
        return LOST
    return BLOCK_HEAD if header else METADATA


def _rows_above(source: Source, header: Header, delimiter: str) -> list[int]:
    """Return the lines above the first table that its rows look like: their own heading is damaged.

    Results, a row a specimen, are as wide as rows by chance alone, and few; some count specimens.
    """
    found: list[int] = []
    run: list[list[str]] = []
    for number in range(header.line + 1):
        cells = split_cells(source.line(number), delimiter) if number < header.line else []
        if len(cells) == header.width and all(map(looks_numeric, cells)):
            run.append(cells)
            continue
        if len(run) >= (SOME if _counts(run) else FEW):
            found += range(number - len(run), number)
        run = []
    return found


def _counts(rows: Sequence[list[str]]) -> bool:
    """Tell whether the first cells count from 1."""
    return [row[0] for row in rows] == [str(i + 1) for i in range(len(rows))]


def _check(source: Source, roles: np.ndarray, bodies: Sequence[Body]) -> None:
    """Refuse a reading in which rows were counted that the file has not."""
    rows = sum(len(body.lines) for body in bodies)
    given = np.count_nonzero(roles >= DATA)
    if given < rows or max(int(b.lines[-1]) for b in bodies) >= len(roles):
        raise Unreadable(f"{source.path}: {rows} rows were read of {given} lines: mixed line ends?")


def lost_lines(found: Ledger) -> list[str]:
    """Name the rows of numbers that are in no log."""
    spans = [(a, b) for a, b in found.spans(LOST) if b - a + 1 >= FEW]
    return [f"lines {a} to {b}: {b - a + 1} rows of another table, or without a heading, not read"
            for a, b in spans]  # fmt: skip
