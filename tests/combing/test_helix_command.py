"""``combing helix`` from the command line."""

import json

import cv2
import numpy as np
import pandas as pd
import pytest
from drawn.helix import draw_helix

from combing.cli import main

R = 6.0
PITCH = 18 * R


def run(*arguments):
    try:
        main(["helix", *map(str, arguments)])
    except SystemExit as ended:
        return ended.code
    return 0


@pytest.fixture(scope="module")
def photo(tmp_path_factory):
    path = tmp_path_factory.mktemp("photos") / "helix.png"
    drawn = draw_helix(R, lambda s: 1 / PITCH, 5 * PITCH, rng=1)
    cv2.imwrite(str(path), drawn.pixels[..., ::-1])
    return path


def test_one_photograph(photo, tmp_path, capsys):
    assert run(photo, "-o", tmp_path, "--scale", "20px/mm", "--json") == 0
    (row,) = json.loads(capsys.readouterr().out)
    assert row["handedness"] == "right"
    assert row["unit"] == "m"
    assert row["pitch"] == pytest.approx(PITCH / 20e3, rel=0.01)
    link = pd.read_csv(tmp_path / "link.csv")
    assert link["link"].median() == pytest.approx(20e3 / PITCH, rel=0.01)
    files = {file.name for file in tmp_path.iterdir()}
    assert files == {
        "DATA.md", "crossings.csv", "link.csv", "link.png", "link.svg", "overlay.png", "phase.csv",
        "summary.json",
    }  # fmt: skip
    assert "arclength of the axis from the root [m]" in (tmp_path / "DATA.md").read_text()


def test_without_a_scale_lengths_are_in_pixels(photo, tmp_path, capsys):
    assert run(photo, "-o", tmp_path) == 0
    assert "no scale: lengths in pixels" in capsys.readouterr().out


def test_a_series(photo, tmp_path):
    assert run(photo, photo, "--x", "0.1,0.2", "-o", tmp_path, "--quiet") == 0
    assert {"profiles.csv", "jumps.csv", "change.svg", "kymograph.png", "helix", "helix-2"} <= {
        file.name for file in tmp_path.iterdir()
    }
    assert pd.read_csv(tmp_path / "profiles.csv")["change"].abs().max() < 0.02


def test_positions_are_displacements_and_the_same_as_x(photo, tmp_path):
    places = ["--positions", "8.5mm,0.017", "--combed", "8.5cm"]
    assert run(photo, photo, *places, "-o", tmp_path, "--quiet") == 0
    assert list(pd.read_csv(tmp_path / "jumps.csv")["x"]) == pytest.approx([0.1, 0.2])


def test_a_photograph_with_one_strand_gives_one_clear_line(tmp_path, capsys):
    picture = np.full((300, 200, 3), 230, np.uint8)
    cv2.line(picture, (100, 30), (100, 270), (40, 40, 200), 12, cv2.LINE_AA)
    path = tmp_path / "single.png"
    cv2.imwrite(str(path), picture)
    assert run(path, "-o", tmp_path / "out") == 2
    said = capsys.readouterr().err.strip()
    assert len(said.splitlines()) == 1
    assert "single.png" in said
    assert "two strands" in said
    assert not (tmp_path / "out").exists()


def test_a_bad_photograph_does_not_stop_the_others(photo, tmp_path, capsys):
    assert run(photo, tmp_path / "missing.png", "-o", tmp_path / "out") == 0
    assert "missing.png: REFUSED" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--tine", "3"], "--tine 3: give 2 or 3 numbers"),
        (["--x", "0.1,0.2"], "--x 0.1,0.2: give 1 numbers"),
        (
            ["--positions", "1mm,2mm", "--combed", "9mm"],
            "--positions 1mm,2mm: give 1 lengths, as 0.01 or 10mm",
        ),
        (["--positions", "1mm"], "where x = d/D is known give --x"),
        (
            ["--positions", "1mm", "--combed", "9 miles"],
            "--combed 9 miles: give 1 lengths, as 0.01 or 10mm",
        ),
        (["--positions", "1mm", "--combed", "0mm"], "D must be positive"),
        (["--x", "0.1", "--combed", "9mm"], "--x: is d/D already"),
        (["--before", "rest.png"], "--before needs --positions or --x"),
        (["--roi", "1,2"], "region of interest '1,2'"),
        (["--scale", "big"], "scale 'big' is not understood"),
    ],
)
def test_wrong_options_are_named(photo, tmp_path, capsys, options, message):
    assert run(photo, "-o", tmp_path / "out", *options) == 2
    assert message in capsys.readouterr().err
