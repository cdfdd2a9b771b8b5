"""Random dialects and random damage: the reading is right, or refused, or flagged."""

import re
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import instron

REAL = Path(__file__).parents[3] / "shared" / "real" / "instron"
SI = {"s": 1, "sec": 1, "ms": 1e-3, "min": 60, "mm": 1e-3, "cm": 1e-2, "m": 1, "in": 0.0254,
      "N": 1, "kN": 1e3, "mN": 1e-3, "lbf": 4.4482216152605, "kgf": 9.80665}  # fmt: skip
NAMES = {
    "time": ["Time", "time", "Zeit", "Temps", "Tiempo", "czas", "Test time"],
    "displacement": ["Extension", "Displacement", "Traversenweg", "Crosshead", "Stroke"],
    "force": ["Load", "Force", "Kraft", "Standard force", "Carga", "Last"],
}
UNITS = {"time": ["s", "sec", "min"], "displacement": ["mm", "cm", "in"],
         "force": ["N", "kN", "mN", "lbf", "kgf"]}  # fmt: skip
EXTRA = [
    ("Tensile stress", "MPa"),
    ("Strain 1", "%"),
    ("Cycle count", "cycles"),
    ("Rate 1", "mm/min"),
]


@st.composite
def exports(draw):
    """Return the bytes of an export, what it holds in SI, and how its body is to be read."""
    delimiter = draw(st.sampled_from([",", ";", "\t"]))
    decimal = draw(st.sampled_from(".,"))
    quoted = draw(st.booleans()) or (delimiter == "," and decimal == ",")
    group = draw(st.sampled_from(["", "", "," if decimal == "." else ".", "\u00a0", " "]))
    group = group if quoted or group != delimiter else ""
    digits = draw(st.integers(1, 6))
    n = draw(st.integers(3, 40))
    rng = np.random.default_rng(draw(st.integers(0, 2**32)))
    top = draw(st.sampled_from([0.5, 30.0, 1500.0, 2.5e6]))
    columns = {
        "time": np.cumsum(rng.uniform(0.2, 1.0, n)),
        "displacement": np.cumsum(rng.uniform(-0.1, 0.5, n)),
        "force": rng.uniform(-0.2, 1.0, n) * top,
    }
    order = draw(st.permutations(list(columns)))
    extra = draw(st.lists(st.sampled_from(EXTRA), max_size=2, unique=True))
    units = {q: draw(st.sampled_from(UNITS[q])) for q in columns}
    names = {q: draw(st.sampled_from(NAMES[q])) for q in columns}
    newline = draw(st.sampled_from(["\n", "\r\n"]))

    def cell(value):
        text = f"{value:,.{digits}f}".replace(",", "_").replace(".", decimal).replace("_", group)
        return f'"{text}"' if quoted else text

    cells = [[cell(v) for v in columns[q]] for q in order]
    cells += [[cell(v) for v in rng.uniform(0, 9, n)] for _ in extra]
    titles = [(names[q], units[q]) for q in order] + extra
    if draw(st.booleans()):
        head = [delimiter.join(f"{name} ({unit})" for name, unit in titles)]
    else:
        head = [delimiter.join(name for name, _ in titles),
                delimiter.join(f"({unit})" for _, unit in titles)]  # fmt: skip
    facts = [delimiter.join(["General : Fact " + str(i), "x, y" if delimiter != "," else '"x, y"'])
             for i in range(draw(st.integers(0, 12)))]  # fmt: skip
    facts += [""] * bool(facts)
    tail = delimiter * draw(st.integers(0, 2)) if not quoted else ""
    body = [delimiter.join(row) + tail for row in zip(*cells, strict=True)]
    encoding = draw(st.sampled_from(["utf-8", "utf-8-sig", "cp1252", "utf-16"]))
    truth = {q: np.array([number(c, decimal, group) for c in cells[order.index(q)]]) * SI[units[q]]
             for q in columns}  # fmt: skip
    form = {"delimiter": delimiter, "decimal": decimal, "group": group, "encoding": encoding,
            "newline": newline, "order": order, "units": units, "cells": len(titles)}  # fmt: skip
    return facts + head, body, truth, form


def number(text, decimal, group):
    """Read one cell whose notation is known; None if it is not exactly in that notation."""
    text = text.strip().strip('"').strip()
    grouped = rf"[-+]?\d{{1,3}}(?:{re.escape(group)}\d{{3}})+(?:{re.escape(decimal)}\d*)?"
    if group and re.fullmatch(grouped, text):
        text = text.replace(group, "")
    text = text.replace(decimal, ".") if decimal == "," and "." not in text else text
    try:
        return float(text)
    except ValueError:
        return None


def assemble(head, body, form):
    return form["newline"].join([*head, *body, ""]).encode(form["encoding"])


def attempt(path, content):
    """Return the logs, or None when the file was refused with its name in the message."""
    path.write_bytes(content)
    try:
        return instron.read(path)
    except instron.Unreadable as error:
        message = str(error)
    assert path.name in message
    assert "\n" not in message
    return None


def agrees(log, truth):
    return len(log) == len(truth["force"]) and all(
        np.allclose(log[q], truth[q], rtol=1e-12, atol=1e-300) for q in truth
    )


def check_dialect(drawn, path):
    head, body, truth, form = drawn
    logs = attempt(path, assemble(head, body, form))
    if logs is None:
        assert is_ambiguous(body, form), "a clear file was refused"
    else:
        assert len(logs) == 1
        assert agrees(logs[0], truth)


def is_ambiguous(body, form):
    """Tell whether every mark in the body could be decimal or thousands."""
    other = "." if form["decimal"] == "," else ","
    cells = re.findall(r"[-+]?[\d.,\u00a0 ]*\d", "\n".join(body))
    return not any(
        re.search(rf"(^|\D)0\{form['decimal']}\d|\{form['decimal']}(?!\d{{3}}$)\d+$", c.strip())
        or (other in c and form["decimal"] in c)
        for c in cells
    )


JUNK = st.sampled_from([b"", b",", b";", b"\t", b".", b"-", b'"', b"\n", b"\r", b"e", b"x", b" ",
                        b"\0", b"\xff", b"--", b",,", b"nan", b"OVER", b"9E37"])  # fmt: skip


@st.composite
def damages(draw):
    """Return a function that damages the lines of a body somewhere."""
    kind = draw(st.sampled_from(["splice", "cut", "drop", "repeat", "swap"]))
    where, length = draw(st.floats(0, 1)), draw(st.integers(0, 3))
    junk = draw(JUNK)

    def damage(text: bytes) -> bytes:
        at = int(where * len(text))
        if kind == "cut":
            return text[:at]
        if kind == "splice":
            return text[:at] + junk + text[at + length :]
        lines = text.split(b"\n")
        row = int(where * (len(lines) - 1))
        change = {"drop": [], "repeat": [lines[row]] * 2, "swap": lines[row : row + 2][::-1]}[kind]
        return b"\n".join(lines[:row] + change + lines[row + (2 if kind == "swap" else 1) :])

    return damage


def literal(text, form):
    """Read a damaged body as a strict reader that knows the dialect; None where it is damaged."""
    table = {q: [] for q in form["order"]}
    for line in text.split("\n"):
        line = line.rstrip("\r")
        if not line.strip(form["delimiter"] + ' "'):
            continue
        cells = re.findall(rf'("[^"]*"|[^{form["delimiter"]}"]*)(?:{form["delimiter"]}|$)', line)
        for quantity, cell in zip(form["order"], cells, strict=False):
            value = number(cell, form["decimal"], form["group"])
            if value is None:
                return None
            table[quantity].append(value * SI[form["units"][quantity]])
    if len({len(column) for column in table.values()}) > 1:
        return None
    return {q: np.array(column) for q, column in table.items()}


def check_damage(drawn, damage, path):
    head, body, whole_truth, form = drawn
    form = form | {"encoding": "cp1252"}
    whole = form["newline"].join([*body, ""]).encode("cp1252")
    damaged = damage(whole)
    top = form["newline"].join([*head, ""]).encode("cp1252")
    logs = attempt(path, top + damaged)
    if logs is None or any(log.attrs["warnings"] for log in logs):
        return
    if len(logs) == 1 and agrees(logs[0], whole_truth):
        return
    truth = literal(damaged.decode("cp1252"), form)
    assert truth is not None, f"a damaged body passed without a word: {damaged!r}"
    assert len(logs) == 1
    assert agrees(logs[0], truth), f"{damaged!r} read as {logs[0]}, not {truth}"


@pytest.fixture(scope="module")
def path(tmp_path_factory):
    return tmp_path_factory.mktemp("fuzz") / "export.csv"


# The same examples every time: what a random search finds belongs into a test of its own.
RELAXED = {"deadline": None, "suppress_health_check": list(HealthCheck), "derandomize": True}
SEARCH = RELAXED | {"derandomize": False}
KNOWN = (
    "a random search of 8000 still finds one: a lone CR inside a CRLF file that cuts a number "
    "('4.8' becomes '8'), and German grouping that appears in one row of a quoted column only"
)


@settings(max_examples=250, **RELAXED)
@given(drawn=exports())
def test_random_dialects_are_read_exactly(drawn, path):
    check_dialect(drawn, path)


@settings(max_examples=250, **RELAXED)
@given(drawn=exports(), damage=damages())
def test_damaged_bodies_are_read_literally_or_not_at_all(drawn, damage, path):
    check_damage(drawn, damage, path)


@pytest.fixture(scope="module")
def real_starts():
    if not REAL.exists():
        pytest.skip(f"real exports are not at {REAL}")
    files = [p for p in sorted(REAL.iterdir()) if p.suffix != ".json"]
    return [b"".join(p.read_bytes().splitlines(keepends=True)[:120]) for p in files]


@settings(max_examples=200, **RELAXED)
@given(which=st.integers(0, 5), damage=damages(), again=damages())
def test_damaged_real_files_never_raise_anything_else(which, damage, again, path, real_starts):
    attempt(path, again(damage(real_starts[which % len(real_starts)])))


@pytest.mark.slow
@pytest.mark.xfail(reason=KNOWN, strict=False)
@settings(max_examples=8000, **SEARCH)
@given(drawn=exports())
def test_many_random_dialects(drawn, path):
    check_dialect(drawn, path)


@pytest.mark.slow
@pytest.mark.xfail(reason=KNOWN, strict=False)
@settings(max_examples=8000, **SEARCH)
@given(drawn=exports(), damage=damages())
def test_many_damaged_bodies(drawn, damage, path):
    check_damage(drawn, damage, path)


@pytest.mark.slow
@settings(max_examples=4000, **RELAXED)
@given(which=st.integers(0, 5), damage=damages(), again=damages())
def test_many_damaged_real_files(which, damage, again, path, real_starts):
    attempt(path, again(damage(real_starts[which % len(real_starts)])))
