"""Tines where combing is hard: a jam with friction, a coarse helix, a strand round the tine."""

import math

import numpy as np
import pytest

import sim
from sim.explicit import Explicit
from sim.scene import Contact, Friction, Tine

from .hard import CLAMPED, march_of, rod, show, watch


def from_axis(march):
    """Return the nodes of the first strand as seen from the tine's axis, (n, 2) [m], across it."""
    now, g = march.tines.now[0], march.tines.geometry[0]
    nodes = march.state.strands()[0] - now[3:6]
    across = np.cross(g[3:6], [0.0, 0.0, 1.0])
    return nodes @ np.column_stack([across, [0.0, 0.0, 1.0]])


def winding(march):
    """Return how often the first strand goes round the tine, in turns."""
    return np.ptp(np.unwrap(np.arctan2(*from_axis(march).T))) / (2 * math.pi)


def wrapped(turns, r=1e-3, tail=30e-3):
    """Return nodes of a strand wound `turns` times round the y axis at 3 r, its tails along z."""
    angle = np.linspace(0, 2 * math.pi * turns, 18 * turns + 1)
    y = 2.2 * r * angle / (2 * math.pi)
    coil = np.column_stack([3 * r * np.cos(angle), y, -3 * r * np.sin(angle)])
    straight = np.linspace(0, tail, 30)[1:, None] * [0, 0, 1.0]
    return np.vstack([coil[0] + straight[::-1], coil, coil[-1] - straight])


@pytest.mark.parametrize("turns", [2, 3])
def test_strand_wrapped_round_a_tine_that_travels_12_mm_with_mu_0p3(turns):
    """Its root clamped, its coils slide round the tine, which never enters it, and stay coils."""
    r = 1e-3
    tine = Tine(position=(0, 1.1 * r * turns, 0), axis=(0, 1, 0), length=0.05, radius=2 * r,
                direction=(0, 0, -1), insertion=0.01, speed=0.2, travel=0.012)  # fmt: skip
    march = march_of(
        rod(wrapped(turns), r, root=CLAMPED), tines=[tine], contact=Contact(self_contact=True),
        friction=Friction(forward=0.3, backward=0.3), drag=20, viscous=1e-5,
        gravity=None,  # the effects of a combing with friction: no march of its own to compile
    )  # fmt: skip
    before = winding(march)
    seen = watch(march, tine.duration)
    assert np.linalg.norm(from_axis(march), axis=1).min() > 0.5 * 3 * r
    assert winding(march) > before - 0.5
    show(f"tine wrapped {turns} times, mu = 0.3", f"{seen}, {winding(march):.2f} turns left")


def test_combing_at_3_elements_per_pitch_pi1_18_with_3_turns_to_the_end():
    """The coarsest mesh that the preset takes: stable, whatever its force is worth."""
    scene = sim.double_helix(pi1=18, turns=3, elements_per_pitch=3)
    march = Explicit(scene)
    seen = watch(march, scene.duration, looks=300, tracked=False)
    assert march.tine_travel()[0] == pytest.approx(scene.tines[0].travel, rel=1e-3)
    show("combing with 3 elements per pitch, pi1 = 18", seen)


@pytest.mark.slow
def test_combing_at_pi1_14_with_mu_0p3_of_6_pitches_to_the_end():
    """The strongest jam of the study with friction: pulled through and released at tens of m/s."""
    scene = sim.double_helix(pi1=14, friction=0.3, turns=6)
    march = Explicit(scene)
    seen = watch(march, scene.duration, looks=3000)  # the release takes 0.1 ms
    assert march.tine_travel()[0] == pytest.approx(scene.tines[0].travel, rel=1e-3)
    assert seen.closest > 0.7
    show("combing at pi1 = 14, mu = 0.3, 6 pitches", seen)
