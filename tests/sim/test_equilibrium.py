"""Rest: static states against closed forms and the march, and what a run says of itself."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq
from scipy.special import ellipe, ellipk

import sim
from sim.explicit import explicit
from sim.march.checkpoint import ROWS
from sim.march.neighbours import rebuild
from sim.march.softness import soften, softness
from sim.march.state import build, rigidities
from sim.rest import imbalance
from sim.scene import (
    Contact,
    Damping,
    End,
    Load,
    Material,
    Output,
    Plane,
    RandomCurvature,
    Rod,
    Scene,
    Straight,
)
from sim.statics.balance import Balance
from sim.statics.newton import factor, settle
from sim.statics.stiffness import close_pairs, stiffness

HAIR = Material(E=1e9, nu=0.4, density=1300)
R, LENGTH, G = 7.5e-5, 0.1, 9.81
DOWN = (0.0, 0.0, -G)


def hair(elements=20, direction=(0, 0, -1), root=(0, 0, 0), **more):
    shape = Straight(root=root, direction=direction, length=LENGTH)
    return Rod(shape=shape, radius=R, elements=elements, **{"material": HAIR} | more)


def scene(*rods, **more):
    usual = {"duration": 4.0, "gravity": DOWN, "rotary_inertia": "element",
             "damping": Damping(drag=2 * math.sqrt(G / LENGTH), material=1e-8),
             "output": Output(sample_rate=100, snapshots=2)}  # fmt: skip
    return Scene(rods=list(rods), **usual | more)


def curly(elements=20, curvature=60.0, **more):
    return hair(elements, curvature=RandomCurvature(sd=curvature), **more)


def settled(of, tolerance=1e-8):
    march = explicit(of)
    found = settle(march, tolerance)
    assert found.converged, found
    return march.state.strands()


def apart(these, those):
    return max(np.abs(a - b).max() for a, b in zip(these, those, strict=True)) / LENGTH


def test_a_straight_rod_hangs_longer_by_its_weight():
    (x,) = settled(scene(hair()))
    stretch = 1300 * G * LENGTH**2 / (2 * 1e9)
    assert -x[-1, 2] - LENGTH == pytest.approx(stretch, rel=1e-3)
    assert np.abs(x[:, :2]).max() == 0


def elastica(load):
    """Return deflection and reach of a cantilever of length 1 under P L^2/B = load at its tip."""

    def shot(bend):
        path = solve_ivp(lambda _, y: [y[1], -load * math.cos(y[0]), math.cos(y[0]),
                                       math.sin(y[0])], (0, 1), [0, bend, 0, 0],
                         rtol=1e-10, atol=1e-12)  # fmt: skip
        return path.y[:, -1]

    bend = brentq(lambda b: shot(b)[1], 0, 2 * math.sqrt(load) + load)
    return shot(bend)[3], shot(bend)[2]


@pytest.mark.parametrize("load", [1.0, 10.0])
def test_a_cantilever_under_an_end_load_is_the_elastica_to_second_order(load):
    bend, _ = rigidities(HAIR, R)
    force = (0, 0, -load * bend / LENGTH**2)
    errors = []
    for elements in (10, 20):
        tip = End(load=Load(force=force))
        (x,) = settled(scene(hair(elements, (1, 0, 0), tip=tip), gravity=None))
        errors.append(np.abs(np.array([-x[-1, 2], x[-1, 0]]) / LENGTH - elastica(load)).max())
    assert errors[1] < 5e-3
    assert 3.5 < errors[0] / errors[1] < 4.5


@pytest.mark.parametrize(("part", "stands"), [(0.97, True), (1.03, False)])
def test_a_column_under_its_own_weight_stands_up_to_greenhills_length(part, stands):
    """It buckles at w L^3/B = 7.837 (Greenhill 1881): a straight one is no minimum."""
    bend, _ = rigidities(HAIR, R)
    g = part * 7.837 * bend / (1300 * math.pi * R**2 * LENGTH**3)
    (x,) = settled(scene(hair(40, (0, 0, 1)), gravity=(0, 0, -g)))
    assert (np.linalg.norm(x[-1, :2]) < 1e-9 * LENGTH) == stands
    assert (x[-1, 2] > 0.999 * LENGTH) == stands


@pytest.mark.parametrize("bent", [0.3, 0.6])
def test_a_column_beyond_eulers_load_rests_on_the_bent_branch(bent):
    """P L^2/B = K(k)^2 with k the sine of half the angle at the tip, which sinks to 2 E/K - 1 and
    goes aside by 2 k/K (the elastica; Timoshenko & Gere, Theory of elastic stability, 2.7).
    """
    bend, _ = rigidities(HAIR, R)
    whole, second = ellipk(bent**2), ellipe(bent**2)
    errors = []
    for elements in (20, 40):
        tip = End(load=Load(force=(0, 0, -bend * (whole / LENGTH) ** 2)))
        (x,) = settled(scene(hair(elements, (0, 0, 1), tip=tip), gravity=None))
        found = np.array([np.linalg.norm(x[-1, :2]), x[-1, 2]]) / LENGTH
        errors.append(np.abs(found - [2 * bent / whole, 2 * second / whole - 1]).max())
    assert errors[1] < 5e-3
    assert errors[0] / errors[1] > 3.0


def test_a_curly_hair_rests_where_the_march_comes_to_rest():
    of = scene(curly(12), seed=3)
    march = explicit(of)
    march.advance(round(3.0 / march.dt))
    assert imbalance(march).max() < 1e-5
    assert apart(settled(of), march.state.strands()) < 1e-6


def test_the_shapes_of_one_hair_converge_over_meshes():
    *shapes, finest = (settled(scene(curly(n)), 1e-5)[0][:: n // 30] for n in (30, 60, 120, 240))
    errors = [np.abs(shape - finest).max() / LENGTH for shape in shapes]
    assert errors[0] < 0.01
    assert errors[2] < errors[0] / 8


def leaning(**more):
    """Three curly hairs that come into each other's way."""
    rods = [curly(12, root=(x, 0, 0)) for x in (0, 4 * R, 8 * R)]
    return scene(*rods, **{"contact": Contact(stiffness=1e6), "seed": 2} | more)


@pytest.fixture(scope="module")
def leant():
    """Return the march of hairs that touch, brought to rest."""
    march = explicit(leaning())
    march.advance(round(1.0 / march.dt))
    found = settle(march, 1e-7)
    assert found.converged, found
    return march


def test_strands_in_contact_stay_where_newton_leaves_them(leant):
    assert len(close_pairs(Balance(leant))) > 0
    before = leant.state.strands()
    assert imbalance(leant).max() <= 1e-7
    leant.advance(round(0.1 / leant.dt))
    assert apart(before, leant.state.strands()) < 1e-7


def test_the_stiffness_is_the_derivative_of_all_forces_also_in_contact(leant):
    balance = Balance(leant)
    matrix = stiffness(balance)
    balance.evaluate()
    frames, strain = balance.frames, balance.strain
    rng, whole = np.random.default_rng(1), np.ones(len(balance.real))
    for only in (slice(0, 3), slice(3, 6), slice(0, 6)):
        move = np.zeros_like(balance.net)
        move[:, only] = rng.standard_normal(move[:, only].shape)
        move[:, :3] *= 1e-3 * R
        move = np.where(balance.free, move, 0.0)
        nets = []
        for size in (1e-5, -1e-5):
            balance.step(frames, strain, size * move, whole)
            nets.append(balance.net)
        slope = ((nets[1] - nets[0]) / 2e-5)[balance.free]
        expected = matrix @ move[balance.free]
        assert np.abs(slope - expected).max() < 1e-4 * np.abs(expected).max()
    balance.put(frames, strain)


def test_rest_in_contact_is_a_minimum_and_a_hair_through_its_neighbour_would_not_be(leant):
    balance = Balance(leant)
    matrix = stiffness(balance)
    assert factor(matrix, balance, 0.0)[1]
    lowest = np.linalg.eigvalsh(matrix.toarray())[0]
    assert lowest > 0
    assert not factor(matrix, balance, -2 * lowest / balance.inertia[balance.free].min())[1]


def test_rods_are_marched_softer_to_rest_and_rest_as_they_are():
    of, march = leaning(), explicit(leaning())
    assert softness(of, build(of)) == 1.0  # a march for its own sake
    marched = explicit(of.model_copy(update={"until": "rest"}))
    assert marched.soft == pytest.approx(0.01)
    assert marched.dt > 1.2 * march.dt
    marched.advance(round(1.2 / marched.dt))
    by, marched.soft = marched.soft, 1.0
    soften(marched.state, 1 / by)
    assert settle(marched, 1e-7, soft=by).converged
    for name in ROWS.split():
        march.state.row(name)[:] = marched.state.row(name)
    rebuild(march)
    march.advance(round(0.1 / march.dt))
    assert apart(march.state.strands(), marched.state.strands()) < 1e-7


def test_a_curl_is_at_rest_unless_a_duration_is_asked_for():
    run = sim.simulate(sim.curl(n=3, elements=12, length=0.1, snapshots=2))
    assert run.unrest() == ""
    assert float(run.data["snapshot_imbalance"][-1]) <= 1e-6
    timed = sim.curl(n=3, duration=0.5)
    assert (timed.until, timed.duration) == ("duration", 0.5)
    assert sim.curl(n=3, duration=0.5, until="rest").until == "rest"


def test_equilibrium_of_strands_in_contact_says_how_it_was_found():
    run = sim.equilibrium(leaning())
    assert "Newton's method from t = " in run.data.attrs["rest"]
    assert float(run.data["snapshot_imbalance"][-1]) <= 1e-6
    assert run.unrest() == ""
    assert run.times[-1] < 2.0
    again = sim.equilibrium(leaning())
    np.testing.assert_array_equal(run.strands()[1], again.strands()[1])


def test_hairs_that_cannot_touch_are_at_rest_without_a_march(tmp_path):
    run = sim.equilibrium(scene(curly(), curly(root=(0.1, 0, 0))), tmp_path / "run.nc")
    assert run.data.attrs["steps"] == 0
    assert sim.open_run(tmp_path / "run.nc").unrest() == ""


def test_friction_is_refused_and_too_short_a_march_is_an_error():
    rubbing = sim.curl(3, elements=8, friction=0.2)
    with pytest.raises(sim.SceneError, match="friction: .* depends on the way there"):
        sim.equilibrium(rubbing)
    short = scene(hair(8, (1, 0, 0), (0, 0, 0.2)), planes=[Plane()], duration=0.02)
    with pytest.raises(sim.NotAtRest, match=r"not at rest at t = 0.02 s: a node of rod 0 .*") as e:
        sim.equilibrium(short)
    assert len(e.value.run.times) == 2


def test_a_scene_that_newton_does_not_know_is_marched_until_it_rests():
    """A pendulum on a pin, released level."""
    pinned = Rod(shape=Straight(direction=(1, 0, -1), length=LENGTH), radius=R, elements=8,
                 material=HAIR, root=End(hold="pinned"))  # fmt: skip
    of = scene(pinned, until="rest", duration=20.0)
    run = sim.simulate(of)
    assert run.data.attrs["rest"].startswith("the march")
    assert 0.3 < run.times[-1] < 10
    assert float(run.data["snapshot_imbalance"][-1]) <= 1e-3
    assert abs(run.strands()[0][-1, 0]) < 2e-3 * LENGTH


def test_a_run_says_how_far_it_is_from_rest():
    """Just let go, a straight rod is out of balance by its weight, but where it is held."""
    of = scene(hair(8, (1, 0, 0)), duration=2e-4, output=Output(sample_rate=1e4, snapshots=3))
    run = sim.simulate(of)
    force, speed = (np.asarray(run.data[f"snapshot_{name}"]) for name in ("imbalance", "speed"))
    assert np.isnan(force[0])
    assert force[-1] == pytest.approx(1, abs=0.2)
    assert speed[-1] == pytest.approx(G * run.times[-1], rel=0.1)
    assert "a node is out of balance by" in run.unrest()


def test_a_run_that_gave_up_is_not_at_rest_though_its_end_is_in_balance():
    """What swings passes through balance, and without weight nothing tells by its speed."""
    run = sim.equilibrium(scene(curly()))
    assert run.unrest() == ""
    late = sim.Run(run.data.assign_attrs(rest="not reached"))
    assert "not at rest" in late.unrest()
