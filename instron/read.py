"""Read the export of a testing machine into force logs: exactly, or not at all."""

import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from instron.errors import NoLog, Unreadable
from instron.headings.columns import Channel, Specimen, Told
from instron.headings.units import Unit, read_unit
from instron.headings.words import QUANTITIES
from instron.source.files import HEAD_BYTES, Source, open_source
from instron.source.sheet import Sheet
from instron.source.testxpert import is_series, specimens
from instron.source.workbook import is_workbook, sheets
from instron.tables.bodies import read_bodies
from instron.tables.body import Body
from instron.tables.checks import (
    against_stated,
    drop_jump_back,
    end_marks,
    milliseconds,
    mixed_units,
    refuse_fill_values,
    refuse_moved_points,
    refuse_other_units,
    refuse_torn_decimals,
)
from instron.tables.join import joined
from instron.tables.labels import by_label
from instron.tables.layout import (
    DELIMITERS,
    Header,
    find_header,
    is_row,
    split_cells,
)
from instron.tables.lines import END_MARK, LOST, Ledger, ledger, lost_lines
from instron.tables.nolog import why_no_log
from instron.tables.preamble import (
    labels_above,
    listed_labels,
    metadata,
    specimen_label,
    stated_maxima,
    stated_units,
)
from instron.tables.results import logs_only, no_lists
from instron.tables.rewrite import REWRITERS

USUAL_UNITS = {"time": "s", "displacement": "mm", "force": "N"}
ONE_TEST = "MTS793|"  # a format that keeps the buffers of one test in one file


def read(
    path: str | Path,
    *,
    columns: Sequence[str] | Mapping[str, str] | None = None,
    units: Mapping[str, str] | None = None,
) -> list[pd.DataFrame]:
    """Return the force logs of an export, one per specimen.

    Parameters
    ----------
    path
        CSV or text export of Bluehill, Merlin, Series IX, Zwick, MTS, Shimadzu and the like, or a
        workbook (.xlsx, .xls, .ods), every sheet of which may hold specimens.
    columns
        Which heading is which quantity, where the file leaves a doubt: ``{"force": "Kraft Ist"}``
        (or ``"#4"``, the fourth column); the others are found as ever. For a file without a header
        a list: what its columns are, in order, of ``"time"``, ``"displacement"``, ``"force"``; any
        other word skips a column.
    units
        Units that the file does not state, e.g. ``{"force": "lbf"}``; of a column that
        ``columns`` names, also instead of what it states.

    Returns
    -------
    list of DataFrame
        Columns ``time`` [s] (NaN where the file has none), ``displacement`` [m], ``force`` [N],
        signs as in the file. ``attrs``: ``source``, ``specimen``, ``dialect``, ``columns`` (name
        and unit in the file), ``metadata``, ``stated``, ``lines`` (how many lines of the file have
        which role), ``lost_rows``, ``choices``, ``warnings``.

    Raises
    ------
    Unreadable
        With file, line and reason, whenever a number or its meaning is in doubt.
    FileNotFoundError
        When there is no such file.
    """
    path = Path(path)
    told = _told_of(path, columns, units or {})
    bare = None if isinstance(columns, Mapping) else columns
    if is_workbook(path):
        return _read_sheets(path, sheets(path), told, bare)
    if is_series(path):
        return _read_sheets(path, specimens(path, told.units), told, bare)
    return _read_source(open_source(path), told, bare)


def _read_sheets(
    path: Path, found: list[Sheet], told: Told, bare: Sequence[str] | None
) -> list[pd.DataFrame]:
    """Return the logs of every sheet that holds one; the others are named."""
    logs: list[pd.DataFrame] = []
    other: list[str] = []
    for sheet in found:
        try:
            tables = _read_source(sheet.source, told, bare)
        except NoLog as reason:
            other.append(f"sheet '{sheet.name}' is no force log")
            first = reason
            continue
        except Unreadable as error:
            if sheet.hollow is None:
                raise
            raise Unreadable(
                f"{sheet.source.path}: line {sheet.hollow}: a formula without a value: open the"
                " workbook in a spreadsheet program and save it"
            ) from error
        logs += [_of_sheet(log, path, sheet, len(tables)) for log in tables]
    if not logs and other:
        raise NoLog(str(first) if len(other) == 1 else f"{path}: no sheet holds a force log")
    if not logs:
        raise NoLog(f"{path}: the workbook is empty")
    for log in logs:
        log.attrs["choices"] += other
    return logs


def _of_sheet(log: pd.DataFrame, path: Path, sheet: Sheet, alike: int) -> pd.DataFrame:
    """Write into a log where in its workbook it comes from."""
    if log.attrs["specimen"] == sheet.source.path.stem and alike == 1:
        log.attrs["specimen"] = sheet.name
    log.attrs |= {"source": str(path), "file": path.name, "sheet": sheet.name}
    for quantity, column in log.attrs["columns"].items():
        count = sheet.formulas.get(column["index"], 0)
        if count:
            log.attrs["choices"].append(
                f"{quantity}: {count} cells are formulas; the values kept with them were read"
            )
    return log


def _read_source(source: Source, told: Told, bare: Sequence[str] | None) -> list[pd.DataFrame]:
    """Return the logs of a source as it stands, or rewritten where that shows no header."""
    try:
        return _read_tables(source, told, bare)
    except NoLog:
        other = next(filter(None, (write(source) for write in REWRITERS)), None)
        if other is None:
            raise
    rewritten, note = other
    logs = _read_tables(rewritten, told, bare)
    for log in logs:
        log.attrs |= {"source": str(source.path), "file": source.path.name}
        log.attrs["choices"].append(note)
    return logs


def _read_tables(source: Source, told: Told, bare: Sequence[str] | None) -> list[pd.DataFrame]:
    delimiter, header = _find(source, told, bare)
    bodies = read_bodies(source, header, delimiter, told)
    taken = logs_only(bodies if told.columns or bare else no_lists(source, bodies, delimiter))
    refuse_fill_values(source, taken)
    logs = joined(taken, source.head[0].startswith(ONE_TEST))
    _refuse_questions(source, logs)
    refuse_other_units(source, logs, delimiter)
    logs = by_label(source, logs, delimiter)
    outside = _outside(source, bodies, taken)
    stated = stated_maxima(outside, delimiter)
    odd = {body.cut: LOST for body in bodies if body.cut is not None}
    tables = [
        _table(source, body, number, delimiter, told, odd)
        for body in logs
        for number in range(len(body.header.specimens))
    ]
    _name(tables, listed_labels(outside, delimiter))
    _check_together(source, tables, stated)
    _account(tables, ledger(source, bodies, taken, odd, delimiter))
    return tables


def _outside(source: Source, bodies: list[Body], taken: list[Body]) -> dict[int, str]:
    """Return the lines that are no data of a log, of a single table those above it."""
    numbers: list[int] = []
    above = 0
    for body in bodies:
        numbers += range(above, body.header.line if len(bodies) == 1 else body.header.first_row)
        if not any(body is log for log in taken):
            numbers += map(int, body.lines)
        above = int(body.lines[-1]) + 1
    if len(bodies) > 1:
        numbers += range(above, source.count)
    return {number: source.line(number) for number in numbers}


def _name(tables: list[pd.DataFrame], labels: list[str]) -> None:
    """Give tables that are named after the file the names that a table of results lists.

    Tables that still have one name among them are numbered.
    """
    if len(labels) == len(tables) and all(labels):
        for table, label in zip(tables, labels, strict=True):
            if table.attrs["specimen"] == Path(table.attrs["file"]).stem:
                table.attrs["specimen"] = label
    names = [table.attrs["specimen"] for table in tables]
    if len(set(names)) == 1 < len(names):
        for number, table in enumerate(tables, 1):
            table.attrs["specimen"] += f" {number}"


def _account(tables: list[pd.DataFrame], found: Ledger) -> None:
    """Write into every table what became of the lines of its file."""
    for table in tables:
        table.attrs["lines"] = found.counts()
        table.attrs["warnings"] += lost_lines(found)


def _refuse_questions(source: Source, bodies: list[Body]) -> None:
    for body in bodies:
        if body.header.question:
            raise Unreadable(f"{source.path}: line {body.header.line + 1}: {body.header.question}")


def _told_of(
    path: Path, columns: Sequence[str] | Mapping[str, str] | None, units: Mapping[str, str]
) -> Told:
    """Return what the user said, checked."""
    for quantity, text in units.items():
        known = read_unit(text)
        if quantity not in QUANTITIES or known is None or known.quantity != quantity:
            raise Unreadable(f"{path}: told that {quantity} is in '{text}': no unit of {quantity}")
    headings = columns if isinstance(columns, Mapping) else {}
    for quantity in headings:
        if quantity not in QUANTITIES:
            raise Unreadable(f"{path}: told which column is {quantity}: say time, displacement or"
                             " force")  # fmt: skip
    return Told(headings, units)


def _find(source: Source, told: Told, bare: Sequence[str] | None) -> tuple[str, Header]:
    """Return the delimiter and the first header of the file."""
    for part in ("head", "lines") if len(source.data) > HEAD_BYTES else ("head",):
        lines = getattr(source, part)
        text = "\n".join(lines)
        present = {mark for mark in DELIMITERS if mark in text}
        for delimiter in [d for d in DELIMITERS if d in present or d == "spaces"]:
            header = (
                _told(lines, delimiter, bare) if bare
                else find_header(lines, delimiter, told=told)
            )  # fmt: skip
            if header is not None:
                header.doubts.extend(_same_above(lines, header.line))
                return delimiter, header
    raise NoLog(f"{source.path}: {why_no_log(source.lines, told)}")


def _same_above(lines: list[str], line: int) -> list[str]:
    """Name the lines above a header that are the same: what damaged their rows' beginning?"""
    return [f"line {number + 1}: the same heading, whose rows cannot be read"
            for number in range(line) if lines[number] == lines[line]]  # fmt: skip


def _told(lines: list[str], delimiter: str, columns: Sequence[str]) -> Header | None:
    """Return a header made of the columns the user named, for a file that has none."""
    specimen: Specimen = {q: Channel(list(columns).index(q), q, None) for q in QUANTITIES
                          if q in columns}  # fmt: skip
    for number, line in enumerate(lines[:200]):
        cells = split_cells(line, delimiter)
        if len(cells) >= len(columns) and is_row(cells, [c.index for c in specimen.values()]):
            names = [*columns, *[""] * (len(cells) - len(columns))]
            return Header(number - 1, number, len(cells), names, [specimen], [])
    return None


def _table(
    source: Source, body: Body, number: int, delimiter: str, told: Told, odd: dict[int, int]
) -> pd.DataFrame:
    """Return one specimen's table in SI, with what is known of it."""
    where, specimen = str(source.path), body.header.specimens[number]
    above = stated_units(_facts(source, body, delimiter))
    written = {q: _unit(q, c, told, above) for q, c in specimen.items()}
    keep = _complete_rows(source, body, specimen)
    ends = end_marks([body.values[specimen[q].index][keep] for q in QUANTITIES if q in specimen])
    lines: Sequence[int] = body.lines[keep]  # type: ignore[assignment]
    columns, notes = {}, [*body.warnings, *body.header.doubts]
    if ends:
        odd |= dict.fromkeys(map(int, lines[-ends:]), END_MARK)
        notes.append(f"line {lines[-1] + 1}: a last row of zeros: an end mark, not data")
        lines, keep = lines[:-ends], slice(0, len(lines) - ends)
    for quantity in QUANTITIES:
        if quantity not in specimen:
            columns[quantity] = np.full(len(lines), np.nan)
            notes.append(_why_no_time(body.header))
            continue
        unit, stated = written[quantity]
        values = body.values[specimen[quantity].index][keep]
        columns[quantity] = _in_si(where, quantity, values, lines, unit)
        notes += _doubts_of_unit(quantity, unit, stated)
    if delimiter == "," and "time" in specimen:
        raw = [body.values[c.index][keep] for c in specimen.values()]
        refuse_torn_decimals(where, raw, columns["time"])
    table = pd.DataFrame(columns, copy=False)
    kept, found = drop_jump_back(where, table, lines)
    if kept < len(table):
        odd[int(lines[-1])] = LOST
        table = table.iloc[:kept]
    table.attrs = _provenance(source, body, number, delimiter, written)
    notes += ["a single row"] * (len(table) == 1)
    notes += found + milliseconds(table, table.attrs["metadata"])
    table.attrs["warnings"] = notes
    table.attrs["lost_rows"] = _lost_rows(notes)
    return table


def _in_si(
    where: str, quantity: str, values: np.ndarray, lines: Sequence[int], unit: Unit
) -> np.ndarray:
    """Return a column in SI; values whose point has moved are refused."""
    if quantity != "time":  # which must not run back anyway
        refuse_moved_points(where, quantity, values, lines)
    scale = unit.to_si()
    return values if scale == 1 else values * scale


def _lost_rows(notes: Sequence[str]) -> int:
    """Return how many rows the warnings say are lost."""
    found = (re.search(r"(\d+) rows? lost", note) for note in notes)
    return sum(int(each[1]) for each in found if each)


def _why_no_time(header: Header) -> str:
    passed = [note for note in header.choices if note.startswith("time is 'absent'")]
    names = f" ({passed[0].partition('; ')[2]}: gaps, or hh:mm:ss)" if passed else ""
    return f"no time column: time is NaN{names}"


def _complete_rows(source: Source, body: Body, specimen: Specimen) -> slice:
    """Return the rows in which the specimen has all its numbers; only its end may lack any.

    Specimens side by side end at different rows, and spreadsheets leave rows of bare delimiters.
    """
    columns = [body.values[c.index] for c in specimen.values()]
    if not any(np.isnan(column.max()) for column in columns):
        return slice(None)
    gaps = np.isnan(np.array(columns))
    own = gaps[[q != "time" for q in specimen], :]
    empty = own.all(axis=0)
    broken = np.flatnonzero(gaps.any(axis=0) & ~empty)
    filled = np.flatnonzero(~empty)
    inner = np.flatnonzero(empty[: filled[-1] + 1]) if len(filled) else np.array([0])
    odd = np.union1d(broken, inner)
    if len(odd) == 1 and odd[0] == len(empty) - 1 and len(filled) > 1:
        body.warnings.append(f"line {body.lines[-1] + 1}: incomplete last row; 1 row lost")
        return slice(0, len(empty) - 1)
    if len(odd):
        raise Unreadable(f"{source.path}: line {body.lines[odd[0]] + 1}: a row lacks numbers")
    timed = ~gaps[:, filled[-1] + 1 :].all(axis=0)
    if timed.any() and len(body.header.specimens) == 1:
        line, rows = body.lines[filled[-1] + 1] + 1, "row" if timed.sum() == 1 else "rows"
        body.warnings.append(f"line {line}: a time alone to the end: {timed.sum()} {rows} lost")
    return slice(0, filled[-1] + 1)


def _unit(
    quantity: str, channel: Channel, told: Told, above: Mapping[str, Unit]
) -> tuple[Unit, bool]:
    """Return the unit of a column, and whether anybody stated it, in its head or above it."""
    said = read_unit(told.units[quantity]) if quantity in told.units else None
    unit = (said or channel.unit) if quantity in told.columns else (channel.unit or said)
    unit = unit or above.get(quantity)
    usual = USUAL_UNITS[quantity]
    return unit or Unit(usual, quantity, usual), unit is not None


def _doubts_of_unit(quantity: str, unit: Unit, stated: bool) -> list[str]:
    if not stated:
        return [f"the unit of {quantity} is not stated: taken as {unit.name}"]
    if unit.loose:
        return [f"'{unit.text}' is taken as 1000 kgf; a short ton is 907 kgf"]
    return []


def _head(source: Source, body: Body) -> list[str]:
    return source.head if body.header.line < len(source.head) else source.lines


def _above(source: Source, body: Body) -> list[str]:
    return _head(source, body)[body.above : body.header.line]


def _facts(source: Source, body: Body, delimiter: str) -> dict[str, str]:
    """Return what the lines above a table say."""
    return metadata(_above(source, body), delimiter)


def _provenance(
    source: Source,
    body: Body,
    number: int,
    delimiter: str,
    written: Mapping[str, tuple[Unit, bool]],
) -> dict[Any, Any]:
    """Return where a table comes from and how its file is written."""
    header, head = body.header, _head(source, body)
    facts = _facts(source, body, delimiter)
    names = labels_above(head, header, delimiter) if len(header.specimens) > 1 else []
    label = names[number] if names else specimen_label(_above(source, body), delimiter)
    return {
        "source": str(source.path),
        "specimen": body.label or label or source.path.stem,
        "dialect": {
            "encoding": source.written,
            "newline": source.newline,
            "delimiter": {"\t": "TAB"}.get(delimiter, delimiter),
            "decimal": body.decimal,
            "thousands": body.thousands,
            "header_line": header.line + 1,
            "first_row": header.first_row + 1,
            "side_by_side": len(header.specimens),
        },
        "columns": {
            q: {"name": c.name, "unit": written[q][0].text, "index": c.index}
            for q, c in header.specimens[number].items()
        },
        "all_columns": list(header.names),
        "choices": list(header.choices),
        "metadata": facts,
        "stated": {},
        "file": source.path.name,
    }


def _check_together(source: Source, tables: list[pd.DataFrame], stated: list) -> None:
    """Check the tables against the file's own results and against each other."""
    columns = [table.attrs["columns"] for table in tables]
    notes = against_stated(str(source.path), tables, stated, columns[0]["force"]["unit"])
    mixed = mixed_units(columns)
    for number, (table, found) in enumerate(zip(tables, notes, strict=True)):
        table.attrs["warnings"] += found + mixed
        if len(stated) == len(tables):
            table.attrs["stated"] = {
                "maximum load": f"{stated[number].value:g} {stated[number].unit or ''}".strip()
            }
        elif stated:
            table.attrs["stated"] = {
                "maximum load": [f"{s.value:g} {s.unit or ''}".strip() for s in stated]
            }
