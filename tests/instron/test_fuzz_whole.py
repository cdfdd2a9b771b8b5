"""Whole files with all that stands around rows, and damage to a line of them.

Channel lines above, marks between blocks, statistics and words below, names and units of rows in
cells of their own: none of it is a row, and no row is taken for any of it without a word.
"""

import re

import numpy as np
import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

STEADY, SEARCH = settings.get_profile("steady"), settings.get_profile("search")
JUNK = st.sampled_from(["", ",", ";", "\t", ".", "-", "x", "e", " ", "\n", "nan", "OVER", "Mean",
                        "1e9", "--", "End", "0", "#"])  # fmt: skip
SAID = re.compile(r"\d+|'[^']*'")  # what changes from one warning to the next of its kind


def _numbers(draw):
    """Return rows of time, displacement and force with their decimals."""
    n = draw(st.integers(6, 30))
    rng = np.random.default_rng(draw(st.integers(0, 2**32)))
    t = np.round(np.arange(n) * 0.1, 1)
    return np.column_stack([t, np.round(t * 0.25 + 0.5, 4), np.round(rng.uniform(1, 9, n), 3)])


@st.composite
def files(draw):
    """Return lines with their roles, the columns and scales of t, d, F, and the delimiter."""
    mark = draw(st.sampled_from([",", ";", "\t"]))
    kind = draw(st.sampled_from(["plain", "index", "row names", "unit cells", "units between"]))
    numbers = _numbers(draw)
    names, units = ["Time", "Stroke", "Force"], ["s", "mm", draw(st.sampled_from(["N", "kN"]))]
    at, lead, pattern = [0, 1, 2], [], "{0}|{1}|{2}"
    head = [mark.join(names), mark.join(units)]
    if kind in ("index", "row names"):
        at, pattern = [1, 2, 3], "{i}|{0}|{1}|{2}"
        lead = ["No."] if kind == "index" else []
        head = [mark.join([*lead, *names]), mark.join([""] * len(lead) + units)]
    elif kind == "unit cells":
        at, pattern = [0, 2, 4], f"{{0}}|{units[0]}|{{1}}|{units[1]}|{{2}}|{units[2]}"
        head = [mark.join(["Time", "Unit", "Stroke", "Unit", "Force", "Unit"])]
    elif kind == "units between":
        head = [mark.join(cell for pair in zip(names, units, strict=True) for cell in pair)]
    rows = [pattern.format(*row, i=i + 1).replace("|", mark) for i, row in enumerate(numbers)]
    lines = [("meta", f"Operator{mark}Zoe"), ("blank", "")]
    again = draw(st.sampled_from(["", "", "mark", "heading"])) if kind == "plain" else ""
    if again == "mark":
        lines.append(("mark", f"Segment{mark}1"))
    lines += [("head", line) for line in head]
    if draw(st.booleans()) and kind == "plain":
        lines += [("channel", mark.join(["Range", "9", "50", "500"][: len(names)])),
                  ("channel", mark.join(["CH No", "1", "2"]))]  # fmt: skip
    middle = draw(st.integers(3, len(rows) - 3)) if again else len(rows)
    lines += [("row", row) for row in rows[:middle]]
    if again == "mark":
        lines.append(("mark", f"Segment{mark}2"))
    elif again:
        lines += [("blank", ""), *(("head", line) for line in head)]
    lines += [("row", row) for row in rows[middle:]]
    for tail in draw(st.lists(st.sampled_from(["Mean", "CV %", "Max", "CHECKSUM"]), max_size=2)):
        cells = [tail] + ["4.25"] * (1 if tail == "CHECKSUM" else max(at))
        lines.append(("tail", mark.join(cells)))
    return lines, numbers, at, [1, 1e-3, 1e3 if units[2] == "kN" else 1], mark


@st.composite
def damages(draw):
    """Return a function that damages a line that is no heading."""
    kind = draw(st.sampled_from(["splice", "splice", "cut", "drop", "repeat", "swap"]))
    where, place, length = draw(st.floats(0, 1)), draw(st.floats(0, 1)), draw(st.integers(0, 3))
    junk = draw(JUNK)

    def damage(lines):
        able = [i for i, (role, _) in enumerate(lines) if role not in ("head", "meta")]
        i = able[int(where * (len(able) - 1))]
        role, line = lines[i]
        at = int(place * len(line))
        if kind == "cut":
            return [*lines[:i], (role, line[:at])], False
        new = {"drop": [], "repeat": [lines[i]] * 2, "swap": lines[i : i + 2][::-1],
               "splice": [(role, line[:at] + junk + line[at + length :])]}[kind]  # fmt: skip
        return lines[:i] + new + lines[i + (2 if kind == "swap" else 1) :], True

    return damage


def _text(lines, closed=True):
    return ("\n".join(line for _, line in lines) + "\n" * closed).encode()


def _kinds(log):
    return {SAID.sub("#", note) for note in log.attrs["warnings"]}


def _is_read(log, numbers, scales):
    columns = ("time", "displacement", "force")
    return len(log) == len(numbers) and all(
        np.allclose(log[q], numbers[:, k] * scales[k], rtol=1e-12) for k, q in enumerate(columns)
    )


def _strict(lines, at, mark, width):
    """Return the numbers of the rows by one who knows which lines they are; None if damaged."""
    found = []
    for role, text in lines:
        for line in text.split("\n") if role == "row" else []:
            if not line.strip():
                continue
            cells = line.split(mark)
            good = [re.fullmatch(r"\s*-?(\d+\.?\d*|\.\d+)(e\d+)?\s*", cells[k])
                    if k < len(cells) else None for k in at]  # fmt: skip
            if not all(good) or len(cells) < width or any(map(str.strip, cells[width:])):
                return None
            found.append([float(match[0]) for match in good])
    return np.array(found)


def check_file(drawn, damage, attempt):
    """Read a file as it is; damaged, it is refused, warned of, or read by the letter."""
    lines, numbers, at, scales, mark = drawn
    whole = attempt(_text(lines))
    assert whole is not None
    assert len(whole) == 1
    assert _is_read(whole[0], numbers, scales), _text(lines).decode()
    after, closed = damage(lines)
    logs = attempt(_text(after, closed))
    if logs is None or any(_kinds(log) - _kinds(whole[0]) for log in logs):
        return
    width = next(text.count(mark) + 1 for role, text in lines if role == "row")
    truth = _strict(after, at, mark, width)
    said = f"{_text(after, closed).decode()}\nread as\n{pd.concat(logs)}"
    assert truth is not None, f"a damaged row passed without a word: {said}"
    assert len(logs) == 1, f"one test was parted without a word: {said}"
    assert _is_read(logs[0], truth, scales), said


@settings(STEADY, max_examples=250)
@given(drawn=files(), damage=damages())
def test_what_stands_around_rows_is_no_row(drawn, damage, attempt):
    check_file(drawn, damage, attempt)


@pytest.mark.slow
@settings(SEARCH, max_examples=4000)
@given(drawn=files(), damage=damages())
def test_much_stands_around_rows(drawn, damage, attempt):
    check_file(drawn, damage, attempt)
