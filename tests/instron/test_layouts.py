"""Look-alikes of whole files as machines write them: what stands around and between the tables."""

import numpy as np
import pytest

import instron

N = 40
T = np.round(np.arange(N) * 0.1, 1)
X = np.round(np.arange(N) * 0.0125, 4)
F = np.round(950 * np.sin(np.arange(N) / 13) - 3.25, 2)
MM, KN = 1e-3, 1e3


def lines(columns, before="", delimiter=",", quote="", after="", newline="\n", decimal="."):
    return "".join(
        before + delimiter.join(f"{quote}{v}{quote}" for v in row).replace(".", decimal) + after
        + newline
        for row in zip(*columns, strict=True)
    )  # fmt: skip


def one(t=T, x=X, f=F, force=1.0):
    return [(t, x * MM, f * force)]


def results_and_blocks_with_a_leading_column():
    head = "Test : Rate 1,Specimen properties : Width,General : Operator\n(mm/min),(mm),\n"
    head += '"50.0","12.5","Zoe"\n\nResults Table 1\n,Width,Thickness\n,(mm),(mm)\n'
    head += '"1","12.51","3.02"\n"2","12.48","3.01"\n\n'
    blocks = [
        f"{k},Time,Displacement,Force\n,(s),(mm),(kN)\n" + lines([T, X, f], ",", quote='"') + "\n"
        for k, f in ((1, F), (2, F / 2))
    ]
    return head + "".join(blocks), one(force=KN) + one(f=F / 2, force=KN)


def empty_results_tables():
    head = "Results Table 1\r\n\r\n\r\nResults Table 2\r\n\r\n\r\n\r\nTime,Displacement,Force\r\n"
    return head + "(s),(mm),(kN)\r\n" + lines([T, X, F], quote='"', newline="\r\n"), one(force=KN)


def results_at_break_before_the_data():
    head = 'Break (Cursor) : Flexure stress at Break (Cursor),"668.9",MPa\n'
    head += 'Modulus (Automatic) : Modulus (Automatic Young\'s),"29577.2",MPa\n\n'
    head += "Time,Extension,Load,Flexure stress,Flexure strain (Extension)\n"
    head += "(s),(mm),(N),(MPa),(mm/mm)\n"
    body = lines([T, X + 0.2, F + 10.4, F / 3, X / 9], quote='"')
    return head + body, one(x=X + 0.2, f=F + 10.4)


def spanish_results_without_blanks():
    head = (
        'Deformación : Deformación por tracción (Extensión) distancia inicial,"100.0",mm\r\n'
        'Máximo Carga : Máximo Carga,"946.7",N\r\n'
        'Máximo Carga : EnergíaalMáximo Carga,"62.9",J\r\n'
        'Máximo Carga : ExtensiónalMáximo Carga,"0.25",mm\r\n'
        "Máximo Carga : Punto de datosalMáximo Carga,20\r\n"
        'Máximo Carga : TiempoalMáximo Carga,"2.0",s\r\n'
    ) + "".join(f"Entrada de opción : Entrada {i},<Ninguno>\r\n" for i in range(40))
    head += "\r\nTiempo,Extensión,Carga\r\n(s),(mm),(N)\r\n"
    return head + lines([T, X, F], quote='"', newline="\r\n"), one(), "cp1252"


def forty_lines_with_stray_commas():
    notes = ("Note : load, extension, time, all zeroed, see page 3", "Comment,,a, b, c,,,",
             "Time of day : 13:05, 3 March", "Load cell, 2kN, 0.5 %, class 1", ",,,,")  # fmt: skip
    head = "".join(notes[i % 5] + "\n" for i in range(40))
    return head + "Time (s),Extension (mm),Load (N)\n" + lines([T, X, F]), one()


def two_lines_of_labels():
    head = "Meta1,Meta2,Meta3\nValue1,Value2,Value3\nTime,Displacement,Force\n(s),(mm),(N)\n"
    return head + lines([T, X, F]), one()


def wordy_names():
    head = "Time measurement (s),Primary load measurement (N),Extension (mm)\n"
    return head + lines([T, -F, -X]), one(x=-X, f=-F)


def wavematrix_ending_in_a_comma():
    head = '"Total Time (s)","Cycle Elapsed Time (s)","Total Cycles","Elapsed Cycles","Step",'
    head += '"Total Cycle Count(Linear Waveform)","Position (mm)","Force (kN)","Stress (MPa)",'
    head += '"Digital Position (mm)","Rotation (deg)","Torque (N·m)",\n'
    ones = np.ones(N)
    body = lines([T, T * 0, ones, ones, ones, ones, X, F, F * 9, X + 3.78, ones, ones], after=",")
    return head + body, one(force=KN)


def mts_with_operator_lines():
    pad = "\t" * 5
    head = f"MTS793|MPT|ESR|1|2|.|/|:|51|1|1|A{pad}\n{pad}\n"
    head += f"Operator Information\t\t\tTime:\t59.9\ts\t1/9/2025{pad}\nNorma: EN 14651{pad}\n"
    head += f'"Vel: 0.5 mm/min hasta 0.1 mm, luego 0.17 mm/min"{pad}\n{pad}\n'
    head += "Data Acquisition\t\t\tTime:\t372.4\ts\t1/9/2025\n"
    head += f"Running Time\tUniversal Displacement\tUniversal Force\tAux Input 1{pad}\n"
    head += f"s\tmm\tkN\tmm{pad}\n"
    body = lines([T + 59.9, X, F, X * 0.01], delimiter="\t", after=pad)
    return head + body, one(t=T + 59.9, force=KN)


def mts_data_acquired_twice():
    block = "Data Acquisition\t\tTime:\t{}\ts\nTime\tCh 1 Position\tCh 1 Force\ns\tmm\tN\n"
    first = "MTS793|MPT|ENU|1|2|.|/|:|1|0|0|A\n\n" + block.format(4.0)
    # The displacement starts anew: another specimen on the machine's clock.
    second = "\n" + block.format(14.0) + lines([T + 10, X, F / 2], delimiter="\t")
    return first + lines([T, X, F], delimiter="\t") + second, one() + one(t=T + 10, f=F / 2)


def zwick_with_a_travel_sensor():
    head = '"Gage length, standard travel",30,"mm"\n"Load cell",""\n"v1",1,"mm/min"\n'
    head += '"Time","Crosshead absolute","Standard travel","Standard force","Capteur de course"\n'
    head += '"s","mm","mm","N","mm"\n'
    return head + lines([T, X + 1190.5, X, F, X * 0.1 + 4.9]), one()


def zwick_abbreviated():
    head = "Prüfzeit;Standardkraft;Traverse abs.;Standardweg\ns;N;mm;mm\n"
    return head + lines([T, F, X + 80.5, X], delimiter=";", decimal=","), one(), "cp1252"


def shimadzu_in_english():
    head = '"Name","1 _ 1","","","","1 _ 2","",""\n"Time","Force","Stroke","","Time","Force",'
    head += '"Stroke"\n"sec","N","mm","","sec","N","mm"\n'
    rows = zip(T, F, X, strict=True)
    body = "".join(
        f"{t},{f},{x},," + (f"{t},{f / 2},{x}\n" if i < 25 else ",,\n")
        for i, (t, f, x) in enumerate(rows)
    )
    short = slice(25)
    return head + body, one() + one(T[short], X[short], F[short] / 2)


def the_first_specimen_is_the_shorter():
    head = "Time 1 (s),Extension 1 (mm),Load 1 (N),Time 2 (s),Extension 2 (mm),Load 2 (N)\n"
    body = "".join(
        (f"{t},{x},{f}," if i < 25 else ",,,") + f"{t},{x},{f / 2}\n"
        for i, (t, x, f) in enumerate(zip(T, X, F, strict=True))
    )
    short = slice(25)
    return head + body, one(T[short], X[short], F[short]) + one(f=F / 2)


def numbered_points_and_units_below():
    head = '"Sample","wool"\n"Specimen",1\n"Point","Time","Load","Extension"\n"","s","N","mm"\n'
    return head + lines([np.arange(N), T, F, X]), one()


def line_breaks_within_header_cells():
    head = '"Time\n(s)","Extension\n(mm)","Load\n(N)"\n'
    return head + lines([T, X, F]), one()


def units_of_nothing():
    return "Time (s),Extension (mm),Load (N)\n(),(),()\n" + lines([T, X, F]), one()


def video_strain_and_rate():
    head = "Time,Extension,Load,Strain 1 (Video),Rate 1,Tensile strain (Strain 1)\n"
    head += "(s),(mm),(N),(%),(mm/min),(mm/mm)\n"
    return head + lines([T, X, F, X, T * 0 + 5, X]), one()


def stopped_at_a_limit_off_the_grid():
    t = np.append(T[:-1] * 1.07, 4.1234)
    return "Time,Extension,Load\n(s),(mm),(N)\n" + lines([t, X, F + 400]), one(t=t, f=F + 400)


def lines_that_end_twice():
    return "Time,Extension,Load\n(s),(mm),(N)\n".replace("\n", "\r\r\n") + lines(
        [T, X, F], newline="\r\r\n"
    ), one()


def grouped_by_apostrophes():
    body = "".join(f"{t};{x};{f * 10:,.2f}\n".replace(",", "'") for t, x, f in zip(T, X, F,
                   strict=True))  # fmt: skip
    return "Zeit;Weg;Kraft\n(s);(mm);(N)\n" + body, one(f=F * 10)


def line_numbers_in_front():
    head = "#,Time (s),Extension (mm),Load (N)\n"
    return head + lines([np.arange(1, N + 1), T, X, F]), one()


def single_blanks():
    return "Time Extension Load\n(s) (mm) (N)\n" + lines([T, X, F], delimiter=" "), one()


def quoted_german_in_a_comma_file():
    def cell(v):
        return '"' + f"{v:,.4f}".translate(str.maketrans(",.", ".,")) + '"'

    body = "".join(f"{cell(t)},{cell(x)},{cell(f)}\n" for t, x, f in zip(T, X, F * 9, strict=True))
    return "Zeit,Weg,Kraft\n(s),(mm),(N)\n" + body, one(f=np.round(F * 9, 4))


def millions_in_a_tab_file():
    body = "".join(f"{t}\t{x}\t{f * 9e3:,.2f}\n" for t, x, f in zip(T, X, F, strict=True))
    force = np.array([float(f"{f * 9e3:.2f}") for f in F])
    return "Time\tExtension\tLoad\n(s)\t(mm)\t(N)\n" + body, one(f=force)


FAMILIES = [
    value
    for value in list(globals().values())
    if getattr(value, "__module__", "") == __name__
    and not value.__code__.co_argcount
]  # fmt: skip


@pytest.mark.parametrize("family", FAMILIES, ids=lambda family: family.__name__)
def test_every_layout_is_read_exactly(family, is_read_exactly):
    is_read_exactly(family)


@pytest.mark.parametrize("encoding", ["utf-8", "cp1252"])
@pytest.mark.parametrize("blank", ["\u00a0", ",", " "])
def test_thousands_that_only_late_rows_have(blank, encoding, tmp_path):
    """The first 64 kB, by which a file is known, hold no thousands and no letter but ASCII."""
    n = 6000
    force = np.round(np.linspace(0.25, 1450.75, n), 2)
    body = "".join(f"{i / 100}\t{i / 800}\t{f:,.2f}\n" for i, f in enumerate(force))
    path = tmp_path / "export.txt"
    text = "Time\tExtension\tLoad\n(s)\t(mm)\t(N)\n" + body.replace(",", blank)
    path.write_bytes(text.encode(encoding))
    np.testing.assert_array_equal(instron.read(path)[0]["force"], force)


@pytest.mark.parametrize("line", ["Sample,a", "Specimen,m", "Batch,g", "Operator,N,", "Probe,V,,"])
@pytest.mark.parametrize("units", ["", "(s),(mm),(N)\n"])
def test_a_label_and_its_letter_are_no_row_of_units(line, units, tmp_path):
    """Ampere, metre, gram, newton and volt are letters that specimens are called by."""
    path = tmp_path / "export.csv"
    rows = "".join(f"{k / 10},{k / 40},{k / 64}\n" for k in range(20))
    path.write_text(f"Time,Extension,Load\n{units}{line}\n{rows}")
    log = instron.read(path)[0]
    assert log["displacement"].iloc[-1] == pytest.approx(19 / 40 * 1e-3)
    assert log["force"].iloc[-1] == 19 / 64


def test_a_row_with_one_unit_is_still_one(tmp_path):
    path = tmp_path / "export.csv"
    path.write_text("Units,Extension,Load\nUnits,mm,kN\n" + ",0.5,0.25\n,0.75,0.5\n")
    assert instron.read(path)[0]["force"].iloc[-1] == 500
