"""Error bars of simulations: against closed forms and draws, and kept with their run."""

import json
import shutil

import numpy as np
import pandas as pd
import pytest
from matplotlib.container import ErrorbarContainer

import instron
import sim
from combing.accuracy.cantilever import Cantilever
from combing.bands import Bands, read_bands, simulate_with_bands
from combing.bands.bands import make_bands
from combing.bands.intervals import SAFETY, around, mesh_error, prediction
from combing.bands.quantities import Quantities
from combing.bands.scenes import RATIO, coarser, scenes_of_bands
from combing.bands.store import with_bands
from combing.cli import main
from combing.compare.bench import compare
from combing.compare.curl import compare_curl
from combing.ensemble import perturbed
from combing.errors import UserError
from combing.figures.force import draw_force
from combing.figures.interactions import draw_interactions
from combing.figures.run import draw_run
from combing.runs import simulating
from combing.study.load import load_study
from combing.study.sets import CurlSet

BRIEF = {"pi1": 18, "turns": 3, "q": 2, "speed": 0.5, "snapshots": 4, "elements_per_pitch": 6}


def brief(**others):
    """Return a scene that combs one pitch: a second of processor time with its bands."""
    return sim.double_helix(**{**BRIEF, **others})


@pytest.fixture(scope="module")
def banded(tmp_path_factory):
    """Simulate with three members; return the run and its folder."""
    folder = tmp_path_factory.mktemp("bands")
    return simulate_with_bands(brief(), folder / "run.nc", members=3), folder


@pytest.mark.parametrize("n", [2, 5])
@pytest.mark.parametrize("level", [0.5, 0.95])
def test_a_prediction_holds_as_many_further_members_as_it_says(n, level):
    """Of normal draws; half the width would hold 65 % of 95, three times the width 100."""
    drawn = np.random.default_rng(1).normal(3.0, 2.0, (n + 1, 20000))
    mean, half = prediction(drawn[:n], level=level)
    held = np.mean(np.abs(drawn[n] - mean) <= half)
    assert held == pytest.approx(level, abs=4 * np.sqrt(level * (1 - level) / 20000))


@pytest.mark.parametrize("elements", [8, 16])
def test_the_error_of_a_mesh_is_that_from_a_closed_form(elements):
    fine = Cantilever(elements=elements).measure()
    rough = Cantilever(elements=round(elements / 2)).measure()
    assert fine.quantity is not None
    found = mesh_error(fine.quantity, rough.quantity, 2.0)
    assert found == pytest.approx(SAFETY * abs(fine.quantity - fine.closed_form), rel=0.1)


def test_an_error_of_the_mesh_does_not_vanish_where_two_curves_cross():
    assert around(np.array([3.0, 0.0, 0.0, 0.0, 1.0]), 1).tolist() == [3, 3, 0, 1, 1]


def test_a_coarser_scene_has_longer_elements_and_is_else_the_same():
    scene = brief(elements_per_pitch=12)
    rough = coarser(scene)
    assert [rod.elements for rod in rough.rods] == [round(36 / RATIO)] * 2
    same = [rod.model_copy(update={"elements": 36}) for rod in rough.rods]
    assert rough.model_copy(update={"rods": same}) == scene


def test_a_mesh_that_cannot_be_coarser_is_told():
    assert coarser(brief(elements_per_pitch=3)) is None
    assert -1 not in scenes_of_bands(brief(elements_per_pitch=3), 2, 0.02)


def test_members_are_bent_by_the_stated_share_and_each_anew():
    scene = brief(turns=200)
    found = [perturbed(scene, seed, 0.02).rods[0].curvature for seed in (1, 2)]
    radius, rise = 4.25e-4, 18 * 4.25e-4 / (2 * np.pi)
    assert found[0].sd == pytest.approx(0.02 * radius / (radius**2 + rise**2))
    curl = sim.curl(2)
    again = perturbed(curl, 5)
    assert (again.rods, again.seed) == (curl.rods, 5)
    straight = curl.rods[0].model_copy(update={"curvature": None})
    bent = perturbed(curl.model_copy(update={"rods": [straight]}), 1, 0.1).rods[0]
    assert bent.curvature.sd == pytest.approx(0.1 * np.pi / 0.2)


def test_bands_are_read_back_as_they_were_made(banded):
    run, folder = banded
    bands = read_bands(run)
    scenes = scenes_of_bands(run.scene, 3, 0.02)
    with simulating(scenes, folder / "runs", quiet=True) as wait:
        made = make_bands(wait(), 0.02)
    for name in ("force", "link", "numbers"):
        pd.testing.assert_frame_equal(getattr(bands, name), getattr(made, name))
    assert bands.about == {**made.about, "notes": []}
    assert bands.numbers["quantity"].tolist() == ["f_max", "D", "w", "first_jam"]


def test_a_band_is_of_the_mesh_up_to_the_release_and_of_the_members_beyond(banded):
    force = read_bands(banded[0]).force
    before = force["d"] <= read_bands(banded[0]).about["mesh_to"]
    assert 0 < before.sum() < len(force)
    assert (force["kind"] == np.where(before, "mesh", "spread")).all()
    np.testing.assert_allclose(
        force["high"][before] - force["value"][before], force["mesh"][before], atol=1e-12
    )
    half = prediction(np.array([[1.0], [2.0], [4.0]]))[1] / np.std([1.0, 2.0, 4.0], ddof=1)
    beyond = force[~before]
    np.testing.assert_allclose(beyond["high"] - beyond["mean"], half * beyond["sd"], atol=1e-9)
    assert (force["x"] * read_bands(banded[0]).numbers["value"][1]).to_numpy() == pytest.approx(
        force["d"].to_numpy()
    )


def test_called_again_nothing_is_simulated_again(banded, monkeypatch):
    run, folder = banded
    before = {path: path.stat().st_mtime_ns for path in (folder / "runs").iterdir()}
    assert len(before) == 5
    again = simulate_with_bands(run.scene, folder / "run.nc", members=3)
    assert before == {path: path.stat().st_mtime_ns for path in (folder / "runs").iterdir()}
    assert again.data.identical(run.data)


def test_a_run_of_another_scene_is_not_written_over(banded):
    run, folder = banded
    with pytest.raises(UserError, match="a finished run of another scene"):
        simulate_with_bands(brief(pi1=30), folder / "run.nc", members=3)
    assert sim.open_run(folder / "run.nc").scene == run.scene
    with pytest.raises(UserError, match="members = 1: a spread needs at least 2"):
        simulate_with_bands(run.scene, folder / "run.nc", members=1)


def test_a_member_that_fails_is_left_out_and_said_to_be(tmp_path, monkeypatch, caplog, banded):
    runs = {key: banded[0] for key in (0, 1, 2, 3)}
    outcomes = runs | {2: sim.SceneError("it flew away"), -1: sim.SceneError("too coarse")}

    class Trying:
        def __init__(self, *given, **options):
            pass

        def __enter__(self):
            return lambda: outcomes

        def __exit__(self, *error):
            pass

    monkeypatch.setattr("combing.bands.simulate.trying", Trying)
    bands = read_bands(simulate_with_bands(brief(), tmp_path / "run.nc", members=3))
    assert bands.about["members"] == 2
    assert bands.about["notes"] == [
        "member 2 is left out of the bands: it flew away",
        "the coarser mesh is left out of the bands: too coarse",
    ]
    assert bands.about["notes"][0] in caplog.text
    outcomes[0] = sim.SceneError("so did this")
    with pytest.raises(sim.SceneError):
        simulate_with_bands(brief(), tmp_path / "other.nc", members=3)
    assert [path.name for path in tmp_path.iterdir()] == ["run.nc"]


def test_a_number_and_its_band_are_said_in_words():
    row = {"value": 4.0, "low": 1.0, "high": 7.0, "kind": "spread", "mesh": np.nan}
    numbers = pd.DataFrame([{"quantity": "rho_2", **row}])
    said = Bands(pd.DataFrame(), pd.DataFrame(), numbers, {"level": 0.95}).said()
    assert said == {"rho_2": "4; one more specimen: 1 to 7 (95 %)"}


def test_a_simulated_curl_is_counted_and_kept(tmp_path):
    scene = sim.curl(3, length=0.04, elements=20, duration=0.01, curvature=60.0, spread=5e-4)
    run = simulate_with_bands(scene, tmp_path / "run.nc", members=2)
    bands = read_bands(run)
    assert bands.force.empty
    assert bands.link.empty
    assert bands.numbers["quantity"].str.match(r"rho_\d").all()
    assert bands.numbers["value"].to_numpy() == pytest.approx(
        list(Quantities(run).scalars().values())
    )
    assert with_bands(run, bands).data.identical(run.data)
    path = tmp_path / "run.nc"
    chosen = CurlSet.model_construct(name="c", strands=None, simulations=[path], truth=None)
    for n_sec in (20, 10):  # the bands are of 20 sections
        plotted = compare_curl(chosen, [], {path: run}, n_sec).plotted
        (panel,) = draw_interactions(plotted, n_sec=n_sec, synthetic=False).axes
        (whiskers,) = [one for one in panel.containers if isinstance(one, ErrorbarContainer)]
        ends = np.array(whiskers.lines[2][0].get_segments())[:, :, 1]
        said = bands.numbers.set_index("quantity").loc[[f"rho_{n}" for n in plotted["N"]]]
        same = np.isclose(ends, said[["low", "high"]].clip(lower=[0, -np.inf], axis=1))
        assert same.all() == (n_sec == 20)


def test_the_command_writes_bands_and_draws_them(tmp_path, capsys):
    given = [text for key, value in BRIEF.items() for text in ("--set", f"{key}={value}")]
    command = ["simulate", "--preset", "double_helix", *given, "--error-bars", "--members", "2"]
    with pytest.raises(SystemExit) as stopped:
        main([*command, "-o", str(tmp_path), "--json"])
    out, err = capsys.readouterr()
    assert stopped.value.code == 0, err
    assert "one more specimen" in json.loads(out)["f_max"]
    names = {path.name for path in tmp_path.iterdir()}
    assert {"band_force.csv", "band_link.csv", "numbers.csv", "run.nc", "runs"} <= names
    run = sim.open_run(tmp_path / "run.nc")
    bands = read_bands(run)
    figure = draw_run(run, run.force_log(), bands.link.assign(link=0.0), bands)
    (drawn,) = [panel for panel in figure.axes if "force" in panel.get_ylabel()]
    averaged = drawn.lines[1].get_ydata()
    np.testing.assert_allclose(averaged, bands.about["newton"] * bands.force["value"])
    labels = [text.get_text() for text in drawn.get_legend().get_texts()]
    assert labels == ["mesh, 95 %", "one more specimen (2 members), 95 %"]


@pytest.mark.slow
def test_bands_hold_fine_references_and_members_that_they_have_not_seen(tmp_path):
    """Bands at half: three times as wide would hold 90 %, half as wide 27 %, of further members."""
    scene = brief(elements_per_pitch=9)
    scenes = {(group, key): perturbed(scene, 10 * group + key) for group in range(5)
              for key in range(6)}  # fmt: skip
    fine = scene.model_copy(
        update={"rods": [rod.model_copy(update={"elements": 72}) for rod in scene.rods]}
    )
    with simulating(scenes | {"fine": fine}, tmp_path, quiet=True) as wait:
        found = {key: Quantities(run) for key, run in wait().items()}
    held = []
    for group in range(5):
        numbers = [[*found[group, key].scalars().values()] for key in range(6)]
        mean, half = prediction(np.array(numbers[:5]), level=0.5)
        held += (np.abs(np.array(numbers[5]) - mean) <= half).tolist()
    assert 0.28 < np.mean(held) < 0.8
    run = simulate_with_bands(scene, tmp_path / "run.nc", members=2)
    force = read_bands(run).force
    before = force[force["kind"] == "mesh"]
    error = np.abs(found["fine"].force(before["d"].to_numpy()) - before["value"])
    assert (error <= before["mesh"]).mean() > 0.9
    assert error.max() > before["mesh"].max() / 6


def test_a_study_with_error_bars_draws_them(tmp_path, monkeypatch, banded):
    """The runs of the fixture are those that the study asks for: nothing is simulated anew."""
    run, folder = banded
    monkeypatch.setattr("combing.bands.simulate.MEMBERS", 3)
    shutil.copytree(folder / "runs", tmp_path / "out" / "runs")
    lines = [f"{key} = {json.dumps(value)}" for key, value in BRIEF.items()]
    (tmp_path / "scene.toml").write_text("\n".join(['preset = "double_helix"', *lines]))
    log = run.force_log()
    instron.write_bluehill(tmp_path / "log.csv", log, {"Origin": "synthetic"}, decimals=9)
    helix = run.scene.rods[0]
    (tmp_path / "rig.toml").write_text(f"r = {helix.radius}\nE = {helix.material.E}\n")
    (tmp_path / "study.toml").write_text(
        'title = "bars"\nerror_bars = true\n[[force]]\nname = "a"\nlogs = "log.csv"\n'
        'rig = "rig.toml"\nsimulation = "scene.toml"\n'
    )
    found = compare(load_study(tmp_path / "study.toml"), tmp_path / "out", quiet=True)
    plotted = found.comparisons["force"].plotted
    drawn = plotted[(plotted["source"] == "simulation") & (plotted["curve"] == "run")]
    bands = read_bands(run).force
    for end in ("low", "high"):
        np.testing.assert_allclose(drawn[end], np.interp(drawn["x"], bands["x"], bands[end]))
    labels = draw_force(plotted, synthetic=True).legends[0].get_texts()
    assert "simulation, 95 % band" in [text.get_text() for text in labels]
    assert len(list((tmp_path / "out" / "runs").iterdir())) == 5
