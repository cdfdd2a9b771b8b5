"""What is refused or flagged in numbers that were read without error."""

import math
from collections.abc import Sequence

import numpy as np
import pandas as pd

from instron.errors import Unreadable
from instron.preamble import StatedMaximum
from instron.units import factor
from instron.words import unit_of

FILL_VALUES = (-999999.0, -1e6, -1e9)
HUGE = 9e36
SLOW = 0.05e-3 / 60  # m/s: slower than any combing or tensile test


def refuse_fill_values(where: str, quantity: str, values: np.ndarray, lines: Sequence[int]) -> None:
    """Refuse infinities and the constants that loggers write where nothing was measured."""
    if values.max() < HUGE and values.min() > max(FILL_VALUES):
        return
    bad = (np.abs(values) >= HUGE) | np.isin(values, FILL_VALUES)
    if bad.any():
        row = int(np.flatnonzero(bad)[0])
        raise Unreadable(
            f"{where}: line {lines[row] + 1}: {quantity} {values[row]:g} is a fill value, not a"
            " measurement"
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


def milliseconds(table: pd.DataFrame) -> list[str]:
    """Flag times that only make sense as milliseconds under a header that says seconds."""
    time, travel = table["time"].to_numpy(), table["displacement"].to_numpy()
    duration = time[-1] - time[0]
    if len(time) < 10 or not duration >= len(time) - 1:
        return []
    speed = np.ptp(travel) / duration
    if 0 < speed < SLOW and np.array_equal(time, np.round(time)):
        return [
            f"time may be in ms although the header says s: whole numbers, {duration:g} s long,"
            f" crosshead at {speed * 6e4:.2g} mm/min"
        ]
    return []


def against_stated(
    where: str, tables: list[pd.DataFrame], stated: list[StatedMaximum], written: str | None
) -> list[list[str]]:
    """Compare each table's peak with the maximum load its file states.

    A ratio of a power of ten is a decimal or unit misread and is refused; another difference is
    flagged (the machine may have measured the maximum between two exported rows).
    """
    notes: list[list[str]] = [[] for _ in tables]
    usable = [(s, _newtons(s, written)) for s in stated]
    values = [(s, v) for s, v in usable if v]
    for number, table in enumerate(tables if values else []):
        peaks = [abs(table["force"].max()), abs(table["force"].min())]
        matched = values[number : number + 1] if len(values) == len(tables) else values
        gaps = [min(abs(math.log(p / abs(v))) if p else math.inf for p in peaks)
                for _, v in matched]  # fmt: skip
        if not gaps or min(gaps) < 0.005:
            continue
        claim, value = matched[int(np.argmin(gaps))]
        tens = min(gaps) / math.log(10)
        text = f"line {claim.line + 1} states a maximum of {value:g} N, the rows reach"
        if round(tens) and abs(tens - round(tens)) < 0.003:
            raise Unreadable(f"{where}: {text} {max(peaks):g} N: a power of ten apart")
        notes[number].append(f"{text} {max(peaks):g} N")
    return notes


def _newtons(claim: StatedMaximum, written: str | None) -> float | None:
    unit = unit_of(claim.unit or written or "N")
    return claim.value * factor(unit[1], "force") if unit and unit[0] == "force" else None


def mixed_units(columns: list[dict[str, dict]]) -> list[str]:
    """Flag specimens of one file that are in different units."""
    for quantity in ("time", "displacement", "force"):
        units = sorted({str(c[quantity]["unit"]) for c in columns if quantity in c})
        if len(units) > 1:
            return [f"specimens differ in the unit of {quantity}: {', '.join(units)}"]
    return []
