"""Forces on tines, strands and holders, and frames, as a run records them: against closed forms."""

import math

import numpy as np
import pytest
from pydantic import ValidationError

import sim
from combing.accuracy.capstan import Capstan, tension
from sim.explicit import explicit
from sim.march.state import build
from sim.scene import Damping, End, Load, Material, Motion, Output, Rod, Scene, Straight

RUBBER = Material(E=1e6, nu=0.5, density=1000)
R, LENGTH = 5e-3, 0.5
WEIGHT = 9.81 * 1000 * math.pi * R**2 * LENGTH
STILL = Output(sample_rate=20, snapshots=2, forces=True)


def rod(direction=(0, 0, -1), **more):
    shape = Straight(root=(0.1, 0.2, 0.3), direction=direction, length=LENGTH)
    return Rod(shape=shape, radius=R, elements=16, **{"material": RUBBER} | more)


def at_rest(rods, **more):
    """Return what a scene records when all is quiet, as numpy arrays by name."""
    damping = Damping(drag=8.0)
    scene = Scene(rods=rods, duration=6.0, damping=damping, output=STILL, **more)
    data = sim.simulate(scene).data
    return {name: np.asarray(data[name][-1]) for name in ("reaction_force", "reaction_moment")}


def test_a_hanging_rod_is_held_by_its_weight():
    found = at_rest([rod(), rod(direction=(0, 0, 1))], gravity=(0, 0, -9.81))
    for number in range(2):
        assert found["reaction_force"][number] == pytest.approx([0, 0, WEIGHT], abs=1e-4 * WEIGHT)
    assert np.abs(found["reaction_moment"]).max() < 1e-6 * WEIGHT * LENGTH


@pytest.mark.parametrize("end", ["root", "tip"])
def test_a_cantilever_is_held_against_force_and_moment(end):
    """Of a load at its other end and its own weight, with the arms that they have when it is bent;
    whichever end is held.
    """
    stiff, pull = RUBBER.model_copy(update={"E": 1e8}), (0, 0, -2.0)
    load = (0.0, 0.2, -0.1)
    ends = {"root": End(hold="free", load=Load(force=load)), "tip": End(hold="clamped")}
    if end == "root":
        ends = {"root": ends["tip"], "tip": ends["root"]}
    scene = Scene(rods=[rod((1, 0, 0), material=stiff, **ends)], duration=2.0, gravity=pull,
                  damping=Damping(drag=22.0), output=STILL)  # fmt: skip
    run = sim.simulate(scene)
    nodes, mass = run.strands()[0], build(scene).row("MASS")[1:18, None]
    forces = mass * np.array(pull)
    forces[16 if end == "root" else 0] += load
    arms = nodes - nodes[0 if end == "root" else 16]
    moment = np.cross(arms, forces).sum(axis=0)
    assert np.abs(moment[1:]).min() > 4e-2
    force, couple = (np.asarray(run.data[f"reaction_{of}"][-1, 0]) for of in ("force", "moment"))
    assert force == pytest.approx(-forces.sum(axis=0), abs=2e-6)
    assert couple == pytest.approx(-moment, abs=2e-6)
    assert list(run.data["end"].values) == [f"0 {end}"]


def combing(**changes):
    """Two strands under a tine, nothing that takes momentum but the tine and the clamps."""
    preset = sim.double_helix(
        pi1=24, turns=2, q=1, elements_per_pitch=6, friction=0.2, speed=0.5, snapshots=5
    )
    tine = preset.tines[0].model_copy(update={"insertion": 6e-3})
    material = Damping(material=preset.damping.material)
    output = preset.output.model_copy(update={"forces": True, "frames": True})
    made = {"tines": [tine], "duration": 20e-3, "damping": material, "output": output}
    return preset.model_copy(update=made | changes)


def test_what_is_recorded_of_a_combing_adds_up_to_the_rate_of_momentum():
    """Window by window, the held nodes of a moving root included; and the tine feels the rest."""
    rods = list(combing().rods)
    moving = End(hold="clamped", motion=Motion(velocity=(0, 0.02, 0.05), start=2e-3, ramp=5e-3))
    rods[1] = rods[1].model_copy(update={"root": moving})
    scene = combing(rods=rods, gravity=(0, 0, -9.81))
    run = sim.simulate(scene)
    data = {name: np.asarray(value) for name, value in run.data.items()}
    assert_balance(scene, data)
    assert data["tine_force"].shape[1:] == (1, 3)
    assert data["strand_force"].shape[1:] == (2, 3)
    np.testing.assert_allclose(
        data["tine_force"].sum(axis=1), -data["strand_force"].sum(axis=1), atol=1e-9
    )
    np.testing.assert_allclose(data["tine_force"][:, 0, 2], data["force"], atol=1e-9)
    assert np.abs(data["strand_force"]).max(axis=(0, 2)).min() > 1e-3


def assert_balance(scene, data):
    """Momentum of a march taken window by window against the impulses that the run holds."""
    march = explicit(scene)
    mass = march.state.row("MASS")
    steps = max(1, round(1 / (scene.output.sample_rate * march.dt)))
    forces = (data["strand_force"].sum(axis=1) + data["reaction_force"].sum(axis=1)
              + np.array(scene.gravity) * mass.sum())  # fmt: skip
    momentum = [np.zeros(3)]
    for _ in range(len(forces)):
        march.advance(steps)
        momentum.append(march.state.rows("V0 V1 V2") @ mass)
    rate = np.diff(momentum, axis=0) / (steps * march.dt)
    np.testing.assert_allclose(forces, rate, atol=1e-8 * np.abs(data["strand_force"]).max())


def test_forces_and_frames_change_nothing_of_what_is_recorded_without_them():
    with_them = sim.simulate(combing())
    without = sim.simulate(combing(output=combing().output.model_copy(
        update={"forces": False, "frames": False})))  # fmt: skip
    new = {"tine_force", "strand_force", "reaction_force", "reaction_moment", "directors"}
    assert set(with_them.data) - set(without.data) == new
    for name, value in without.data.items():
        scale = float(np.abs(value).max())
        np.testing.assert_allclose(with_them.data[name], value, atol=1e-6 * scale, err_msg=name)


def test_the_tine_of_a_capstan_bears_both_tensions():
    """A strand slides round half a turn: T1 pulls at its tip, T2 is the reaction at its root."""
    capstan = Capstan(friction=0.3, wrap=math.pi)
    scene = capstan.scene()
    output = Output(sample_rate=1000, snapshots=2, forces=True)
    data = sim.simulate(scene.model_copy(update={"output": output})).data
    late = np.asarray(data["time"]) > capstan.settling
    held = float(data["reaction_force"][late, 0, 1].mean())
    tine = float(data["tine_force"][late, 0, 1].mean())
    assert held / -tension() == pytest.approx(math.exp(0.3 * math.pi), rel=0.02)
    # Both ends leave downwards; what is left is the drag that the strand meets on its way.
    assert tine == pytest.approx(held - tension(), rel=0.01)


def test_frames_are_those_of_the_elements():
    run = sim.simulate(combing())
    for snapshot in range(len(run.times)):
        for nodes, frames in zip(run.strands(snapshot), run.frames(snapshot), strict=True):
            assert len(frames) == len(nodes) - 1
            np.testing.assert_allclose(
                frames @ frames.transpose(0, 2, 1), np.broadcast_to(np.eye(3), frames.shape),
                atol=1e-10,
            )  # fmt: skip
            tangents = np.diff(nodes, axis=0)
            tangents /= np.linalg.norm(tangents, axis=1, keepdims=True)
            assert np.sum(frames[:, 2] * tangents, axis=1).min() > 0.99
    assert not np.array_equal(run.frames(0)[0], run.frames(-1)[0])


def test_a_run_without_frames_says_so():
    run = sim.simulate(Scene(rods=[rod()], duration=1e-3))
    with pytest.raises(sim.SceneError, match=r"no frames in this run; ask for output.frames"):
        run.frames()


class Stop(Exception):
    pass


def test_a_run_with_forces_and_frames_resumes_to_the_last_bit(tmp_path):
    def stop(done):
        if done > 0.5:
            raise Stop

    whole = sim.simulate(combing(), tmp_path / "whole.nc")
    with pytest.raises(Stop):
        sim.simulate(combing(), tmp_path / "run.nc", progress=stop, checkpoint_every=0.0)
    so_far = sim.open_run(tmp_path / "run.nc.part")
    assert so_far.data["reaction_moment"].shape == (len(so_far.data["time"]), 2, 3)
    run = sim.simulate(combing(), tmp_path / "run.nc")
    for name, value in whole.data.variables.items():
        np.testing.assert_array_equal(run.data[name], value, err_msg=name)


def test_forces_of_a_scene_with_nothing_to_bear_them_are_refused():
    loose = rod(root=End(hold="free"))
    with pytest.raises(ValidationError, match=r"no tine and no held end to record forces of"):
        Scene(rods=[loose], duration=1.0, output=Output(forces=True))


def test_a_key_of_the_wrong_kind_is_named_in_one_line(tmp_path):
    path = tmp_path / "scene.toml"
    path.write_text(
        'duration = 1.0\n[output]\nforces = "all"\n[[rods]]\nradius = 1e-3\nelements = 9\n'
        "shape = {kind = 'straight', length = 0.1}\nmaterial = {E = 1e6, density = 1000}\n"
    )
    with pytest.raises(sim.SceneError, match=r"output.forces") as caught:
        sim.load_scene(path)
    assert str(path) in str(caught.value)
    assert "\n" not in str(caught.value)
