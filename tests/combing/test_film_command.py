"""``combing helix`` with a film."""

import json

import cv2
import numpy as np
import pandas as pd
import pytest
from drawn.helix import draw_helix

from combing.cli import main
from combing.film import Way, started

R = 5.0
PITCH = 18 * R
LENGTH = 6 * PITCH
PLACE = 2.5 * PITCH
COLOURS = ((200, 40, 40), (40, 70, 190), (60, 140, 60))


def run(*arguments):
    try:
        main(["helix", *map(str, arguments)])
    except SystemExit as ended:
        return ended.code
    return 0


def picture(*, combed):
    """Draw a helix, or one with half of its link above a tine that spreads it."""

    def link(s):
        wound = np.where(s < PLACE, 0.5, 1.2) / PITCH if combed else 1 / PITCH + 0 * s
        return np.where(combed & (np.abs(s - PLACE) < 0.4 * PITCH), 0.0, wound)

    def radius(s):
        return R * (1 + combed * 2.2 * np.exp(-(((s - PLACE) / (0.35 * PITCH)) ** 2)))

    tine, beside = (PLACE, 2 * R) if combed else None, -np.pi * (PLACE / PITCH - 0.4)
    return draw_helix(
        R, link, LENGTH, helix_radius=radius, tine=tine, phase=beside, colours=COLOURS, rng=4
    ).pixels


@pytest.fixture(scope="module")
def film(tmp_path_factory):
    """Ten frames a second: a second at rest, then a tine that is there at once."""
    rest, combed = picture(combed=False), picture(combed=True)
    height, width = (
        2 * (min(pair) // 2) for pair in np.transpose([rest.shape[:2], combed.shape[:2]])
    )
    path = tmp_path_factory.mktemp("films") / "run.mp4"
    writer = cv2.VideoWriter(str(path), cv2.VideoWriter_fourcc(*"mp4v"), 10.0, (width, height))
    for one in [rest] * 10 + [combed] * 12:
        writer.write(np.ascontiguousarray(one[:height, :width, ::-1]))
    writer.release()
    return path


@pytest.fixture(scope="module")
def log(film):
    """Log a machine that waits for half a second before it moves by 2 mm/s."""
    time = np.arange(0, 3, 0.02)
    d = 2.0 * np.maximum(time - 0.5, 0)
    table = pd.DataFrame({"Time (s)": time, "Extension (mm)": d, "Load (N)": 0.1 + 0.05 * d})
    path = film.with_name("run.csv")
    table.to_csv(path, index=False)
    return path


def test_a_film_beside_its_log(film, log, tmp_path, capsys):
    """One frame at rest, one a second after the start of motion: seen, and in the log."""
    asked = [film, "-o", tmp_path, "--log", log, "--every", "1s", "--scale", "10px/mm", "--jobs", 1]
    assert run(*asked, "--json") == 0
    rows = json.loads(capsys.readouterr().out)
    assert [row["frame"] for row in rows] == [0, 12, 20]
    table = pd.read_csv(tmp_path / "film.csv")
    np.testing.assert_allclose(table["d"], [0, 0.4e-3, 2e-3], atol=0.05e-3)
    np.testing.assert_allclose(table["force"], [0.1, 0.12, 0.2], atol=0.01)
    late = table.iloc[-1]
    assert late["lambda_0"] == pytest.approx(10e3 / PITCH, rel=0.02)
    assert late["tine"] == pytest.approx(PLACE / 10e3, rel=0.06)
    assert 0.3 < late["jump"] < 1.0
    assert late["turns"] < table["turns"].iloc[0] - 0.5
    names = {file.name for file in tmp_path.iterdir()}
    assert names == {"film.csv", "profiles.csv", "film.png", "film.svg", "frames"}
    assert not list((tmp_path / "frames").glob("*.png"))


def test_it_goes_on_where_it_stopped(film, log, tmp_path, monkeypatch):
    asked = [film, "-o", tmp_path, "--speed", "2mm/s", "--start", "1s", "--every", "5mm",
             "--quiet", "--jobs", 1]  # fmt: skip
    assert run(*asked) == 0
    records = sorted((tmp_path / "frames").glob("*.json"))
    first = [record.stat().st_mtime_ns for record in records]
    assert [record.stem for record in records] == ["frame_000000", "frame_000010"]
    monkeypatch.setattr("combing.film.measure_pair", None)  # nothing is left to measure
    assert run(*asked) == 0
    assert [record.stat().st_mtime_ns for record in records] == first


def test_a_log_counts_from_where_it_begins_to_move():
    time = np.arange(0, 2, 0.1)
    d = 0.01 + 1e-3 * np.maximum(time - 0.7, 0)
    log = pd.DataFrame({"time": time, "displacement": d, "force": time})
    found = started(log)
    assert found["time"].iloc[0] == 0
    assert found["force"].iloc[0] == pytest.approx(0.7)
    assert found["displacement"].iloc[3] == pytest.approx(0.3e-3)
    assert Way(log=found).at(0.5) == pytest.approx((0.5e-3, 1.2))
    assert np.isnan(Way(log=found).at(5.0)[0])


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ([], "a film needs --speed of the tine, as 1mm/s, or --log"),
        (["--speed", "fast"], "--speed fast: give a length a second"),
        (["--speed", "1mm/s", "--every", "often"], "--every often: give"),
        (["--speed", "1mm/s", "--every", "0s"], "--every 0s: give"),
        (["--speed", "1mm/s", "--start", "soon"], "--start soon: give seconds"),
        (["--speed", "1mm/s", "--x", "0.1"], "--x: is for photographs, not for a film"),
    ],
)
def test_wrong_options_are_named(film, tmp_path, capsys, options, message):
    assert run(film, "-o", tmp_path / "out", *options) == 2
    assert message in capsys.readouterr().err


def test_a_photograph_is_no_film(tmp_path, capsys):
    assert run(tmp_path / "a.png", "-o", tmp_path / "out", "--speed", "1mm/s") == 2
    assert "are for one film" in capsys.readouterr().err
