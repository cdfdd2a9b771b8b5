"""What is refused before the first step, what takes shorter steps by itself, what a run says."""

import logging
import math

import numpy as np
import pytest

import sim
from sim.about import about
from sim.cost import cost
from sim.explicit import Explicit, explicit
from sim.scene import (
    Contact,
    Damping,
    End,
    Helix,
    Load,
    Material,
    Motion,
    Output,
    Points,
    RandomCurvature,
    Rod,
    Scene,
    Straight,
    Tine,
)

from .hard import FREE, closest, line, march_of
from .hard import rod as strand

R = 1e-3
NYLON = Material(E=2.18e8, nu=0.4, density=1140)
SOFT = Material(E=1e4, nu=0.5, density=1e4)


def pair(first, second, **contact):
    rods = [strand(nodes, R, NYLON) for nodes in (first, second)]
    return Scene(rods=rods, duration=0.01, contact=Contact(**contact))


def wound(handedness, turns=3, elements=72):
    t = np.linspace(0, 2 * math.pi * turns, elements + 1)
    return np.column_stack([R * np.cos(t), handedness * R * np.sin(t), -9 * R * t / math.pi])


@pytest.mark.parametrize(
    ("first", "second"),
    [
        (wound(1), wound(-1)),  # right- and left-handed, through each other wherever they cross
        (line([0, 0, 0], [1, 0, 0], 0.05, 20), line([0, 0, 1.85 * R], [0, 1, 0], 0.05, 23)),
        (line([0, 0, 0], [1, 0, 0], 0.05, 20), line([0, 0, 1.85 * R], [1, 0, 0], 0.03, 9)),
        (line([0, 0, 0], [1, 0, 0], 0.05, 20), line([0, 0, 0], [1, 0, 0], 0.05, 20) + 1e-9),
    ],
    ids=["wound through each other", "crossing", "side by side", "the same twice"],
)
def test_strands_that_lie_in_each_other_as_drawn_are_refused(first, second):
    with pytest.raises(sim.SceneError, match=r"rods.0 and rods.1 lie in each other as drawn"):
        Explicit(pair(first, second))
    Explicit(pair(first, second, overlap="push apart"))


def test_a_strand_that_lies_in_itself_as_drawn_is_refused():
    t = np.linspace(-0.6, 1.6, 60) * math.pi
    loop = 20 * R * np.column_stack([np.sin(2 * t), np.sin(t), 0.01 * np.sin(t)])
    rods = [strand(loop, R, NYLON)]
    with pytest.raises(sim.SceneError, match="rods.0 and rods.0 lie in each other"):
        Explicit(Scene(rods=rods, duration=1, contact=Contact(self_contact=True)))
    Explicit(Scene(rods=rods, duration=1, contact=Contact()))


@pytest.mark.parametrize("pi1", [9, 18, 60])
@pytest.mark.parametrize("elements_per_pitch", [6, 8, 12, 24])
def test_chords_of_wound_strands_may_overlap(pi1, elements_per_pitch):
    explicit(sim.double_helix(pi1=pi1, turns=3, elements_per_pitch=elements_per_pitch))


def test_a_helix_wound_more_tightly_than_its_strands_are_thick_is_refused():
    with pytest.raises(sim.SceneError, match="lie in each other as drawn"):
        explicit(sim.double_helix(pi1=4, turns=4))


def test_a_tine_that_covers_a_clamp_is_refused():
    with pytest.raises(sim.SceneError, match=r"tines.0: .* from the clamped end of rod 0"):
        explicit(sim.double_helix(pi1=24, pi3=40, turns=6))


@pytest.mark.parametrize("speed", [15.0, 60.0])
def test_a_tip_shot_at_a_flank_comes_back_or_is_said_to_go_through(speed):
    """Straight at the axis, where it cannot slide aside: 60 m/s are more than the contact bears."""
    thrown = strand(line([0, 0, 0.03], [0, 0, -1], 0.05, 50), R, NYLON)
    held = strand(line([0, 0, 0], [1, 0, 0], 0.04, 40), R, NYLON,
                  root=End(hold="clamped"), tip=End(hold="clamped"))  # fmt: skip
    march = march_of(thrown, held)
    march.state.row("V2")[march.state.nodes(0)] = -speed
    if speed > 50:
        with pytest.raises(sim.Unstable, match="pass through each other") as caught:
            march.advance(round(0.04 / speed / march.dt))
        assert (caught.value.rod, caught.value.element, caught.value.partner[0]) == (0, 49, 1)
        return
    for _ in range(100):
        march.advance(round(4e-4 / speed / march.dt))
        assert closest(march) > 0.5
    assert march.state.rows("V2")[0, march.state.nodes(0)].mean() > 0


def hanging(material, length, pull=9.81, drag=4.0, **changes):
    """Return a rod straight down from a clamp under `pull` [m/s^2], and its stretch at rest [m]."""
    rod = Rod(shape=Straight(length=length), radius=2e-3, elements=40, material=material)
    scene = Scene(rods=[rod], duration=1, gravity=(0, 0, -pull), damping=Damping(drag=drag),
                  **changes)  # fmt: skip
    return explicit(scene), material.density * pull * length**2 / (2 * material.E)


@pytest.mark.parametrize(
    ("material", "length", "pull", "drag", "duration"),
    [
        (SOFT, 0.3, 9.81, 4.0, 6.0),
        (SOFT, 0.3, 9.81, 1.0, 16.0),
        (Material(E=1e6, nu=0.5, density=1e3), 0.2, 9.81e4, 200.0, 0.1),
    ],
    ids=["soft and heavy", "the same, less damped", "10^4 g"],
)
def test_a_soft_or_heavy_rod_hangs_as_far_as_it_should(material, length, pull, drag, duration):
    """Bodily motion is no reason to stop, and a wave that strains too fast for one step none."""
    march, stretch = hanging(material, length, pull, drag)
    march.advance(round(duration / march.dt))
    assert (march.finest > 1) == (pull > 10)
    assert -march.state.strands()[0][-1, 2] - length == pytest.approx(stretch, rel=2e-3)
    assert march.time == pytest.approx(duration, abs=march.dt)


def test_free_fall_is_no_reason_for_shorter_steps():
    rod = Rod(shape=Straight(length=0.3), radius=2e-3, elements=60, material=SOFT, root=FREE)
    march = explicit(Scene(rods=[rod], duration=1, gravity=(0, 0, -9.81), damping=Damping(drag=0)))
    march.advance(round(1 / march.dt))
    assert march.parts == march.finest == 1
    fallen = -march.state.strands()[0][0, 2]
    assert fallen == pytest.approx(0.5 * 9.81 * march.time**2, rel=1e-12)


def test_shorter_steps_are_said_and_recorded_and_forces_stay_means(caplog):
    """A tine holds a soft rod up; its mean force is the weight, whatever the steps were."""
    tine = Tine(position=(0, 0, -3.2e-3), axis=(0, 1, 0), length=0.1, radius=1e-3, insertion=0)
    rod = Rod(shape=Straight(root=(-0.02, 0, 0), direction=(1, 0, 0), length=0.04), radius=2e-3,
              elements=16, material=Material(E=1e6, nu=0.5, density=1e3), root=FREE)  # fmt: skip
    scene = Scene(rods=[rod], duration=1e-3, tines=[tine], gravity=(0, 0, -9.81),
                  output=Output(sample_rate=2e4))  # fmt: skip
    march = explicit(scene)
    march.advance(100)
    march._take(4)
    march.advance(100)
    assert march.time == pytest.approx(200 * march.dt, rel=1e-12)
    whole = explicit(scene)
    whole.advance(200)
    np.testing.assert_allclose(march.take_load(), whole.take_load(), rtol=0.02, atol=1e-6)
    heavy, _ = hanging(Material(E=1e6, nu=0.5, density=1e3), 0.2, 9.81e4, 200.0)
    output = Output(sample_rate=1e6)
    with caplog.at_level(logging.INFO, "sim"):
        run = sim.simulate(heavy.scene.model_copy(update={"duration": 0.01, "output": output}))
    assert any("in steps of" in each for each in caplog.messages)
    assert run.data.attrs["shortest_step_s"] < run.data.attrs["time_step_s"]
    assert "one sample a time step" in run.data.attrs["notes"]


def straight(tip, **changes):
    rod = Rod(shape=Straight(length=0.2, direction=(1, 0, 1)), radius=R, elements=20,
              material=NYLON, tip=tip, **changes)  # fmt: skip
    return Scene(rods=[rod], duration=1e-3, output=Output(sample_rate=1e4))


TWISTED = End(hold="clamped", motion=Motion(spin=(30, 0, 30)))


@pytest.mark.parametrize(
    ("scene", "says"),
    [
        (straight(TWISTED), True),
        (straight(End(load=Load(force=(-1, 0, -1)))), True),
        (straight(End(load=Load(force=(-1, 0, -0.9)))), False),
        (straight(TWISTED, curvature=RandomCurvature(sd=0.01)), False),
        (straight(TWISTED).model_copy(update={"gravity": (0, 0, -9.81)}), False),
        (straight(End()), False),
    ],
    ids=["twisted", "pressed", "pressed askew", "curved a little", "sagging", "left alone"],
)
def test_a_perfectly_straight_scene_says_that_it_cannot_buckle(scene, says, caplog):
    said = about(explicit(scene))
    assert ("cannot buckle" in said["attributes"].get("notes", "")) == says


def test_a_run_says_what_it_costs_and_refuses_what_is_absurd(tmp_path, caplog):
    with caplog.at_level(logging.INFO, "sim"):
        run = sim.simulate(straight(TWISTED), tmp_path / "run.nc")
    said = next(each for each in caplog.messages if "steps, about" in each)
    assert "MB of memory, a file of" in said
    assert (
        cost(explicit(straight(TWISTED)), about(explicit(straight(TWISTED)))).steps
        == (run.data.attrs["steps"])
    )
    absurd = straight(TWISTED).model_copy(update={"duration": 1e7})
    with pytest.raises(sim.SceneError, match=r"about .* days, .*--any-cost"):
        sim.simulate(absurd, tmp_path / "absurd.nc")
    with pytest.raises(sim.SceneError, match=r"pi1 = 1e\+09: 3.5e-07 of a pitch fits"):
        sim.double_helix(pi1=1e9)
    assert [each.name for each in tmp_path.iterdir()] == ["run.nc"]


def test_an_absurd_number_of_snapshots_is_one_a_sample(caplog):
    scene = straight(TWISTED).model_copy(
        update={"output": Output(sample_rate=1e4, snapshots=10**12)}
    )
    run = sim.simulate(scene)
    assert len(run.times) == 11
    assert "11 snapshots, one a sample, where 1000000000000 were asked" in run.data.attrs["notes"]


def test_telling_the_cost_leaves_the_march_as_it_was():
    scene = sim.double_helix(pi1=24, turns=2, elements_per_pitch=6, friction=0.2)
    told, other = explicit(scene), explicit(scene)
    cost(told, about(told))
    for march in (told, other):
        march.advance(100)
    np.testing.assert_array_equal(told.state.rows("X0 X1 X2 V0"), other.state.rows("X0 X1 X2 V0"))


def test_a_finished_run_of_another_scene_is_not_written_over(tmp_path):
    path = tmp_path / "run.nc"
    sim.simulate(straight(TWISTED), path)
    kept = path.read_bytes()
    other = straight(End(load=Load(force=(1, 0, 0))))
    with pytest.raises(sim.SceneError, match=r"run\.nc: a finished run of another scene \(.*rods"):
        sim.simulate(other, path)
    assert path.read_bytes() == kept
    assert [each.name for each in tmp_path.iterdir()] == ["run.nc"]
    sim.simulate(straight(TWISTED), path)
    sim.simulate(other, path, resume=False)
    path.write_bytes(b"measured by hand")
    with pytest.raises(sim.SceneError, match=r"run\.nc: not a run"):
        sim.simulate(other, path)
    assert path.read_bytes() == b"measured by hand"


def test_points_and_helices_without_overlap_are_not_refused():
    """Side by side within a per cent of touching, and a coil as tight as its own strand allows."""
    rods = [strand(line([0, 0, z], [1, 0, 0], 0.05, 20), R) for z in (0, 1.99 * R)]
    Explicit(Scene(rods=rods, duration=1, contact=Contact()))
    coil = Helix(radius=4 * R, pitch=2.02 * R, height=8 * R)
    rod = Rod(shape=coil, radius=R, elements=120, material=NYLON)
    Explicit(Scene(rods=[rod], duration=1, contact=Contact(self_contact=True)))
    corner = Points(nodes=[(0, 0, 0), (0.01, 0, 0), (0.01, 0.01, 0)])
    Explicit(Scene(rods=[Rod(shape=corner, radius=R, elements=2, material=NYLON)], duration=1,
                   contact=Contact(self_contact=True)))  # fmt: skip


@pytest.mark.parametrize("insertion", [0.0125, 0.025])
def test_how_fast_a_tine_is_inserted_does_not_decide_the_link(insertion):
    """Loose strands whirled at 2 m/s and lost half of their link to a tine that grew in 0.05 s."""
    scene = sim.double_helix(pi1=36, height=0.06, elements_per_pitch=8, insertion=insertion)
    run = sim.simulate(scene.model_copy(update={"duration": insertion}))
    about = run.data.attrs
    assert about["link_drawn"] == pytest.approx(0.06 / (36 * 4.25e-4), abs=1e-3)
    assert about["link_inserted"] == pytest.approx(3.859, rel=2e-3)
    assert "insertion" not in about


def test_a_tine_that_misses_and_a_link_that_is_lost_are_said(caplog):
    scene = sim.double_helix(pi1=36, height=0.06, elements_per_pitch=6)
    damping = scene.damping.model_copy(update={"insertion": 0.0})
    slow = scene.tines[0].model_copy(update={"insertion": 0.1})
    lost = scene.model_copy(update={"damping": damping, "tines": [slow], "duration": 0.1})
    beside = scene.tines[0].model_copy(update={"position": (4e-3, 4e-3, -0.0153)})
    missed = scene.model_copy(update={"tines": [beside], "duration": 0.025})
    assert (
        "turns are left once the tines are inserted" in sim.simulate(lost).data.attrs["insertion"]
    )
    assert "it has slipped out" in sim.simulate(missed).data.attrs["insertion"]
