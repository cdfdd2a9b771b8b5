"""Workbooks go through the same grammar, ledger and checks as text."""

import datetime
import zipfile

import numpy as np
import openpyxl
import pytest
import xlwt

import instron

N = 40
T = np.arange(N) * 0.1
X = np.arange(N) * 0.025
F = np.round(3.1 * np.sin(np.arange(N) / 9) ** 2 + 0.125, 4)


def workbook(path, sheets):
    """Write sheets, each a list of rows."""
    book = openpyxl.Workbook()
    book.remove(book.active)
    for name, rows in sheets.items():
        sheet = book.create_sheet(name)
        for row in rows:
            sheet.append(row)
    book.save(path)
    return path


def old_workbook(path, sheets):
    book = xlwt.Workbook()
    for name, rows in sheets.items():
        sheet = book.add_sheet(name)
        for i, row in enumerate(rows):
            for k, cell in enumerate(row):
                if cell is not None:
                    sheet.write(i, k, cell)
    book.save(str(path))
    return path


def specimen(scale=1.0, names=("Time", "Extension", "Load"), units=("s", "mm", "N")):
    rows = [[float(t), float(x), float(f * scale)] for t, x, f in zip(T, X, F, strict=True)]
    return [list(names), list(units), *rows]


STATISTICS = [["Series", "F max", "n"], ["mean", 3.2, 3], ["s", 0.1, None]]
WRITERS = {".xlsx": workbook, ".xls": old_workbook}


@pytest.mark.parametrize("suffix", WRITERS)
def test_one_sheet_a_specimen_behind_a_statistics_sheet(suffix, tmp_path):
    sheets = {"Statistics": STATISTICS, "Specimen 1": specimen(), "Specimen 2": specimen(0.5)}
    logs = instron.read(WRITERS[suffix](tmp_path / f"series{suffix}", sheets))
    assert [log.attrs["specimen"] for log in logs] == ["Specimen 1", "Specimen 2"]
    np.testing.assert_allclose(logs[0]["force"], F, rtol=1e-14)
    np.testing.assert_allclose(logs[1]["force"], F / 2, rtol=1e-14)
    np.testing.assert_allclose(logs[0]["displacement"], X * 1e-3, rtol=1e-14)
    assert logs[0].attrs["source"].endswith(suffix)
    assert logs[0].attrs["sheet"] == "Specimen 1"
    assert logs[0].attrs["lines"] == {"heading": 1, "units": 1, "data": N}
    assert "sheet 'Statistics' is no force log" in logs[0].attrs["choices"]
    assert logs[0].attrs["warnings"] == []


def test_several_tables_of_a_sheet(tmp_path):
    one = specimen()
    beside = [[*a, None, *b] for a, b in zip(one, specimen(0.5), strict=True)]
    stacked = [*one, [], ["Specimen label", "b"], [], *specimen(0.25)]
    for rows, scale in ((beside, 0.5), (stacked, 0.25)):
        logs = instron.read(workbook(tmp_path / "tables.xlsx", {"data": rows}))
        assert len(logs) == 2
        np.testing.assert_allclose(logs[0]["force"], F, rtol=1e-14)
        np.testing.assert_allclose(logs[1]["force"], F * scale, rtol=1e-14)


HEADINGS = {
    ("Zeit [s]", "Weg [mm]", "Kraft Ist [kN]"): 1e3,
    ("Time (s)", "Extension (mm)", "Load (x10^3 N)"): 1e3,
    ("Time\n(s)", "Extension\n(mm)", "Load\n(mN)"): 1e-3,
    ("Temps (s)", "Spost. (mm)", "Force (N)"): 1,
}


@pytest.mark.parametrize("names", HEADINGS)
def test_the_same_grammar(names, tmp_path):
    rows = specimen(names=names)
    del rows[1]
    (log,) = instron.read(workbook(tmp_path / "names.xlsx", {"data": rows}))
    np.testing.assert_allclose(log["force"], F * HEADINGS[names], rtol=1e-14)


@pytest.mark.parametrize("number", [1.424, 1424.0, 12.125, 1e-7, 2e6, -0.001])
def test_numbers_are_numbers_whatever_they_look_like(number, tmp_path):
    rows = [["Extension (mm)", "Load (N)"], *[[float(i), number] for i in range(5)]]
    (log,) = instron.read(workbook(tmp_path / "numbers.xlsx", {"data": rows}))
    assert (log["force"] == number).all()


def changed(row, cell, value, column=2):
    rows = specimen()
    rows[row][column] = value
    return rows


REFUSED = {
    "a date": (changed(20, 2, datetime.date(2020, 1, 2)), r"line 21.*\(a date\)"),
    "a date and time": (changed(20, 2, datetime.datetime(2020, 1, 2, 3, 4)), "line 21.*a date"),
    "text": (changed(20, 2, "OVER"), "line 21.*'OVER'"),
    "a gap": (changed(20, 2, None), "line 21: a row lacks numbers"),
    "a formula without a value": (changed(20, 2, "=C20*2"), "line 21: a formula without a value"),
    "two forces": ([[*r, (r[2] if i < 2 else r[2] + i)] for i, r in enumerate(
        specimen(names=("Time", "Extension", "Load 1")))], "which column is force"),
    "two columns of another unit": (specimen(names=("Time", "Extension", "Load (N)"),
                                             units=("s", "mm", "kN")), "the heading says 'N'"),
    "no log": (STATISTICS, "no header that names"),
    "nothing": ([], "empty"),
}  # fmt: skip


@pytest.mark.parametrize("kind", REFUSED)
def test_a_doubtful_sheet_is_refused_by_its_name_and_row(kind, tmp_path):
    rows, reason = REFUSED[kind]
    with pytest.raises(instron.Unreadable, match=reason) as caught:
        instron.read(workbook(tmp_path / "doubt.xlsx", {"Specimen 7": rows}))
    assert "doubt.xlsx" in str(caught.value)
    assert "\n" not in str(caught.value)


def test_formulas_are_told_from_numbers(tmp_path):
    path = workbook(tmp_path / "formulas.xlsx", {"data": specimen()})
    with zipfile.ZipFile(path) as old:
        members = {name: old.read(name) for name in old.namelist()}
    sheet = members["xl/worksheets/sheet1.xml"]
    members["xl/worksheets/sheet1.xml"] = sheet.replace(b'<c r="C9" t="n"><v>', b'<c r="C9" t="n">'
                                                        b"<f>B9*2</f><v>")  # fmt: skip
    with zipfile.ZipFile(path, "w") as new:
        for name, content in members.items():
            new.writestr(name, content)
    (log,) = instron.read(path)
    np.testing.assert_array_equal(log["force"], F)
    assert "force: 1 cells are formulas" in log.attrs["choices"][-1]


def test_a_damaged_workbook_is_refused_in_one_line(tmp_path):
    whole = workbook(tmp_path / "whole.xlsx", {"data": specimen()}).read_bytes()
    for content in (whole[:2000], b"PK\x03\x04" + bytes(300), b"\xd0\xcf\x11\xe0" + bytes(600)):
        path = tmp_path / "damaged.xlsx"
        path.write_bytes(content)
        with pytest.raises(instron.Unreadable, match="cannot be opened") as caught:
            instron.read(path)
        assert "\n" not in str(caught.value)


def test_what_is_no_export_says_how_to_make_one(tmp_path):
    for name, content, reason in (
        ("a.is_tens", b"<?xml version='1.0'?><Sample/>", "Bluehill sample"),
        ("a.id_tens", b"TDAT" + bytes(100), "Bluehill data file"),
        ("a.zs2", b"\x1f\x8b\x08" + bytes(100), "testXpert"),
    ):
        (tmp_path / name).write_bytes(content)
        with pytest.raises(instron.Unreadable, match=reason) as caught:
            instron.read(tmp_path / name)
        assert "export the" in str(caught.value)
