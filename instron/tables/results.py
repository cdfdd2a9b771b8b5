"""Tables of results, a row a specimen, which are no log of one test."""

import re
from collections.abc import Sequence
from itertools import pairwise

from instron.errors import NoLog
from instron.headings.grammar import read_heading
from instron.headings.words import SPECIMEN, plain, word_set
from instron.numbers.numerals import looks_numeric
from instron.source.files import Source
from instron.tables.body import Body
from instron.tables.labels import BESIDE
from instron.tables.layout import split_cells

# A row is never a specimen of its own; a sample, though, may be a reading of the logger.
ONE_TEST = SPECIMEN - word_set("sample test run trial rep replicate")
NAMES = word_set("name label id")
CLOCK = re.compile(r"\d{1,2}:\d{2}")
MOST = 1000  # specimens


def _names_a_specimen_each(source: Source, body: Body, delimiter: str) -> str:
    """Return the heading of the column in which every row names another specimen, or "".

    Without a time, words that change from row to row are names whatever their column is called.
    """
    if not 1 < len(body.lines) <= MOST:
        return ""
    rows = [split_cells(source.line(int(line)), delimiter) for line in body.lines]
    timed = all("time" in specimen for specimen in body.header.specimens)
    used = set(body.header.used())
    for index, name in enumerate(body.header.names):
        cells = [row[index] if index < len(row) else "" for row in rows]
        if index in used or not _change(cells):
            continue
        words = set(plain(read_heading(name).name).split())
        named = words & (SPECIMEN | NAMES) and words <= SPECIMEN | BESIDE
        if all(map(looks_numeric, cells)):
            if named and words & ONE_TEST:
                return name
        elif named or not (timed or any(map(looks_numeric, cells)) or _counts(cells)):
            return name
    return ""


def _change(cells: Sequence[str]) -> bool:
    """Tell whether each cell is another than the one above, and none a time of a clock."""
    return (
        all(cells)
        and all(one != other for one, other in pairwise(cells))
        and not any(map(CLOCK.search, cells))
    )


def _counts(cells: Sequence[str]) -> bool:
    """Tell whether cells differ in their digits alone, as names of pictures do."""
    return len({re.sub(r"\d+", "", cell) for cell in cells}) == 1


def no_lists(source: Source, bodies: list[Body], delimiter: str) -> list[Body]:
    """Leave out tables in which every row is another specimen's.

    Raises
    ------
    NoLog
        When nothing else is in the file.
    """
    named = [_names_a_specimen_each(source, body, delimiter) for body in bodies]
    if all(named):
        line = bodies[0].header.line + 1
        raise NoLog(f"{source.path}: line {line}: every row has another '{named[0]}': results, a"
                    " row a specimen, and no log of a test")  # fmt: skip
    return [body for body, name in zip(bodies, named, strict=True) if not name]


def logs_only(bodies: list[Body]) -> list[Body]:
    """Leave out results: tables of a row or two, or without time, where others are longer.

    What is short under the names of a longer one is the rest of a test.
    """
    names = [b.header.names for b in bodies if len(b.lines) > 2]
    long = [b for b in bodies if len(b.lines) > 2 or b.header.names in names] or bodies
    return [b for b in long if all("time" in s for s in b.header.specimens)] or long
