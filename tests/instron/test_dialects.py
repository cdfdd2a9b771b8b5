"""Look-alikes of every dialect, written from known numbers and read back exactly."""

import numpy as np
import pytest

N = 60
T = np.round(np.arange(N) * 0.1, 3)
X = np.round(T * 0.5, 4)
F = np.round(1900 * np.sin(np.pi * np.arange(N) / (N - 1)) ** 2 - 0.25 * (np.arange(N) < 3), 2)
MM, KN, LBF, INCH, KGF = 1e-3, 1e3, 4.4482216152605, 0.0254, 9.80665


def rows(columns, cell="{}".format, delimiter=",", newline="\r\n"):
    return "".join(delimiter.join(map(cell, row)) + newline for row in zip(*columns, strict=True))


def two(value):
    return f"{value:.2f}"


def grouped(value):
    return f"{value:,.2f}"


def quoted(value):
    return f'"{value:,.4f}"'


def comma(value):
    return f"{value:.4f}".replace(".", ",")


def si(t=1.0, x=MM, f=1.0, cut=slice(None)):
    return T[cut] * t, X[cut] * x, F[cut] * f


def bluehill2():
    head = 'Text Inputs : Specimen label,"22L.3"\r\nGeneral : Start Date,13/11/2018 5:14 PM\r\n\r\n'
    return head + "Time,Extension,Load\r\n(sec),(mm),(N)\r\n" + rows([T, X, F]), [si()]


def bluehill3_all_quoted_with_thousands():
    head = "Specimen properties : Length,50,mm\r\n\r\n"
    return head + "Time,Extension,Load\r\n(s),(mm),(N)\r\n" + rows([T, X, F], quoted), [si()]


def bluehill_thousands_only_in_high_forces():
    body = "".join(
        f'{t},{x},"{f:,.2f}"\r\n' if abs(f) >= 1000 else f"{t},{x},{f:.2f}\r\n"
        for t, x, f in zip(T, X, F, strict=True)
    )
    return "Time,Extension,Load\r\n(s),(mm),(N)\r\n" + body, [si()]


def bluehill_trailing_commas():
    head = "General : Specimen number,1,,,\nSpecimen properties : Width,11.9,mm,,\n,,,,\n"
    body = rows([T, X, F, X / 50, F / 30], newline="\n")
    return head + "Time,Extension,Load,Strain,Tensile stress\n(s),(mm),(N),(%),(MPa)\n" + body, [
        si()
    ]


def quoted_decimal_comma_in_comma_file():
    head = 'Specimen properties : Anvil height,"3,11",mm\n\nTime,Extension,Load,Cycle count\n'
    body = rows([T, X, F, F * 0], lambda v: f'"{v:.2f}"'.replace(".", ","), newline="\n")
    return head + "(s),(mm),(N),\n" + body, [(np.round(T, 2), _round2(X) * MM, F)]


def _round2(values):
    return np.array([float(f"{v:.2f}") for v in values])


def results_table_before_the_data():
    head = (
        "Results Table 1\r\n,Maximum Load (N),Extension at Maximum Load (mm),Load at Break (N)\r\n"
        f'1,"{F.max():,.2f}",1.475,3.1\r\n\r\n\r\n'
    )
    return head + "Time (s),Extension (mm),Load (N)\r\n" + rows([T, X, F]), [si()]


def results_block_beside():
    head = f"Results : Maximum load,{F.max():.2f},N\nResults : Notes, a, b, c\n\n"
    return head + "Time;Extension;Load\n".replace(";", ",") + "(s),(mm),(N)\n" + rows([T, X, F]), [
        si()
    ]


def cycles():
    body = rows([T, -X, -F, np.full(N, 22476), np.arange(N) // 30])
    head = "Time,Extension,Load,Segment ID,Total Cycle Count\r\n(sec),(mm),(N),,\r\n"
    return head + body, [(T, -X * MM, -F)]


def german_semicolon_decimal_comma():
    head = '"Prüfer";"Müller"\r\n"Vorkraft";"0,5";"N"\r\n'
    body = rows([T, X, F], comma, ";")
    return (
        head + '"Zeit";"Traversenweg";"Last"\r\n"(s)";"(mm)";"(N)"\r\n' + body,
        [si()],
        "cp1252",
    )


def german_grouped_by_points():
    def cell(v):
        return f"{v:,.4f}".translate(str.maketrans(",.", ".,"))

    return "Zeit [s];Traversenweg [mm];Kraft [N]\r\n" + rows([T, X, F], cell, ";"), [si()]


def french_tabs_nbsp_thousands():
    def cell(v):
        return f"{v:,.4f}".replace(",", "\u00a0").replace(".", ",")

    body = rows([T, X, F], cell, "\t")
    return ("Opérateur :\tZoé\r\nTemps\tTraverse\tForce\r\ns\tmm\tN\r\n" + body, [si()], "cp1252")


def thin_space_thousands_utf8():
    def cell(v):
        return f"{v:,.4f}".replace(",", "\u202f")

    return "Time (s)\tExtension (mm)\tLoad (N)\n" + rows([T, X, F], cell, "\t", "\n"), [si()]


def polish_cp1250():
    body = rows([T, X, F], comma, ";")
    return ("Próbka;wełna\r\nczas;wydłużenie;siła\r\ns;mm;N\r\n" + body, [si()], "cp1250")


def spanish():
    head = "Tiempo;Desplazamiento;Carga\n(s);(mm);(kN)\n"
    return head + rows([T, X, F], comma, ";", "\n"), [si(f=KN)], "utf-8-sig"


def chinese_gbk():
    return "时间,位移,载荷\r\n(s),(mm),(N)\r\n" + rows([T, X, F]), [si()], "gbk"


def chinese_units_in_header():
    return "时间(秒)\t位移(毫米)\t力(牛)\r\n" + rows([T, X, F], delimiter="\t"), [si()], "utf-8"


def shimadzu_side_by_side_shift_jis():
    head = '"名前","1 _ 1","","","1 _ 2","",""\r\n'
    head += '"時間","試験力","ストローク","時間","試験力","ストローク"\r\n'
    head += '"sec","N","mm","sec","N","mm"\r\n'
    short = 40
    lines = []
    for i in range(N):
        left = f"{T[i]},{F[i]},{X[i]}"
        lines.append(left + ("," + left if i < short else ",,,"))
    return head + "\r\n".join(lines) + "\r\n", [si(), si(cut=slice(short))], "shift_jis"


def shared_time_side_by_side():
    head = "Time (s),Extension 1 (mm),Load 1 (N),Extension 2 (mm),Load 2 (N)\n"
    return head + rows([T, X, F, X * 2, F / 2], newline="\n"), [si(), (T, X * 2 * MM, F / 2)]


def stacked_specimens():
    one = 'Specimen label,"a"\r\n\r\nTime,Extension,Load\r\n(s),(mm),(N)\r\n' + rows([T, X, F])
    two_ = one.replace('"a"', '"b"')
    return one + "\r\n" + two_, [si(), si()]


def block_with_a_leading_empty_column():
    body = rows([T, X, F], newline="\n")
    body = "".join("," + line + "\n" for line in body.splitlines())
    return ",Specimen 1,,\n,Time,Extension,Load\n,(s),(mm),(N)\n" + body, [si()]


def column_order_free():
    body = rows([X, F, F / 3, T], newline="\n")
    return "Extension,Load,Tensile stress,Time\n(mm),(N),(MPa),(s)\n" + body, [si()]


def bluehill_universal():
    head = "Time,Displacement,Force,Tensile displacement,Displacement (Strain 1)\n"
    body = rows([T, X, F, X, X * 0.9], lambda v: f'"{v:.6f}"', newline="\n")
    return head + "(s),(mm),(N),(mm),(mm)\n" + body, [si()]


def compressive_both_signs():
    head = "Time,Compressive extension,Compressive load,Rate 1\n(s),(mm),(N),(mm/min)\n"
    return head + rows([T, -X, -F, T * 0 + 5]), [(T, -X * MM, -F)]


def pounds_and_inches():
    head = "Time (sec)\tCrosshead (in)\tLoad (lbf)\tExtensometer (in/in)\n"
    return head + rows([T, X, F, X], delimiter="\t"), [si(x=INCH, f=LBF)]


def kilogram_force_minutes_centimetres():
    head = "Time,Extension,Load\n(min),(cm),(kgf)\n"
    return head + rows([T, X, F]), [si(t=60.0, x=0.01, f=KGF)]


def grams_spelled_out_milliseconds():
    head = "Time (ms),Position (mm),Load (gram-force)\n"
    return head + rows([T * 100, X, F]), [si(t=100 * 1e-3, f=KGF / 1000)]


def millinewtons_are_not_meganewtons():
    return "Time,Extension,Load\n(s),(mm),(mN)\n" + rows([T, X, F]), [si(f=1e-3)]


def zwick_tra():
    head = '"Largeur éprouvette",5.96,"mm"\n"Date/heure",43173.4,""\n"v1",1,"mm/min"\n'
    head += '"Temps","Traverse absolue","Force standard","Course standard"\n"s","mm","N","mm"\n'
    return head + rows([T, X - 794.8, F, X], newline="\n"), [si()], "cp1252"


def zwick_german():
    head = '"Prüfzeit";"Standardkraft";"Standardweg";"Traversenweg absolut"\n"s";"N";"mm";"mm"\n'
    return head + rows([T, F, X, X + 80], comma, ";", "\n"), [si()], "cp1252"


def mts_mpt():
    head = "MTS793|MPT|ENU|1|2|.|/|:|1|0|0|A\n\nData Acquisition\t\t\tTime:\t16.4\ts\t10/19/2023\n"
    head += "Time\tCh 1 LVDT\tCh 1 Force\ns\tmm\tN\n"
    return head + rows([T, X, F], delimiter="\t", newline="\n"), [si()]


def mts_testsuite():
    head = "DAQ- Crosshead, … - (Timed)\n\nTest Run 3\n\n\n\nCrosshead ,Load ,Time \nmm,kN,s\n"
    return head + rows([X, F, T], newline="\n"), [si(f=KN)], "utf-8"


def space_aligned():
    body = "".join(f"{t:12.3f}{x:12.4f}{f:14.2f}\n" for t, x, f in zip(T, X, F, strict=True))
    return (
        "     Time      Position          Load\n       (s)          (mm)           (N)\n" + body,
        [si()],
    )


def header_cell_variants():
    head = "Time_s;Kraft in N;Weg/mm\n"
    return head + rows([T, F, X], delimiter=";"), [si()]


def units_alone():
    return "(s),(mm),(N)\n" + rows([T, X, F]), [si()]


def utf16():
    return (
        "Time\tExtension\tLoad\r\n(s)\t(mm)\t(N)\r\n" + rows([T, X, F], delimiter="\t"),
        [si()],
        "utf-16",
    )


def utf16_without_mark():
    return "Time,Extension,Load\r\n(s),(mm),(N)\r\n" + rows([T, X, F]), [si()], "utf-16-le"


def carriage_returns_only():
    return "Time,Extension,Load\r(s),(mm),(N)\r" + rows([T, X, F], newline="\r"), [si()]


def no_newline_at_the_end():
    return ("Time,Extension,Load\n(s),(mm),(N)\n" + rows([T, X, F], two))[:-2], [
        (_round2(T), _round2(X) * MM, F)
    ]


def sep_line_of_a_spreadsheet():
    return "sep=;\r\nTime;Extension;Load\r\n(s);(mm);(N)\r\n" + rows([T, X, F], delimiter=";"), [
        si()
    ]


def data_starting_at_preload_with_duplicate_zeros():
    t = np.concatenate([[0.0, 0.0], T[1:-1]])
    return "Time,Extension,Load\n(s),(mm),(N)\n" + rows([t, X + 1, F + 10.4]), [
        (t, (X + 1) * MM, F + 10.4)
    ]


def notes_in_extra_cells_of_the_first_row():
    first, rest = rows([T, X, F], newline=",,\n").split("\n", 1)
    return "Time (s),Extension (mm),Load (N),Width (mm),Note\n" + first[:-2] + ",5.0,1\n" + rest, [
        si()
    ]


def blank_tail_of_a_spreadsheet():
    return "Time,Extension,Load\n(s),(mm),(N)\n" + rows([T, X, F]) + ",,\r\n" * 12, [si()]


def dos_end_of_file():
    return "Time,Extension,Load\r\n(s),(mm),(N)\r\n" + rows([T, X, F]) + "\x1a", [si()]


def tensile_extension_before_extension():
    head = "Time,Tensile extension,Load,Extension\n(s),(mm),(N),(mm)\n"
    return head + rows([T, X - 1, F, X]), [si()]


def wavematrix_with_nested_brackets():
    head = '"Total Time (s)","Cycle Elapsed Time (s)","Total Cycles","Step",'
    head += '"Position(8800 (0,1):Position) (mm)","Load(8800 (0,1):Load) (kN)"\n'
    return head + rows([T, T, T * 0, T * 0 + 1, X, F]), [si(f=KN)]


def exponents():
    def cell(v):
        return f"{v:.8E}"

    return "Time,Extension,Load\n(s),(mm),(N)\n" + rows([T, X, F], cell), [si()]


FAMILIES = [
    value
    for value in list(globals().values())
    if getattr(value, "__module__", "") == __name__ and not value.__code__.co_argcount
]


@pytest.mark.parametrize("family", FAMILIES, ids=lambda family: family.__name__)
def test_every_dialect_is_read_exactly(family, is_read_exactly):
    is_read_exactly(family)
