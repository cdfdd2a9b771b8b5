"""Floors and walls: a rod's weight borne, bounces, Coulomb's cone, and the ledger."""

import numpy as np
import pytest

from sim.energy import books
from sim.errors import SceneError
from sim.explicit import explicit
from sim.scene import Contact, Damping, End, Material, Output, Plane, Rod, Scene, Straight

STUFF = Material(E=1e6, nu=0.5, density=1000)
R, LENGTH, G = 5e-3, 0.2, 9.81
AREA = np.pi * R**2
FREE = End()


def rod(root=(0, 0, R), direction=(1, 0, 0), elements=10, **more):
    shape = Straight(root=root, direction=direction, length=LENGTH)
    return Rod(shape=shape, radius=R, elements=elements, material=STUFF, root=FREE, **more)


def marched(scene, duration):
    march = explicit(scene)
    march.advance(round(duration / march.dt))
    return march


def test_a_rod_at_rest_presses_with_its_weight_and_sinks_in_by_w_over_k():
    scene = Scene(rods=[rod()], duration=1, gravity=(0, 0, -G), planes=[Plane()],
                  damping=Damping(drag=200.0))  # fmt: skip
    march = marched(scene, 0.5)
    march.effects.planes.load[:] = 0
    before = march.steps
    march.advance(1000)
    weight = 1000 * AREA * LENGTH * G
    load = march.effects.planes.load[0] / (march.steps - before)
    assert load == pytest.approx([0, 0, -weight], rel=1e-3, abs=1e-12)
    sunk = 1000 * AREA * G / (0.3 * 1e6)
    assert march.state.strands()[0][:, 2] == pytest.approx(R - sunk, abs=1e-3 * sunk)


def test_a_rod_bounces_off_a_wall_as_fast_as_it_came_and_leaves_momentum_in_it():
    """A wall aslant. A straight rod bounces as a whole; what is lost falls with the time step."""
    normal = np.array([0, 3, 4]) / 5
    scene = Scene(rods=[rod(root=tuple(1.5 * R * normal))], duration=1, time_step=5e-6,
                  planes=[Plane(normal=(0, 3, 4))], output=Output(energy=True))  # fmt: skip
    march = explicit(scene)
    for k in range(3):
        march.state.row(f"V{k}")[march.state.nodes(0)] = -0.5 * normal[k]
    start = books(march)
    march.advance(round(0.03 / march.dt))
    velocity = march.state.rows("V0 V1 V2")[:, march.state.nodes(0)]
    assert velocity == pytest.approx(0.5 * np.outer(normal, np.ones(11)), abs=2e-3)
    momentum = 1000 * AREA * LENGTH * normal  # twice times a half
    assert -march.effects.planes.load[0] * march.dt == pytest.approx(momentum, rel=4e-3)
    end = books(march)
    assert end["plane_contact"] == 0
    assert end["balance"] == pytest.approx(start["balance"], rel=5e-3)


@pytest.mark.parametrize(("slope", "slides"), [(0.28, False), (0.32, True)])
def test_a_rod_holds_on_a_slope_up_to_the_angle_of_friction(slope, slides):
    """Lying down the slope, mu = 0.3: below it sticks, above it slides with g (sin - mu cos)."""
    down = np.array([1, 0, -slope]) / np.hypot(1, slope)
    normal = np.array([slope, 0, 1]) / np.hypot(1, slope)
    sunk = 1000 * AREA * G / np.hypot(1, slope) / (0.3 * 1e6)  # it does not bounce
    lying = rod(root=tuple((R - sunk) * normal), direction=tuple(down))
    floor = Plane(normal=tuple(normal), friction=0.3)
    scene = Scene(rods=[lying], duration=1, gravity=(0, 0, -G), planes=[floor],
                  damping=Damping(tine=2e-4), output=Output(energy=True))  # fmt: skip
    march = explicit(scene)
    start, ways, steps = books(march), [0.0], round(0.1 / march.dt)
    for _ in range(3):
        march.advance(steps)
        ways.append(float((march.state.strands()[0].mean(axis=0) - R * normal) @ down) - LENGTH / 2)
    gain = G * (slope - 0.3) / np.hypot(1, slope) * (steps * march.dt) ** 2 if slides else 0.0
    assert np.diff(ways)[2] - np.diff(ways)[1] == pytest.approx(gain, rel=1e-3, abs=1e-9)
    end = books(march)
    assert end["balance"] == pytest.approx(start["balance"], abs=1e-6)
    if slides:
        lost = 0.3 * 1000 * AREA * LENGTH * G / np.hypot(1, slope) * ways[-1]
        assert end["lost_friction"] == pytest.approx(lost, rel=0.01)
    else:
        assert ways[-1] < 1e-5  # what sets the elastic slip up


def test_a_rod_that_slides_sideways_comes_to_roll():
    """A solid cylinder thrown flat over a rough floor ends at 2/3 of its speed, rolling."""
    scene = Scene(rods=[rod()], duration=1, gravity=(0, 0, -G), planes=[Plane(friction=0.3)],
                  damping=Damping(material=1e-5))  # fmt: skip
    march = explicit(scene)
    march.state.row("V1")[march.state.nodes(0)] = 0.3
    march.advance(round(0.2 / march.dt))
    assert march.state.row("V1")[march.state.nodes(0)] == pytest.approx(0.2, rel=0.01)
    spin = march.state.rows("W0 W1 W2")[2, march.state.first[0] : march.state.first[0] + 10]
    assert np.abs(spin) == pytest.approx(0.2 / R, rel=0.02)


def test_without_planes_the_march_is_the_same_to_the_last_bit_and_far_ones_change_nothing():
    far = Plane(point=(0, 0, -1.0), friction=0.5)
    runs = [
        marched(Scene(rods=[rod()], duration=1, gravity=(0, 0, -G), contact=Contact(),
                      time_step=1e-5, planes=planes), 0.02).state.strands()[0]
        for planes in ([], [far])
    ]  # fmt: skip
    np.testing.assert_array_equal(*runs)


def test_what_is_drawn_behind_a_plane_is_refused():
    with pytest.raises(SceneError, match=r"planes.0: node 0 of rod 0, .* clear of the plane"):
        explicit(Scene(rods=[rod(root=(0, 0, 0))], duration=1, planes=[Plane()]))
    with pytest.raises(ValueError, match="a direction needs a length"):
        Plane(normal=(0, 0, 0))
