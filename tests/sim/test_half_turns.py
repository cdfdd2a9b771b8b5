"""Turns near and beyond half a turn from element to element, which no frame can tell apart."""

import math

import numpy as np
import pytest

from sim.errors import SceneError, Unstable
from sim.kernels import rod as kernels
from sim.march.state import build, rigidities
from sim.scene import End, Helix, Motion, RandomCurvature, Rod, Scene, Straight

from .hard import CLAMPED, FREE, SOFT, line, march_of, rod, show
from .test_hard_rods import turn_element

R = 5e-3


@pytest.mark.parametrize("axis", ["d1", "d2", "d3"])
@pytest.mark.parametrize("below_pi", [1e-2, 1e-4, 1e-6, 1e-8])
def test_couple_at_pi_minus(below_pi, axis):
    """At the angle theta about one director: B theta/D or C theta/D, for all digits up to pi."""
    march = march_of(rod(line([0, 0, 0], [1, 0, 0], 0.02, 2), R))
    k, theta = ["d1", "d2", "d3"].index(axis), math.pi - below_pi
    turn_element(march, 1, theta * np.eye(3)[k])
    state = march.state
    kernels.bend_and_twist(state.buf, state.n + 1, None)
    bend, twist = rigidities(SOFT, R)
    expected = (twist if axis == "d3" else bend) * theta / 0.01
    couple = state.rows("L0 L1 L2")[:, state.first[0] + 1]
    assert np.abs(couple)[k] == pytest.approx(expected, rel=1e-13)
    np.testing.assert_allclose(np.delete(couple, k), 0, atol=1e-7 * expected)
    show(f"logarithm at pi - {below_pi:g} about {axis}", f"{abs(couple[k]) / expected - 1:.0e}")


def scene(shape, elements, **others):
    return Scene(
        rods=[Rod(shape=shape, radius=1e-3, elements=elements, material=SOFT, **others)], duration=1
    )


@pytest.mark.parametrize("per_turn", [1.0, 1.9, 2.0])
def test_helix_of_no_more_than_2_elements_per_turn_is_refused(per_turn):
    """With one element a turn its chords are a straight line, and nothing would say so."""
    shape = Helix(radius=0.01, pitch=0.02, height=0.2)
    with pytest.raises(SceneError, match=r"rods.0.elements = \d+: .* of a turn of the helix"):
        build(scene(shape, round(10 * per_turn)))
    build(scene(shape, 30))


def test_rest_curvature_of_more_than_half_a_turn_per_element_is_refused():
    """A random curvature of 500/m over elements of 10 mm turns 5 rad from one to the next."""
    curvature = RandomCurvature(sd=500.0, correlation=0)
    with pytest.raises(SceneError, match=r"rods.0: .* half a turn .* node \d+"):
        build(scene(Straight(length=0.3), 30, curvature=curvature))
    build(scene(Straight(length=0.3), 3000, curvature=curvature))


@pytest.mark.parametrize("below_pi", [0.0, 1e-6])
def test_strand_drawn_folded_back_onto_itself_by_180_degrees_is_refused(below_pi):
    """No frame can be carried round a fold without a plane: its node is named."""
    back = [-math.cos(below_pi), 0, math.sin(below_pi)]
    nodes = np.array([[0, 0, 0], [0.01, 0, 0], [0.02, 0, 0], [0.02, 0, 0] + 0.01 * np.array(back)])
    with pytest.raises(SceneError, match="rods.0.shape: .* node 2"):
        march_of(rod(nodes, R, root=FREE))


@pytest.mark.parametrize("elements", [4, 8])
def test_rod_twisted_further_than_half_a_turn_per_element_stops_there_and_says_so(elements):
    """A clamp turns on and on: each of n elements takes 2 pi/n of a turn until one has its half.

    The clamps' own half elements twist by half as much, so the stop comes after n/2 turns; without
    it every further turn would slip through unseen.
    """
    spin = 20.0
    tip = End(hold="clamped", motion=Motion(spin=(spin, 0, 0)))
    nodes = line([0, 0, 0], [1, 0, 0], 0.02 * elements, elements)
    march = march_of(rod(nodes, R, root=CLAMPED, tip=tip), drag=20)
    with pytest.raises(
        Unstable, match=r"half a turn at t = .* rod 0 twists by 17\d degrees"
    ) as stop:
        march.advance(round(2 * math.pi * elements / spin / march.dt))
    turns = (stop.value.time - 0.005) * spin / (2 * math.pi)
    assert turns == pytest.approx(elements / 2 * 177 / 180, rel=0.03)
    assert 0 <= stop.value.element <= elements
    show(f"clamp turned on, {elements} elements", f"stopped after {turns:.2f} turns")
