"""`combing view` as a user meets it: a page on which a run moves, in a browser, by a real drag."""

import base64
import json
import re

import cv2
import numpy as np
import pytest
from PIL import Image

import sim
from combing.viewer import run_page, shown
from combing.viewer.shots import NODE, _curvature, _packed
from sim.topology import link_density


def unpacked(packed, shape):
    steps = np.frombuffer(base64.b64decode(packed["steps"]), "<i2").astype(float)
    return np.where(
        steps == -32767, np.nan, packed["low"] + packed["step"] * (steps + 32766)
    ).reshape(shape)


@pytest.fixture(scope="module")
def combed(tmp_path_factory):
    """Simulate a combing of three turns and return its file."""
    path = tmp_path_factory.mktemp("run") / "made.nc"
    sim.simulate(sim.double_helix(pi1=18, turns=3, elements_per_pitch=8, snapshots=24), path)
    return path


@pytest.fixture(scope="module")
def hanging(tmp_path_factory):
    path = tmp_path_factory.mktemp("curl") / "made.nc"
    scene = sim.curl(n=3, elements=12, length=0.05, duration=0.02, snapshots=5)
    sim.simulate(scene, path)
    return path


def test_packing_keeps_a_number_to_half_a_step_and_none_as_none():
    rng = np.random.default_rng(8)
    values = rng.normal(size=(7, 5)) * [1e-3, 1, 10, 1e-6, 2]
    values[3, 2] = np.nan
    packed = _packed(values)
    back = unpacked(packed, values.shape)
    assert np.isnan(back[3, 2])
    np.testing.assert_allclose(back, values, atol=0.501 * packed["step"])
    assert packed["step"] == pytest.approx(np.ptp(values[np.isfinite(values)]) / 65533)
    assert unpacked(_packed(np.full(3, 2.5)), 3) == pytest.approx(2.5)


def test_the_curvature_of_a_circle_is_that_of_a_circle():
    angle = np.linspace(0, 4, 81)
    ring = 0.03 * np.column_stack([np.cos(angle), np.sin(angle), 0 * angle])
    assert _curvature(ring)[1:-1] == pytest.approx(1 / 0.03, rel=1e-3)
    assert _curvature(ring)[[0, -1]].tolist() == [0, 0]


def test_the_page_holds_what_the_run_holds(combed):
    made = sim.open_run(combed)
    data = shown(made).data
    positions = np.asarray(made.data["position"])
    np.testing.assert_allclose(unpacked(data["position"], positions.shape), positions, atol=2e-6)
    assert data["displacement"] == pytest.approx(made.displacements)
    log = made.force_log()
    assert max(data["force"]["F"]) == pytest.approx(log["force"].max(), rel=0.2)
    # Over the pair's length the density adds up to the link: lambda_0 times the mean of its share.
    links = unpacked(data["links"], (len(made.times), -1))
    for snapshot in (0, len(made.times) // 2):
        total = link_density(*made.strands(snapshot)).attrs["total_link"]
        mean = links[snapshot].mean() * data["rest"] * data["length"][snapshot]
        assert mean == pytest.approx(total, abs=0.12)


def test_a_long_run_is_thinned_to_its_end(combed):
    made = sim.open_run(combed)
    whole = shown(made)
    fewer = shown(made, limit=NODE * len(made.times) * made.data.sizes["node"] / 3)
    assert (whole.every, fewer.every) == (1, 3)
    assert fewer.data["displacement"][-1] == whole.data["displacement"][-1]
    packed = [len(one.data["position"]["steps"]) for one in (whole, fewer)]
    assert packed[1] == pytest.approx(packed[0] / 3, rel=0.05)


def test_dragging_the_scrubber_moves_the_strands(combed, chromium, capsys, run):
    page = combed.with_suffix(".html")
    assert run("view", combed) == 0
    assert str(page) in capsys.readouterr().out
    assert page.stat().st_size < 8e6
    made = sim.open_run(combed)
    chromium.open(page, 640, 480)
    first = chromium.value("document.querySelector('.space canvas').toDataURL()")
    left, width, middle = chromium.value(
        "(() => { const f = scrub.getBoundingClientRect();"
        "return [f.left, f.width, f.top + f.height / 2]; })()"
    )
    chromium.drag((left + 8, middle), (left + 0.6 * width, middle))
    snapshot = int(chromium.value("scrub.value"))
    assert 0.5 < snapshot / (len(made.times) - 1) < 0.7
    told = chromium.value("document.querySelector('.space p').textContent")
    said = float(re.match(r"d = ([\d.]+) mm", told).group(1))
    assert said == pytest.approx(1e3 * made.displacements[snapshot], abs=0.06)
    assert chromium.value("document.querySelector('.space canvas').toDataURL()") != first
    for colour in ("strand", "bend", "link"):
        chromium.value(
            f"$('colour').value = '{colour}'; $('colour').dispatchEvent(new Event('change'))"
        )
    assert chromium.complaints == []
    assert all(address.startswith("file:") for address in chromium.requests)


def test_runs_side_by_side_and_scenes_without_a_tine(combed, hanging, chromium, capsys, run):
    both = combed.with_name("both.html")
    assert run("view", combed, combed, "-o", both) == 0
    chromium.open(both, 640, 480)
    chromium.key("ArrowRight")
    assert chromium.value("spaces.length") == 2
    assert chromium.value("scrub.value") == "1"
    assert run("view", hanging) == 0
    chromium.open(hanging.with_suffix(".html"), 640, 480)
    assert chromium.value("$('panels').childElementCount") == 0
    assert chromium.value("$('where').textContent").startswith("t = 0")
    assert chromium.complaints == []
    assert run("view", combed, hanging) == 2
    assert "no common axis" in capsys.readouterr().err


def test_a_page_of_a_scene_without_a_pair_is_whole(hanging):
    page = run_page([shown(sim.open_run(hanging))])
    packed = re.search(r'id="data">(.*?)</script>', page, re.DOTALL).group(1)
    assert json.loads(packed)["runs"][0]["strands"] == [13, 13, 13]


def test_a_film_has_a_frame_a_snapshot_and_a_mark_where_the_tine_is(combed, tmp_path, capsys, run):
    for needed in ("pyvista", "imageio_ffmpeg"):
        pytest.importorskip(needed, reason="needs combing[render]")
    made = sim.open_run(combed)
    short = sim.Run(made.data.isel(snapshot=[2, 10, 20]))
    short.save(tmp_path / "made.nc")
    assert run("view", tmp_path / "made.nc", "--film", tmp_path / "made.mp4", "--quiet") == 0
    shots = list(read_film(tmp_path / "made.mp4"))
    assert [shot.shape for shot in shots] == [(960, 720, 3)] * 3
    marks = [red_column(shot[740:880]) for shot in shots]
    travels = short.displacements
    # The mark goes along the axis as the tine does.
    expected = (travels[1] - travels[0]) / (travels[2] - travels[0])
    assert (marks[1] - marks[0]) / (marks[2] - marks[0]) == pytest.approx(expected, abs=0.01)
    assert run("view", tmp_path / "made.nc", "--film", tmp_path / "made.gif", "--quiet") == 0
    with Image.open(tmp_path / "made.gif") as gif:
        assert gif.n_frames == 3
    capsys.readouterr()
    assert run("view", combed, combed, "--film", tmp_path / "two.mp4") == 2
    assert run("view", combed, "--film", tmp_path / "made.avi") == 2
    assert ".mp4 or .gif" in capsys.readouterr().err


def read_film(path):
    film = cv2.VideoCapture(str(path))
    while (found := film.read())[0]:
        yield found[1].astype(int)
    film.release()


def red_column(strip):
    """Return the middle of the columns that are red from top to bottom."""
    red = (strip[..., 2] - strip[..., 1] > 80).mean(axis=0)
    return float(np.flatnonzero(red > 0.8).mean())
