"""Specimens stacked under one header and told apart by columns of labels."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from instron.errors import Unreadable
from instron.headings.grammar import read_heading
from instron.headings.words import SPECIMEN, plain, word_set
from instron.numbers.numerals import is_count, looks_numeric
from instron.source.files import Source
from instron.tables.body import Body
from instron.tables.layout import split_cells

BESIDE = {"id", "name", "label", "no", "number", "nr", "nummer", "num", "index"}
LABELS = SPECIMEN | word_set("id name label file filename datei dateiname fichier archivo path"
                             " material group batch condition treatment type fiber fibre faser"
                             " hair strand filament")  # fmt: skip
# What changes within a test.
STAGE = word_set("step segment stage phase section part block cycle cycles loop zyklus cyclus ramp"
                 " hold loading unloading load unload state status event count counter line row"
                 " point frame image index direction")  # fmt: skip
FEWEST = 5  # rows of a specimen
JUMP = 0.5  # of the travel: what a crosshead does not do from one row to the next
USUAL = 20  # usual steps
NEAR = 0.05  # of the travel: where a test begins that begins where another did
GRID = 2000  # rows that are looked at for a label, before those between


@dataclass(frozen=True)
class _Labels:
    """The cells of a table beside those in use."""

    source: Source
    body: Body
    delimiter: str

    def row(self, row: int) -> list[str]:
        return split_cells(self.source.line(int(self.body.lines[row])), self.delimiter)

    def key(self, columns: Sequence[int]) -> Callable[[int], tuple[str, ...]]:
        """Return what gives the cells of some columns in a row."""

        def cells(row: int) -> tuple[str, ...]:
            found = self.row(row)
            return tuple(found[i] if i < len(found) else "" for i in columns)

        return cells

    def named(self) -> list[int]:
        """Return the columns whose heading names specimens, or files, materials and the like."""
        return [i for i, words in self.beside() if words & LABELS and words <= LABELS | BESIDE]

    def worded(self) -> list[int]:
        """Return the columns that begin with a word, which is no stage of a test."""
        first = self.row(0)
        return [i for i, words in self.beside()
                if i < len(first) and first[i] and not looks_numeric(first[i])
                and STAGE.isdisjoint(words.union(plain(first[i]).split()))]  # fmt: skip

    def runs(self, columns: Sequence[int]) -> tuple[list[int], list[str]]:
        """Return where the cells of some columns change, and what they call each run of rows.

        Nothing unless every run is long enough to be a specimen's, and called otherwise.
        """
        key, count = self.key(columns), len(self.body.lines)
        starts = _changes(key, count) if columns else []
        runs = list(pairwise([0, *starts, count]))
        if not starts or any(b - a < FEWEST or key(a) != key(b - 1) for a, b in runs):
            return [], []
        labels = _names(key, starts)
        return (starts, labels) if all(labels) and len(set(labels)) == len(labels) else ([], [])

    def unlike(self, starts: Sequence[int]) -> list[int]:
        """Return the columns of one word or number in each run of rows, which is no stage of it."""
        runs = list(pairwise([0, *starts, len(self.body.lines)]))
        firsts, lasts = ([self.row(row) for row in rows]
                         for rows in ([a for a, _ in runs], [b - 1 for _, b in runs]))  # fmt: skip
        found = []
        for i, words in self.beside():
            one, other = ([row[i] if i < len(row) else "" for row in rows]
                          for rows in (firsts, lasts))  # fmt: skip
            said = words.union(*(plain(cell).split() for cell in one))
            counts = words.isdisjoint(SPECIMEN | BESIDE) and _counts(one)
            if one == other and all(one) and said.isdisjoint(STAGE) and not counts:
                found.append(i)
        return found

    def beside(self) -> list[tuple[int, set[str]]]:
        """Return the columns that are not in use, with the words of their headings."""
        used = set(self.body.header.used())
        names = enumerate(self.body.header.names)
        return [(i, set(plain(read_heading(n).name).split())) for i, n in names if i not in used]


def _counts(cells: Sequence[str]) -> bool:
    """Tell whether cells are 1, 2, 3, which may as well be cycles."""
    return all(is_count(c) for c in cells) and all(int(b) - int(a) == 1 for a, b in pairwise(cells))


def by_label(source: Source, bodies: list[Body], delimiter: str) -> list[Body]:
    """Split tables where columns of specimen names change and the test starts anew.

    Raises
    ------
    Unreadable
        When a table without time jumps back and no such column tells why.
    """
    return [part for body in bodies for part in _parts(_Labels(source, body, delimiter))]


def _parts(table: _Labels) -> list[Body]:
    body = table.body
    alone = "time" in body.header.specimens[0] and not table.beside()
    if len(body.header.specimens) > 1 or alone:
        return [body]
    restarts, named = _restarts(body), table.named()
    starts, labels = table.runs(named)
    if starts and set(restarts) <= set(starts) and all(_anew(body, row) for row in starts):
        return _cut(body, starts, labels)
    if restarts and all(_elsewhere(body, row) for row in restarts):
        labels = _names(table.key(table.unlike(restarts)), restarts)
        if len(set(labels)) == len(labels):
            return _cut(body, restarts, labels)
    if restarts and "time" not in body.header.specimens[0]:
        _refuse(table.source, body, restarts[0])
    for columns in [named, *([i] for i in table.worded() if i not in named)]:
        starts, labels = table.runs(columns)
        if starts:
            body.warnings.append(_one_test(table, columns[0], starts[0]))
    return [body]


def _changes(key: Callable[[int], tuple[str, ...]], count: int) -> list[int]:
    """Return the rows whose label is another than that of the row before.

    Of a long table every so many rows are looked at, then those between two that differ.
    """
    rows = np.unique(np.linspace(0, count - 1, GRID).astype(int))
    labels, found = list(map(key, rows)), []
    for (low, before), (high, after) in pairwise(zip(map(int, rows), labels, strict=True)):
        if before != after:
            while high - low > 1:
                middle = (low + high) // 2
                low, high = (middle, high) if key(middle) == before else (low, middle)
            found.append(high)
    return found


def _names(key: Callable[[int], tuple[str, ...]], starts: Sequence[int]) -> list[str]:
    """Return what each run of rows is called, by those of its cells that change."""
    cells = list(zip(*(key(row) for row in (0, *starts)), strict=True))
    telling = [column for column in cells if len(set(column)) > 1]
    return [", ".join(parts) for parts in zip(*telling, strict=True)] or [""] * (len(starts) + 1)


def _restarts(body: Body) -> list[int]:
    """Return the rows at which a test starts anew: time, or else displacement, jumps back."""
    specimen = body.header.specimens[0]
    if "time" in specimen:
        starts = np.flatnonzero(np.diff(body.values[specimen["time"].index]) < 0) + 1
    else:
        starts = np.flatnonzero(_jumps(body)) + 1
    lengths = np.diff([0, *starts, len(body.lines)])
    return list(map(int, starts)) if lengths.min() >= FEWEST else []


def _jumps(body: Body) -> np.ndarray:
    """Tell from row to row whether the displacement jumps, as no crosshead does."""
    x = body.values[body.header.specimens[0]["displacement"].index]
    size = np.abs(np.diff(x))
    usual = float(np.median(size[size > 0])) if size.any() else 0.0
    return np.asarray(size > max(JUMP * np.ptp(x), USUAL * usual))


def _elsewhere(body: Body, row: int) -> bool:
    """Tell whether the displacement of a row is not where the row before leaves off, but where
    the first row has it, or far from both.
    """
    x = body.values[body.header.specimens[0]["displacement"].index]
    near = abs(x[row] - x[0]) <= NEAR * np.ptp(x)
    steps = np.abs(np.diff(x[max(row - USUAL, 0) : row]))
    return bool(near or abs(x[row] - x[row - 1]) > USUAL * float(np.median(steps)) > 0)


def _anew(body: Body, row: int) -> bool:
    """Tell whether a test starts at a row: its time or its displacement begins again."""
    specimen = body.header.specimens[0]
    time = body.values[specimen["time"].index] if "time" in specimen else None
    return (time is not None and bool(time[row] < time[row - 1])) or _elsewhere(body, row)


def _one_test(table: _Labels, column: int, row: int) -> str:
    (before,), (after,) = map(table.key([column]), (row - 1, row))
    name, line = table.body.header.names[column], int(table.body.lines[row]) + 1
    return (
        f"line {line}: '{name}' changes from '{before}' to '{after}', but no test is seen to begin"
        " there: read as one test"
    )


def _cut(body: Body, starts: Sequence[int], labels: list[str]) -> list[Body]:
    """Return a body for each run of rows, named by its label."""
    lines = np.asarray(body.lines)
    bounds = [0, *starts, len(lines)]
    return [
        replace(body, values={i: v[a:b] for i, v in body.values.items()}, lines=lines[a:b],
                label=label, warnings=list(body.warnings))
        for a, b, label in zip(bounds[:-1], bounds[1:], labels, strict=True)
    ]  # fmt: skip


def _refuse(source: Source, body: Body, row: int) -> None:
    values = body.values[body.header.specimens[0]["displacement"].index]
    raise Unreadable(
        f"{source.path}: line {int(np.asarray(body.lines)[row]) + 1}: displacement jumps from"
        f" {values[row - 1]:g} to {values[row]:g} in one row: tests appended without a header?"
    )
