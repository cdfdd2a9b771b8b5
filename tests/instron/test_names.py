"""Names, units and rows that do not stand one above the other; roles glued to words; trailers."""

import numpy as np
import pytest

import instron

N = 12
T, D, F = np.arange(N) * 0.5, np.arange(N) * 0.125, np.round(np.sin(np.arange(N)) + 2, 3)


def rows(pattern):
    """Return rows by a pattern with ``{i} {t} {d} {f}``."""
    return "".join(pattern.format(i=i + 1, t=T[i], d=D[i], f=F[i]) + "\n" for i in range(N))


def reading(tmp_path, text, scales=(1, 1e-3, 1), name="export.csv"):
    """Read a text that holds T, D and F and check its numbers; return its warnings."""
    path = tmp_path / name
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    (log,) = instron.read(path)
    columns = ("time", "displacement", "force")
    for column, values, scale in zip(columns, (T, D, F), scales, strict=True):
        if scale is not None:
            np.testing.assert_allclose(log[column], values * scale, rtol=1e-12, err_msg=column)
    return log.attrs["warnings"]


@pytest.mark.parametrize(
    ("text", "scales", "said"),
    [
        # A column more than names: R's own tables, with and without quotes.
        ('"time" "disp" "load"\n' + rows('"{i}" {t} {d} {f}'), (1, 1e-3, 1), "no name"),
        ('"time_s","disp_mm","load_kN"\n' + rows('"run {i}",{t},{d},{f}'),
         (1, 1e-3, 1e3), "no name"),
        ("time (s)\tdisp (mm)\tload (N)\n" + rows("{i}\t{t}\t{d}\t{f}"), (1, 1e-3, 1), "counts"),
        ("Zeit;Weg;Kraft\ns;mm;kN\n" + rows("{i};{t};{d};{f}"), (1, 1e-3, 1e3), "counts"),
        # Units in cells of their own: between the names, or beside every number.
        ("Time, s, Stroke, mm, Force, kN\n" + rows("{t},{d},{f}"), (1, 1e-3, 1e3), ""),
        ("Weg;cm;Kraft;N;Zeit;min\n" + rows("{d};{f};{t}"), (60, 1e-2, 1), ""),
        ("No;Load;Unit;Travel;Unit;Time (s)\n" + rows("{i};{f};lbf;{d};in;{t}"),
         (1, 0.0254, 4.4482216152605), ""),
        ("t [s],Kraft,Einheit,Weg,Einheit 2\n" + rows("{t},{f},kN,{d},mm"), (1, 1e-3, 1e3), ""),
        # Names that say nothing, over units that do.
        ("X-Wert;Y-Wert\nmm;kN\n" + rows("{d};{f}"), (None, 1e-3, 1e3), "by their units"),
        ("Ch A (N),Ch B (mm),Ch C (s)\n" + rows("{f},{d},{t}"), (None, 1e-3, 1), "by their units"),
        # A word below the rows.
        ("Time\tStroke\tForce\ns\tmm\tN\n" + rows("{t}\t{d}\t{f}") + "CHECKSUM\t48211\n",
         (1, 1e-3, 1), "CHECKSUM"),
        ("Time (s),Stroke (mm),Force (N)\n" + rows("{t},{d},{f}") + "\nRecords,12\n",
         (1, 1e-3, 1), "Records"),
        # Roles glued to their word, in front and behind.
        ("Sollweg (mm);Istweg (mm);Istkraft (N);Zeit (s)\n" + rows("7.5;{d};{f};{t}"),
         (1, 1e-3, 1), ""),
        ("时间(s),目标位移(mm),位移(mm),设定力(N),力(N)\n" + rows("{t},9.5,{d},8.5,{f}"),
         (1, 1e-3, 1), ""),
    ],
)  # fmt: skip
def test_columns_are_those_that_the_rows_below_tell(tmp_path, text, scales, said):
    warnings = reading(tmp_path, text, scales)
    assert (said in " ".join(warnings)) if said else warnings == []


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("No;Load;Unit;Travel;Unit\n" + rows("{i};{f};N;{d};mm").replace("3;2.909;N", "3;2.909;kN"),
         "N or kN"),
        ("Sollweg (mm),Kraft (N)\n" + rows("{d},{f}"), "no displacement"),
        ("位移(mm),设定力(N)\n" + rows("{d},{f}"), "no force"),
        ("Load (N\u00b710\u00b3),Stroke (mm)\n" + rows("{f},{d}"), "multiplied"),
        ("Load (N) \u00b710,Stroke (mm)\n" + rows("{f},{d}"), "multiplied"),
        ("Ch A (mm),Ch B (g)\n" + rows("{d},{f}"), "no header"),
        ("Time (s),Stroke (mm),Force (N)\n" + rows("{t},{d},{f}") + "OVER,1.5\n", "OVER"),
        ("Time (s),Stroke (mm),Force (N)\n" + rows("{t},{d},{f}") + "x6.5,1.5\n", "x6.5"),
        ("Time (s),Stroke (mm),Force (N)\n0,0,1\nSTOP,2\n" + rows("{t},{d},{f}"), "STOP"),
    ],
)  # fmt: skip
def test_what_could_be_otherwise_is_refused(tmp_path, text, why):
    path = tmp_path / "export.csv"
    path.write_text(text)
    with pytest.raises(instron.Unreadable, match=why):
        instron.read(path)


def test_a_unit_that_changes_late_is_refused(tmp_path):
    path = tmp_path / "export.csv"
    late = rows("{f};N;{d};mm") * 12 + "1.5;kN;2.5;mm\n"
    path.write_text("Load;Unit;Travel;Unit\n" + late.replace("\n0.", "\n0."))
    with pytest.raises(instron.Unreadable, match="line 146: the unit in column 2 is 'kN'"):
        instron.read(path, columns={"force": "Load"})


def test_the_zero_byte_behind_a_first_line_of_words_is_no_damage(tmp_path):
    head = b'"C:\\tests\\pull.TXT",\0\r\n"Points","Elapsed Time ","Disp ","Load 1 ",\r\n'
    body = '"","Sec","mm","N",\n' + rows("{i},{t},{d},{f},")
    assert reading(tmp_path, head + body.replace("\n", "\r\n").encode(), name="pull.TXT") == []
    damaged = tmp_path / "damaged.csv"
    damaged.write_bytes(b"Time,Stroke,Force\n0,1,2\0\n1,2,3\n2,3,4\n")
    with pytest.raises(instron.Unreadable, match="zero bytes"):
        instron.read(damaged)


@pytest.mark.parametrize("apart", [1.006, 1.013, 1.0197, 1.03])
def test_a_maximum_a_few_percent_off_is_flagged_and_not_refused(tmp_path, apart):
    text = f"Maximum load, {F.max() * apart:.4f}, N\n\nTime (s),Stroke (mm),Force (N)\n"
    assert "states a maximum" in " ".join(reading(tmp_path, text + rows("{t},{d},{f}")))


@pytest.mark.parametrize(
    ("head", "pattern", "last"),
    [
        ("No.,Time (s),Stroke (mm),Force (N)", "{i},{t},{d},{f}", ",4.25,4.25,4.25"),
        ("No.\tTime (s)\tStroke (mm)\tForce (N)", "{i}\t{t}\t{d}\t{f}", "\t6\t1.5\t2.1"),
        ("Time (s);Stroke (mm);Force (N);Cycle", "{t};{d};{f};1", "6;1.5;2.1;"),
        ("Time (s);Stroke (mm);Temp (C);Force (N)", "{t};{d};21.5;{f}", "6;1.5;;2.1"),
        ("Time (s),Stroke (mm),Force (N),Note", "{t},{d},{f},a", "6,1.5,2.1"),
    ],
)
def test_a_last_row_without_a_cell_that_all_others_have_is_said(tmp_path, head, pattern, last):
    """It may be a statistic that lost its name: read, but not without a word."""
    path = tmp_path / "export.csv"
    path.write_text(f"{head}\n{rows(pattern)}{last}\n")
    try:
        (log,) = instron.read(path)
    except instron.Unreadable:
        return
    said = [note for note in log.attrs["warnings"] if "lacks a cell" in note or "lost" in note]
    assert said
    whole = tmp_path / "whole.csv"
    whole.write_text(f"{head}\n{rows(pattern)}")
    (log,) = instron.read(whole)
    assert not [note for note in log.attrs["warnings"] if "lacks a cell" in note]


def test_cells_that_are_often_empty_say_nothing(tmp_path):
    """A note in some rows alone is missing from the last as from others."""
    lines = rows("{t},{d},{f},").splitlines()
    lines[3] += "slipped"
    text = "Time (s),Stroke (mm),Force (N),Note\n" + "\n".join(lines) + "\n"
    assert not [note for note in reading(tmp_path, text) if "lacks a cell" in note]


@pytest.mark.parametrize(
    ("head", "first", "pattern"),
    [
        ("No.,Time (s),Stroke (mm),Force (N)", ",0,50,500", "{i},{t},{d},{f}"),
        ("Time (s);Stroke (mm);Force (N);Cycle", "-1;50;500;", "{t};{d};{f};1"),
        ("Time (s)\tStroke (mm)\tForce (N)\tNote", "-1\t0.5\t2", "{t}\t{d}\t{f}\ta"),
    ],
)
def test_a_first_row_without_a_cell_that_all_others_have_is_said(tmp_path, head, first, pattern):
    """It may be a line about channels that lost its name."""
    path = tmp_path / "export.csv"
    path.write_text(f"{head}\n{first}\n{rows(pattern)}")
    (log,) = instron.read(path)
    assert "line 2: lacks a cell that every row below has" in log.attrs["warnings"]
