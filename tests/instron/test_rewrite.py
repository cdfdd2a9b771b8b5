"""Layouts in which numbers do not stand bare under their headings."""

import numpy as np
import openpyxl
import pytest

import instron

N = 40
T = np.round(np.arange(N) * 0.1, 2)
X = np.round(T * 0.35, 4)
F = [np.round(1.5 * np.abs(np.sin(np.arange(N) / (4 + k))) + 0.25 * k, 4) for k in range(3)]
ONE = [(T, X * 1e-3, F[0])]
THREE = [(T, X * 1e-3, f) for f in F]


def comma(text):
    return text.replace(".", ",")


def beside(cell="{:.4f} {}", names="Time,Extension,Load", delimiter=",", units=("s", "mm", "N")):
    """Return a table in which every number has its unit beside it."""
    rows = (delimiter.join(map(cell.format, row, units)) for row in zip(T, X, F[0], strict=True))
    return "\n".join([names.replace(",", delimiter), *rows, ""])


def units_after_a_blank():
    return beside(), ONE


def units_without_a_blank():
    return beside("{:.4f}{}", delimiter="\t"), ONE


def units_also_in_the_heading():
    return beside(names="Time (s),Extension (mm),Load (N)"), ONE


def units_and_decimal_commas():
    return comma(beside(names="Zeit;Weg;Kraft", delimiter=";")), ONE


def units_in_quotes_with_commas():
    cells = (f'"{v:.4f} {u}"'.replace(".", ",") for row in zip(T, X, F[0], strict=True)
             for v, u in zip(row, ("s", "mm", "N"), strict=True))  # fmt: skip
    rows = (",".join(row) for row in zip(*[cells] * 3, strict=True))
    return "\n".join(["Zeit,Weg,Kraft", *rows, ""]), ONE


def units_and_exponents():
    return beside("{:.6e} {}", delimiter="\t", units=("sec", "mm", "N")), ONE


def units_below_a_line_of_such_facts():
    return "Gauge length,20 mm,Preload,0.1 N\n\n" + beside(), ONE


def units_of_a_stress_beside():
    text = beside("{:.4f} {}").replace(" N\n", " N,1.25 MPa\n").replace("Load", "Load,Stress")
    return text, ONE


def fortran():
    rows = (" ".join(f"{v:15.7E}".replace("E", "D") for v in row)
            for row in zip(T, X, F[0], strict=True))  # fmt: skip
    return "\n".join(["  TIME(S)  DISP(MM)  LOAD(N)", *rows, ""]), ONE


def fortran_in_commas():
    rows = (",".join(f"{v:.7e}".replace("e", "d") for v in row)
            for row in zip(T, X, F[0], strict=True))  # fmt: skip
    return "\n".join(["Time (s),Displacement (mm),Force (N)", *rows, ""]), ONE


def formulas_of_text():
    rows = (",".join(f'="{v:.4f}"' for v in row) for row in zip(T, X, F[0], strict=True))
    return "\n".join(['="Time (s)",="Extension (mm)",="Load (N)"', *rows, ""]), ONE


def single_quotes():
    rows = (";".join(comma(f"'{v:.4f}'") for v in row) for row in zip(T, X, F[0], strict=True))
    return "\n".join(["'Time (s)';'Extension (mm)';'Load (N)'", *rows, ""]), ONE


def lying(names, columns, delimiter=",", units=None):
    rows = [[name, *([unit] if units else []), *(f"{v:.4f}" for v in column)]
            for name, unit, column in zip(names, units or names, columns, strict=True)]  # fmt: skip
    return "\n".join(map(delimiter.join, rows)) + "\n"


def on_its_side():
    return lying(["Time (s)", "Extension (mm)", "Load (N)"], (T, X, F[0])), ONE


def on_its_side_with_cells_of_units():
    text = lying(["Zeit", "Weg", "Kraft"], (T, X, F[0]), ";", ["s", "mm", "N"])
    return comma(text), ONE


def on_its_side_below_facts_and_numbers_of_rows():
    counted = ",".join(map(str, range(1, N + 1)))
    text = lying(["Time (s)", "Extension (mm)", "Load (N)"], (T, X, F[0]))
    return f"Operator,Zoe\n\nPoint,{counted}\n{text}", ONE


def three_on_their_sides():
    names = [f"{q} {k}" for k in (1, 2, 3) for q in ("Time (s)", "Extension (mm)", "Load (N)")]
    return lying(names, [c for f in F for c in (T, X, f)], "\t"), THREE


def three_on_their_sides_stacked():
    names = ["Time (s)", "Extension (mm)", "Load (N)"]
    return "\n".join(f"Specimen {k}\n\n{lying(names, (T, X, f))}" for k, f in enumerate(F)), THREE


def grouped(head, name, delimiter=",", before="", columns=3):
    """Return specimens under one header, each below its name."""
    parts = [
        before + name.format("abc"[k], k + 1) + "\n" + "".join(
            delimiter.join(f"{v:.4f}" for v in row[3 - columns :]) + "\n"
            for row in zip(T, X, f, strict=True))
        for k, f in enumerate(F)
    ]  # fmt: skip
    return head.replace(",", delimiter) + "\n" + "".join(parts)


HEAD = "Time (s),Extension (mm),Load (N)"


def names_between_groups():
    return grouped(HEAD, "Specimen {1}"), THREE


def names_between_groups_after_blank_lines():
    return comma(grouped(HEAD, "Hair_{0};;", ";", before="\n")), THREE


def names_with_a_key_between_groups():
    return grouped(HEAD, "Sample,S{0}", before="\n\n"), THREE


def names_in_brackets_below_a_row_of_units():
    return grouped("Time,Extension,Load\n(s),(mm),(N)", "[Probe {1}]", "\t"), THREE


def names_between_groups_without_time():
    text = grouped("Extension (mm),Load (N)", "Curl {0}", columns=2)
    return text, [(np.full(N, np.nan), x, f) for _, x, f in THREE]


FAMILIES = [
    units_after_a_blank, units_without_a_blank, units_also_in_the_heading, units_and_decimal_commas,
    units_in_quotes_with_commas, units_and_exponents, units_below_a_line_of_such_facts,
    units_of_a_stress_beside, fortran, fortran_in_commas, formulas_of_text, single_quotes,
    on_its_side, on_its_side_with_cells_of_units, on_its_side_below_facts_and_numbers_of_rows,
    three_on_their_sides, three_on_their_sides_stacked, names_between_groups,
    names_between_groups_after_blank_lines, names_with_a_key_between_groups,
    names_in_brackets_below_a_row_of_units, names_between_groups_without_time,
]  # fmt: skip


def read(tmp_path, text, name="export.csv"):
    path = tmp_path / name
    path.write_text(text)
    return instron.read(path)


@pytest.mark.parametrize("end", ["\n", "\r\n"])
@pytest.mark.parametrize("family", FAMILIES, ids=lambda f: f.__name__)
def test_every_such_layout_is_read_exactly(family, end, tmp_path):
    text, expected = family()
    logs = read(tmp_path, text.replace("\n", end))
    assert len(logs) == len(expected)
    for log, columns in zip(logs, expected, strict=True):
        assert len(log) == N
        for name, values in zip(("time", "displacement", "force"), columns, strict=True):
            np.testing.assert_allclose(log[name], values, rtol=1e-12, atol=1e-15, err_msg=name)
        assert [w for w in log.attrs["warnings"] if "no time" not in w] == []
        assert log.attrs["source"] == str(tmp_path / "export.csv")
    assert len({log.attrs["specimen"] for log in logs}) == len(logs)


@pytest.mark.parametrize(("family", "names"), [
    (names_between_groups, ["Specimen 1", "Specimen 2", "Specimen 3"]),
    (names_between_groups_after_blank_lines, ["Hair_a", "Hair_b", "Hair_c"]),
    (names_with_a_key_between_groups, ["Sa", "Sb", "Sc"]),
    (names_in_brackets_below_a_row_of_units, ["Probe 1", "Probe 2", "Probe 3"]),
])  # fmt: skip
def test_groups_are_called_what_stands_above_them(family, names, tmp_path):
    logs = read(tmp_path, family()[0])
    assert [log.attrs["specimen"] for log in logs] == names
    assert sum(logs[0].attrs["lines"].values()) == len(family()[0].splitlines())
    assert "lost" not in logs[0].attrs["lines"]


def test_a_workbook_on_its_side_is_read(tmp_path):
    book = openpyxl.Workbook()
    for name, column in zip(HEAD.split(","), (T, X, F[0]), strict=True):
        book.active.append([name, *map(float, column)])
    book.save(tmp_path / "lying.xlsx")
    (log,) = instron.read(tmp_path / "lying.xlsx")
    np.testing.assert_array_equal(log["force"], F[0])
    assert any("lies on its side" in note for note in log.attrs["choices"])
    assert log.attrs["specimen"] == "Sheet"


REFUSED = {
    "a gauge that changes its unit": (
        beside().replace("0.5000 s,0.1750 mm,", "0.5000 s,0.1750 cm,"),
        r"line 7: column 2 holds '0.1750 cm', in the first rows its unit is 'mm'",
    ),
    "a unit that is missing": (
        beside().replace("0.5000 s,0.1750 mm,", "0.5000 s,0.1750,"),
        r"line 7: column 2 holds '0.1750', in the first rows",
    ),
    "another unit in the heading": (
        beside(names="Time (s),Extension (mm),Load (kN)"),
        r"line 1: the heading of column 3 says 'kN', the numbers below it 'N'",
    ),
    "a letter in a number beside its unit": (
        beside().replace("0.5000 s,0.1750 mm,", "0.5000 s,0.1x50 mm,"),
        r"line 7: column 2 holds '0.1x50 mm'",
    ),
    "results on their side": (
        "Specimen,A,B,C,D,E,F\nLoad (N),1,2,3,4,5,6\nExtension (mm),3,4,3.5,3,4,3.25\n",
        "every row has another 'Specimen'",
    ),
    "two forces on their side": (
        lying(["Time (s)", "Extension (mm)", "Force X (N)", "Force Y (N)"], (T, X, F[0], F[1])),
        "which column is force",
    ),
    "a damaged number on its side": (
        lying(HEAD.split(","), (T, X, F[0])).replace(",1.4", ",1.x4", 1),
        r"turned upright\]: line \d+",
    ),
    "rows that are lost below a name": (
        grouped(HEAD, "Specimen {1}").replace("Specimen 2\n0.0000", "Specimen 2\n9.0000", 1),
        "text within the data",
    ),
    "a restart without a name": (
        grouped(HEAD, "Specimen {1}").replace("Specimen 2\n", "", 1),
        "time jumps back",
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", REFUSED)
def test_what_leaves_a_doubt_is_refused_with_its_reason(name, tmp_path):
    text, reason = REFUSED[name]
    with pytest.raises(instron.Unreadable, match=reason):
        read(tmp_path, text)


def test_a_remark_above_rows_that_do_not_start_anew_makes_no_group(tmp_path):
    rows = grouped(HEAD, "in water").split("in water\n")[1].splitlines(keepends=True)
    text = HEAD + "\n" + "".join([*rows[:20], "stop 7\n", *rows[20:]])
    with pytest.raises(instron.Unreadable, match="line 22: text within the data"):
        read(tmp_path, text)


@pytest.mark.parametrize("keep", [3, 9, 12, 15, 20])
def test_a_file_cut_beside_its_units_keeps_the_good_rows(keep, tmp_path):
    whole = beside().splitlines(keepends=True)
    (log,) = read(tmp_path, "".join(whole[:-1]) + whole[-1][:keep])
    assert len(log) == N - 1
    assert log.attrs["lost_rows"] == 1
