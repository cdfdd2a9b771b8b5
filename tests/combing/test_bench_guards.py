"""What the bench must not take without a word: copies, other specimens, sets without use."""

import json

import numpy as np
import pandas as pd
import pytest
from PIL import Image

import instron
import sim
from combing.compare.agreement import disagreements, of_rig, of_scene
from combing.compare.bench import compare
from combing.compare.copies import refuse_copied_logs, refuse_copies
from combing.compare.force import compare_force, measure_force
from combing.errors import UserError
from combing.study import ForceSet, load_study
from combing.tables import read_table, write_table

RIG = "r = 4.25e-4\nE = 2.184e8\nzero = 'none'\n"


def export(path, seed, *, factor=1.0, decimals=6, force_unit="N", newline="\n"):
    """Write a jam at x of about 0.5 with noise, as a machine exports it."""
    rng = np.random.default_rng(seed)
    x = np.linspace(0, 1, 401)
    force = 2 * np.exp(-(((x - 0.5) / 0.1) ** 2)) + 0.01 * rng.standard_normal(len(x))
    rows = [
        f"{20 * one:.{decimals}f},{100 * one:.{decimals}f},{factor * load:.{decimals}f}"
        for one, load in zip(x, force, strict=True)
    ]
    text = newline.join(["Time,Extension,Load", f"(s),(mm),({force_unit})", *rows, ""])
    path.write_text(text, newline="")


@pytest.fixture
def lab(tmp_path):
    (tmp_path / "logs").mkdir()
    for number in (1, 2, 3):
        export(tmp_path / f"logs/a{number}.csv", number)
    (tmp_path / "rig.toml").write_text(RIG)
    rng = np.random.default_rng(0)
    for number in (1, 2):
        pixels = rng.integers(60, 80, (80, 60, 3), dtype=np.uint8)
        Image.fromarray(pixels).save(tmp_path / f"photo{number}.png")

    def study(text):
        (tmp_path / "study.toml").write_text('title = "t"\n' + text)
        return load_study(tmp_path / "study.toml")

    study.folder = tmp_path
    return study


FORCE = '[[force]]\nname = "{name}"\nlogs = {logs}\nrig = "rig.toml"\n'


def force(name="a", logs='"logs/a*.csv"', more=""):
    return FORCE.format(name=name, logs=logs) + more


def notes_of(out):
    return json.loads((out / "summary.json").read_text(encoding="utf-8"))


@pytest.mark.parametrize("second", ["a", " a ", "a\\t"])
def test_two_sets_of_one_name_are_refused(lab, second):
    with pytest.raises(UserError, match=r"\[\[force\]\] 1 and 2 are both named 'a'"):
        lab(force() + force(second))


def test_sets_of_different_kinds_may_share_a_name(lab):
    link = '[[link]]\nname = "a"\nphotos = "photo*.png"\npositions = [0, 1]\npixel_size = 1e-4\n'
    assert [one.name for one in lab(force() + link).sets] == ["a", "a"]


@pytest.mark.parametrize(
    ("logs", "said"),
    [
        ('["logs/a*.csv", "logs/*1.csv"]', "a1.csv is named by 'logs/a*.csv' and by 'logs/*1.csv'"),
        ('["logs/a1.csv", "logs/a1.csv"]', "a1.csv is named twice by 'logs/a1.csv'"),
        ('["logs/a1.csv", "logs/../logs/a1.csv"]', "a1.csv"),
        ('["logs/a1.csv", "logs/link.csv"]', "link.csv and a1.csv are one file"),
    ],
)  # fmt: skip
def test_a_log_named_twice_is_refused(lab, logs, said):
    (lab.folder / "logs/link.csv").symlink_to(lab.folder / "logs/a1.csv")
    with pytest.raises(UserError) as caught:
        lab(force(logs=logs))
    assert said in str(caught.value)
    assert "would count twice" in str(caught.value)


def test_the_photograph_before_is_not_one_of_the_series(lab):
    link = '[[link]]\nname = "a"\nphotos = "photo*.png"\npositions = [0, 1]\npixel_size = 1e-4\n'
    with pytest.raises(UserError, match="photo1.png is also among the photos"):
        lab(link + 'before = "photo1.png"\n')


@pytest.mark.parametrize(
    "copy",
    [
        {},
        {"newline": "\r\n"},
        {"decimals": 4},
        {"factor": 1e-3, "decimals": 9, "force_unit": "kN"},
    ],
)
def test_a_copy_of_a_log_is_found_by_its_readings(lab, copy):
    export(lab.folder / "logs/b1.csv", 1, **copy)
    study = lab(force(logs='["logs/a*.csv", "logs/b1.csv"]'))
    with pytest.raises(UserError, match=r"a1\.csv.*b1\.csv.*same readings and would count twice"):
        compare(study, lab.folder / "out", quiet=True)
    assert not (lab.folder / "out").exists()


def test_repeats_that_differ_by_a_digit_of_noise_are_no_copies():
    d = np.linspace(0, 1, 50)
    rough = np.round(np.sin(3 * d), 2)
    other = rough + 0.01 * np.where(np.arange(50) % 7 == 0, 1, 0)
    curves = [pd.DataFrame({"d": d, "F": F}) for F in (rough, other)]
    refuse_copied_logs("a", curves)
    with pytest.raises(UserError, match="would count twice"):
        refuse_copied_logs("a", [curves[0], curves[1], curves[0].copy()])


def test_a_picture_that_is_there_twice_is_named():
    with pytest.raises(UserError, match="c: two and three hold the same picture"):
        refuse_copies("c", "picture", [("one", 1), ("two", 2), ("three", 2)])


HELIX = 'preset = "double_helix"\npi1 = 36\nheight = 0.03\n'


def test_another_specimen_in_rig_and_scene_is_refused_before_anything_is_simulated(lab):
    rig = RIG + f"pitch = {14 * 4.25e-4}\nhelix_radius = 4.25e-4\nturns = 25\n"
    (lab.folder / "rig.toml").write_text(rig)
    (lab.folder / "scene.toml").write_text(HELIX)
    scene = 'simulation = "scene.toml"\n'
    with pytest.raises(UserError, match=r"a: P = 0\.00595 m in rig\.toml but P = 0\.0153 m in sce"):
        compare(lab(force(more=scene)), lab.folder / "out", quiet=True)
    with pytest.raises(UserError, match="turns = 25 in rig.toml but turns = 1.961 in scene.toml"):
        compare(lab(force(more=scene + 'allow_different = ["P"]\n')), lab.folder / "o", quiet=True)
    assert not list(lab.folder.rglob("*.nc*"))


@pytest.mark.parametrize(
    ("key", "value", "fact"),
    [
        ("r = 4.25e-4", "r = 4.4e-4", "r"),
        ("pitch = 0.0153", "pitch = 0.0160", "P"),
        ("helix_radius = 4.25e-4", "helix_radius = 8.5e-4", "R"),
        ("turns = 9.8", "turns = 12", "turns"),
    ],
)
def test_each_fact_is_compared_and_may_be_allowed_by_name(tmp_path, key, value, fact):
    text = RIG + "pitch = 0.0153\nhelix_radius = 4.25e-4\nturns = 9.8\n"
    scene = of_scene("scene.toml", sim.double_helix(36, height=0.15))
    (tmp_path / "good.toml").write_text(text)
    assert disagreements("a", [of_rig(tmp_path / "good.toml"), scene], []) == []
    (tmp_path / "rig.toml").write_text(text.replace(key, value))
    with pytest.raises(UserError, match=f'{fact} = .*allow_different = \\["{fact}"\\]'):
        disagreements("a", [of_rig(tmp_path / "rig.toml"), scene], [])
    (note,) = disagreements("a", [of_rig(tmp_path / "rig.toml"), scene], [fact])
    assert "the study allows it" in note


def test_what_a_source_does_not_state_is_not_compared(tmp_path):
    (tmp_path / "rig.toml").write_text("B = 1e-6\n")
    scene = of_scene("scene.toml", sim.double_helix(36))
    assert disagreements("a", [of_rig(tmp_path / "rig.toml"), scene], []) == []


def test_a_set_that_cannot_be_used_is_said_and_the_others_go_on(lab):
    (lab.folder / "logs/bad.csv").write_text("no log\n")
    curl = '[[curl]]\nname = "no marker"\nphotos = "photo*.png"\nmarker_side = 0.01\n'
    study = lab(force() + force("broken", '"logs/bad.csv"') + curl)
    out = lab.folder / "out"
    result = compare(study, out, quiet=True)
    assert len(result.left_out) == 2
    summary = notes_of(out)
    assert summary["left_out"] == result.left_out
    assert "bad.csv" in summary["left_out"][0]
    assert "marker" in summary["left_out"][1]
    page = (out / "report.html").read_text(encoding="utf-8")
    assert "Left out" in page
    assert "bad.csv" in page
    assert pd.read_csv(out / "force.csv", comment="#")["set"].unique().tolist() == ["a"]


def test_exit_code_tells_that_something_is_missing(lab, monkeypatch, capsys):
    from combing.cli import main

    (lab.folder / "logs/bad.csv").write_text("no log\n")
    lab(force() + force("broken", '"logs/bad.csv"'))
    monkeypatch.chdir(lab.folder)
    with pytest.raises(SystemExit) as ended:
        main(["compare", "study.toml", "-o", "out"])
    assert ended.value.code == 3
    said = capsys.readouterr()
    assert "combing: left out: force 'broken'" in said.err
    assert "force 'a': 3 files, 3 specimens, 0 runs" in said.err
    assert said.out == f"report: {'out/report.html'}\n"


def test_where_nothing_is_left_the_study_is_at_fault_and_nothing_is_written(lab):
    (lab.folder / "logs/bad.csv").write_text("no log\n")
    text = force("x", '"logs/bad.csv"') + force("y", '"logs/bad.csv"')
    with pytest.raises(UserError, match="nothing is left to compare"):
        compare(lab(text), lab.folder / "out", quiet=True)
    assert not (lab.folder / "out").exists()


def test_counts_of_every_set_are_in_the_report_and_what_no_set_names_is_noted(lab):
    study = lab(force(logs='"logs/a1.csv"') + force("b", '["logs/a1.csv", "logs/a2.csv"]'))
    out = lab.folder / "out"
    compare(study, out, quiet=True)
    summary = notes_of(out)
    counts = [(one["set"], one["files"], one["specimens"], one["runs"]) for one in summary["sets"]]
    assert counts == [("a", 1, 1, 0), ("b", 2, 2, 0)]
    assert f"{lab.folder / 'logs'}: 1 file of the same kind in no set: a3.csv" in summary["notes"]
    assert "a and b share a1.csv" in summary["notes"]
    page = (out / "report.html").read_text(encoding="utf-8")
    assert "What each set holds" in page
    assert "1 file of the same kind in no set" in page


def test_a_name_with_signs_of_its_own_comes_back_from_every_table(lab):
    name = 'n°1 #2 = $x, \\"y\\"'
    out = lab.folder / "out"
    compare(lab(force(name)), out, quiet=True)
    for read in (
        lambda path: pd.read_csv(path, comment="#"),
        lambda path: read_table(path, []),
    ):
        table = read(out / "force.csv")
        assert table["set"].unique().tolist() == [name.replace("\\", "")]
        assert table["f"].dtype == float


def test_a_hash_in_a_cell_is_no_comment(tmp_path):
    table = pd.DataFrame({"photo": ["#1.jpg", "a #2.jpg", "b=3.jpg"], "d": [1.0, np.nan, 0.03]})
    write_table(tmp_path / "t.csv", table, ["two\nlines"])
    for found in (read_table(tmp_path / "t.csv", ["d"]),
                  pd.read_csv(tmp_path / "t.csv", comment="#")):  # fmt: skip
        pd.testing.assert_frame_equal(found, table)
    (tmp_path / "by_hand.csv").write_text("# where\nphoto,d\nIMG#1.jpg,0.01\n")
    assert read_table(tmp_path / "by_hand.csv", ["d"])["photo"].tolist() == ["IMG#1.jpg"]


def test_a_name_that_a_spreadsheet_would_calculate_is_refused(lab):
    with pytest.raises(UserError, match="'=1' begins with '=': a spreadsheet"):
        lab(force("=1"))


def test_what_is_doubtful_about_a_simulation_reaches_the_notes(lab):
    """A force that still rises when the run stops gives a D that means nothing."""
    whole = sim.simulate(sim.double_helix(18, turns=3, elements_per_pitch=6, speed=0.5))
    run = sim.Run(whole.data.assign(force=1.0 * whole.data["displacement"]))
    chosen = ForceSet.model_construct(
        name="a", logs=[], rig=lab.folder / "rig.toml", simulation="run", active_length=None,
        truth=None,
    )  # fmt: skip
    measured = measure_force(chosen.model_copy(update={"logs": [lab.folder / "logs/a1.csv"]}))
    found = compare_force(chosen, measured, {"run": run})
    doubts = instron.scale(run.force_log(), instron.load_rig(chosen.rig)).attrs["warnings"]
    assert "the log stops before combing ends: D is the last displacement" in doubts
    said = [note for note in found.notes if note.startswith("a, simulation: ")]
    assert said == [f"a, simulation: {doubt}" for doubt in doubts]  # each once
