"""Strands that hang and come to rest on each other: two cases measured on other solvers too.

Silicone of 10 MPa, 0.3 m long, drag 10 1/s, gravity, as in the comparison of solvers.
"""

import math

import numpy as np
import pytest
from scipy.integrate import solve_bvp

from sim.march.state import rigidities
from sim.scene import Material
from sim.scene.shapes import helix
from sim.topology import link_density

from .hard import CLAMPED, largest_speed, line, march_of, rod, show, watch

SILICONE = Material(E=1e7, nu=0.5, density=1200)
G, LENGTH = 9.81, 0.3


def weight(r):
    """Return the weight per length [N/m]."""
    return SILICONE.density * math.pi * r**2 * G


def cantilever(r=5e-3):
    """Return a rod along +y, clamped 12 mm above and 75 mm beyond the x axis' middle."""
    nodes = line([0.5 * LENGTH, -0.25 * LENGTH, 0.012], [0, 1, 0], LENGTH, 50)
    return rod(nodes, r, SILICONE, root=CLAMPED)


def elastica_tip(r=5e-3):
    """Return how far the tip of the heavy elastica reaches out and down."""
    bend, _ = rigidities(SILICONE, r)

    # B theta'' = -w (L - s) cos(theta), theta(0) = 0, theta'(L) = 0.
    def slope(s, y):
        return np.vstack([y[1], -weight(r) * (LENGTH - s) * np.cos(y[0]) / bend])

    s = np.linspace(0, LENGTH, 2001)
    guess = np.vstack([np.linspace(0, 1.2, s.size), np.ones(s.size)])
    angle = solve_bvp(slope, lambda a, b: [a[0], b[1]], s, guess).sol(s)[0]
    return np.trapezoid(np.cos(angle), s), np.trapezoid(np.sin(angle), s)


def test_cantilever_of_the_bridge_alone_hangs_as_the_heavy_elastica():
    """Without the rod below: the tip within 0.2 % of the length of a shooting solution."""
    march = march_of(cantilever(), gravity=(0, 0, -G), drag=10)
    seen = watch(march, 1.5)
    tip = march.state.strands()[0][-1] - [0.15, -0.225, 0.012]
    out, down = elastica_tip()
    np.testing.assert_allclose(tip, [0, out, -down], atol=2e-3 * LENGTH)
    show("cantilever of 0.3 m under its weight", f"{seen}, tip {tip[2] / -down:.4f} of theory")


def test_bridge_rod_that_rests_on_another_settles_below_1e_4_m_per_s_in_2_s():
    """It sags onto a bridge and rests; the solver compared with never falls below 0.1 m/s."""
    nodes = line([0.5 * LENGTH, 0, 0], [1, 0, 0], LENGTH, 50)
    below = rod(nodes, 5e-3, SILICONE, root=CLAMPED, tip=CLAMPED)
    march = march_of(below, cantilever(), gravity=(0, 0, -G), drag=10)
    seen = watch(march, 2.0, looks=100)
    assert largest_speed(march) < 1e-4
    assert march.state.strands()[1][-1, 2] > -0.02  # borne up: alone it hangs at -0.14
    show("rod resting on a bridge for 2 s", f"{seen}, speed {largest_speed(march):.1e} m/s")


def test_hanging_double_helix_of_4_turns_keeps_its_link_for_half_a_second():
    """Two strands at 1.05 r, 4 turns: their link stays and they sink less than two lone helices.

    A lone helix sinks by R^2 (cos^2 a/C + sin^2 a/B) w L^2/2, and any strand at least stretches by
    w L^2/2 E A; in contact they cannot shrink onto the axis.
    """
    r, turns = 1.5e-3, 4
    radius = 1.05 * r
    height = math.sqrt(LENGTH**2 - (2 * math.pi * radius * turns) ** 2)
    march = march_of(
        *(
            rod(helix(radius, height / turns, height, 100, phase), r, SILICONE, root=CLAMPED)
            for phase in (0, math.pi)
        ),
        gravity=(0, 0, -G),
        drag=10,
    )
    before = np.array([x[-1] for x in march.state.strands()])
    seen = watch(march, 0.5, looks=10)
    strands = march.state.strands()
    link = link_density(*strands).attrs["total_link"]
    sunk = before[:, 2] - [x[-1, 2] for x in strands]
    bend, twist = rigidities(SILICONE, r)
    steep = height / LENGTH
    lone = radius**2 * ((1 - steep**2) / twist + steep**2 / bend) * weight(r) * LENGTH**2 / 2
    stretch = weight(r) * LENGTH**2 / (2 * SILICONE.E * math.pi * r**2)
    assert link == pytest.approx(turns, rel=0.01)
    assert ((stretch < sunk) & (sunk < lone + stretch)).all()
    assert largest_speed(march) < 0.01
    show("hanging double helix of 4 turns, 0.5 s", f"{seen}, link {link:.3f}")
