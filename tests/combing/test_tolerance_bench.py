"""Tolerances in sweeps and studies: which setting is taken, what verifies it, what is said."""

import json
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest

import instron
import sim
from combing.cli import main
from combing.compare import accurate, compare
from combing.errors import UserError
from combing.runs import model_version
from combing.study import load_study, load_sweep
from combing.study import plan as plan_module
from combing.sweep import Store, run_sweep
from combing.tolerance import front

BRIEF = {"pi1": 18, "turns": 3, "q": 2, "speed": 0.5, "snapshots": 9, "elements_per_pitch": 6}
TOML = "\n".join(f"{key} = {json.dumps(value)}" for key, value in BRIEF.items())


def brief(**others):
    return sim.double_helix(**{**BRIEF, **others})


@pytest.fixture(autouse=True)
def known_front(monkeypatch):
    """Put a made-up front of this solver in place of the measured one."""
    rows = [(6, 0.95, 0.8, 0.3, 0.08, 1.0), (12, 0.95, 0.4, 0.3, 0.02, 3.0)]
    table = pd.DataFrame(rows, columns=[*front.KNOBS, "error", "seconds"])
    table["work"] = 1e6 * table["seconds"]
    table.attrs["solver"] = model_version()
    monkeypatch.setattr(front, "load_front", lambda: table)
    plan_module._cheapest.cache_clear()
    yield
    plan_module._cheapest.cache_clear()


def sweep_of(tmp_path, head):
    (tmp_path / "sweep.toml").write_text(f'preset = "double_helix"\n{head}\n[fixed]\n{TOML}\n')
    return load_sweep(tmp_path / "sweep.toml")


def test_points_of_a_sweep_take_the_cheapest_setting_that_holds(tmp_path):
    rough = sweep_of(tmp_path, 'tolerance = "draft"\nseeds = 2').members()
    fine = sweep_of(tmp_path, "tolerance = 0.03\nseeds = 2").members()
    assert [one.scene.rods[0].elements for one in rough] == [18, 18]
    assert {one.scene.rods[0].elements for one in fine} == {36}
    assert fine[0].scene.tines[0].speed == 0.4
    assert fine[0].scene.rods[0].shape.pitch != fine[1].scene.rods[0].shape.pitch
    asked = sweep_of(tmp_path, "seeds = 2").members()
    assert asked[0].setting is None
    other = plan_module.second(fine[0])  # every error twice as large
    assert other.setting == pytest.approx(
        {"elements": 12 / np.sqrt(2), "safety": 0.95, "speed": 0.8, "stiffness": 0.15}
    )


@pytest.mark.parametrize(
    ("head", "said"),
    [
        (
            'tolerance = "finest"',
            "tolerance: finest: expected a share such as 2% or 0.02, or draft",
        ),
        ("tolerance = 3", "tolerance: 3: expected a share"),
    ],
)
def test_a_wrong_tolerance_gets_one_clear_line(tmp_path, head, said):
    with pytest.raises(UserError) as caught:
        sweep_of(tmp_path, head)
    assert said in str(caught.value)
    assert "\n" not in str(caught.value)


def test_curls_have_no_tolerance(tmp_path):
    (tmp_path / "sweep.toml").write_text('preset = "curl"\ntolerance = "3%"\n')
    with pytest.raises(UserError, match="a tolerance is for helices that one tine combs"):
        load_sweep(tmp_path / "sweep.toml")


def test_a_sweep_verifies_the_first_member_of_every_point(tmp_path, monkeypatch):
    sweep = sweep_of(tmp_path, 'tolerance = "draft"\nseeds = 2')
    table = run_sweep(sweep, tmp_path / "out", jobs=2, quiet=True)
    assert list(table["state"]) == ["done", "done"]
    assert len(list((tmp_path / "out" / "runs").glob("*.nc"))) == 3
    first, other = table.iloc[0], table.iloc[1]
    assert 0 < first["force_error"] < 2
    assert np.isnan(other["force_error"])
    worst = max(first["force_error"], np.nan_to_num(first["link_error"]))
    assert list(table["held"]) == ["yes" if worst <= 0.1 else "no", ""]
    kept = json.loads(
        Store(tmp_path / "out").path(sweep.members()[0]).with_suffix(".json").read_text()
    )
    assert kept["setting"]["elements"] == 6
    monkeypatch.setattr("combing.sweep.run.apart", None)  # what was compared is on disk
    monkeypatch.setattr("combing.sweep.run.Crew", None)
    again = run_sweep(sweep, tmp_path / "out", jobs=2, quiet=True)
    assert again["force_error"].iloc[0] == pytest.approx(first["force_error"])


def test_scenes_that_are_alike_are_verified_once_and_what_cannot_be_held_stays(monkeypatch):
    asked = []

    def settle(scene, folder, tolerance, **how):
        asked.append(scene.seed)
        if scene.seed == 9:
            raise UserError("the tine is let go at once")
        record = {"tolerance": tolerance, "held": False, "tries": 2, "force": 0.04, "link": 0.3}
        record |= {"said": "coarse", "seconds": 1.0, "next_half": 2.0, "front_of_this_solver": True}
        setting = {"elements": 9.0, "safety": 0.9, "speed": 0.25, "stiffness": 0.3}
        return SimpleNamespace(), record | {"setting": setting}

    monkeypatch.setattr(accurate, "settle", settle)
    scenes = {("a", "1"): brief(seed=1), ("a", "2"): brief(seed=2), ("b", "9"): brief(seed=9)}
    scenes |= {("c", "3"): sim.curl(n=2, elements=8)}
    alike = {("a", "1"): "a", ("a", "2"): "a"}
    held, notes = accurate.held_to(scenes, alike, None, 0.02)
    assert asked == [1, 9]
    assert [held["a", key].rods[0].elements for key in "12"] == [27, 27]
    assert [held["a", key].tines[0].speed for key in "12"] == [0.25, 0.25]
    assert held["b", "9"] == scenes["b", "9"]
    assert held["c", "3"] == scenes["c", "3"]
    assert "NOT HELD after 2 settings: f within 4 %, lambda within 30 %" in notes[0]
    assert notes[1] == ("b, 9: no setting was chosen, it is simulated as it is: the tine is let go "
                        "at once")  # fmt: skip


def test_a_study_with_a_tolerance_says_what_was_held(tmp_path):
    (tmp_path / "scene.toml").write_text(f'preset = "double_helix"\n{TOML}\n')
    log = sim.simulate(brief()).force_log()
    instron.write_bluehill(tmp_path / "log.csv", log, decimals=9)
    (tmp_path / "rig.toml").write_text(f"r = {log.attrs['r']}\nE = {log.attrs['E']}\n")
    (tmp_path / "study.toml").write_text(
        'title = "t"\ntolerance = "draft"\n[[force]]\nname = "a"\nlogs = "log.csv"\n'
        'rig = "rig.toml"\nsimulation = "scene.toml"\n'
    )
    found = compare(load_study(tmp_path / "study.toml"), tmp_path / "out", quiet=True)
    summary = json.loads((tmp_path / "out" / "summary.json").read_text())
    (said,) = [note for note in summary["notes"] if "up to the first release" in note]
    assert said.startswith("scene.toml: within 10 % up to the first release: ")
    assert "elements a pitch" in said
    assert found.left_out == []


def test_any_cost_reaches_the_processes(tmp_path, monkeypatch):
    asked = []

    def crew(scenes, workers, *, any_cost=False):
        asked.append(any_cost)
        raise UserError("enough")

    monkeypatch.setattr("combing.runs.Crew", crew)
    for flags in (["--error-bars"], ["--tolerance", "draft"]):
        for more in ([], ["--any-cost"]):
            out = ["-o", str(tmp_path / "out")]
            settings = [f"--set={key}={value}" for key, value in BRIEF.items()]
            with pytest.raises(SystemExit):
                main(["simulate", "--preset", "double_helix", *settings, *out, *flags, *more])
    assert asked == [False, True, False, True]
