"""A run that is stopped, by whatever means, goes on later as if it had not been."""

import json
import os
import shutil
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import sim
from sim.explicit import Explicit
from sim.march.checkpoint import FORMAT, freeze, thaw
from sim.records.journal import Journal
from sim.scene import Contact, Damping, End, Friction, Load, Motion, Output, Plane


def scene(**changes):
    """Two strands, a tine that is already among them, friction: all that has a memory."""
    preset = sim.double_helix(
        pi1=24, turns=2, q=1, elements_per_pitch=6, friction=0.2, speed=0.5, snapshots=5
    )
    tine = preset.tines[0].model_copy(update={"insertion": 6e-3})
    return preset.model_copy(update={"tines": [tine], "duration": 8e-3, **changes})


@pytest.fixture(scope="module")
def uninterrupted(tmp_path_factory):
    return sim.simulate(scene(), tmp_path_factory.mktemp("whole") / "run.nc")


class Stop(Exception):
    """Stands for whatever ends a process."""


def stop_at(fraction):
    def progress(done):
        if done >= fraction:
            raise Stop

    return progress


def stopped_run(path, fraction=0.5, checkpoint_every=0.0, **changes):
    with pytest.raises(Stop):
        sim.simulate(
            scene(**changes), path, progress=stop_at(fraction), checkpoint_every=checkpoint_every
        )
    return path.with_name("run.nc.part")


def assert_equal_to_the_last_bit(run, other):
    for name, variable in run.data.variables.items():
        np.testing.assert_array_equal(variable, other.data[name], err_msg=name)


KILLED = """
import os, signal, sys
from pathlib import Path
import sim
from sim.scene import Scene

def progress(done):
    if done > float(sys.argv[3]):
        os.kill(os.getpid(), signal.SIGKILL)

scene = Scene.model_validate_json(Path(sys.argv[1]).read_text())
sim.simulate(scene, sys.argv[2], progress=progress, checkpoint_every=0.0)
"""


def simulate_elsewhere(folder, name, kill_after):
    """Simulate in a process that has done nothing else, and return how it ended."""
    command = [sys.executable, "-c", KILLED, "scene.json", name, str(kill_after)]
    environment = {**os.environ, "PYTHONPATH": str(Path(sim.__file__).parents[1])}
    return subprocess.run(command, cwd=folder, env=environment, check=False).returncode


@pytest.mark.skipif(sys.platform == "win32", reason="no SIGKILL")
def test_a_killed_run_resumes_and_ends_bitwise_as_if_uninterrupted(tmp_path):
    (tmp_path / "scene.json").write_text(scene().model_dump_json())
    assert simulate_elsewhere(tmp_path, "whole.nc", kill_after=2) == 0
    assert simulate_elsewhere(tmp_path, "run.nc", kill_after=0.4) == -signal.SIGKILL
    part = tmp_path / "run.nc.part"
    with np.load(part / "checkpoint.npz") as saved:
        assert saved["contact.slip"].any()
        assert saved["tines.slip"].any()
    for name in ("samples.f64", "snapshots.f64"):  # killed in the middle of writing, too
        with (part / name).open("ab") as table:
            table.write(b"rows and a half, " * 999)
    # Between two snapshots: its checkpoint counts what it has cut off.
    assert simulate_elsewhere(tmp_path, "run.nc", kill_after=0.55) == -signal.SIGKILL
    assert simulate_elsewhere(tmp_path, "run.nc", kill_after=2) == 0
    whole, run = (sim.open_run(tmp_path / name) for name in ("whole.nc", "run.nc"))
    assert_equal_to_the_last_bit(run, whole)
    assert not part.exists()


SUMMED = """
import hashlib, sys
from pathlib import Path
import numpy as np
import sim
from sim.scene import Scene
run = sim.simulate(Scene.model_validate_json(Path(sys.argv[1]).read_text()))
print(hashlib.sha256(np.asarray(run.data["position"]).tobytes()).hexdigest())
"""


@pytest.mark.slow
def test_the_run_that_has_to_compile_is_the_one_that_finds_its_kernels_compiled(tmp_path):
    (tmp_path / "scene.json").write_text(scene(duration=2e-3).model_dump_json())
    root = Path(sim.__file__).parents[1]
    environment = {"PYTHONPATH": str(root), "NUMBA_CACHE_DIR": str(tmp_path / "cache")}
    command = [sys.executable, "-c", SUMMED, "scene.json"]
    first, second = (
        subprocess.run(command, cwd=tmp_path, env=environment, check=True, capture_output=True)
        for _ in range(2)
    )
    assert first.stdout == second.stdout


def test_a_run_stopped_before_its_first_checkpoint_begins_anew(tmp_path, uninterrupted):
    stopped_run(tmp_path / "run.nc", checkpoint_every=1e9)
    assert_equal_to_the_last_bit(sim.simulate(scene(), tmp_path / "run.nc"), uninterrupted)


def test_what_is_recorded_so_far_can_be_read(tmp_path, uninterrupted):
    part = stopped_run(tmp_path / "run.nc")
    so_far = sim.open_run(part)
    log, whole = so_far.force_log(), uninterrupted.force_log()
    assert len(log) == -(-len(whole) // 2)
    np.testing.assert_array_equal(log, whole[: len(log)])
    assert len(so_far.times) == 3
    np.testing.assert_array_equal(so_far.strands(2)[1], uninterrupted.strands(2)[1])
    with pytest.raises(sim.SceneError, match=r"has not ended; .* is in .*run\.nc\.part"):
        sim.open_run(tmp_path / "run.nc")


def test_a_run_of_another_scene_is_not_touched(tmp_path):
    part = stopped_run(tmp_path / "run.nc")
    before = {each: each.read_bytes() for each in part.iterdir()}
    with pytest.raises(sim.SceneError, match=r"another scene \(it differs in friction\)"):
        sim.simulate(scene(friction=Friction(forward=0.3, backward=0.3)), tmp_path / "run.nc")
    assert {each: each.read_bytes() for each in part.iterdir()} == before


def test_a_run_of_another_solver_is_not_touched(tmp_path):
    part = stopped_run(tmp_path / "run.nc")
    about = json.loads((part / "about.json").read_text())
    (part / "about.json").write_text(json.dumps(about | {"solver": "older"}))
    with pytest.raises(sim.SceneError, match="another version of the solver"):
        sim.simulate(scene(), tmp_path / "run.nc")


def test_on_request_a_run_begins_anew_over_an_unfinished_one(tmp_path, uninterrupted):
    stopped_run(tmp_path / "run.nc", friction=None)
    run = sim.simulate(scene(), tmp_path / "run.nc", resume=False)
    assert_equal_to_the_last_bit(run, uninterrupted)


def test_two_processes_do_not_write_the_same_run(tmp_path):
    about = {"scene": {}, "solver": "", "samples": {}, "strands": [2], "attributes": {}}
    journal = Journal(tmp_path / "run.nc.part", about, resume=True)
    with pytest.raises(sim.SceneError, match="another process is writing this run"):
        Journal(tmp_path / "run.nc.part", about, resume=True)
    journal.close()
    Journal(tmp_path / "run.nc.part", about, resume=True).close()


def test_a_folder_that_is_no_journal_is_not_opened_as_a_run(tmp_path):
    with pytest.raises(sim.SceneError, match="not an unfinished run"):
        sim.open_run(tmp_path)


DAMAGES = {
    "samples.f64 cut": ("samples.f64", lambda data: data[:100]),
    "snapshots.f64 cut": ("snapshots.f64", lambda data: data[:-8]),
    "samples.f64 emptied": ("samples.f64", lambda data: b""),
    "samples.f64 zeroed": ("samples.f64", lambda data: bytes(len(data))),
    "checkpoint.npz cut": ("checkpoint.npz", lambda data: data[:3000]),
    "checkpoint.npz emptied": ("checkpoint.npz", lambda data: b""),
    "checkpoint.npz no archive": ("checkpoint.npz", lambda data: b"x" * 999),
    "about.json cut": ("about.json", lambda data: data[:50]),
    "about.json emptied": ("about.json", lambda data: b""),
    "about.json a list": ("about.json", lambda data: b"[]"),
}


@pytest.fixture(scope="module")
def stopped(tmp_path_factory):
    return stopped_run(tmp_path_factory.mktemp("stopped") / "run.nc")


def assert_refused_and_untouched(part, name, scene):
    before = {each: each.read_bytes() for each in part.iterdir()}
    with pytest.raises(sim.SceneError) as caught:
        sim.simulate(scene, part.with_name("run.nc"))
    assert str(part / name) in str(caught.value)
    assert "\n" not in str(caught.value)
    assert {each: each.read_bytes() for each in part.iterdir()} == before


@pytest.mark.parametrize("damage", DAMAGES)
def test_a_damaged_journal_is_refused_with_the_name_of_the_file(tmp_path, stopped, damage):
    part = shutil.copytree(stopped, tmp_path / "run.nc.part")
    name, change = DAMAGES[damage]
    (part / name).write_bytes(change((part / name).read_bytes()))
    assert_refused_and_untouched(part, name, scene())


@pytest.mark.parametrize("name", ["samples.f64", "snapshots.f64", "about.json"])
def test_a_journal_with_a_file_missing_is_refused(tmp_path, stopped, name):
    part = shutil.copytree(stopped, tmp_path / "run.nc.part")
    (part / name).unlink()
    assert_refused_and_untouched(part, name, scene())


def test_a_journal_with_a_checkpoint_of_another_run_is_refused(tmp_path, stopped):
    part = stopped_run(tmp_path / "run.nc", damping=Damping(drag=49.0))
    shutil.copy(stopped / "checkpoint.npz", part)
    assert_refused_and_untouched(part, "checkpoint.npz", scene(damping=Damping(drag=49.0)))


def test_a_checkpoint_of_another_format_is_refused(tmp_path, stopped):
    part = shutil.copytree(stopped, tmp_path / "run.nc.part")
    with np.load(part / "checkpoint.npz") as saved:
        arrays = dict(saved) | {"format": np.asarray(99)}
    np.savez(part / "checkpoint.npz", **arrays)
    assert_refused_and_untouched(part, "checkpoint.npz", scene())


# Beside the strands, one of which is thrown against it.
WALL = Plane(point=(0.0, -2.1 * 4.25e-4, 0.0), normal=(0.0, 1.0, 0.0), friction=0.2)


def everything():
    rods = list(scene().rods)
    tip = End(hold="clamped", motion=Motion(velocity=(0, 0, 1e-3)))
    rods[0] = rods[0].model_copy(update={"tip": tip})
    rods[1] = rods[1].model_copy(update={"tip": End(load=Load(force=(0, 0, -1e-3)))})
    return scene(
        rods=rods,
        gravity=(0.0, 0.0, -9.81),
        planes=[WALL],
        damping=Damping(drag=1.0, material=1e-6),
        output=Output(energy=True, forces=True, frames=True),
    )


BARE = {"contact": None, "friction": None, "tines": [], "damping": None}
ALONE = {
    "nothing": {},
    "gravity": {"gravity": (1.0, 0.0, -9.81)},
    "drag": {"damping": Damping(drag=50.0)},
    "material": {"damping": Damping(material=1e-7)},
    "contact": {"contact": Contact()},
    "self-contact": {"contact": Contact(self_contact=True)},
    "friction": {"contact": Contact(), "friction": Friction(forward=0.3, backward=0.2)},
    "tine": {"tines": scene().tines},
    "tine damping": {"tines": scene().tines, "damping": Damping(tine=1e-6)},
    "tine friction": {"tines": scene().tines, "friction": Friction(forward=0.3, backward=0.3)},
    "plane": {"planes": [WALL.model_copy(update={"friction": 0.0})]},
    "plane friction": {"planes": [WALL]},
    "motion": {"rods": [everything().rods[0]]},
    "load": {"rods": [everything().rods[1]]},
    "energy": {"output": Output(energy=True)},
    "reactions": {"output": Output(forces=True)},
    "forces": {"tines": scene().tines, "output": Output(forces=True)},
}
MATRIX = {name: scene(**BARE | effect) for name, effect in ALONE.items()}


@pytest.mark.parametrize(
    "case",
    [
        "all of the preset",
        "everything",
        *(pytest.param(name, marks=pytest.mark.slow) for name in MATRIX),  # each is compiled
    ],
)
@pytest.mark.parametrize("parts", [1, 4])
def test_a_march_goes_on_to_the_last_bit_wherever_it_is_stopped(case, parts):
    """Every effect x the place where it stops, also while it takes shorter steps."""
    chosen = MATRIX | {"all of the preset": scene(), "everything": everything()}
    windows, steps = 6, 40
    whole = Explicit(chosen[case])
    kick(whole, parts)
    saved = []
    for _ in range(windows):
        saved.append({name: value.copy() for name, value in freeze(whole).items()})
        whole.advance(steps)
    for stop in range(windows):
        again = Explicit(chosen[case])
        thaw(again, saved[stop])
        for _ in range(stop, windows):
            again.advance(steps)
        end, there = freeze(again), freeze(whole)
        assert end.keys() == there.keys()
        for name in there:
            np.testing.assert_array_equal(end[name], there[name], err_msg=f"{name}, {stop}")


def kick(march, parts):
    """Throw the strands at each other and at the tine, which is not there yet on its own."""
    for number in range(len(march.state.first)):
        march.state.row("V1")[march.state.nodes(number)] = 3.0 * (-1) ** number
    march.steps = round(5e-3 / march.dt)  # the tine is nearly as thick as it will be
    march._take(parts)


def test_a_checkpoint_holds_all_that_changes_in_a_march_with_every_effect(rng):
    march, fresh = Explicit(everything()), Explicit(everything())
    assert None not in march.effects
    changed = {
        name: rng.permuted(np.arange(1, array.size + 1)).reshape(array.shape).astype(array.dtype)
        for name, array in freeze(march).items()
    } | {"format": np.asarray(FORMAT)}
    thaw(fresh, changed)
    again = freeze(fresh)
    assert again.keys() == changed.keys()
    for name in changed:
        np.testing.assert_array_equal(again[name], changed[name], err_msg=name)
    assert type(fresh.effects.contact.stiffness) is float  # or the march would be compiled again
