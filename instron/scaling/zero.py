"""Zero and sign of a load cell, and whether the record ends with a free tine."""

from dataclasses import dataclass

import numpy as np

from instron.scaling.rig import Rig

QUIET = 0.05  # the share of the rows at the end that is looked at for a free tine
FIRST = 0.01  # the share of the rows at the start that count as before combing, or half a length
LOADED = 0.5  # an end that is this far up from the start to the highest force bears load
APART = 6.0  # sd of the averaged force from which on start and end disagree
PUSHED = 0.1  # of the rows below such a zero, by 15 % of the highest force: combing does not push
PUSH = 0.15
LIKE_DRIFT = 0.25  # relative: the slope of the free end explains the difference of start and end


@dataclass(frozen=True)
class Zero:
    """What is taken off the force, and what is said of it.

    Attributes
    ----------
    level
        Force that means nothing [N], a number or one a row.
    sign
        +1 or -1: by which the force is multiplied so that it is positive where it resists.
    rule, warnings
        In words.
    start, free
        Medians of the first and the last rows [N].
    rows
        That ``free`` is the median of.
    suspect
        Whether start and end disagree by more than noise.
    drift
        Standard uncertainty of the zero by what start and end differ [N].
    """

    level: np.ndarray | float
    sign: int
    rule: str
    warnings: list[str]
    start: float
    free: float
    rows: int
    suspect: bool
    drift: float


def find_zero(
    F: np.ndarray, smooth: np.ndarray, noise: float, rows: float, rig: Rig, after: int = 0
) -> Zero:
    """Return the zero and the sign by the rig's rules.

    Parameters
    ----------
    F, smooth
        Readings, and their average over the stated length [N].
    noise
        Standard deviation of ``smooth`` [N].
    rows
        Rows to the averaging length.
    after
        Rows after combing where they are known; where they are too few, or the force still fades
        there, the last QUIET of all count as such.
    """
    span = float(np.ptp(smooth))
    size = max(3, int(QUIET * len(F)))
    first = max(3, int(min(FIRST * len(F), rows / 2)))
    begin, doubt = _begin(F[: max(5, first)])
    if after > size and (
        _is_quiet(F[-after:], 0.2 * span, noise) or _is_drift(F, smooth, begin, after, span, noise)
    ):
        size = after
    start, free = float(np.median(F[:first])), float(np.median(F[-size:]))
    quiet = _is_quiet(F[-size:], span, noise)
    loaded = _bears_load(smooth, begin, free, rig.force_sign)
    limit = max(APART * float(np.hypot(noise, doubt)), 0.01 * span)
    suspect = abs(free - begin) > limit
    drifting = _drifts(smooth, begin, free, size)
    loaded = loaded or (suspect and not drifting and _pushes(smooth, begin, free, rig.force_sign))
    rule = rig.zero
    notes: list[str] = []
    if rule == "auto":
        if suspect and drifting and not loaded:
            rule = "drift"
        elif quiet and not loaded:
            rule = "free"
        else:
            rule = "none"
            notes = ["the log does not end at a quiet force, so the file's own zero is kept"]
    line = begin + (free - begin) * np.linspace(0, 1 / (1 - 0.5 * size / len(F)), len(F))
    table: dict[str, tuple[np.ndarray | float, str]] = {
        "none": (0.0, "none"),
        "start": (start, f"start: median of the first {first} rows"),
        "free": (free, f"free: median of the last {size} rows"),
        "drift": (line, "drift: line from start to free end"),
    }
    level, words = table[rule]
    sign = rig.force_sign or _sign(smooth - level, smooth - begin, loaded)
    drift = _drift_doubt(rule, abs(free - begin), 2 * doubt)
    return Zero(level, sign, words, notes, start, free, size, suspect, drift)


def _is_quiet(end: np.ndarray, span: float, noise: float) -> bool:
    """Tell whether the force at the end neither falls nor wanders: the tine is free.

    By medians of its quarters, which a touch does not move.
    """
    levels = [float(np.median(part)) for part in np.array_split(end, min(4, len(end)))]
    return max(levels) - min(levels) <= max(0.02 * span, 4 * noise)


def _is_drift(
    F: np.ndarray, smooth: np.ndarray, start: float, after: int, span: float, noise: float
) -> bool:
    """Tell whether the end is a line, quiet beside that, which explains the force at the start."""
    row = np.arange(after)
    rest = F[-after:] - np.polyval(np.polyfit(row, F[-after:], 1), row)
    free = float(np.median(F[-after:]))
    return _is_quiet(rest, 0.2 * span, noise) and _drifts(smooth, start, free, after)


def _begin(F: np.ndarray) -> tuple[float, float]:
    """Return the force at the first row by a line through the first rows, and its sd.

    Force may rise from the first row on; that is no zero that has moved.
    """
    row = np.arange(len(F))
    slope, begin = np.polyfit(row, F, 1)
    rest = F - begin - slope * row
    return float(begin), float(2 * np.sqrt((rest**2).sum() / max(1, len(F) - 2) / len(F)))


def _bears_load(smooth: np.ndarray, start: float, free: float, sign: int) -> bool:
    """Tell whether the end lies well up between the start and the highest force."""
    away = sign * (smooth - start) if sign else _outward(smooth - start)
    top = float(away.max())
    end = sign * (free - start) if sign else float(away[-1])
    return top > 0 and end > LOADED * top


def _pushes(smooth: np.ndarray, start: float, free: float, sign: int) -> bool:
    """Tell whether the end as zero would make much of the force pull the tine along."""
    sign = sign or (1 if np.ptp(smooth - start) == 0 else _sign(smooth - start, smooth, False))
    away = sign * (smooth - start)
    most = PUSH * float(away.max())
    return (
        sign * (free - start) > most
        and float(np.mean(away < sign * (free - start) - most)) > PUSHED
    )


def _drift_doubt(rule: str, apart: float, noise: float) -> float:
    """Return the standard uncertainty of the zero where start and end are ``apart`` [N].

    What is more than noise may have come about anywhere in between: a uniform distribution of that
    width. Of a drift taken off as a line, what a drift that is none would leave.
    """
    width = float(np.sqrt(max(0.0, apart**2 - noise**2)))
    share = {"free": 1.0, "start": 1.0, "drift": LIKE_DRIFT, "none": 0.0}[rule]
    return share * width / np.sqrt(12)


def _outward(F: np.ndarray) -> np.ndarray:
    """Return F with the sign that makes its largest excursion positive."""
    return F if F.max() >= -F.min() else -F


def _drifts(smooth: np.ndarray, start: float, free: float, size: int) -> bool:
    """Tell whether the slope of the end, carried back to the start, meets the force there."""
    rows = np.arange(len(smooth))
    slope = np.polyfit(rows[-size:], smooth[-size:], 1)[0]
    back = free - slope * (len(smooth) - size / 2)
    return abs(back - start) <= LIKE_DRIFT * abs(free - start)


def _sign(F: np.ndarray, risen: np.ndarray, loaded: bool) -> int:
    """Return the sign of the larger excursion from zero; of a loaded end from the start."""
    excursion = risen if loaded else F
    return 1 if excursion.max() >= -excursion.min() else -1
