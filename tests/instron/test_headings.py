"""The grammar of headings: what a column is, what its unit and factor are, and when to ask."""

import numpy as np
import pytest

import instron

N = 40
T = np.round(np.arange(N) * 0.1, 1)
X = np.round(T * 0.25, 4)
F = np.round(3.1 * np.sin(np.arange(N) / 9) ** 2 + 0.125, 4)
OTHER = np.round(1.7 + np.cos(np.arange(N) / 5), 4)  # a column that must not be taken
VALUES = {"t": T, "x": X, "F": F, "o": OTHER, "-": None, "V": np.full(N, -1e6), "g": X * 0.7 + 0.1}


def read(tmp_path, header, letters, delimiter=";", **told):
    """Read a table whose columns are given by letters: t, x, F, another, empty, volts."""

    def cell(column, i):
        if column == "~":
            return str(T[i]) if i % 10 == 0 else ""
        return "" if column == "-" else str(VALUES[column][i])

    rows = "".join(delimiter.join(cell(c, i) for c in letters) + "\n" for i in range(N))
    path = tmp_path / "export.csv"
    path.write_text(header + "\n" + rows, encoding="utf-8")
    return instron.read(path, **told)


def check(log, force=1.0, length=1e-3, time=1.0):
    np.testing.assert_allclose(log["force"], F * force, rtol=1e-12)
    np.testing.assert_allclose(log["displacement"], X * length, rtol=1e-12)
    if time:
        np.testing.assert_allclose(log["time"], T * time, rtol=1e-12)
    else:
        assert log["time"].isna().all()


FACTORS = {
    "Load (x10^3 N)": 1e3, "Load [x 10^2 N]": 1e2, "Force (10^-3 N)": 1e-3,
    "Kraft (\u00d710\u00b3 N)": 1e3, "Load (10\u207b\u00b3 N)": 1e-3, "Load (1/100 N)": 1e-2,
    "Load (kilo N)": 1e3, "Last (milli N)": 1e-3, "Load (x1000 N)": 1e3, "Load (kN)": 1e3,
    "Load_kN_": 1e3, "Load__kN_": 1e3, "Load..kN.": 1e3, "Load.kN": 1e3, "Load - kN": 1e3,
    "kN Load": 1e3, "Load, kN": 1e3, "LoadkN": 1e3, "Kraft in kN": 1e3, "Kraft/kN": 1e3,
    "ForceN": 1, "\u529bN": 1, "\u8ca0\u8377[kN]": 1e3, "Newtons": 1, "force_n": 1,
    "Load (dyn)": 1e-5, "Load (uN)": 1e-6, "Load (\u00b5N)": 1e-6, "Load (nN)": 1e-9,
    "Load (daN)": 10, "Load (tf)": 9806.65, "Load (gmf)": 9.80665e-3, "Load (g)": 9.80665e-3,
    "Load(8800 (0,1):Load) (kN)": 1e3,
}  # fmt: skip


@pytest.mark.parametrize("heading", FACTORS)
def test_units_and_factors_of_a_force(heading, tmp_path):
    (log,) = read(tmp_path, f"Time (s);Extension (mm);{heading}", "txF")
    check(log, FACTORS[heading])
    assert log.attrs["warnings"] == []


LENGTHS = {
    "Extension (1/100 mm)": 1e-5, "Weg [1/10 mm]": 1e-4, "Extension (x10^-3 m)": 1e-3,
    "Extension (nm)": 1e-9, "Weg/\u00b5m": 1e-6, "disp_um": 1e-6, "Displacement.in": 0.0254,
    "Extension (mil)": 2.54e-5, "X [mm]": 1e-3, "dL [mm]": 1e-3,
}  # fmt: skip


@pytest.mark.parametrize("heading", LENGTHS)
def test_units_and_factors_of_a_length(heading, tmp_path):
    (log,) = read(tmp_path, f"Time (s);{heading};Load (N)", "txF")
    check(log, length=LENGTHS[heading])


ASKED = [
    "Load (% of 50 N)", "Load (% of 2 kN)", "Load/10 (N)", "Load (N)/10", "Load x10 (N)",
    "1000*Load (N)", "Force \u00d7 100 (N)", "Load (10 kN)", "Load (1000 N)", "Load_mn",
    "Load (mn)",    "Load (zorg)", "Load (10E-3 N)", "Load cell 500 kN",
]  # fmt: skip


@pytest.mark.parametrize("heading", ASKED)
def test_a_number_that_a_heading_does_not_explain_is_asked_for(heading, tmp_path):
    with pytest.raises(instron.Unreadable, match=r"line 1: force is .* Say --column force=") as e:
        read(tmp_path, f"Time (s);Extension (mm);{heading}", "txF")
    assert "\n" not in str(e.value)
    told = {"columns": {"force": heading}, "units": {"force": "mN"}}
    check(read(tmp_path, f"Time (s);Extension (mm);{heading}", "txF", **told)[0], 1e-3)


@pytest.mark.parametrize("below", ["s;mm;kN", "(s);(mm);(mN)", "s;mm;lbf"])
def test_a_heading_and_a_units_row_that_disagree(below, tmp_path):
    with pytest.raises(instron.Unreadable, match="the heading says 'N', the row below it"):
        read(tmp_path, f"Time;Extension;Load (N)\n{below}", "txF")
    (log,) = read(tmp_path, "Time;Extension;Load (N)\n" + "s;mm;newton", "txF")
    check(log)


ROLES = {
    "Zeit [s];Weg [mm];Kraft Soll [N];Kraft Ist [N]": "txoF",
    "Time (s);Position (mm);Load Demand (N);Load Actual (N)": "txoF",
    "Time (s);Stroke (mm);Force error (N);Force value (N)": "txoF",
    "Time (s);Axial Displacement Command (mm);Axial Displacement (mm);Axial Force (N)": "toxF",
    "Temps (s);Consigne force (N);D\u00e9placement (mm);Force (N)": "toxF",
    "Zeit [s];Weg_soll [mm];Weg_ist [mm];Kraft_ist [N]": "toxF",
    "t [s];s_soll [mm];s_ist [mm];F_soll [N];F_ist [N]": "toxoF",
    "Time (s);Load setpoint (N);Load feedback (N);Crosshead (mm)": "toFx",
}


@pytest.mark.parametrize("header", ROLES)
def test_what_was_measured_is_taken_not_what_was_told(header, tmp_path):
    (log,) = read(tmp_path, header, ROLES[header])
    check(log)
    assert "not taken" in log.attrs["choices"][0]


SHORT = {
    "Temps (s);Traverse absolue (mm);Force (N);Course standard (mm)": "txF",
    "Time (s);Position (mm);Load (N);Extension (mm)": "txF",
    "Time (s);Extension (mm);Load A1 (N);Load A2 (N)": "txF",
    "Time (s);Extension (mm);Load (N);Time (s);Extension (mm);Load (N)": "txF",
    "Zeit [s];Weg [mm];Kraft [N];Zeit [s];Weg [mm];Kraft [N]": "txFtx",
}


@pytest.mark.parametrize("header", SHORT)
def test_a_column_that_every_row_ends_before_is_missed(header, tmp_path):
    letters = SHORT[header]
    (log,) = read(tmp_path, header, letters)
    (warning,) = log.attrs["warnings"]
    lost = [name.split(" ")[0] for name in header.split(";")[len(letters) :]]
    assert warning.startswith("every row ends before ")
    assert all(name in warning for name in lost)
    told = {q: f"#{'txF'.index(c) + 1}" for q, c in (("displacement", "x"), ("force", "F"))}
    answered = read(tmp_path, header, letters, columns=told | {"time": "#1"})[0].attrs["warnings"]
    assert answered == []


TIES = {
    "Time (s);Displacement (mm);Force X (N);Force Y (N);Force Z (N)": "txooF",
    "Time (s);Displacement (mm);Fx [N];Fy [N];Fz [N]": "txooF",
    "Time (s);Crosshead (mm);Load Cell 1 (N);Load Cell 2 (N)": "txFo",
    "Time (s);Stroke (mm);Load left (N);Load right (N)": "txFo",
    "Time (s);Weg (mm);Kraft oben (N);Kraft unten (N)": "txFo",
    "Time (s);Extension (mm);Force1 (N);Force2 (N)": "txFo",
    "Time (s);LVDT 1 (mm);LVDT 2 (mm);Load (N)": "txoF",
    "Time (s);Force 1 (N);Force 2 (N);Position 1 (mm);Position 2 (mm)": "tFoxg",
    "Time (s);Tangential Force (N);Normal Force (N);Displacement (mm)": "tFox",
    "Time (s);Weg (mm);Radialkraft (N);Axialkraft (N)": "txoF",
    "Time (s);Shear load (N);Axial load (N);Stroke (mm)": "toFx",
    "Time (s);Raw force (N);Filtered force (N);Position (mm)": "tFox",
}


@pytest.mark.parametrize("header", TIES)
def test_a_tie_is_asked_for_and_the_answer_taken(header, tmp_path):
    with pytest.raises(instron.Unreadable, match="which column is (force|displacement): '"):
        read(tmp_path, header, TIES[header])
    names = header.split(";")
    columns = {q: names[TIES[header].index(c)] for q, c in (("force", "F"), ("displacement", "x"))}
    check(read(tmp_path, header, TIES[header], columns=columns)[0])
    numbers = {q: f"#{TIES[header].index(c) + 1}" for q, c in (("force", "F"),
                                                               ("displacement", "x"))}  # fmt: skip
    check(read(tmp_path, header, TIES[header], columns=numbers)[0])


def test_columns_that_hold_the_same_are_no_tie(tmp_path):
    (log,) = read(tmp_path, "Time (s);Extension (mm);Force (N);Load (N)", "txFF")
    check(log)
    header = "Time (s);Extension (mm);Extension (m);Load (N);Load (kN)"
    rows = "".join(f"{t};{x};{x / 1000};{f};{f / 1000}\n" for t, x, f in zip(T, X, F, strict=True))
    (tmp_path / "units.csv").write_text(header + "\n" + rows)
    (log,) = instron.read(tmp_path / "units.csv")
    check(log)


SPECIMENS = ["x_mm;A1_force_N;A2_force_N;A3_force_N",
             "Weg (mm);S1 Kraft (N);S2 Kraft (N);S3 Kraft (N)",
             "Displacement (mm);Specimen 1 Load (N);Specimen 2 Load (N);Specimen 3 Load (N)",
             "Extension (mm);Load Sample 1 (N);Load Sample 2 (N);Load Sample 3 (N)"]  # fmt: skip


@pytest.mark.parametrize("header", SPECIMENS)
def test_forces_of_labelled_specimens_share_a_displacement(header, tmp_path):
    logs = read(tmp_path, header, "xFoF")
    assert len(logs) == 3
    check(logs[0], time=0)
    np.testing.assert_array_equal(logs[1]["force"], OTHER)


WORDS = {
    "Desplaz. [mm];Fuerza [N]": "xF", "Alarg. (mm);Carga (N)": "xF", "Spost. [mm];Carico [N]": "xF",
    "Elong. (mm);Force (N)": "xF", "Depth (mm);Load (N)": "xF", "Distance (mm);Force (N)": "xF",
    "Actuator (mm);Load (N)": "xF", "Jaw Separation (mm);Force (N)": "xF",
    "Maytec [mm];Kraft [N];Standardwegaufnehmer [mm]": "gFx", "Taster [mm];Kraft [N]": "xF",
    "Verpl. [mm];Kracht [N]": "xF", "Deform.(mm);For\u00e7a (N)": "xF",
    "Posuv [mm];S\u00edla [N]": "xF",
    "Machine_Displacement;Machine_Load;MD_Displacement--1;MD_Load--1": "xF--",
    "Position z [mm];Force z [N]": "xF", "Crosshead Position (mm);Crosshead Load (N)": "xF",
    "Extensometer (mm);Crosshead (mm);Load (N);Strain (%)": "gxFo",
    "Load point displacement [mm];Load [N]": "xF",
    "SetName;Size_mm;Displacement_mm;Force_N": "ooxF",
    "Load (N);Machine Extension (mm);Extension from Preload (mm)": "Fxg",
    "Kraft [N];Weg [mm];Drehwinkel [V]": "FxV",
    "Load (N);Position (mm);Aux (V);Gain (mV/V)": "FxVV",
    "Load;Displacement;Th_time": "Fx~", "Kraft;Weg;Zeit Thermoelement": "Fx~",
    "Force (N);Travel (mm);Time DIC (s)": "Fx-",
    "Position des Aktuators (mm);Kraft (N);Digitale Position (mm)": "xFg",
    "Siirtymä (mm);Voima (N)": "xF", "Forlengelse [mm];Kraft [N]": "xF",
    "Vandring (mm);Kraft (N)": "xF", "Chuyển vị (mm);Lực (N)": "xF",
}  # fmt: skip


@pytest.mark.parametrize("header", WORDS)
def test_words_of_many_machines(header, tmp_path):
    check(read(tmp_path, header, WORDS[header])[0], time=0)


def test_matlab_and_r_names(tmp_path):
    for header in ("TotalTime_s_;Position_mm_;Load__kN_", "Time..s.;Extension..mm.;Load..kN.",
                   "Time_s;Disp_mm;Force_kN", "time.s;ext.mm;load.kN"):  # fmt: skip
        (log,) = read(tmp_path, header, "txF")
        check(log, 1e3)
        assert log.attrs["warnings"] == []


def test_naming_one_column_leaves_the_others_and_keeps_its_unit(tmp_path):
    header = "Zeit [min];Weg [mm];Kanal 7 [kN];Kraft [N]"
    (log,) = read(tmp_path, header, "txFo", columns={"force": "Kanal 7"})
    check(log, 1e3, time=60)
    (log,) = read(tmp_path, header, "txFo", columns={"force": "kanal 7 [kN]"})
    check(log, 1e3, time=60)
    with pytest.raises(instron.Unreadable, match='agrees with --column force="Kanal 9"'):
        read(tmp_path, header, "txFo", columns={"force": "Kanal 9"})
    with pytest.raises(instron.Unreadable, match="which column is weight"):
        read(tmp_path, header, "txFo", columns={"weight": "Kanal 7"})


@pytest.mark.parametrize(
    ("header", "said"),
    [
        ("Tid;Voima;Liike\ns;N;mm", "is the only column in"),
        ("Zeit;Kanal 3;Weg\n(s);(N);(mm)", "is the only column in"),
        ("Aika [s];Jarru [N];Nousu [mm]", "taken by their units"),
    ],
)
def test_an_unknown_word_is_read_by_its_unit_with_a_warning(header, said, tmp_path):
    (log,) = read(tmp_path, header, "tFx")
    check(log)
    assert said in log.attrs["warnings"][0]


@pytest.mark.parametrize(
    "header", ["Aika [s];Jarru [N];Nousu [mm];Lasku [mm]", "Aika [s];Jarru [g];Nousu [mm]"]
)
def test_unknown_words_are_not_read_where_units_leave_a_doubt(header, tmp_path):
    with pytest.raises(instron.Unreadable):
        read(tmp_path, header, "tFxo" if "Lasku" in header else "tFx")


@pytest.mark.parametrize(
    "header", ["Zeit;Weg;Kraft Soll\ns;mm;N", "Time;Travel;Peak load\n(s);(mm);(N)"]
)
def test_units_below_names_are_no_header(header, tmp_path):
    with pytest.raises(instron.Unreadable):
        read(tmp_path, header, "txo")


def test_only_a_setpoint_is_no_force(tmp_path):
    with pytest.raises(instron.Unreadable, match="no force column"):
        read(tmp_path, "Zeit [s];Weg [mm];Kraft Soll [N]", "txF")


def test_tons_are_read_with_a_word(tmp_path):
    (log,) = read(tmp_path, "Time (s);Extension (mm);Load (ton)", "txF")
    check(log, 9806.65)
    assert "a short ton is 907 kgf" in log.attrs["warnings"][0]


def test_channels_of_one_machine_are_no_specimens(tmp_path):
    with pytest.raises(instron.Unreadable, match="which column is force"):
        read(tmp_path, "Time (s);Ch 1 Position (mm);Ch 1 Load (N);Ch 2 Position (mm);Ch 2 Load (N)",
             "txFgo")  # fmt: skip


def test_a_numbered_extension_beside_the_position_is_an_extensometer(tmp_path):
    (log,) = read(tmp_path, "Time (s);Position (mm);Force (N);Extension 1 (mm)", "txFg")
    check(log)


@pytest.mark.parametrize("name", ["Verformung in mm", "Deformation, mm", "compression_mm",
                                  "Encoder_mm", "Stage Position (mm)"])  # fmt: skip
def test_a_length_by_its_unit(name, tmp_path):
    (log,) = read(tmp_path, f"Time (s);{name};Kraft in N", "txF")
    check(log)


ABOVE = {
    "Force Unit,kgf\nDisplacement Unit,cm\n": ("kgf", "cm"),
    "Load units: kgf\nUnit of displacement: cm\n": ("kgf", "cm"),
    "Model,ZTA\nUnit,kgf\nSampling rate,10 Hz\n": ("kgf", "mm"),
    "[Info]\nForceUnit=kgf\nDisplacementUnit=cm\n[Data]\n": ("kgf", "cm"),
    "Einheit der Kraft;kgf\n": ("kgf", "mm"),
    "Units: kgf, cm, s\n": ("kgf", "cm"),
}


@pytest.mark.parametrize("head", ABOVE)
def test_units_that_lines_above_state(head, tmp_path):
    path = tmp_path / "export.csv"
    rows = "".join(f"{i};{i / 8};{i / 4}\n" for i in range(1, 30))
    path.write_text((head + "Time (s);Displacement;Force\n" + rows).replace(";", ","))
    (log,) = instron.read(path)
    columns = log.attrs["columns"]
    assert (columns["force"]["unit"], columns["displacement"]["unit"]) == ABOVE[head]
    np.testing.assert_allclose(log["force"].iloc[0], 0.25 * 9.80665)


def test_units_above_that_disagree_are_none(tmp_path):
    path = tmp_path / "export.csv"
    path.write_text("Unit,kgf\nForce unit,N\nDisplacement,Force\n0.1,2\n0.2,3\n0.3,4\n")
    (log,) = instron.read(path)
    assert any("unit of force is not stated" in note for note in log.attrs["warnings"])


@pytest.mark.parametrize("mark", ["#", "%", "# ", "//"])
def test_names_behind_a_comment_mark(mark, tmp_path):
    path = tmp_path / "export.txt"
    body = "".join(f"{i / 10} {i / 8} {i / 4}\n" for i in range(9))
    path.write_text(f"{mark} Time(s) Disp(mm) Force(N)\n" + body)
    (log,) = instron.read(path)
    assert log["force"].tolist() == [i / 4 for i in range(9)]
    assert log.attrs["columns"]["time"]["unit"] == "s"
