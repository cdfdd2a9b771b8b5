"""Sweeps: which points a file stands for, and that none is lost or computed twice."""

import json
import math
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import instron
import sim
from combing.ensemble import members
from combing.errors import UserError
from combing.study import load_sweep
from combing.sweep import Store, part_of_points, run_sweep, simulate_points
from combing.workers import Died

ROOT = Path(__file__).parents[2]
SHORT = "turns = 3\nelements_per_pitch = 6\nspeed = 0.5\nsnapshots = 2\n"


@pytest.fixture
def sweep(tmp_path):
    def write(text):
        (tmp_path / "sweep.toml").write_text(text)
        return load_sweep(tmp_path / "sweep.toml")

    return write


def test_a_grid_is_every_combination_and_a_list_side_by_side(sweep):
    found = sweep(
        'preset = "double_helix"\n[fixed]\nheight = 0.03\n[grid]\npi1 = [14, 18]\npi3 = [2, 4]\n'
        "[list]\nfriction = [0.0, 0.2]\n"
    ).points()
    assert len(found) == 8
    assert found[0] == {"height": 0.03, "pi1": 14, "pi3": 2, "friction": 0.0}
    assert {(one["pi1"], one["pi3"], one["friction"]) for one in found} == {
        (a, b, c) for a in (14, 18) for b in (2, 4) for c in (0.0, 0.2)
    }
    paired = sweep('preset = "double_helix"\n[list]\npi1 = [14, 18]\nturns = [10, 8]\n').points()
    assert paired == [{"pi1": 14, "turns": 10}, {"pi1": 18, "turns": 8}]


@pytest.mark.parametrize("seed", [0, 3])
def test_every_nth_of_a_range_is_met_once_by_a_latin_hypercube(sweep, seed):
    text = 'preset = "double_helix"\n[latin]\npoints = 17\nseed = {}\npi1 = [14, 48]\n'
    text += "r = [1e-4, 5e-4]\n"
    points = sweep(text.format(seed)).points()
    for name, low, high in (("pi1", 14, 48), ("r", 1e-4, 5e-4)):
        share = (np.array([one[name] for one in points]) - low) / (high - low)
        assert sorted(np.floor(17 * share)) == list(range(17))
    assert points == sweep(text.format(seed)).points()
    assert points != sweep(text.format(seed + 1)).points()


def test_whole_numbers_stay_whole_in_a_latin_hypercube(sweep):
    points = sweep('preset = "curl"\n[latin]\npoints = 5\nn = [2, 12]\n').points()
    assert all(isinstance(one["n"], int) and 2 <= one["n"] <= 12 for one in points)


def test_seeds_make_an_ensemble_of_every_point(sweep):
    text = 'preset = "double_helix"\n{}[grid]\npi1 = [14, 18]\n'
    assert [one.seed for one in sweep(text.format("")).members()] == [None, None]
    found = sweep(text.format("seeds = 3\n")).members()
    assert [(one.parameters["pi1"], one.seed) for one in found] == [
        (pi1, seed) for pi1 in (14, 18) for seed in (1, 2, 3)
    ]
    assert [one.seed for one in sweep(text.format("seeds = [7, 9]\n")).members()[:2]] == [7, 9]


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ('preset = "helix"\n', "preset: input should be 'double_helix' or 'curl', not 'helix'"),
        ('preset = "curl"\n[grid]\npi1 = [1]\n', "curl has no parameter 'pi1'; known are n, len"),
        ('preset = "double_helix"\n[grid]\npi_1 = [1]\n', "'pi_1'; did you mean 'pi1'?"),
        ('preset = "double_helix"\n[grid]\npi1 = 18\n', "input should be a valid list"),
        ('preset = "double_helix"\n[grid]\npi1 = []\n', "at least 1 item"),
        ('preset = "double_helix"\n[grid]\nseed = [1]\n', "seed: give seeds = 5"),
        ('preset = "double_helix"\n[grid]\npi1=[1]\n[fixed]\npi1=2\n', "pi1 is in [fixed] and in"),
        ('preset = "double_helix"\n[list]\npi1=[9]\npi2=[1, 2]\n', "pi1 has 1 values, pi2 has 2"),
        ('preset = "double_helix"\n[grid]\npi1=[18]\npi2=[1, 0.5]\n', "(at pi1 = 18, pi2 = 0.5)"),
        ('preset = "double_helix"\n[latin]\npi1=[9, 18]\n', "the key 'points' is missing"),
        ('preset = "double_helix"\n[latin]\npoints=3\npi1=[18, 9]\n', "expected [lowest, highest]"),
        ('preset = "double_helix"\nseeds = 0\n', "seeds: input should be greater than 0"),
        ('preset = "double_helix"\nseeds = [1, 1]\n', "a seed is there twice"),
        ('preset = "double_helix"\ngrids = 0\n', "unknown key 'grids'; did you mean 'grid'?"),
        ("preset = ", "not TOML"),
    ],
)  # fmt: skip
def test_a_wrong_sweep_gets_one_clear_line(sweep, text, said):
    with pytest.raises(UserError) as caught:
        sweep(text)
    assert said in str(caught.value)
    assert "\n" not in str(caught.value)


def test_imperfections_have_the_stated_size_and_nothing_else_changes():
    asked = {"pi1": 20.0, "turns": 5, "imperfection": 0.03}
    drawn = members("double_helix", asked, range(1, 401))
    pitch = np.array([one.scene.rods[0].shape.pitch for one in drawn]) / (20 * 4.25e-4) - 1
    phase = np.array([np.subtract(*[r.shape.phase for r in one.scene.rods[::-1]]) for one in drawn])
    for off in (pitch / 0.03, (phase / math.pi - 1) / 0.03):
        # 400 normal draws: mean within 0.05 and sd within 0.036 at one standard error.
        assert abs(off.mean()) < 0.2
        assert off.std() == pytest.approx(1, abs=0.14)
    (nominal,) = members("double_helix", asked, None)
    for rod in drawn[0].scene.rods:
        curvature = nominal.scene.rods[0].curvature.sd
        assert rod.curvature.sd == pytest.approx(curvature, rel=0.2)
        assert rod.material == nominal.scene.rods[0].material
    assert len({one.scene.seed for one in drawn}) == 400
    assert members("double_helix", asked, [5])[0].scene == drawn[4].scene


def test_size_is_two_per_cent_where_none_is_given_and_none_where_it_is_zero():
    (two,) = members("double_helix", {"pi1": 18}, [1])
    (stated,) = members("double_helix", {"pi1": 18, "imperfection": 0.02}, [1])
    (none,) = members("double_helix", {"pi1": 18, "imperfection": 0.0}, [1])
    assert two.scene == stated.scene
    assert none.scene == sim.double_helix(18, seed=1)


def test_parts_are_all_points_and_none_twice():
    points = list(range(23))
    parts = [part_of_points(points, (i, 4)) for i in range(1, 5)]
    assert sorted(sum(parts, [])) == points
    assert max(map(len, parts)) - min(map(len, parts)) <= 1


class Pretend:
    """An engine that needs no time: every scene ends as `outcome` says."""

    fraction = 1.0

    def __init__(self, outcome):
        self.outcome, self.asked = outcome, []

    def __call__(self, scenes):
        self.scenes = scenes
        self.asked += [path.name for path in scenes]
        return self

    def wait(self, look, ended):
        for path in self.scenes:
            ended(path, self.outcome)

    def stop(self):
        raise AssertionError("stopped")

    def dismiss(self):
        pass


def unstable():
    return sim.Unstable("the motion left\nits range", 0.1, 0, 3, "contact", "bending")


def test_a_point_that_fails_is_recorded_and_not_tried_again_but_for_asking(sweep, tmp_path):
    chosen = sweep('preset = "double_helix"\n[grid]\npi1 = [14, 18]\n')
    engine = Pretend(unstable())
    table = run_sweep(chosen, tmp_path / "out", quiet=True, start=engine)
    assert table["state"].tolist() == ["failed", "failed"]
    assert table["reason"].tolist() == ["the motion left its range"] * 2
    run_sweep(chosen, tmp_path / "out", quiet=True, start=engine)
    assert len(engine.asked) == 2
    run_sweep(chosen, tmp_path / "out", quiet=True, start=engine, retry=True)
    assert len(engine.asked) == 4
    written = pd.read_csv(tmp_path / "out/points.csv", comment="#")
    assert written["state"].tolist() == ["failed", "failed"]


@pytest.mark.parametrize("error", [OSError(28, "No space left"), Died("killed"), TypeError("ours")])
def test_what_may_pass_is_tried_again(sweep, tmp_path, error):
    chosen = sweep('preset = "double_helix"\n')
    engine = Pretend(error)
    for _ in range(2):
        table = run_sweep(chosen, tmp_path / "out", quiet=True, start=engine)
        assert table["state"].tolist() == ["failed"]
    assert len(engine.asked) == 2


def test_a_point_that_another_process_is_simulating_has_not_failed(sweep, tmp_path):
    chosen = sweep('preset = "double_helix"\n')
    busy = sim.SceneError("x.part: another process is writing this run; wait for it")
    table = run_sweep(chosen, tmp_path / "out", quiet=True, start=Pretend(busy))
    assert table["state"].tolist() == ["missing"]


@pytest.fixture(scope="module")
def done(tmp_path_factory):
    folder = tmp_path_factory.mktemp("sweep")
    (folder / "sweep.toml").write_text(
        f'preset = "double_helix"\n[fixed]\n{SHORT}[grid]\npi1 = [18, 24]\n'
    )
    chosen = load_sweep(folder / "sweep.toml")
    run_sweep(chosen, folder / "out", jobs=1, quiet=True, part=(1, 2))
    return chosen, folder / "out"


def test_parts_fill_one_folder_and_nothing_is_computed_twice(done):
    chosen, out = done
    assert pd.read_csv(out / "points_1of2.csv", comment="#")["state"].tolist() == ["done"]
    assert not (out / "points.csv").exists()
    (first,) = out.glob("runs/*.nc")
    before = first.stat().st_mtime_ns
    table = run_sweep(chosen, out, jobs=1, quiet=True, part=(2, 2))
    assert table["state"].tolist() == ["done"]
    assert first.stat().st_mtime_ns == before
    never = Pretend(None)
    run_sweep(chosen, out, quiet=True, start=never)
    assert never.asked == []
    table = pd.read_csv(out / "points.csv", comment="#")
    assert table["pi1"].tolist() == [18, 24]
    assert table["state"].tolist() == ["done", "done"]


def test_what_a_point_gave_stands_beside_it(done):
    chosen, out = done
    run_sweep(chosen, out, jobs=1, quiet=True)
    store = Store(out)
    for member in chosen.members():
        kept = json.loads(store.path(member).with_suffix(".json").read_text(encoding="utf-8"))
        assert kept["parameters"] == dict(member.parameters)
        log = sim.open_run(store.path(member)).force_log()
        curve = instron.scale(log, instron.Rig(r=4.25e-4, E=0.078 * 2.8e9, zero="none"))
        assert kept["results"]["f_max"] == pytest.approx(curve.attrs["f_max"])
        assert kept["results"]["D"] == pytest.approx(curve.attrs["D"])
    names = {path.name.split(".")[0] for path in (out / "runs").iterdir()}
    assert names == {store.path(member).stem for member in chosen.members()}


def test_a_sweep_that_is_killed_goes_on(tmp_path):
    (tmp_path / "sweep.toml").write_text(
        f'preset = "double_helix"\n[fixed]\n{SHORT}[grid]\npi1 = [18, 20, 24]\n'
    )
    program = [sys.executable, "-c", "from combing.cli import main; main()"]
    command = [*program, "sweep", "sweep.toml", "-o", "out", "--jobs", "1", "--quiet"]
    settings = {"cwd": tmp_path, "env": os.environ | {"PYTHONPATH": str(ROOT)}}
    first = subprocess.Popen(command, **settings)
    while not list(tmp_path.glob("out/runs/*.nc")) and first.poll() is None:
        time.sleep(0.1)
    first.send_signal(signal.SIGKILL)
    first.wait()
    kept = {path: path.stat().st_mtime_ns for path in tmp_path.glob("out/runs/*.nc")}
    again = subprocess.run(command, **settings, check=False)
    assert again.returncode == 0
    assert {path: path.stat().st_mtime_ns for path in kept} == kept
    table = pd.read_csv(tmp_path / "out/points.csv", comment="#")
    assert table["state"].tolist() == ["done"] * 3
    assert not list(tmp_path.glob("out/runs/*.part*"))


def test_a_folder_that_cannot_be_written_to_is_said_before_any_work(sweep, tmp_path):
    (tmp_path / "file").touch()
    with pytest.raises(UserError, match="cannot be written to"):
        simulate_points(sweep('preset = "curl"\n').members(), Store(tmp_path / "file"))


@pytest.mark.parametrize("text", ["0/3", "4/3", "a", "1", "1/0"])
def test_a_wrong_part_is_said(tmp_path, text, capsys):
    from combing.cli import main

    (tmp_path / "s.toml").write_text('preset = "curl"\n')
    with pytest.raises(SystemExit) as ended:
        main(["sweep", str(tmp_path / "s.toml"), "--part", text])
    assert ended.value.code == 2
    assert "expected i/n with i from 1 to n" in capsys.readouterr().err
