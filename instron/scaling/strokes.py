"""Strokes of a crosshead: a log that turns back is split at its reversals."""

import itertools

import numpy as np
import pandas as pd

from instron.errors import Unscalable

FEWEST = 5  # rows of a stroke
BACKLASH = 0.02  # of the whole travel: what the crosshead may turn back without a new stroke
WHOLE = 0.5  # of the longest stroke: shorter ones only settle the specimen


def strokes(log: pd.DataFrame) -> list[pd.DataFrame]:
    """Return every outward stroke of a force log, displacement growing.

    Parameters
    ----------
    log
        Columns ``displacement`` [m] and ``force`` [N].

    Returns
    -------
    list of DataFrame
        The log's rows between a turning point and the next one outward, those that are at least
        half as long as the longest. ``attrs`` are the log's with ``direction`` (+1 or -1, the
        displacement was multiplied by it), ``stroke`` and ``strokes`` (number and count), and
        ``rows`` of the whole log.

    Raises
    ------
    Unscalable
        When the crosshead does not move, or only returns.
    """
    good = np.isfinite(log["displacement"]) & np.isfinite(log["force"])
    kept = log[good]
    d = kept["displacement"].to_numpy(dtype=float)
    if len(d) < FEWEST or np.ptp(d) == 0:
        raise Unscalable(f"{name_of(log)}: the crosshead does not move in {len(d)} rows")
    direction = 1 if d.max() - d[0] >= d[0] - d.min() else -1
    d = direction * d
    outward = [(a, b) for a, b in _legs(d) if d[b] > d[a] and b - a + 1 >= FEWEST]
    if not outward:
        raise Unscalable(f"{name_of(log)}: the crosshead only returns; no outward stroke")
    longest = max(d[b] - d[a] for a, b in outward)
    whole = [(a, b) for a, b in outward if d[b] - d[a] >= WHOLE * longest]
    found = []
    for number, (a, b) in enumerate(whole, start=1):
        part = kept.iloc[a : b + 1].assign(displacement=d[a : b + 1]).reset_index(drop=True)
        part.attrs = dict(log.attrs) | {"direction": direction}
        if "stroke" not in log.attrs:
            part.attrs |= {"stroke": number, "strokes": len(whole), "rows": len(log)}
        found.append(part)
    return found


def name_of(log: pd.DataFrame) -> str:
    """Return what a log is called in a message."""
    return str(log.attrs.get("specimen", log.attrs.get("source", "force log")))


def _legs(d: np.ndarray) -> list[tuple[int, int]]:
    """Return first and last row of every leg between reversals, which may wander by BACKLASH."""
    slack = BACKLASH * np.ptp(d)
    turns, i = [0], 0
    first = np.flatnonzero(np.abs(d - d[0]) > slack)[0]
    for sign in itertools.cycle((1, -1) if d[first] > d[0] else (-1, 1)):
        rest = sign * d[i:]
        back = np.flatnonzero(np.maximum.accumulate(rest) - rest > slack)
        stop = len(rest) if not len(back) else int(back[0])
        # Of equal places the last: a dwell at the turning point belongs to the stroke.
        top = stop - 1 - int(np.argmax(rest[:stop][::-1]))
        i += top
        turns.append(i)
        if not len(back):
            break
    return list(zip(turns[:-1], turns[1:], strict=True))
