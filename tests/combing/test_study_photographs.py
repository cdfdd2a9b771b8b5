"""How a study looks at photographs: the words of the commands, and tine places from the log."""

import json

import cv2
import numpy as np
import pandas as pd
import pytest
from drawn.helix import draw_helix
from PIL import Image

import instron
from combing.cli import main
from combing.compare.link import measure_link
from combing.errors import UserError
from combing.study import combed, load_study, tine_positions
from combing.view import metres

R = 6.0
PITCH = 18 * R
D = 0.08
PHOTOS = (
    'title = "t"\n[[link]]\nname = "b"\nphotos = "?.jpg"\npixel_size = 5e-5\nrig = "rig.toml"\n'
)
LOG = PHOTOS + 'log = "log.csv"\n'


def taken(path, seconds):
    """Write a photograph taken some seconds after noon."""
    exif = Image.Exif()
    exif.get_ifd(0x8769).update(
        {0x9003: f"2026:05:01 12:00:{int(seconds):02d}", 0x9291: f"{seconds % 1:.2f}"[2:]}
    )
    Image.fromarray(np.zeros((40, 40, 3), np.uint8)).save(path, exif=exif)


@pytest.fixture
def study(tmp_path):
    """Make a lab whose machine went 2 mm/s from 5 mm on, from 4 s on; combing ends at D = 80 mm."""
    time = np.linspace(0, 50, 1001)
    d = np.maximum(time - 4, 0) * 2e-3
    noise = np.random.default_rng(3).normal(0, 1e-4, len(d))
    force = np.where(d < D, 0.2 * np.sin(np.pi * np.clip(d / D, 0, 1)) ** 0.5, 0) + noise
    log = pd.DataFrame({"time": time, "displacement": 5e-3 + d, "force": force})
    instron.write_bluehill(tmp_path / "log.csv", log)
    (tmp_path / "rig.toml").write_text("r = 4.25e-4\nE = 1e9\npoisson = 0.4\n")
    taken(tmp_path / "1.jpg", 19.0)
    taken(tmp_path / "2.jpg", 29.5)
    (tmp_path / "mask.png").touch()

    def study(text):
        (tmp_path / "study.toml").write_text(text)
        return load_study(tmp_path / "study.toml").link[0]

    study.folder = tmp_path
    return study


def test_photographs_are_placed_by_the_cameras_clock(study):
    """The log began at 11:59:55 of the camera: the pictures are of 24 s and 34.5 s."""
    link = study(LOG + "log_began = 2026-05-01T11:59:55\n")
    assert tine_positions(link) == pytest.approx([0.040, 0.061], abs=1e-4)
    assert combed(link) == pytest.approx(D, rel=0.02)


@pytest.mark.parametrize(
    ("table", "expected"),
    [
        ("photo,time\n1.jpg,14\n2.jpg,24\n", [0.020, 0.040]),
        ("photo,displacement\n1.jpg,0.015\n2.jpg,0.045\n", [0.010, 0.040]),
        ("photo,d\n1.jpg,0.015\n2.jpg,0.045\n", [0.015, 0.045]),
    ],
)
def test_photographs_are_placed_by_what_the_machine_showed(study, table, expected):
    (study.folder / "where.csv").write_text(table)
    link = study(LOG + 'positions = "where.csv"\n')
    assert tine_positions(link) == pytest.approx(expected, abs=1e-4)


def test_x_is_d_over_D(study):
    assert tine_positions(study(PHOTOS + "x = [0.1, 0.5]\ncombed = 0.08\n")) == [0.008, 0.04]
    found = tine_positions(study(LOG + "x = [0.1, 0.5]\n"))
    assert found == pytest.approx([0.008, 0.04], rel=0.02)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (PHOTOS, "the key 'positions' is missing"),
        (PHOTOS + "x = [0, 1]", "d = x D needs D: give combed"),
        (PHOTOS + "x = [0, 1]\npositions = [0, 1]", "positions and x both say where the tine was"),
        (PHOTOS + "log_began = 2026-05-01T12:00:00", "log_began: needs the log"),
        (LOG.replace('rig = "rig.toml"', "") + "x = [0, 1]", "rig: the log needs one"),
        (LOG + "log_began = 2026-05-01T13:00:00", "1.jpg is of time = -3581, the stroke in"),
        (LOG + "x = [0, 1]\ntine = [[1, 2]]", "tine: 1 places for 2 photographs"),
        (LOG + "x = [0, 1]\nscale = '41px/mm'", "give the scale: marker_side, pixel_size or scale"),
        (LOG.replace("pixel_size = 5e-5", "scale = 'big'"), "scale 'big' is not understood"),
        (LOG.replace("pixel_size = 5e-5", "scale = 'marker:2mm@b.jpg'"), "there is no file"),
        (LOG + "x = [0, 1]\nroi = [1, 2, 3]", "region of interest '1,2,3': give x0,y0,x1,y1"),
        (LOG + "x = [0, 1]\nignore = 'none.png'", "there is no file"),
    ],
)  # fmt: skip
def test_what_is_wrong_gets_one_clear_line(study, text, message):
    with pytest.raises(UserError) as caught:
        tine_positions(study(text))
    assert message in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_photograph_without_a_time_stamp_is_named(study):
    Image.fromarray(np.zeros((40, 40, 3), np.uint8)).save(study.folder / "2.jpg")
    with pytest.raises(UserError, match=r"2\.jpg: its EXIF does not say when it was taken"):
        tine_positions(study(LOG + "log_began = 2026-05-01T11:59:55\n"))


@pytest.mark.parametrize(("text", "expected"), [("10mm", 0.01), ("0.02", 0.02), ("1e-3 m", 1e-3)])
def test_lengths_with_and_without_a_unit(text, expected):
    assert metres(text) == pytest.approx(expected)


def test_a_study_measures_what_the_command_measures(tmp_path):
    """Region, ruler, side of the clamp and tine: the same numbers from both doors."""
    drawn = draw_helix(R, lambda s: 1 / PITCH, 5 * PITCH, rng=1)
    picture = cv2.rotate(drawn.pixels[..., ::-1], cv2.ROTATE_180)
    height, width = picture.shape[:2]
    cv2.imwrite(str(tmp_path / "1.png"), picture)
    box, ruler = f"0,0,{width},{height - 4}", "ruler:10,10,10,110=5mm+-1%"
    tine = [width // 2, height // 2, 8]
    asked = ["--roi", box, "--scale", ruler, "--root", "bottom"]
    asked += ["--tine", ",".join(map(str, tine))]
    with pytest.raises(SystemExit) as ended:
        main(["helix", str(tmp_path / "1.png"), *asked, "-o", str(tmp_path / "out"), "--quiet"])
    assert not ended.value.code
    (tmp_path / "study.toml").write_text(
        f'title = "t"\n[[link]]\nname = "a"\nphotos = "1.png"\npositions = [0.01]\n'
        f"roi = {json.dumps(box.split(','))}\nscale = '{ruler}'\nroot = 'bottom'\ntine = {tine}\n"
    )
    link = load_study(tmp_path / "study.toml").link[0]
    found = measure_link(link.photos[0], link)
    command = pd.read_csv(tmp_path / "out" / "link.csv")
    np.testing.assert_allclose(found["link"], command["link"], rtol=1e-5)
    np.testing.assert_allclose(found["sd"], command["sd"], rtol=1e-5)
    np.testing.assert_allclose(found["s"], command["s"], rtol=1e-5)
