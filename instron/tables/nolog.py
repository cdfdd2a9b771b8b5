"""Why a text is no force log: which part of one it lacks."""

from itertools import zip_longest

from instron.headings.columns import Told
from instron.headings.grammar import read_heading
from instron.headings.units import VOLTS, read_unit
from instron.tables.layout import DELIMITERS, LONGEST_HEADER, split_cells


def why_no_log(lines: list[str], told: Told) -> str:
    """Say which part of a force log the file lacks."""
    if told.columns:
        names = ", ".join(f'{q}="{text}"' for q, text in told.columns.items())
        return f"no heading that agrees with --column {names} over rows of numbers"
    for number, line in enumerate(lines[:400], start=1):
        if len(line) > LONGEST_HEADER:
            continue
        for delimiter in DELIMITERS[:4]:
            cells = split_cells(line, delimiter)
            headings = [read_heading(cell) for cell in cells]
            found = {heading.quantity for heading in headings} - {None}
            if len(found) < 2 or len(cells) < 2:
                continue
            below = split_cells(lines[number], delimiter) if number < len(lines) else []
            pairs = list(zip_longest(cells, below, fillvalue=""))
            if all(_in_volts(cell, unit) for cell, unit in pairs
                   if read_heading(cell).quantity in ("force", "displacement")):  # fmt: skip
                return f"line {number}: columns in volts: a voltage logger, not a force log"
            for cell, unit in pairs:
                wrong = _wrong_unit(cell, unit)
                if wrong:
                    return f"line {number}: {wrong}"
            if any(heading.role for heading in headings):
                found = {h.quantity for h in headings if not h.role}
            missing = [q for q in ("displacement", "force") if q not in found]
            if missing:
                return f"line {number}: no {' and no '.join(missing)} column in '{line[:60]}'"
            return (
                f"line {number}: a header, but no row of numbers follows it{_below(lines, number)}"
            )
    return (
        "no header that names displacement and force; for a bare table say what its columns are:"
        " columns=('time', 'displacement', 'force')"
    )


def _below(lines: list[str], start: int) -> str:
    """Quote the first line below a header that holds a digit, which it may be that is damaged."""
    digits = (n for n in range(start, len(lines)) if any(map(str.isdigit, lines[n])))
    first = next(digits, None)
    return "" if first is None else f": line {first + 1} is '{lines[first].strip()[:40]}'"


def _in_volts(cell: str, below: str) -> bool:
    unit = read_heading(cell, below).unit
    return unit is not None and unit.text.strip("()[] ").casefold() in VOLTS


def _wrong_unit(cell: str, below: str) -> str:
    """Say that a column's unit, in its cell or below, is not of the quantity it names, or ""."""
    heading = read_heading(cell, below if read_unit(below) else "")
    if heading.quantity is None or heading.unit is None or heading.fits:
        return ""
    return f"'{heading.name}' in '{heading.unit.text.strip('()[]')}' is no {heading.quantity}"
