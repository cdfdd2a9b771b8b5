"""Specimens stacked under one header and told apart by a column of labels."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from instron.errors import Unreadable
from instron.headings.grammar import read_heading
from instron.headings.words import SPECIMEN, plain
from instron.source.files import Source
from instron.tables.body import Body
from instron.tables.layout import split_cells

BESIDE = {"id", "name", "label", "no", "number", "nr", "nummer", "num", "index"}
FEWEST = 5  # rows of a specimen
JUMP = 0.5  # of the travel: what a crosshead does not do from one row to the next
USUAL = 20  # usual steps


def by_label(source: Source, bodies: list[Body], delimiter: str) -> list[Body]:
    """Split tables where a column of specimen names changes and the test starts anew.

    Raises
    ------
    Unreadable
        When a table without time jumps back and no such column tells why.
    """
    found: list[Body] = []
    for body in bodies:
        column, timed = _label_column(body), "time" in body.header.specimens[0]
        starts = _starts(body) if column is not None or not timed else []
        labels = _labels(source, body, starts, column, delimiter) if column is not None else []
        if len(set(labels)) == len(starts) + 1 and starts:
            found += _cut(body, starts, labels)
            continue
        if starts and not timed:
            _refuse(source, body, starts[0])
        found.append(body)
    return found


def _starts(body: Body) -> Sequence[int]:
    """Return the rows at which a test starts anew: time, or else displacement, jumps back."""
    specimen = body.header.specimens[0]
    if len(body.header.specimens) > 1:
        return []
    values = body.values[specimen["time" if "time" in specimen else "displacement"].index]
    steps = np.diff(values)
    size = np.abs(steps)
    if "time" in specimen:
        starts = np.flatnonzero(steps < 0) + 1
    else:
        usual = float(np.median(size[size > 0])) if size.any() else 0.0
        starts = np.flatnonzero(size > max(JUMP * np.ptp(values), USUAL * usual)) + 1
    lengths = np.diff([0, *starts, len(values)])
    return list(map(int, starts)) if lengths.min() >= FEWEST else []


def _label_column(body: Body) -> int | None:
    """Return the column whose heading names specimens."""
    used = set(body.header.used())
    for index, name in enumerate(body.header.names):
        words = set(plain(read_heading(name).name).split())
        if index not in used and words & SPECIMEN and words <= SPECIMEN | BESIDE:
            return index
    return None


def _labels(
    source: Source, body: Body, starts: Sequence[int], column: int, delimiter: str
) -> list[str]:
    """Return what each run of rows is called, if its first and last row agree."""
    bounds = [0, *starts, len(body.lines)]
    ends = [[_cell(source, int(body.lines[k]), column, delimiter) for k in (a, b - 1)]
            for a, b in zip(bounds[:-1], bounds[1:], strict=True)]  # fmt: skip
    return [first for first, last in ends if first == last]


def _cell(source: Source, line: int, column: int, delimiter: str) -> str:
    cells = split_cells(source.line(line), delimiter)
    return cells[column] if column < len(cells) else ""


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
