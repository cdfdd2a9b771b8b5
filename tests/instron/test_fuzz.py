"""Random dialects, and damage to them, to look-alikes and to real exports.

The reading is right, or refused, or flagged.
"""

import csv
import re
import runpy
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

STEADY, SEARCH = settings.get_profile("steady"), settings.get_profile("search")
REAL = Path(__file__).parents[3] / "shared" / "real" / "instron"
SI = {"s": 1, "sec": 1, "ms": 1e-3, "min": 60, "mm": 1e-3, "cm": 1e-2, "m": 1, "in": 0.0254,
      "N": 1, "kN": 1e3, "mN": 1e-3, "lbf": 4.4482216152605, "kgf": 9.80665,
      "gram-force": 9.80665e-3, "秒": 1, "毫米": 1e-3, "牛": 1}  # fmt: skip
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
def heads(draw, delimiter, titles):
    """Return the lines above a body: perhaps some facts, names, units behind or below them."""
    if draw(st.booleans()):
        names = [delimiter.join(f"{name} ({unit})" for name, unit in titles)]
    else:
        names = [delimiter.join(name for name, _ in titles),
                 delimiter.join(f"({unit})" for _, unit in titles)]  # fmt: skip
    facts = [delimiter.join(["General : Fact " + str(i), "x, y" if delimiter != "," else '"x, y"'])
             for i in range(draw(st.integers(0, 12)))]  # fmt: skip
    return facts + [""] * bool(facts) + names


@st.composite
def exports(draw):
    """Return the bytes of an export, what it holds in SI, and how its body is to be read."""
    delimiter = draw(st.sampled_from([",", ";", "\t"]))
    decimal = draw(st.sampled_from(".,"))
    quoted = draw(st.sampled_from(["all", "none", "where needed"]))
    quoted = "all" if quoted == "none" and delimiter == decimal else quoted
    group = draw(st.sampled_from(["", "", "," if decimal == "." else ".", "\u00a0", " "]))
    group = group if quoted != "none" or group != delimiter else ""
    digits = draw(st.sampled_from([0, 1, 2, 3, 3, 4, 5, 6]))
    stripped = draw(st.booleans())  # of zeros at the end, as some releases write
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
    newline = draw(st.sampled_from(["\n", "\n", "\r\n", "\r\n", "\r", "\r\r\n"]))

    def cell(value):
        text = f"{value:,.{digits}f}".replace(",", "_")
        text = text.rstrip("0").rstrip(".") if stripped and "." in text else text
        text = text.replace(".", decimal).replace("_", group)
        return f'"{text}"' if quoted == "all" or delimiter in text else text

    cells = [[cell(v) for v in columns[q]] for q in order]
    cells += [[cell(v) for v in rng.uniform(0, 9, n)] for _ in extra]
    titles = [(names[q], units[q]) for q in order] + extra
    head = draw(heads(delimiter, titles))
    tail = delimiter * draw(st.integers(0, 2)) if quoted == "none" else ""
    body = [delimiter.join(row) + tail for row in zip(*cells, strict=True)]
    encoding = draw(st.sampled_from(["utf-8", "utf-8-sig", "cp1252", "utf-16"]))
    truth = {q: np.array([number(c, decimal, group) for c in cells[order.index(q)]]) * SI[units[q]]
             for q in columns}  # fmt: skip
    form = {"delimiter": delimiter, "decimal": decimal, "group": group, "encoding": encoding,
            "newline": newline, "order": order, "units": units, "cells": len(titles)}  # fmt: skip
    return head, body, truth, form


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


def agrees(log, truth):
    return len(log) == len(truth["force"]) and all(
        np.allclose(log[q], truth[q], rtol=1e-12, atol=1e-300) for q in truth
    )


def check_dialect(drawn, attempt):
    head, body, truth, form = drawn
    logs = attempt(assemble(head, body, form))
    if logs is None:
        assert is_ambiguous(body, form), "a clear file was refused"
    else:
        assert len(logs) == 1
        assert agrees(logs[0], truth)


def is_ambiguous(body, form):
    """Tell whether at most one number shows which mark is decimal; one alone may be damaged.

    So may 1,056 among decimals, where no number such as 1,056.5 shows that commas group.
    """
    other = "." if form["decimal"] == "," else ","
    cells = [c.strip() for row in csv.reader(body, delimiter=form["delimiter"]) for c in row]
    one_reading = rf"(^|\D)0\{form['decimal']}\d|\{form['decimal']}(?!\d{{3}}$)\d+$"
    both = any(other in c and form["decimal"] in c for c in cells)
    whole = rf"[-+]?\d{{1,3}}({re.escape(form['group'])}\d{{3}})+"
    if form["group"] and not both and any(re.fullmatch(whole, c) for c in cells):
        return True
    return not both and sum(bool(re.search(one_reading, c)) for c in cells) < 2


JUNK = st.sampled_from([b"", b",", b";", b"\t", b".", b"-", b'"', b"\n", b"\r", b"e", b"x", b" ",
                        b"\0", b"\xff", b"--", b",,", b"nan", b"OVER", b"9E37",
                        b"1e400"])  # fmt: skip


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
    for line in re.split(r"[\r\n]+", text):
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


def check_damage(drawn, damage, attempt):
    head, body, whole_truth, form = drawn
    form = form | {"encoding": "cp1252"}
    whole = form["newline"].join([*body, ""]).encode("cp1252")
    damaged = damage(whole)
    top = form["newline"].join([*head, ""]).encode("cp1252")
    logs = attempt(top + damaged)
    if logs is None or any(log.attrs["warnings"] for log in logs):
        return
    if len(logs) == 1 and agrees(logs[0], whole_truth):
        return
    truth = literal(damaged.decode("cp1252"), form)
    assert truth is not None, f"a damaged body passed without a word: {damaged!r}"
    assert len(logs) == 1
    assert agrees(logs[0], truth), f"{damaged!r} read as {logs[0]}, not {truth}"


def look_alikes(*modules):
    """Return the bytes of every look-alike, by name."""
    found = {}
    for module in modules:
        for family in runpy.run_path(str(Path(__file__).with_name(module)))["FAMILIES"]:
            text, _, *encoding = family()
            found[family.__name__] = text.encode(*encoding or ["utf-8"])
    return found


def real_starts():
    files = [p for p in sorted(REAL.iterdir()) if p.suffix != ".json"] if REAL.exists() else []
    return {p.name: b"".join(p.read_bytes().splitlines(keepends=True)[:120]) for p in files}


EXPORTS = look_alikes("test_dialects.py", "test_layouts.py") | real_starts()
ALL = EXPORTS | look_alikes("test_rewrite.py")  # and those in which numbers do not stand bare


def split_export(content, dialect):
    """Return head and body of an export, in an encoding of which each character is a byte."""
    if "utf-16" in dialect["encoding"]:
        marked = content[:2] in (b"\xff\xfe", b"\xfe\xff")
        content = content.decode("utf-16" if marked else "utf-16-le").encode()
    newline = b"\r" if dialect["newline"] == "CR" else b"\n"
    lines = content.split(newline)
    first = dialect["first_row"] - 1
    return newline.join(lines[:first]) + newline, newline.join(lines[first:])


def check_damaged_export(name, damages, attempt):
    """Damage rows of an export: what is read must be what a reader told the dialect would read."""
    logs = attempt(EXPORTS[name])
    head, body = split_export(EXPORTS[name], logs[0].attrs["dialect"])
    for damage in damages:
        body = damage(body)
    after = attempt(head + body)
    if after is None or len(logs) > 1 or any(log.attrs["warnings"] for log in after):
        return
    assert len(after) == 1
    encoding = logs[0].attrs["dialect"]["encoding"].replace("utf-16", "utf-8")
    truth = strict_rows(body.decode(encoding, errors="replace"), logs[0].attrs)
    for quantity, column in truth.items():
        assert len(column) == len(after[0]), f"{len(column)} rows: {body!r}"
        for allowed, value in zip(column, after[0][quantity], strict=True):
            assert any(np.isclose(a, value, rtol=1e-12) for a in allowed), f"{value}: {body!r}"


def damage_anywhere(name, damages, attempt):
    """Damage an export, its head too: it is read or refused, and nothing else happens."""
    content = ALL[name]
    for damage in damages:
        content = damage(content)
    attempt(content)


def strict_rows(text, attrs):
    """Return the possible values of every used cell, as a strict reader told the dialect."""
    dialect, columns = attrs["dialect"], attrs["columns"]
    delimiter = {"TAB": "\t", "spaces": " "}.get(dialect["delimiter"], dialect["delimiter"])
    rows = {quantity: [] for quantity in columns}
    for line in re.split(r"[\r\n]+", text):
        if not re.search(r"\d", line):
            continue
        mark, blank = re.escape(delimiter), " " if delimiter == "\t" else r"[ \t]"
        between = rf'{blank}*("[^"]*"|[^{mark}"]*){blank}*(?:{mark}|$)'
        cells = line.split() if delimiter == " " else re.findall(between, line)
        for quantity, column in columns.items():
            cell = cells[column["index"]] if column["index"] < len(cells) else ""
            scale = SI[column["unit"].strip("()[]")]
            rows[quantity].append([v * scale for v in readings(cell, dialect["decimal"])])
    return rows


def readings(cell, decimal):
    """Return every value that the cell may have, whatever groups its thousands."""
    found = {number(cell, decimal, group) for group in ",.' \xa0\u202f" if group != decimal}
    return [v for v in found if v is not None and np.isfinite(v)]


@settings(STEADY, max_examples=250)
@given(drawn=exports())
def test_random_dialects_are_read_exactly(drawn, attempt):
    check_dialect(drawn, attempt)


@settings(STEADY, max_examples=250)
@given(drawn=exports(), damage=damages())
def test_damaged_bodies_are_read_literally_or_not_at_all(drawn, damage, attempt):
    check_damage(drawn, damage, attempt)


@pytest.mark.slow
@settings(SEARCH, max_examples=6000)
@given(drawn=exports())
def test_many_random_dialects(drawn, attempt):
    check_dialect(drawn, attempt)


@pytest.mark.slow
@settings(SEARCH, max_examples=6000)
@given(drawn=exports(), damage=damages())
def test_many_damaged_bodies(drawn, damage, attempt):
    check_damage(drawn, damage, attempt)


@settings(STEADY, max_examples=250)
@given(name=st.sampled_from(sorted(EXPORTS)), damages=st.lists(damages(), min_size=1, max_size=2))
def test_damaged_exports_are_read_literally_or_not_at_all(name, damages, attempt):
    check_damaged_export(name, damages, attempt)


@settings(STEADY, max_examples=250)
@given(name=st.sampled_from(sorted(ALL)), damages=st.lists(damages(), min_size=1, max_size=3))
def test_damage_anywhere_never_raises_anything_else(name, damages, attempt):
    damage_anywhere(name, damages, attempt)


@pytest.mark.slow
@settings(SEARCH, max_examples=6000)
@given(name=st.sampled_from(sorted(EXPORTS)), damages=st.lists(damages(), min_size=1, max_size=2))
def test_many_damaged_exports(name, damages, attempt):
    check_damaged_export(name, damages, attempt)


@pytest.mark.slow
@settings(SEARCH, max_examples=3000)
@given(name=st.sampled_from(sorted(ALL)), damages=st.lists(damages(), min_size=1, max_size=3))
def test_much_damage_anywhere(name, damages, attempt):
    damage_anywhere(name, damages, attempt)
