"""Results are no log: a row a specimen, rows of statistics, lines that describe channels."""

import numpy as np
import pytest

import instron

N = 40
T = np.round(np.arange(N) * 0.1, 1)
X = np.round(T * 0.75, 3)
F = np.round(12 * np.sin(np.arange(N) / 11) ** 2 + 0.25, 3)
LOG = "".join(f"{i + 1},{x},{f}\n" for i, (x, f) in enumerate(zip(X, F, strict=True)))
TIMED = "".join(f"{t},{x},{f}\n" for t, x, f in zip(T, X, F, strict=True))


def read(tmp_path, text, encoding="utf-8", **told):
    path = tmp_path / "export.csv"
    path.write_bytes(text.encode(encoding))
    return instron.read(path, **told)


def table(header, labels, delimiter=","):
    rows = [header]
    rows += [f"{label},{20 + 3 * i}.5,{4 + i}.25" for i, label in enumerate(labels)]
    return ("\n".join(rows) + "\n").replace(",", delimiter)


RESULTS = {
    "names": ("Sample,Load (N),Extension (mm)", ["PLA 1", "PLA 2", "PETG", "ABS 1", "ABS 2"]),
    "codes": ("Specimen ID,Tensile (N),Tensile Elong [mm]", ["SVA7P", "5ZB92", "Y35ZN", "MT5RQ"]),
    "numbers": ("Specimen,Force (N),Displacement (mm)", range(1, 9)),
    "German": ("Probe,Kraft [N],Weg [mm]", ["a", "b", "c", "d", "e"]),
    "settings": ("name,gain load,gain displacement", ["H11L", "H12R", "H13R", "H14L"]),
    "material": ("Material,Force (N),Displacement (mm)", ["PLA", "ABS", "PETG", "nylon 6"]),
    "tag": ("Physical_Tag,Sex,Force,Disp", ["C18-L,M", "C18-LL,M", "C18-RR,F"]),
    "label": ("Label,Load (N),Stroke (mm)", ["left", "right", "upper", "lower"]),
}


@pytest.mark.parametrize("kind", RESULTS)
@pytest.mark.parametrize("delimiter", [",", "\t"])
def test_a_row_a_specimen_is_no_log(kind, delimiter, tmp_path):
    with pytest.raises(instron.Unreadable, match="no log|no header"):
        read(tmp_path, table(*RESULTS[kind], delimiter))


NO_RESULTS = {
    "a counter of samples": ("Sample,Load (N),Extension (mm)", range(N)),
    "one name": ("Specimen,Load (N),Extension (mm)", ["PLA 1"] * N),
    "a clock": ("Label,Load (N),Extension (mm)", [f"2024-03-01T10:00:{i:02d}" for i in range(N)]),
    "pictures": ("Image,Load (N),Extension (mm)", [f"frame_{i:04d}.tif" for i in range(N)]),
    "phases": ("Phase,Load (N),Extension (mm)", ["rise"] * 20 + ["fall"] * (N - 20)),
    "points": ("Point,Load (N),Extension (mm)", [f"P{i}" for i in range(N)]),
    "a column of remarks": ("Name,Load (N),Extension (mm)", ["", "jam", *[""] * (N - 2)]),
}


@pytest.mark.parametrize("kind", NO_RESULTS)
def test_labels_that_a_log_may_have(kind, tmp_path):
    header, labels = NO_RESULTS[kind]
    rows = "".join(f"{n},{f},{x}\n" for n, f, x in zip(labels, F, X, strict=True))
    (log,) = read(tmp_path, header + "\n" + rows)
    np.testing.assert_allclose(log["force"], F)


def test_results_above_raw_data_leave_the_data(tmp_path):
    text = table(*RESULTS["names"]) + "\nPoint,Stroke (mm),Load (N)\n" + LOG
    (log,) = read(tmp_path, text)
    np.testing.assert_allclose(log["force"], F)


FOOTERS = {
    "mean and maximum": "Mean,1.46,5.66\nMax,2.925,12.1\n",
    "five rows": "Mean,1.4,5.6\nStd. Dev.,0.4,0.6\nMin,0.1,0.2\nMax,2.9,12.1\nCV %,4.1,3.3\n",
    "German": "Mittelwert,1.46,5.66\nMaximum,2.925,12.1\n",
    "after a blank line": "\nAverage,1.46,5.66\nMedian,1.5,6.1\n",
    "French": "Moyenne,1.46,5.66\nEcart-type,0.3,0.4\n",
}


@pytest.mark.parametrize("kind", FOOTERS)
@pytest.mark.parametrize("timed", [True, False])
def test_statistics_below_the_rows_are_no_rows(kind, timed, tmp_path):
    header = "Time (s)" if timed else "Point"
    body = TIMED if timed else LOG
    (log,) = read(tmp_path, f"{header},Extension (mm),Load (N)\n" + body + FOOTERS[kind])
    np.testing.assert_allclose(log["force"], F)
    np.testing.assert_allclose(log["displacement"] * 1e3, X)


@pytest.mark.parametrize("word", ["max", "mean", "Std", "Mittelwert"])
def test_statistics_that_a_column_of_remarks_names(word, tmp_path):
    rows = "".join(f"{x},{f},\n" for x, f in zip(X, F, strict=True))
    (log,) = read(tmp_path, "Extension (mm),Load (N),Note\n" + rows + f"1.5,6.2,{word}\n")
    assert len(log) == N


def test_a_remark_within_the_rows_takes_no_row_away(tmp_path):
    rows = [f"{x},{f}," for x, f in zip(X, F, strict=True)]
    rows[9] += "first jam"
    rows[20] += "max"
    rows[-1] += "end"
    (log,) = read(tmp_path, "Extension (mm),Load (N),Note\n" + "\n".join(rows) + "\n")
    assert len(log) == N


CHANNELS = {
    "factor and offset": "Channel,Stroke (mm),Load (kN)\nFactor,1,1\nOffset,0,0\n",
    "a units row last": "CH name,Stroke,Load\nCH No,CH1,CH2\nRange,10,50\nUnit,mm,kN\n",
    "a units row first": "CH name,Stroke,Load\nUnit,mm,kN\nRange,10,50\nCoef,1,1\nOffset,0,0\n",
    "Japanese": "CH名称,変位,荷重\nCH No,CH1,CH2\nレンジ,10,50\n校正係数,1,1\n単位,mm,kN\n",
    "over the time": "Time (s),Stroke,Load\nRange,10,50\nUnit,mm,kN\n",
    "units above": "Unit,mm,kN\nRange,10,50\nChannel,Stroke,Load\n",
    "units above, LabVIEW": "Y_Unit_Label\tmm\tkN\nX0\t0.0\t0.0\nX_Value\tStroke\tLoad\n",
}


@pytest.mark.parametrize("mark", ["nan1", "OVER1", "xx", "nan"])
@pytest.mark.parametrize("cells", ["0.1,0.0125,3.0", "0.1,0.0125,x", "--,0.0125,3.0", "ab,cd,3.0"])
def test_a_damaged_first_line_number_describes_no_channel(mark, cells, tmp_path):
    path = tmp_path / "export.csv"
    rows = "".join(f"{k},{k / 10},{k / 80},{3.0 * k}\n" for k in range(2, 40))
    path.write_text(f"No,Time (s),Stroke (mm),Load (N)\n{mark},{cells}\n{rows}")
    try:
        log = instron.read(path)[0]
    except instron.Unreadable:
        return
    assert len(log) == 39 or log.attrs["warnings"], mark


@pytest.mark.parametrize("kind", CHANNELS)
def test_lines_that_describe_channels_are_no_rows(kind, tmp_path):
    head = CHANNELS[kind]
    body = TIMED.replace(",", "\t") if "\t" in head else TIMED
    (log,) = read(tmp_path, head + body)
    np.testing.assert_allclose(log["force"], F * 1e3)
    np.testing.assert_allclose(log["displacement"] * 1e3, X)
    assert not any("unit of force" in note for note in log.attrs["warnings"])


def test_channels_in_volts_are_no_forces(tmp_path):
    head = "CH name,Stroke,Load\nRange,10,10\nUnit,V,V\n"
    with pytest.raises(instron.Unreadable, match="volts|no header|no displacement"):
        read(tmp_path, head + TIMED)


@pytest.mark.parametrize("cell", ["OVER", "x.0", "nan"])
def test_a_damaged_first_row_describes_no_channel(cell, tmp_path):
    rows = TIMED.splitlines()
    rows[0] = f"{cell},{X[0]},{F[0]}"
    with pytest.raises(instron.Unreadable):
        read(tmp_path, "Time (s),Stroke (mm),Load (N)\n" + "\n".join(rows) + "\n")


def test_results_above_raw_data_name_the_specimens(tmp_path):
    heading = ",Specimen label,Width,Maximum Tensile stress\n,,(mm),(MPa)\n"
    results = "".join(f'"{k}","{name}","12.5","427.0"\n' for k, name in enumerate("pqr", 1))
    blocks = [
        f"{k},Time,Displacement,Force\n,(s),(mm),(N)\n"
        + "".join(f'"","{t}","{x}","{k * f}"\n' for t, x, f in zip(T, X, F, strict=True))
        for k in (1, 2, 3)
    ]
    mean = '"Mean","","12.5","427.0"\n\n'
    text = "Results Table 1\n" + heading + results + mean + "\n".join(blocks)
    assert [log.attrs["specimen"] for log in read(tmp_path, text)] == ["p", "q", "r"]
    (one,) = read(
        tmp_path,
        "Results Table 1\n" + heading + results.splitlines(keepends=True)[0] + "\n" + blocks[0],
    )
    assert one.attrs["specimen"] == "p"


@pytest.mark.parametrize("line", ["Specimen {}", "[Sample {}]", "Probe {},,"])
def test_a_line_above_its_heading_names_a_specimen(line, tmp_path):
    blocks = [line.format(k) + "\nTime (s),Stroke (mm),Force (N)\n" + TIMED for k in ("a1", "a2")]
    names = [log.attrs["specimen"] for log in read(tmp_path, "\n".join(blocks))]
    assert names == [line.format(k).strip("[],") for k in ("a1", "a2")]
