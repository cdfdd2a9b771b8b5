"""Blocks of one test, as a controller's buffers leave them, joined to one table."""

from dataclasses import replace

import numpy as np

from instron.tables.body import Body
from instron.tables.layout import Header

LONGEST_PAUSE = 20  # samples between two blocks of one test
SHORTEST = 2  # rows; a block of so few has no speed to go by


def joined(bodies: list[Body], one_test: bool) -> list[Body]:
    """Join blocks of one test: the same columns, and time and displacement run on.

    Parameters
    ----------
    bodies
        Tables in the order of the file.
    one_test
        Whether the file's format keeps one test a file, so that time alone decides.
    """
    kept: list[Body] = []
    for body in bodies:
        alike = bool(kept) and _alike(kept[-1].header, body.header)
        if alike and _runs_on(kept[-1], body, one_test):
            kept[-1].parts.append(body)
            continue
        if alike and (one := _half_runs_on(kept[-1], body)):
            body.warnings.append(f"line {body.lines[0] + 1}: {one}: read as another test")
        kept.append(replace(body, parts=[body]))
    return [_whole(body) for body in kept]


def _alike(one: Header, other: Header) -> bool:
    return len(one.specimens) == len(other.specimens) == 1 and one.specimens == other.specimens


def _near(x: np.ndarray, y: np.ndarray) -> bool:
    """Tell whether a displacement goes on where the one before leaves off."""
    step = np.abs(np.diff(x)).max(initial=0.0)
    return bool(abs(y[0] - x[-1]) <= 3 * step + 0.005 * np.ptp(x))


def _is_away(x: np.ndarray) -> bool:
    """Tell whether a displacement ends elsewhere than it begins, where any other test begins."""
    return bool(abs(x[-1] - x[0]) > 10 * np.abs(np.diff(x)).max(initial=0.0) > 0)


def _soon(t: np.ndarray, u: np.ndarray) -> bool:
    """Tell whether a time goes on after the one before, and soon."""
    return bool(0 <= u[0] - t[-1] <= LONGEST_PAUSE * np.diff(t).max(initial=0.0))


def _runs_on(before: Body, after: Body, one_test: bool) -> bool:
    """Tell whether a block goes on where the one before it ends."""
    last, specimen = before.parts[-1], before.header.specimens[0]
    x, y = (part.values[specimen["displacement"].index] for part in (last, after))
    if "time" not in specimen:
        return _near(x, y) and _is_away(x)
    t, u = (part.values[specimen["time"].index] for part in (last, after))
    if max(len(x), len(y)) <= SHORTEST:
        return bool(t[-1] < u[0])  # a row or two is no test of its own
    if one_test and _near(x, y) | (_cyclic(x) and _cyclic(y)):
        return bool(t[-1] <= u[0])
    return _near(x, y) and _soon(t, u)


def _half_runs_on(before: Body, after: Body) -> str:
    """Say so where only time or only displacement goes on: is a number at the seam damaged?"""
    last, specimen = before.parts[-1], before.header.specimens[0]
    if "time" not in specimen:
        return ""
    x, y = (part.values[specimen["displacement"].index] for part in (last, after))
    t, u = (part.values[specimen["time"].index] for part in (last, after))
    if _near(x, y):
        return "displacement runs on from the block above, time does not" * _is_away(x)
    return "time runs on from the block above, displacement does not" * _soon(t, u)


def _cyclic(x: np.ndarray) -> bool:
    """Tell whether a displacement goes forth and back: of such a test not every cycle is kept."""
    return bool(np.abs(np.diff(x)).sum() > 1.9 * np.ptp(x) > 0)


def _whole(body: Body) -> Body:
    """Return the parts of a test as one body that says so."""
    parts = body.parts
    if len(parts) == 1:
        return parts[0]
    values = {i: np.concatenate([part.values[i] for part in parts]) for i in body.values}
    lines = np.concatenate([np.asarray(part.lines) for part in parts])
    note = f"{len(parts)} blocks joined to one test: time and displacement run on"
    return replace(body, values=values, lines=lines, parts=[], cut=parts[-1].cut,
                   warnings=[*(w for part in parts for w in part.warnings), note])  # fmt: skip
