"""Contact does not feel the mesh: gradient of its energy, no washboard, whole caps."""

import numpy as np
import pytest
from scipy.integrate import quad

from sim.explicit import Explicit
from sim.kernels.ledger import contact_energy, tine_energy
from sim.kernels.touch import touching_loads
from sim.scene import (
    Contact,
    Damping,
    End,
    Material,
    Points,
    Rod,
    Scene,
    Straight,
    Tine,
)

RUBBER = Material(E=1e6, nu=0.5, density=1000)
R = 0.005


def bent(rng, middle, direction, elements=7):
    """Return a rod with elements of unlike lengths that bends by some tenths of a radian a node."""
    along = np.linspace(-0.5, 0.5, elements + 1)[:, None] * 0.1 * np.array(direction)
    nodes = middle + along + rng.normal(0, 1e-3, (elements + 1, 3))
    return Rod(shape=Points(nodes=[tuple(map(float, p)) for p in nodes]), radius=R, elements=2,
               material=RUBBER, root=End(hold="free"))  # fmt: skip


def touching(march):
    """Return the forces of all that touches on nodes and on flex, (6, n) [N]."""
    state = march.state
    for name in ["F0", "F1", "F2"]:
        state.row(name)[:] = 0
    touching_loads(state.buf, state.n, 1.0, march.dt, march.contact, None, march.tines, None)
    return state.rows("F0 F1 F2 P0 P1 P2")


def energy(march):
    buf, n = march.state.buf, march.state.n
    return contact_energy(buf, n, march.contact) + tine_energy(buf, n, march.tines)


def test_forces_on_every_node_and_flex_are_the_slope_of_the_energy(rng):
    """Two bent rods across each other at odd places, and a tine under both."""
    tine = Tine(position=(0.011, 0, -0.0083), axis=(0.3, 1, 0.1), length=0.2, radius=0.004,
                insertion=0)  # fmt: skip
    rods = [bent(rng, (0.0, 0.0, 0.0), (1, 0.2, 0)), bent(rng, (0.003, 0.0, 0.0085), (0.5, 1, 0))]
    march = Explicit(Scene(rods=rods, duration=1, contact=Contact(), tines=[tine]))
    for name in ["Y0", "Y1", "Y2"]:
        march.state.row(name)[:] = rng.normal(0, 2e-4, march.state.n)
    force, h = touching(march), 1e-7
    assert np.abs(force[:3]).max() > 1e-3
    assert np.abs(force[3:]).max() > 1e-4
    for k, name in enumerate(["X0", "X1", "X2", "Y0", "Y1", "Y2"]):
        for i in range(1, march.state.n - 1):
            row = march.state.row(name)
            kept = row[i]
            row[i] = kept + h
            above = energy(march)
            row[i] = kept - h
            slope = (above - energy(march)) / (2 * h)
            row[i] = kept
            assert force[k, i] == pytest.approx(-slope, abs=5e-3 * np.abs(force).max())


def hung(elements):
    """Two soft ropes at right angles, the upper one let down onto the lower: where do they go?

    As in the experiment `crossing` of cosseratbench (Saxena, 2026), smaller.
    """

    x = np.linspace(-0.5, 0.5, elements + 1)
    rods = [
        Rod(shape=Points(nodes=[tuple(map(float, p)) for p in 0.4 * x[:, None] * along + down]),
            radius=R, elements=2, material=RUBBER, rest="straight", root=End(hold="pinned"),
            tip=End(hold="pinned"))
        for along, down in (
            (np.array([1, 0, 0]), np.column_stack([0 * x, 0 * x, -0.055 * np.cos(np.pi * x)])),
            # Hung so that its middle would fall by 0.06 m, were it not for the other.
            (np.array([0, 1, 0]), np.column_stack([0 * x, 0 * x, -0.04 - 0.03 * np.sin(2 * np.pi * x) ** 2])),
        )
    ]  # fmt: skip
    scene = Scene(rods=rods, duration=1, contact=Contact(), gravity=(0, 0, -9.81),
                  damping=Damping(drag=12.0, material=1e-4), rotary_inertia="element")  # fmt: skip
    march = Explicit(scene)
    march.advance(round(1.5 / march.dt))
    return march


@pytest.mark.parametrize("elements", [20, 21, 40, 41])
def test_crossing_ropes_stay_in_their_planes_wherever_in_an_element_they_touch(elements):
    """After a push of 0.01 mm; a chain of chords slides by 0.18 of an element from odd meshes."""
    march = hung(elements)
    state = march.state
    shape = 1e-5 * np.cos(np.pi * np.linspace(-0.5, 0.5, elements + 1))
    state.row("X1")[state.nodes(0)] += shape
    state.row("X0")[state.nodes(1)] += shape
    march.advance(round(3.0 / march.dt))
    lower, upper = state.strands()
    tolerance = max(1e-3 * 0.4 / elements, 1e-6)
    assert np.abs(touching(march)[:3]).max() > 0.05  # they do bear on each other
    assert np.abs(lower[:, 1]).max() < tolerance
    assert np.abs(upper[:, 0]).max() < tolerance


@pytest.mark.parametrize("gap", [1.7, 1.9])
def test_the_round_cap_at_a_tip_is_integrated_in_full(gap):
    """Flank of one rod against the tip of another: k times the integral of the overlap of two."""
    first = Rod(shape=Straight(root=(-0.05, 0, 0), direction=(1, 0, 0), length=0.1), radius=R,
                elements=11, material=RUBBER, root=End(hold="free"))  # fmt: skip
    second = Rod(shape=Straight(root=(0, 0, gap * R), direction=(0, 0, 1), length=0.1), radius=R,
                 elements=10, material=RUBBER, root=End(hold="free"))  # fmt: skip
    march = Explicit(Scene(rods=[first, second], duration=1, contact=Contact(stiffness=1e5)))
    force = touching(march)[:3]
    g, edge = gap * R, np.sqrt(4 - gap**2) * R
    expected = quad(lambda x: (2 * R / np.hypot(x, g) - 1) * g, -edge, edge)[0] * 1e5
    assert force[:, march.state.nodes(1)].sum(axis=1)[2] == pytest.approx(expected, rel=3e-3)
    np.testing.assert_allclose(force.sum(axis=1), 0, atol=1e-12)
