import json

import numpy as np
import pandas as pd
import pytest
from click.testing import CliRunner

import instron
from combing.cli import main

RIG = "r = 4.25e-4\nE = 2.8e9\npitch = 0.0102\nhelix_radius = 8.5e-4\n"


def log(seed):
    rng = np.random.default_rng(seed)
    d = np.linspace(0, 0.09, 1500)
    jams = sum(np.exp(-(((d - c - rng.normal(0, 5e-4)) / 2e-3) ** 2)) for c in (0.02, 0.04, 0.06))
    F = (1 - np.exp(-d / 0.01)) / (1 + np.exp((d - 0.08) / 5e-4)) + jams
    F = F + 0.2 + rng.normal(0, 0.005, len(d))
    return pd.DataFrame({"time": d / 1e-3, "displacement": d, "force": F})


@pytest.fixture
def bench(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "rig.toml").write_text(RIG)
    (tmp_path / "runs").mkdir()
    for k in range(3):
        instron.write_bluehill(tmp_path / f"runs/{k}.csv", log(k), {"Specimen label": f"helix {k}"})
    return tmp_path


def run(capsys, *arguments):
    code = 0
    try:
        main(["force", *arguments])
    except SystemExit as stop:
        code = stop.code
    out = capsys.readouterr()
    return code, out.out, out.err


def test_a_folder_of_repeats_becomes_tables_and_a_figure(bench, capsys):
    code, out, err = run(capsys, "runs", "--rig", "rig.toml", "-o", "out", "--active-length", "0.1")
    assert (code, err) == (0, "")
    assert "helix 1" in out
    assert "fewer than 4 repeats" in out
    written = {path.name for path in (bench / "out").iterdir()}
    assert {"curves.csv", "mean.csv", "repeats.csv", "summary.csv", "events.csv", "theory.csv",
            "force.png", "force.svg", "section.html"} <= written  # fmt: skip
    curves = pd.read_csv(bench / "out/curves.csv")
    assert list(curves) == ["repeat", "specimen", "file", "x", "f", "d", "F"]
    assert curves.groupby("repeat").size().tolist() == [1500] * 3
    table = pd.read_csv(bench / "out/repeats.csv")
    assert table["file"].tolist() == ["0.csv", "1.csv", "2.csv"]
    assert table["peaks"].tolist() == [3, 3, 3]
    assert table["D"].mean() == pytest.approx(0.0815, rel=0.01)
    section = (bench / "out/section.html").read_text()
    assert section.startswith("<section")
    assert "<svg" in section
    assert [p.name for p in bench.iterdir()].count(".force-") == 0


def test_json_is_json(bench, capsys):
    code, out, _ = run(capsys, "runs/0.csv", "--rig", "rig.toml", "--json")
    found = json.loads(out)
    assert code == 0
    assert found["curves"][0]["specimen"] == "helix 0"
    assert found["curves"][0]["B"] == pytest.approx(np.pi / 4 * 2.8e9 * 4.25e-4**4)


def test_explain_says_what_was_understood(bench, capsys):
    code, out, _ = run(capsys, "--explain", "runs/0.csv")
    assert code == 0
    assert "column 3 'Load' in N" in out
    assert "delimiter ','" in out
    assert "lines      1504: 1 blank, 1 metadata, 1 heading, 1 units, 1500 data" in out
    assert 8 <= len(out.splitlines()) <= 13


def test_a_folder_as_it_is(bench, capsys):
    """Notes, a broken file and Bluehill's own among the exports, and one export copied."""
    (bench / "runs/1.is_tens").write_text("<?xml version='1.0'?><Sample/>")
    (bench / "runs/photo.jpg").write_bytes(b"\xff\xd8")
    (bench / "runs/notes.txt").write_text("second run slipped\n")
    (bench / "runs/broken.csv").write_text("Time,Extension,Load\n(s),(mm),(N)\n0,1,OVER\n1,2,3\n")
    (bench / "runs/copy.csv").write_bytes((bench / "runs/0.csv").read_bytes())
    code, _, err = run(capsys, "runs", "--rig", "rig.toml", "-o", "out")
    assert code == 2
    assert "broken.csv" in err
    assert "--skip-unreadable goes on without it" in err
    code, out, _ = run(capsys, "--explain", "runs")
    assert code == 0
    assert out.count("unreadable") == 4
    assert "1.is_tens: a Bluehill sample: export the raw data from Bluehill as CSV" in out
    assert "1 with another ending not looked at: photo.jpg" in out
    assert out.count("column 3 'Load' in N") == 4
    code, out, err = run(capsys, "runs", "--rig", "rig.toml", "-o", "out", "--skip-unreadable")
    assert code == 0
    assert "copy.csv: the same numbers as" in err
    assert "combing: skipped: runs/1.is_tens: a Bluehill sample" in err
    skipped = pd.read_csv(bench / "out/skipped.csv")
    assert [name.split("/")[-1] for name in skipped["file"]] == [
        "broken.csv",
        "notes.txt",
        "1.is_tens",
        "runs",
    ]
    assert "no header" in skipped["reason"][1]
    assert pd.read_csv(bench / "out/repeats.csv")["file"].tolist() == ["0.csv", "1.csv", "2.csv"]


def test_a_column_is_named_where_the_file_leaves_a_doubt(bench, capsys):
    text = (bench / "runs/0.csv").read_text().replace("Load", "Kanal 3").replace("(N)", "")
    (bench / "doubt.csv").write_text(text)
    code, _, err = run(capsys, "doubt.csv", "--rig", "rig.toml")
    assert code == 2
    assert "doubt.csv: " in err
    code, out, _ = run(
        capsys, "doubt.csv", "--explain", "--column", "force=Kanal 3", "--units", "force=N"
    )
    assert code == 0
    assert "column 3 'Kanal 3' in N" in out
    code, _, err = run(capsys, "doubt.csv", "--explain", "--column", "Kanal 3")
    assert code == 2
    assert "write it as --column force=" in err


@pytest.mark.parametrize(
    ("arguments", "reason"),
    [
        (("nowhere.csv", "--rig", "rig.toml"), "nowhere.csv: no such file"),
        (("empty.csv", "--rig", "rig.toml"), "empty.csv: the file is empty"),
        (("runs/0.csv", "--rig", "negative.toml"), "r = -1.0: input should be greater than 0"),
        (("runs/0.csv", "--rig", "key.toml"), "unknown key 'radius'"),
        (("runs/0.csv", "--rig", "nowhere.toml"), "nowhere.toml"),
        (("runs/0.csv",), "--rig is missing"),
        (("runs/0.csv", "--explain", "--units", "force"), "--units 'force'"),
        (("runs/0.csv", "--rig", "rig.toml", "--active-length", "-1"), "must be positive"),
        (("hollow", "--rig", "rig.toml"), "hollow: no exports"),
        (("runs/0.csv", "--rig", "rig.toml", "-o", "rig.toml"), "rig.toml: is a file"),
        (("runs/0.csv", "--rig", "rig.toml", "-o", "/proc/out"), "/proc/out: cannot be written"),
        (("runs/0.csv", "--rig", "rig.toml", "--units", "force=stone"), "'stone'"),
    ],
)
def test_a_users_mistake_is_one_line_and_exit_code_2(bench, capsys, arguments, reason):
    (bench / "empty.csv").write_text("")
    (bench / "negative.toml").write_text("r = -1.0\nE = 1e9\n")
    (bench / "key.toml").write_text("radius = 1.0\nE = 1e9\n")
    (bench / "hollow").mkdir()
    before = sorted(bench.rglob("*"))
    arguments = arguments if "-o" in arguments else (*arguments, "-o", "out")
    code, out, err = run(capsys, *arguments)
    assert code == 2
    assert reason in err
    assert len(err.strip().splitlines()) == 1
    assert out == ""
    assert sorted(bench.rglob("*")) == before


def test_help_shows_an_example():
    from combing.commands.force import command

    assert "combing force run1.csv" in CliRunner().invoke(command, ["--help"]).output
