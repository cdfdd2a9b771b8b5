"""``combing simulate`` as a user meets it."""

import json
from functools import partial

import pandas as pd
import pytest

import sim
from combing.cli import main
from sim.explicit import Explicit
from sim.scene.presets import PRESETS

SHORT = ["--preset", "double_helix", "--set", "pi1=24", "--set", "turns=2", "--set", "q=1",
         "--set", "elements_per_pitch=6", "--set", "snapshots=4", "--set", "speed=0.5"]  # fmt: skip


@pytest.fixture
def run_combing(capsys):
    """Run the command line; return its exit code and what it printed."""

    def run(*arguments):
        with pytest.raises(SystemExit) as stopped:
            main([str(argument) for argument in arguments])
        return stopped.value.code, *capsys.readouterr()

    return run


def test_simulate_writes_the_run_its_tables_and_a_picture(run_combing, tmp_path):
    code, out, err = run_combing("simulate", *SHORT, "-o", tmp_path / "out", "--json")
    assert code == 0, err
    summary = json.loads(out)
    names = {path.name for path in (tmp_path / "out").iterdir()}
    assert names == {"run.nc", "force.csv", "link.csv", "strands.csv", "run.png", "run.svg"}
    log = pd.read_csv(tmp_path / "out" / "force.csv", comment="#")
    assert log["force"].max() == pytest.approx(summary["largest force [N]"], rel=1e-3)
    run = sim.open_run(tmp_path / "out" / "run.nc")
    assert summary["link at the start and the end"][0] == pytest.approx(2, abs=0.01)
    assert len(run.times) == 4


@pytest.mark.parametrize(
    ("arguments", "expected"),
    [
        (["none.toml"], "none.toml: no such file"),
        ([], "give a scene file or --preset"),
        (["--preset", "helix"], "choose from double_helix, curl"),
        (["--preset", "double_helix", "--set", "r=-1"], "r = -1: Input should be greater than 0"),
        (["--preset", "double_helix", "--set", "r"], "expected KEY=VALUE"),
        (["--preset", "double_helix", "--set", "frction=1"], "did you mean friction?"),
    ],
)
def test_a_wrong_call_gets_one_line_and_leaves_nothing(run_combing, tmp_path, arguments, expected):
    code, _, err = run_combing("simulate", *arguments, "-o", tmp_path / "out")
    assert code == 2
    assert expected in err
    assert len(err.strip().splitlines()) == 1
    assert not (tmp_path / "out").exists()


CURL = ('preset = "curl"', "n = 2", "length = 0.02", "elements = 8", "duration = 0.01")


def scene_file(folder, *lines):
    path = folder / "scene.toml"
    path.write_text("\n".join(lines or CURL))
    return path


@pytest.fixture
def interrupt(monkeypatch):
    """Press Ctrl-C in the n-th sampling window, counted from now on."""
    advance = Explicit.advance

    def press(window):
        monkeypatch.setattr("sim.cost.TRIAL", 0.0)
        calls = iter(range(window))  # one for the step that the trial takes all the same

        def advancing(march, steps):
            if next(calls, None) is None:
                raise KeyboardInterrupt
            advance(march, steps)

        monkeypatch.setattr(Explicit, "advance", advancing)

    yield press
    monkeypatch.undo()


def test_a_scene_that_is_to_end_at_rest_says_how_it_came_there(run_combing, tmp_path):
    path = scene_file(tmp_path, *CURL[:-1], "duration = 20.0")
    code, out, err = run_combing("simulate", path, "--rest", "-o", tmp_path / "out", "--json")
    assert code == 0, err
    summary = json.loads(out)
    assert summary["rest"].startswith(("the march, t = ", "Newton's method from t = "))
    assert summary["largest net force at the end [node weights]"] <= 1e-3


def test_a_scene_that_has_not_come_to_rest_is_written_and_said_to(run_combing, tmp_path):
    code, out, err = run_combing("simulate", scene_file(tmp_path), "--rest", "-o", tmp_path / "out")
    assert code == 0
    assert "not at rest at t = 0.01 s: a node of rod" in err
    assert "rest: not reached" in out


def test_help_names_every_parameter_of_every_preset(run_combing):
    _, out, _ = run_combing("simulate", "--help")
    words = set(out.replace(",", " ").replace(".", " ").split())
    for name, preset in PRESETS.items():
        assert {name, *preset.model_fields} <= words


def test_after_ctrl_c_the_same_command_goes_on_and_says_so(
    run_combing, tmp_path, monkeypatch, interrupt
):
    monkeypatch.setattr(sim, "simulate", partial(sim.simulate, checkpoint_every=0.0))
    command = ("simulate", scene_file(tmp_path), "-o", tmp_path / "out")
    interrupt(10)
    code, _, err = run_combing(*command)
    assert code == 130
    assert "the same command goes on from" in err
    assert [each.name for each in (tmp_path / "out").iterdir()] == ["run.nc.part"]
    monkeypatch.undo()
    code, _, err = run_combing(*command, "--seed", "1")
    assert code == 2
    assert "another scene (it differs in rods, seed)" in err
    code, out, err = run_combing(*command)
    assert code == 0
    assert "going on from t = " in err
    assert not (tmp_path / "out" / "run.nc.part").exists()
    interrupt(2)
    run_combing(*command)
    monkeypatch.undo()
    code, _, err = run_combing(*command, "--fresh", "--seed", "1")
    assert code == 0
    assert "going on" not in err


@pytest.mark.parametrize(
    "lines",
    [
        CURL,
        ["duration = 1e-3", "output = {sample_rate = 1e4}", "[[rods]]", "radius = 1e-3",
         "elements = 8",
         'shape = {kind = "straight", length = 0.1}', "material = {E = 1e8, density = 1e3}",
         "curvature = {sd = 10.0, correlation = 0.01}"],
    ],
    ids=["preset", "scene"],
)  # fmt: skip
def test_seed_and_snapshots_of_a_scene_file_can_be_overruled(run_combing, tmp_path, lines):
    path, runs = scene_file(tmp_path, *lines), []
    for seed in (1, 2):
        out = tmp_path / f"out{seed}"
        code, _, err = run_combing(
            "simulate", path, "-o", out, "--seed", seed, "--snapshots", 3, "--quiet"
        )
        assert (code, err) == (0, "")
        runs.append(sim.open_run(out / "run.nc"))
    assert [run.scene.seed for run in runs] == [1, 2]
    assert len(runs[0].times) == 3
    assert abs(runs[0].strands(-1)[0] - runs[1].strands(-1)[0]).max() > 0


def test_a_first_run_says_that_it_compiles(run_combing, tmp_path, monkeypatch):
    monkeypatch.setattr("sim.compilation.CACHE", tmp_path)
    command = ("simulate", scene_file(tmp_path), "-o", tmp_path / "out")
    assert "compiling for these effects, once" in run_combing(*command)[2]
    assert "compiling" not in run_combing(*command)[2]


def test_an_unstable_run_gets_one_line_and_keeps_what_was_good(run_combing, tmp_path):
    path = scene_file(
        tmp_path, "duration = 1e-2", "[output]", "sample_rate = 1e4", "[[rods]]",
        "radius = 1e-3", "elements = 8", 'shape = {kind = "straight", length = 0.1}',
        "material = {E = 1e8, density = 1e3}",
        'tip = {hold = "pinned", motion = {velocity = [1e5, 0, 0], start = 5e-3, ramp = 0}}',
    )  # fmt: skip
    code, _, err = run_combing("simulate", path, "-o", tmp_path / "out", "--json")
    assert code == 2
    (line,) = err.strip().splitlines()
    assert "prescribed motion" in line
    assert line.endswith("run.unstable.nc")
    assert sim.open_run(tmp_path / "out" / "run.unstable.nc").times[-1] < 5.1e-3
