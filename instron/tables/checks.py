"""What is refused or flagged in numbers that were read without error."""

import math
import re
from collections.abc import Mapping, Sequence

import numpy as np
import pandas as pd

from instron.errors import Unreadable
from instron.headings.units import read_unit
from instron.source.files import Source
from instron.tables.body import Body
from instron.tables.layout import split_cells
from instron.tables.preamble import StatedMaximum

FILL_VALUES = (-999999.0, -1e6, -1e9)
HUGE = 9e36
PIECE = 1 << 14  # numbers
POUND, KILOGRAM = 4.4482216, 9.80665  # N
LEAST_SLIP = 0.5  # of the logarithm: pounds for kilograms are 0.8
SLOW = 0.05e-3 / 60  # m/s: slower than any combing or tensile test
SLOW_AND_SPARSE = 1e-3 / 60  # m/s: seldom sampled at less than once in 2 s
RATE = re.compile(r"(\d+(?:\.\d+)?)\s*(mm/min|mm/s)\b")


def refuse_fill_values(source: Source, bodies: Sequence[Body]) -> None:
    """Refuse infinities and the constants that loggers write where nothing was measured.

    Comes before anything is calculated: the difference of two infinities is no number.
    """
    for body in bodies:
        for specimen in body.header.specimens:
            for quantity, channel in specimen.items():
                _refuse_fill_values(source, quantity, body.values[channel.index], body.lines)


def _refuse_fill_values(
    source: Source, quantity: str, values: np.ndarray, lines: Sequence[int] | np.ndarray
) -> None:
    if values.max() < HUGE and values.min() > max(FILL_VALUES):
        return
    bad = (np.abs(values) >= HUGE) | np.isin(values, FILL_VALUES)
    if bad.any():
        row = int(np.flatnonzero(bad)[0])
        raise Unreadable(
            f"{source.path}: line {lines[row] + 1}: {quantity} {values[row]:g} is a fill value,"
            " not a measurement"
        )


def refuse_other_units(source: Source, bodies: Sequence[Body], delimiter: str) -> None:
    """Refuse rows whose own unit is not that of the first rows: a gauge that changes its range."""
    for body in bodies:
        for line in map(int, body.lines if body.header.unit_cells else ()):
            cells = split_cells(source.line(line), delimiter)
            for index, text in body.header.unit_cells.items():
                found = cells[index] if index < len(cells) else ""
                if found != text:
                    raise Unreadable(
                        f"{source.path}: line {line + 1}: the unit in column {index + 1} is"
                        f" '{found}', in the first rows '{text}'"
                    )


def refuse_moved_points(
    where: str, quantity: str, values: np.ndarray, lines: Sequence[int]
) -> None:
    """Refuse a column that jumps by ten or a hundred and back: a spreadsheet moved its points.

    Where it takes the point of 1.0114 for a thousands mark and 1.063 for what it is, a steady
    0.99 1.01 1.03 1.06 becomes 0.99 10.114 10.285 1.063. Such jumps are far larger than the
    column's usual step, of a power of ten, go both ways, and not always from the same level as
    those of a square wave.
    """
    every = len(values) // 10_000 + 1
    some = np.abs(values[1::every] - values[:-1:every])
    usual = float(np.median(some[some > 0])) if some.any() else 0.0
    if _largest_step(values) <= 20 * usual:
        return
    least = 0.05 * max(values.max(), -values.min())
    large = np.flatnonzero(np.abs(np.diff(values)) > 20 * usual)
    before, after = np.abs(values[large]), np.abs(values[large + 1])
    counts = (np.minimum(before, after) > 0) & (np.maximum(before, after) > least)
    large, tens = large[counts], np.log10(after[counts] / before[counts])
    power = (np.abs(tens - np.round(tens)) < 0.02) & (np.abs(tens) > 0.5)
    up, down = (np.count_nonzero(power & (sign * tens > 0)) for sign in (1, -1))
    low = np.minimum(before, after)[counts][power]
    if min(up, down) < 2 or low.max() < 1.5 * low.min():
        return
    row = int(large[power][0]) + 1
    raise Unreadable(
        f"{where}: line {lines[row] + 1}: {quantity} jumps from {values[row - 1]:g} to"
        f" {values[row]:g} and so on, by powers of ten and back: has a spreadsheet moved its"
        " decimal points?"
    )


def _largest_step(values: np.ndarray) -> float:
    """Return the size of the largest step, looked for in pieces that fit a core's cache."""
    buffer, largest = np.empty(PIECE), 0.0
    for first in range(0, len(values) - 1, PIECE):
        piece = values[first : first + PIECE + 1]
        steps = np.subtract(piece[1:], piece[:-1], out=buffer[: len(piece) - 1])
        largest = max(largest, float(steps.max()), -float(steps.min()))
    return largest


def _whole(values: np.ndarray) -> bool:
    """Tell whether all are whole numbers; mostly the first thousand show that they are not."""
    return all(np.array_equal(part, np.round(part)) for part in (values[:1000], values))


def refuse_torn_decimals(where: str, columns: Sequence[np.ndarray], time: np.ndarray) -> None:
    """Refuse whole numbers only whose times mostly repeat: what decimal commas leave of 0,1 0,2."""
    if len(time) < 50 or not all(map(_whole, columns)):
        return
    if np.median(np.diff(time)) == 0:
        raise Unreadable(
            f"{where}: whole numbers only, and most times repeat: decimal commas without quotes?"
        )


def drop_jump_back(where: str, table: pd.DataFrame, lines: Sequence[int]) -> tuple[int, list[str]]:
    """Return how many rows to keep, so that time does not run back, and what was found.

    A last row that jumps back is dropped; a jump elsewhere is refused, unless it is smaller than
    the usual time step.
    """
    time = table["time"].to_numpy()
    back = np.flatnonzero(time[1:] < time[:-1])
    if not len(back):
        return len(time), []
    steps = np.diff(time)
    usual = float(np.median(np.abs(steps)))
    large = back[-steps[back] > 1.5 * usual]
    if len(large) == 1 and large[0] == len(time) - 2:
        text = f"line {lines[-1] + 1}: time jumps back from {time[-2]:g} s to {time[-1]:g} s"
        return len(time) - 1, [f"{text}; this last row was dropped"]
    if len(large):
        row = int(large[0])
        raise Unreadable(
            f"{where}: line {lines[row + 1] + 1}: time jumps back from {time[row]:g} s to"
            f" {time[row + 1]:g} s: a damaged value, or tests appended without a header"
        )
    return len(time), [f"line {lines[back[0] + 1] + 1}: time steps back by less than one sample"]


def end_marks(columns: Sequence[np.ndarray]) -> int:
    """Return how many last rows are nothing but zeros that the test did not come back to."""
    zero = np.logical_and.reduce([column[-100:] == 0 for column in columns])
    count = len(zero) if zero.all() else int(np.argmin(zero[::-1]))
    if not count or count + 2 >= len(zero):
        return 0
    for column in columns[:-1]:  # a force may drop to nothing at once, time and travel may not
        before = column[: len(column) - count]
        if abs(before[-1]) > 3 * np.abs(np.diff(before)).max():
            return count
    return 0


def milliseconds(table: pd.DataFrame, metadata: Mapping[str, str]) -> list[str]:
    """Flag times that only make sense as milliseconds under a header that says seconds.

    Either the crosshead would be a thousand times slower than the speed the file states, or the
    times are whole numbers and it would be slower than any test.
    """
    time, travel = table["time"].to_numpy(), table["displacement"].to_numpy()
    duration = time[-1] - time[0]
    if len(time) < 10 or not duration >= len(time) - 1:
        return []
    speed = np.ptp(travel) / duration
    sparse = 0 < speed < SLOW_AND_SPARSE and _whole(time) and np.median(np.diff(time)) >= 2
    whole = sparse or (0 < speed < SLOW and _whole(time))
    if whole or any(300 < ratio < 3000 for ratio in _ratios(metadata, speed)):
        return [
            f"time may be in ms although the header says s: {duration:g} s long, crosshead at"
            f" {speed * 6e4:.2g} mm/min"
        ]
    return []


def _ratios(metadata: Mapping[str, str], speed: float) -> list[float]:
    """Return how many times faster than ``speed`` [m/s] the speeds in the metadata are."""
    found = [RATE.search(value) for value in metadata.values()]
    per = {"mm/min": 1e-3 / 60, "mm/s": 1e-3}
    return [float(m[1]) * per[m[2]] / speed for m in found if m and speed > 0]


def against_stated(
    where: str, tables: list[pd.DataFrame], stated: list[StatedMaximum], written: str | None
) -> list[list[str]]:
    """Compare each table's peak with the maximum load its file states.

    A ratio of a power of ten, or of pounds or kilograms to newtons besides, is a decimal or unit
    misread and is refused; another difference is flagged (the machine may have measured the
    maximum between two exported rows, or stated that of another specimen).
    """
    notes: list[list[str]] = [[] for _ in tables]
    usable = [(s, _newtons(s, written)) for s in stated]
    values = [(s, v) for s, v in usable if 0 < abs(v) < HUGE]
    for number, table in enumerate(tables if values else []):
        peaks = [peak for peak in (table["force"].max(), -table["force"].min()) if peak > 0]
        matched = values[number : number + 1] if len(values) == len(tables) else values
        gaps = [min(_gap(p, v) for p in peaks) for _, v in matched if peaks]
        if not gaps or min(gaps) < 0.005:
            continue
        claim, value = matched[int(np.argmin(gaps))]
        text = f"line {claim.line + 1} states a maximum of {value:g} N, the rows reach"
        if any(_is_slip(_gap(p, value)) for p in peaks):
            raise Unreadable(
                f"{where}: {text} {max(peaks):g} N: a power of ten or a unit of force apart"
            )
        notes[number].append(f"{text} {max(peaks):g} N")
    return notes


def _gap(peak: float, value: float) -> float:
    """Return the size of the logarithm of a ratio."""
    return abs(math.log(peak) - math.log(abs(value)))


def _is_slip(gap: float) -> bool:
    """Tell whether the logarithm of a ratio is that of units or decimals taken for others.

    Ten newtons for a kilogram are 2 % apart, as are many maxima between two exported rows.
    """
    if gap < LEAST_SLIP:
        return False
    units = (1.0, POUND, KILOGRAM, KILOGRAM / POUND)
    tens = [(gap + sign * math.log(unit)) / math.log(10) for unit in units for sign in (1, -1)]
    return any(abs(t - round(t)) < 0.003 for t in tens)


def _newtons(claim: StatedMaximum, written: str | None) -> float:
    """Return a stated maximum [N], 0 where its unit is none of force."""
    unit = read_unit(claim.unit or written or "N")
    return claim.value * unit.to_si() if unit and unit.quantity == "force" else 0.0


def mixed_units(columns: list[dict[str, dict]]) -> list[str]:
    """Flag specimens of one file that are in different units."""
    for quantity in ("time", "displacement", "force"):
        units = sorted({str(c[quantity]["unit"]) for c in columns if quantity in c})
        if len(units) > 1:
            return [f"specimens differ in the unit of {quantity}: {', '.join(units)}"]
    return []
