"""The virtual lab's instruments against closed forms, and what it says of itself."""

import numpy as np
import pandas as pd
import pytest
from PIL import Image
from skimage.color import rgb2lab

import instron
import sim
from combing.camera import project
from combing.render import Tine
from combing.study import Study
from combing.view import View
from combing.virtual_lab import photographs, specimens
from combing.virtual_lab.machine import LoadCell, draw_cell, record
from combing.virtual_lab.palette import palette
from imaging import Unmeasurable
from imaging.scale import from_marker

RADIUS, PITCH = 4.25e-4, 18 * 4.25e-4
QUIET = LoadCell(offset=0.0, drift=0.0, noise=0.0, resolution=1e-9)


def hanging_helix(turns=3, per_pitch=12):
    angle = np.linspace(0, 2 * np.pi * turns, turns * per_pitch + 1)
    return [
        np.column_stack(
            [RADIUS * np.cos(angle + lag), RADIUS * np.sin(angle + lag), -PITCH * angle / 2 / np.pi]
        )
        for lag in (0, np.pi)
    ]


def force_log(rows=5000):
    d = np.linspace(0, 0.15, rows)
    return pd.DataFrame(
        {"time": d / 0.2, "displacement": d, "force": 2 * np.sin(np.pi * d / 0.15) ** 2}
    )


def test_a_perfect_machine_keeps_work_and_peak():
    truth = force_log()
    log = record(truth, QUIET, samples=1000, rng=0)
    assert len(log) == 1000
    assert log["time"].iloc[0] == 0
    work = np.trapezoid(log["force"], log["displacement"])
    assert work == pytest.approx(0.15, rel=1e-3)
    assert log["force"].max() == pytest.approx(2, rel=1e-4)


def test_the_load_cell_adds_what_it_says():
    truth = force_log(20000).assign(force=0.0)
    cell = LoadCell(offset=0.03, drift=0.05, noise=0.004, resolution=1e-4)
    log = record(truth, cell, samples=20000, rng=4)
    slope, offset = np.polyfit(log["time"] / log["time"].iloc[-1], log["force"], 1)
    assert offset == pytest.approx(0.03, abs=3e-4)
    assert slope == pytest.approx(0.05, abs=3e-4)
    assert instron.noise_of(log["force"].to_numpy()) == pytest.approx(0.004, rel=0.03)
    np.testing.assert_allclose(log["force"] / 1e-4, np.round(log["force"] / 1e-4), atol=1e-6)


def test_an_export_is_read_back_and_says_synthetic(tmp_path):
    log = record(force_log(), draw_cell(np.random.default_rng(1)), samples=500, rng=2)
    path = instron.write_bluehill(tmp_path / "a.csv", log, {"General : Origin": "synthetic data"})
    (read,) = instron.read(path)
    np.testing.assert_allclose(read["force"], log["force"], atol=1e-5)
    np.testing.assert_allclose(read["displacement"], log["displacement"], atol=1e-8)
    assert "synthetic" in str(read.attrs["metadata"])


def test_twelve_colours_stay_apart():
    lab = rgb2lab(np.array([palette(12)]))[0]
    apart = np.linalg.norm(lab[:, None] - lab[None], axis=2)
    assert apart[np.triu_indices(12, 1)].min() > 25
    assert lab[:, 0].min() > 35


def test_spline_through_twelve_nodes_a_pitch_is_a_helix():
    for strand in hanging_helix():
        inner = photographs.smooth(strand)[40:-40]
        assert np.abs(np.hypot(inner[:, 0], inner[:, 1]) / RADIUS - 1).max() < 2e-3


def test_broadside_looks_along_the_thin_direction():
    kink = [np.array([[0, 0, 0], [0.02, 0.01, -0.05], [0.06, 0.03, -0.06]])]
    towards = photographs.broadside(kink)
    assert towards[2] == 0
    assert np.abs(towards @ [2, 1, 0]) < 1e-9


def test_everything_is_in_the_frame():
    strands = [strand + [0, 0, 0] for strand in hanging_helix(6)]
    strands[0][-1] += [0.03, 0.02, 0]
    camera = photographs.frame(strands, np.array([0, 1.0, 0]), RADIUS / 8)
    marker = photographs.marker_beside_clamp(strands, np.array([0, 1.0, 0]))
    seen = project(np.vstack([*strands, marker.corner]), camera)
    assert np.all(seen > 0)
    assert np.all(seen < camera.size)


def test_pixels_have_the_asked_size():
    strands = hanging_helix(6)
    camera = photographs.frame(strands, np.array([0, 1.0, 0]), RADIUS / 8)
    ends = project(np.array([[0, 0, 0], [0, 0, -0.01]]), camera)
    assert ends[1, 1] - ends[0, 1] == pytest.approx(0.01 / (RADIUS / 8), rel=1e-9)


@pytest.fixture(scope="module")
def photo(tmp_path_factory):
    pytest.importorskip("pyvista", reason="drawing needs the render extra")
    strands = [photographs.smooth(strand) for strand in hanging_helix(5)]
    camera = photographs.frame(strands, np.array([0, 1.0, 0]), RADIUS / 8)
    tine = Tine(np.array([0, 0, -0.01]), np.array([0, 1.0, 0]), 2 * RADIUS, 0.02)
    pixels = photographs.photograph(strands, RADIUS, photographs.NYLON, camera, tine=tine, rng=1)
    path = tmp_path_factory.mktemp("photo") / "synthetic_helix.jpg"
    photographs.save_photo(path, pixels, {"what": "test"})
    return path, camera


def test_photograph_says_synthetic_in_its_exif(photo):
    found = View().read(photo[0])
    assert "synthetic" in found.exif["ImageDescription"]


def test_marker_gives_the_scale_and_is_kept_out(photo):
    scale, found = from_marker(View().read(photo[0]), photographs.MARKER_SIDE)
    assert scale.metres_per_pixel == pytest.approx(RADIUS / 8, rel=0.004)
    marker = photographs.marker_beside_clamp(hanging_helix(), np.array([0, 1.0, 0]))
    middle = marker.corner + photographs.MARKER_SIDE / 2 * (marker.right + marker.down)
    column, row = np.round(project(middle[None], photo[1])[0]).astype(int)
    assert found.ignore[row, column]
    # Only paper is bright in all three channels.
    assert found.pixels[~found.ignore].min(axis=1).max() < 150


def test_a_photograph_without_marker_is_refused(tmp_path):
    path = tmp_path / "plain.png"
    Image.fromarray(np.full((200, 300, 3), 90, np.uint8)).save(path)
    with pytest.raises(Unmeasurable, match="no ArUco marker found"):
        from_marker(View().read(path), 0.008)


def test_specimens_differ_as_stated():
    combed = specimens.helices()
    assert len({one.parameters["seed"] for one in combed}) == len(combed) == 5
    assert all(0.1 <= one.parameters["friction"] <= 0.3 for one in combed)
    pitch = np.array([one.parameters["pi1"] for one in combed])
    assert 0.003 < np.std(pitch / 18) < 0.06
    assert all(one.name.startswith("synthetic_") for one in (*combed, *specimens.curls()))


def test_the_demos_scenes_are_scenes(tmp_path):
    for name, text in specimens.study_scenes().items():
        path = tmp_path / name
        path.write_text(text)
        assert len(sim.load_scene(path).rods) in (2, 12)


def test_the_study_has_only_known_keys():
    import tomllib

    from combing.virtual_lab.papers import STUDY

    tables = tomllib.loads(STUDY)
    known = {"force", "link", "curl", "title", "n_sec"}
    assert set(tables) == known
    assert known <= set(Study.model_fields)
