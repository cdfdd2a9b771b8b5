"""Read the export of a testing machine into force logs: exactly, or not at all."""

import re
from collections.abc import Mapping, Sequence
from itertools import zip_longest
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from instron.body import Body, read_bodies
from instron.checks import (
    against_stated,
    drop_jump_back,
    milliseconds,
    mixed_units,
    refuse_fill_values,
    refuse_moved_points,
    refuse_torn_decimals,
)
from instron.errors import Unreadable
from instron.layout import (
    DELIMITERS,
    LONGEST_HEADER,
    Channel,
    Header,
    Specimen,
    find_header,
    is_row,
    split_cells,
)
from instron.preamble import labels_above, metadata, specimen_label, stated_maxima
from instron.source import HEAD_BYTES, Source, open_source
from instron.units import factor
from instron.words import QUANTITIES, VOLTS, is_unit, quantity_of, split_unit, unit_of

CLOCK = re.compile(r"\s*\"?\d+:\d\d")
USUAL_UNITS = {"time": "s", "displacement": "mm", "force": "N"}


def read(
    path: str | Path,
    *,
    columns: Sequence[str] | None = None,
    units: Mapping[str, str] | None = None,
) -> list[pd.DataFrame]:
    """Return the force logs of an export, one per specimen.

    Parameters
    ----------
    path
        CSV or text export of Bluehill, Merlin, Series IX, Zwick, MTS, Shimadzu and the like.
    columns
        Only for a file without a header: what its columns are, in order, of ``"time"``,
        ``"displacement"``, ``"force"``; any other word skips a column.
    units
        Units that the file does not state, e.g. ``{"force": "lbf"}``.

    Returns
    -------
    list of DataFrame
        Columns ``time`` [s] (NaN where the file has none), ``displacement`` [m], ``force`` [N],
        signs as in the file. ``attrs``: ``source``, ``specimen``, ``dialect``, ``columns`` (name
        and unit in the file), ``metadata``, ``stated``, ``lost_rows``, ``warnings``.

    Raises
    ------
    Unreadable
        With file, line and reason, whenever a number or its meaning is in doubt.
    FileNotFoundError
        When there is no such file.
    """
    path = Path(path)
    _refuse_unknown_units(path, units or {})
    source = open_source(path)
    delimiter, header = _find(source, columns)
    bodies = _logs_only(read_bodies(source, header, delimiter))
    lines = source.head[: header.line] if len(bodies) == 1 else source.lines
    stated = stated_maxima(lines, delimiter)
    tables = [
        _table(source, body, number, delimiter, units or {})
        for body in bodies
        for number in range(len(body.header.specimens))
    ]
    _check_together(source, tables, stated)
    return tables


def _refuse_unknown_units(path: Path, told: Mapping[str, str]) -> None:
    for quantity, text in told.items():
        known = unit_of(text)
        if quantity not in QUANTITIES or known is None or known[0] != quantity:
            raise Unreadable(f"{path}: told that {quantity} is in '{text}': no unit of {quantity}")


def _find(source: Source, columns: Sequence[str] | None) -> tuple[str, Header]:
    """Return the delimiter and the first header of the file."""
    for part in ("head", "lines") if len(source.data) > HEAD_BYTES else ("head",):
        lines = getattr(source, part)
        present = {mark for mark in DELIMITERS if any(mark in line for line in lines)}
        for delimiter in [d for d in DELIMITERS if d in present or d == "spaces"]:
            header = _told(lines, delimiter, columns) if columns else find_header(lines, delimiter)
            if header is not None:
                return delimiter, header
    raise Unreadable(f"{source.path}: {_why_no_header(source.lines)}")


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


def _why_no_header(lines: list[str]) -> str:
    """Say which part of a force log the file lacks."""
    for number, line in enumerate(lines[:400], start=1):
        if len(line) > LONGEST_HEADER:
            continue
        for delimiter in DELIMITERS[:4]:
            cells = split_cells(line, delimiter)
            names = [split_unit(cell) for cell in cells]
            found = {quantity_of(name) for name, _ in names} - {None}
            if len(found) < 2 or len(cells) < 2:
                continue
            below = split_cells(lines[number], delimiter) if number < len(lines) else []
            marks = {(u or "").casefold() for _, u in names} | {c.strip("()[]").casefold()
                                                                for c in below}  # fmt: skip
            if marks & VOLTS:
                return f"line {number}: columns in volts: a voltage logger, not a force log"
            for name, unit in zip_longest(cells, below, fillvalue=""):
                wrong = _wrong_unit(name, unit)
                if wrong:
                    return f"line {number}: {wrong}"
            missing = [q for q in ("displacement", "force") if q not in found]
            if missing:
                return f"line {number}: no {' and no '.join(missing)} column in '{line[:60]}'"
            if any(
                CLOCK.match(cell) for x in lines[number : number + 3] for cell in x.split(delimiter)
            ):
                return f"line {number}: times written as hh:mm:ss; export the time in seconds"
            return f"line {number}: a header, but no row of numbers follows it"
    return (
        "no header that names displacement and force; for a bare table say what its columns are:"
        " columns=('time', 'displacement', 'force')"
    )


def _wrong_unit(cell: str, below: str) -> str:
    """Say that a column's unit, in its cell or below, is not of the quantity it names, or ""."""
    name, unit = split_unit(cell)
    unit, quantity = unit or below.strip("()[] "), quantity_of(name)
    known = unit_of(unit) if unit else None
    if quantity is None or not is_unit(unit) or (known and known[0] == quantity):
        return ""
    return f"'{name}' in '{unit}' is no {quantity}"


def _logs_only(bodies: list[Body]) -> list[Body]:
    """Leave out results: tables of a row or two, or without time, where others are longer."""
    long = [b for b in bodies if len(b.lines) > 2] or bodies
    return [b for b in long if all("time" in s for s in b.header.specimens)] or long


def _table(
    source: Source, body: Body, number: int, delimiter: str, told: Mapping[str, str]
) -> pd.DataFrame:
    """Return one specimen's table in SI, with what is known of it."""
    where, specimen = str(source.path), body.header.specimens[number]
    written = {q: _unit(source, body.header, q, c, told) for q, c in specimen.items()}
    keep = _complete_rows(source, body, specimen)
    lines = body.lines[keep]
    columns, notes = {}, list(body.warnings)
    for quantity in QUANTITIES:
        if quantity not in specimen:
            columns[quantity] = np.full(len(lines), np.nan)
            notes.append(f"no {quantity} column: {quantity} is NaN")
            continue
        values = body.values[specimen[quantity].index][keep]
        refuse_fill_values(where, quantity, values, lines)
        if quantity != "time":  # which must not run back anyway
            refuse_moved_points(where, quantity, values, lines)
        unit, stated = written[quantity]
        scale = factor(unit, quantity)
        columns[quantity] = values if scale == 1 else values * scale
        if not stated:
            notes.append(f"the unit of {quantity} is not stated: taken as {unit}")
    if delimiter == "," and "time" in specimen:
        raw = [body.values[c.index][keep] for c in specimen.values()]
        refuse_torn_decimals(where, raw, columns["time"])
    table = pd.DataFrame(columns, copy=False)
    kept, found = drop_jump_back(where, table, lines)
    table = table.iloc[:kept] if kept < len(table) else table
    table.attrs = _provenance(source, body, number, delimiter, written)
    notes += found + milliseconds(table, table.attrs["metadata"])
    table.attrs["warnings"] = notes
    table.attrs["lost_rows"] = sum("row lost" in note for note in notes)
    return table


def _complete_rows(source: Source, body: Body, specimen: Specimen) -> slice:
    """Return the rows in which the specimen has all its numbers; only its end may lack any.

    Specimens side by side end at different rows, and spreadsheets leave rows of bare delimiters.
    """
    columns = [body.values[c.index] for c in specimen.values()]
    if not any(np.isnan(column).any() for column in columns):
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
    return slice(0, filled[-1] + 1)


def _unit(
    source: Source, header: Header, quantity: str, channel: Channel, told: Mapping[str, str]
) -> tuple[str, bool]:
    """Return the pint unit of a column, and whether anybody stated it."""
    text = channel.unit or told.get(quantity)
    if text is None:
        return USUAL_UNITS[quantity], False
    known = unit_of(text)
    if known is None or known[0] != quantity:
        raise Unreadable(
            f"{source.path}: line {header.line + 1}: '{text}' of column '{channel.name}' is no"
            f" unit of {quantity} (known: s ms min, mm cm m in, N kN mN lbf kgf gf)"
        )
    return known[1], True


def _provenance(
    source: Source,
    body: Body,
    number: int,
    delimiter: str,
    written: Mapping[str, tuple[str, bool]],
) -> dict[Any, Any]:
    """Return where a table comes from and how its file is written."""
    header = body.header
    head = source.head if header.line < len(source.head) else source.lines
    facts = metadata(head[body.above : header.line], delimiter)
    names = labels_above(head, header, delimiter) if len(header.specimens) > 1 else []
    label = names[number] if names else specimen_label(facts)
    return {
        "source": str(source.path),
        "specimen": label or source.path.stem,
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
            q: {"name": c.name, "unit": c.unit or written[q][0], "index": c.index}
            for q, c in header.specimens[number].items()
        },
        "all_columns": list(header.names),
        "choices": list(header.choices),
        "metadata": facts,
        "stated": {},
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
