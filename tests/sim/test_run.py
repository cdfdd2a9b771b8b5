"""Whole runs: recorded, written, read back, repeated; and combing itself."""

import pickle
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import sim
from sim.explicit import explicit
from sim.kernels.compiled import source_age, source_digest
from sim.scene import Damping, Friction, Output


@pytest.fixture(scope="module")
def short_run(tmp_path_factory):
    path = tmp_path_factory.mktemp("run") / "run.nc"
    done = []
    scene = sim.double_helix(pi1=24, turns=5, q=3, speed=0.4, elements_per_pitch=8, snapshots=12)
    return sim.simulate(scene, path, progress=done.append), path, done


def test_force_log_has_the_columns_and_signs_of_an_export(short_run):
    run, _, _ = short_run
    log = run.force_log()
    assert list(log.columns) == ["time", "displacement", "force"]
    assert (np.diff(log.time) > 0).all()
    assert (np.diff(log.displacement) >= 0).all()
    assert log.force.max() > 0.01
    assert (
        abs(log.force[log.displacement > log.displacement.iloc[-1] - 1e-3]).max()
        < 0.05 * log.force.max()
    )


def test_combing_takes_the_link_out_of_the_part_behind_the_tine(short_run):
    run, _, _ = short_run
    total = [sim.link_density(*run.strands(i)).attrs["total_link"] for i in (0, -1)]
    assert total[0] == pytest.approx(5, abs=0.01)
    assert total[1] < 2.6  # the three pitches below the tine are gone


def test_force_is_sampled_as_often_as_asked(short_run):
    run, _, _ = short_run
    log = run.force_log()
    pitch = 24 * 4.25e-4
    moving = log[(log.displacement > 0.2 * pitch) & (log.displacement < 1.2 * pitch)]
    assert len(moving) >= 199


def test_progress_rises_to_one(short_run):
    _, _, done = short_run
    assert done[-1] == 1
    assert (np.diff(done) > 0).all()


def test_run_reads_back_as_it_was(short_run):
    run, path, _ = short_run
    again = sim.open_run(path)
    assert again.scene == run.scene
    np.testing.assert_array_equal(again.force_log(), run.force_log())
    np.testing.assert_array_equal(again.strands(3)[1], run.strands(3)[1])
    assert again.data["force"].attrs["units"] == "N"
    assert [p.name for p in path.parent.iterdir()] == ["run.nc"]


def test_the_same_scene_gives_the_same_run_to_the_last_bit():
    scene = sim.double_helix(pi1=24, turns=2, q=1, elements_per_pitch=8, friction=0.1)
    scene = scene.model_copy(update={"duration": 0.01})
    first, second = sim.simulate(scene), sim.simulate(scene)
    np.testing.assert_array_equal(first.data["position"], second.data["position"])


def test_an_effect_with_zero_coefficient_is_as_good_as_absent():
    absent = sim.double_helix(pi1=24, turns=2, q=1, elements_per_pitch=8)
    absent = absent.model_copy(update={"duration": 2e-4, "damping": None})
    zero = absent.model_copy(
        update={
            "gravity": (0.0, 0.0, 0.0),
            "friction": Friction(forward=0.0, backward=0.0),
            "damping": Damping(drag=0.0, material=0.0),
        }
    )
    there, here = sim.simulate(zero), sim.simulate(absent)
    np.testing.assert_allclose(there.data["position"], here.data["position"], atol=1e-13)


def test_a_run_that_blows_up_stops_says_where_and_keeps_what_was_good(monkeypatch):
    monkeypatch.setattr("sim.explicit.SHORTEST", 1)
    scene = sim.double_helix(pi1=24, turns=2, elements_per_pitch=8)
    # Viscous damping beyond what the explicit march resolves, smuggled past the step's choice.
    march = sim.explicit.explicit(scene)
    march.effects = march.effects._replace(viscous=50 * march.dt)
    with pytest.raises(sim.Unstable, match=r"node \d+ of rod \d+ moves at") as error:
        march.advance(100_000)
    assert error.value.time > 0
    assert 0 <= error.value.rod < 2
    again = pickle.loads(pickle.dumps(error.value))  # as a worker process hands it back
    assert str(again) == str(error.value)
    assert again.time == error.value.time


def test_something_else_is_not_opened_as_a_run(tmp_path):
    for content in (None, b"", b"not a data set"):
        path = tmp_path / "x.nc"
        if content is not None:
            path.write_bytes(content)
        with pytest.raises(sim.SceneError, match=r"x\.nc"):
            sim.open_run(path)


def test_a_scene_without_tine_has_no_force_log():
    scene = sim.curl(n=2, length=0.02, elements=8, duration=1e-3)
    with pytest.raises(sim.SceneError, match="no tine"):
        sim.simulate(scene).force_log()


def test_an_edited_kernel_changes_the_cache_folder(tmp_path):
    """Numba itself does not see an edit of a callee in another file."""
    source = Path(sim.__file__).parent / "kernels"
    copy = tmp_path / "kernels"
    shutil.copytree(source, copy, ignore=shutil.ignore_patterns("__pycache__"))
    assert source_digest(copy) == source_digest(source)
    assert source_age(copy) != source_age(
        source
    )  # numba would drop one's machine code for the other
    (copy / "vectors.py").write_text((copy / "vectors.py").read_text() + "\n")
    assert source_digest(copy) != source_digest(source)


CALLER = """
import sys
sys.path.insert(0, {root!r})
from sim.kernels.vectors import point
from sim.kernels.vectors import dot
import numpy as np
from sim.kernels.topology import pair_link
print(pair_link((0., 0., 0.), (1., 0., 0.), (0., 0., 1.), (0., 1., 1.)))
"""


def test_an_edited_callee_is_recompiled(tmp_path):
    """Edit `half_solid_angle`'s callee `dot`; the caller's cached machine code must not be used."""
    package = Path(sim.__file__).parent
    shutil.copytree(package, tmp_path / "sim", ignore=shutil.ignore_patterns("__pycache__"))
    script = tmp_path / "call.py"
    script.write_text(CALLER.format(root=str(tmp_path)))

    def call():
        found = subprocess.run(
            [sys.executable, str(script)], capture_output=True, text=True, check=True,
            env={"NUMBA_CACHE_DIR": str(tmp_path / "cache"), "PATH": ""},
        )  # fmt: skip
        return float(found.stdout)

    before = call()
    vectors = tmp_path / "sim" / "kernels" / "vectors.py"
    text = vectors.read_text()
    edited = text.replace(
        "return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]",
        "return a[0] * b[0] + a[1] * b[1] - a[2] * b[2]",
    )
    assert edited != text
    vectors.write_text(edited)
    assert call() != before


@pytest.mark.slow  # compiles for a minute
def test_the_ledger_of_energy_is_recorded_beside_the_force():
    """Put in less lost is stored: the balance stays, to a hundredth of the work of the tine."""
    scene = sim.double_helix(pi1=24, turns=2, q=1, elements_per_pitch=8, friction=0.2)
    tine = scene.tines[0].model_copy(update={"insertion": 5e-3})
    output = Output(sample_rate=2e3, energy=True)
    scene = scene.model_copy(update={"tines": [tine], "duration": 0.02, "output": output})
    data = sim.simulate(scene).data
    assert data["energy_kinetic"].attrs["units"] == "J"
    np.testing.assert_allclose(data["energy_time"] - data["time"], 0.5 / 2e3, rtol=1e-6)
    balance, work = (np.asarray(data[f"energy_{name}"]) for name in ("balance", "work_tines"))
    assert work[-1] > 0
    assert np.ptp(balance) < 0.01 * work[-1]


def test_force_is_that_on_the_tines_of_a_comb_and_not_on_fixed_ones():
    scene = sim.double_helix(pi1=24, turns=3, q=2, elements_per_pitch=8)
    first = scene.tines[0].model_copy(update={"insertion": 5e-3})
    pitch = 24 * 4.25e-4
    below = {"position": (0.0, 0.0, first.position[2] - pitch)}
    peg = {"position": (0.0, 0.0, first.position[2] + pitch / 2), "speed": 0.0, "travel": 0.0}
    tines = [first.model_copy(update=peg), first, first.model_copy(update=below)]
    scene = scene.model_copy(
        update={"tines": tines, "duration": 0.012, "output": Output(sample_rate=1e3)}
    )
    log, march = sim.simulate(scene).force_log(), explicit(scene)
    march.advance(round(0.011 / march.dt))
    march.take_load()
    steps = round(1e-3 / march.dt)
    march.advance(steps)
    on_tines = march.take_load()[:, 2] / steps
    assert abs(on_tines).min() > 1e-4
    assert log.force.iloc[-1] == pytest.approx(on_tines[1] + on_tines[2], rel=1e-9)
    assert log.displacement.iloc[-1] == pytest.approx(march.tine_travel()[1], rel=0.2)
