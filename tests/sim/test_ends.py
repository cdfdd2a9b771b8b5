"""Rods that start stretched, and ends that slide along a direction: against closed forms."""

import numpy as np
import pytest

from sim.energy import books, elastic_energy
from sim.errors import SceneError
from sim.explicit import explicit
from sim.scene import Damping, End, Load, Material, Motion, Output, Points, Rod, Scene, Straight

STUFF = Material(E=1e6, nu=0.5, density=1000)
R, LENGTH = 5e-3, 0.5
AREA, BEND = np.pi * R**2, 1e6 * np.pi * R**4 / 4


def rod(elements=20, length=LENGTH, **more):
    shape = Straight(root=(0, 0, 0), direction=(1, 0, 0), length=length)
    return Rod(shape=shape, radius=R, elements=elements, material=STUFF, **more)


def marched(rods, duration, **more):
    march = explicit(Scene(rods=rods, duration=duration, **more))
    march.advance(round(duration / march.dt))
    return march


@pytest.mark.parametrize("stretch", [0.98, 1.3, [1.0 + 0.01 * k for k in range(20)]])
def test_a_stretched_rod_carries_its_tension_from_the_start(stretch):
    """Drawn even longer by a factor than at rest: EA (stretch - 1), its energy, its mass."""
    march = marched([rod(stretch=stretch, tip=End(hold="pinned"))], 1e-4)
    each = np.broadcast_to(stretch, 20)
    lengths = LENGTH / 20 / each
    energy = 0.5 * 1e6 * AREA * np.sum((each - 1) ** 2 * lengths)
    assert elastic_energy(march.state) == pytest.approx(energy, rel=2e-3)
    assert march.state.row("MASS").sum() == pytest.approx(1000 * AREA * lengths.sum())


def test_a_rod_stretched_evenly_between_two_holds_stays_as_it_is():
    still = End(hold="clamped", motion=Motion())
    march = marched([rod(stretch=1.2, tip=still)], 0.05)
    np.testing.assert_allclose(
        march.state.strands()[0][:, 0], np.linspace(0, LENGTH, 21), atol=1e-12
    )
    force = march.effects.driven.reaction[0] / march.steps
    assert force == pytest.approx([-0.2e6 * AREA, 0, 0], rel=1e-9, abs=1e-12)


def test_stretch_of_points_is_one_value_for_each_element():
    nodes = [(0.1 * k, 0, 0) for k in range(4)]
    given = Rod(shape=Points(nodes=nodes), radius=R, elements=3, material=STUFF, stretch=[1, 2, 1])
    lengths = explicit(Scene(rods=[given], duration=1e-3)).state.row("LENGTH")
    assert lengths[1:4] == pytest.approx([0.1, 0.05, 0.1])
    with pytest.raises(SceneError, match=r"rods.0.stretch: 2 values for 20 elements"):
        explicit(Scene(rods=[rod(stretch=[1, 1])], duration=1e-3))


@pytest.mark.parametrize(
    ("hold", "factor"), [("pinned", 1 / 184.6), ("clamped", 1 / 384)]
)  # a beam clamped at its root, its tip held across, under its own weight
def test_a_sliding_end_carries_across_and_gives_along(hold, factor):
    """Largest deflection w L^4/(184.6 B) propped, w L^4/(384 B) clamped; no tension comes up."""
    g = 0.05
    tip = End(hold=hold, slides=(1, 0, 0), motion=Motion())
    march = marched(
        [rod(40, tip=tip)], 3.0, gravity=(0, 0, -g), damping=Damping(drag=8.0, material=1e-5)
    )
    x = march.state.strands()[0]
    weight = 1000 * AREA * g
    assert -x[:, 2].min() == pytest.approx(weight * LENGTH**4 * factor / BEND, rel=0.02)
    assert x[-1, 1:] == pytest.approx([0, 0], abs=1e-15)
    assert x[-1, 0] < LENGTH  # drawn in by the sag


def test_a_sliding_clamp_is_pulled_by_its_load():
    force = 0.01 * 1e6 * AREA
    tip = End(hold="clamped", slides=(2, 0, 0), load=Load(force=(force, 0, 5.0), ramp=0.05))
    march = marched([rod(tip=tip)], 1.0, damping=Damping(drag=60.0))
    assert march.state.strands()[0][-1] == pytest.approx([1.01 * LENGTH, 0, 0], rel=1e-5, abs=1e-12)


def test_an_end_is_moved_across_while_it_slides_and_the_books_balance():
    """A pendulum bob on a rail: nothing but the prescribed motion puts energy in."""
    tip = End(hold="pinned", slides=(1, 0, 0), motion=Motion(velocity=(0, 0, -0.1), ramp=0.1))
    scene = Scene(
        rods=[rod(tip=tip)], duration=0.5, gravity=(0, 0, -1.0), output=Output(energy=True)
    )
    march = explicit(scene)
    before = books(march)["balance"]
    march.advance(round(0.5 / march.dt))
    after = books(march)
    assert march.state.strands()[0][-1, 2] == pytest.approx(-0.1 * (0.5 - 0.05), rel=1e-3)
    assert after["balance"] == pytest.approx(before, abs=2e-3 * after["elastic"])


@pytest.mark.parametrize(
    ("keys", "complaint"),
    [
        ({"slides": (1, 0, 0)}, "slides needs an end that is held"),
        ({"hold": "pinned", "slides": (0, 0, 0)}, "a direction needs a length"),
        (
            {"hold": "pinned", "slides": (1, 0, 0), "motion": {"velocity": (1, 1, 0)}},
            "leads along slides",
        ),
    ],
)
def test_ends_that_make_no_sense_are_refused(keys, complaint):
    with pytest.raises(ValueError, match=complaint):
        End(**keys)
