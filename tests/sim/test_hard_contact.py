"""Strands in contact where contact is hard: parallel, overlapping, crushed, of unlike size.

What `watch` asserts in each is said there; the numbers compared with are closed forms of the
contact potential, U = integral k/2 (reach - d)^2 ds.
"""

import math

import numpy as np
import pytest
from scipy.optimize import brentq

from sim.energy import kinetic_energy
from sim.march.effects import SOFTNESS
from sim.scene import Contact, Material
from sim.scene.presets import NYLON_SCALED, material_time

from .hard import (
    SOFT,
    contact_potential,
    energies,
    line,
    march_of,
    momentum,
    rod,
    show,
    watch,
)

R, L = 5e-3, 0.3
K = SOFTNESS * SOFT.E
LINE_DENSITY = SOFT.density * math.pi * R**2
NEARLY_PARALLEL = pytest.mark.parametrize(
    "angle", [0, 1e-6, 1e-3, math.radians(1)], ids=["0_rad", "1e-6_rad", "1e-3_rad", "1_degree"]
)


def two_strands(angle, gap, *, elements=(20, 17), length=L):
    """Return free strands of unlike meshes, the second `gap` above the first and turned."""
    lower = line([0, 0, 0], [1, 0, 0], length, elements[0])
    upper = line([0, 0, gap], [math.cos(angle), math.sin(angle), 0], length, elements[1])
    return march_of(rod(lower, R), rod(upper, R), contact=Contact(overlap="push apart"))


@NEARLY_PARALLEL
def test_strands_parallel_within_an_angle_bounce_at_1_m_per_s(angle):
    """Strings of springs: the overlap reaches v sqrt(rho A/2k), and the momentum changes over."""
    march = two_strands(angle, 2.02 * R)
    march.state.row("V2")[march.state.nodes(1)] = -1.0
    before, energy = momentum(march), kinetic_energy(march.state)
    seen = watch(march, 3e-3, looks=60)
    overlap = math.sqrt(LINE_DENSITY / (2 * K)) / (2 * R)
    assert 1 - seen.closest == pytest.approx(overlap, rel=0.1)
    assert np.linalg.norm(momentum(march) - before) < 1e-10 * np.linalg.norm(before)
    assert contact_potential(march) == 0
    assert energies(march).sum() == pytest.approx(energy, rel=0.02)
    show(f"strands parallel within {angle:.1e} rad, thrown at 1 m/s", seen)


@pytest.mark.parametrize("degrees", [0, 1, 90])
def test_strands_that_start_with_20_percent_overlap_are_pushed_apart(degrees):
    """All of the potential at the start is energy of motion and bending at the end, no more.

    Parallel ones part at the speed delta sqrt(k/2 rho A) each.
    """
    march = two_strands(math.radians(degrees), 0.8 * 2 * R)
    start = contact_potential(march)
    seen = watch(march, 6e-3, looks=60)
    assert contact_potential(march) == 0
    assert seen.closest == pytest.approx(0.8, abs=0.01)
    assert energies(march).sum() == pytest.approx(start, rel=0.03)
    if degrees == 0:
        parting = 0.2 * 2 * R * math.sqrt(K / (2 * LINE_DENSITY))
        middle = march.state.row("V2")[march.state.nodes(1)][5:-5].mean()
        assert middle == pytest.approx(parting, rel=0.1)
    show(f"20 % overlap at the start, strands at {degrees} degrees", seen)


@pytest.mark.parametrize("offset", [0.0, 1e-12, 1e-3])
def test_centrelines_that_cross_exactly_or_within_an_offset_of_r(offset):
    """0/0 in a solver that normalises the gap; here a force of no direction is no force.

    Exactly on top of each other strands stay, as an unstable balance does; beside it they part,
    with the energy that their overlap held, U = integral k/2 (2r - |s|)^2 ds = 8 k r^3/3.
    """
    march = two_strands(math.pi / 2, offset * R)
    start = contact_potential(march)
    assert start == pytest.approx(8 * K * R**3 / 3, rel=0.01)
    seen = watch(march, 0.01, looks=100, separate=-1)
    assert energies(march).sum() < 1.02 * start
    if offset > 0:
        assert contact_potential(march) < 0.01 * start
    show(f"centrelines crossing within {offset:g} r", seen)


def crossed(gap, r, k):
    """Return the force between straight strands that cross at right angles `gap` apart [N]."""
    half = math.sqrt((2 * r) ** 2 - gap**2)
    s = np.linspace(-half, half, 20001)
    d = np.sqrt(gap**2 + s**2)
    return np.trapezoid(k * (2 * r - d) * gap / d, s)


@pytest.mark.parametrize("times", [1, 100])
def test_a_strand_pressed_with_a_multiple_of_the_typical_force_on_a_crossing(times):
    """Typical is 0.03 N, what a tine's mean 0.3 N leaves for each of ten crossings of the preset.

    A short strand lies across a held one under an even load. The gap follows from the integral of
    the straight crossing; bending widens the contact by some 8 % at 100 times the load.
    """
    nylon, r = Material(E=NYLON_SCALED, nu=0.4, density=1140), 4.25e-4
    force, k = 0.03 * times, SOFTNESS * NYLON_SCALED
    gap = brentq(lambda gap: crossed(gap, r, k) - force, r, 2 * r * (1 - 1e-9))
    lower = line([0, 0, 0], [1, 0, 0], 6 * r, 6)
    upper = line([0, 0, gap], [0, 1, 0], 6 * r, 8)
    mass = nylon.density * math.pi * r**2 * 6 * r
    march = march_of(
        rod(lower, r, nylon), rod(upper, r, nylon), gravity=(0, 0, -force / mass), drag=2e5,
        contact=Contact(overlap="push apart"),
        viscous=material_time(r, nylon.E, nylon.density),
    )  # fmt: skip
    march.state.row("INV_MASS")[march.state.nodes(0)] = 0
    march.state.row("INV_J1")[march.state.nodes(0)] = 0
    march.state.row("INV_J3")[march.state.nodes(0)] = 0
    seen = watch(march, 2e-4)  # long enough to settle, too short to tip over
    found = march.state.row("X2")[march.state.nodes(1)][4]
    assert (2 * r - found) / (2 * r - gap) == pytest.approx(1, abs=0.12)
    overlap = f"overlap {1 - found / (2 * r):.3f} of touching, theory {1 - gap / (2 * r):.3f}"
    show(f"pressed with {times} times the typical force", f"{seen}, {overlap}")


@pytest.mark.parametrize("thin_first", [False, True])
def test_rods_of_10_to_1_radius_contrast_collide(thin_first):
    """The thin one is thrown at the thick one and comes back, momentum and energy kept."""
    thick = rod(line([0, 0, 0], [1, 0, 0], 0.15, 10), R)
    thin = rod(line([0, 0, 1.15 * R], [0.3, 1, 0], 1.6 * R, 8), R / 10)
    march = march_of(*((thin, thick) if thin_first else (thick, thin)))
    number = 0 if thin_first else 1
    at = march.state.nodes(number)
    march.state.row("V2")[at] = -0.5
    before, energy = momentum(march), kinetic_energy(march.state)
    seen = watch(march, 4e-3, looks=60)
    assert march.state.row("V2")[at].mean() > 0
    assert np.linalg.norm(momentum(march) - before) < 1e-10 * np.linalg.norm(before)
    assert energies(march).sum() == pytest.approx(energy, rel=0.02)
    show("radii 10:1, thrown at 0.5 m/s", seen)
