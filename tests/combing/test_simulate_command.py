"""``combing simulate`` as a user meets it."""

import json

import pandas as pd
import pytest

import sim
from combing.cli import main

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
