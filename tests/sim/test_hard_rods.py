"""Single rods where the rod is hard: sharp turns, extreme slenderness, odd meshes, long runs."""

import math

import numpy as np
import pytest
from scipy.optimize import brentq
from scipy.spatial.transform import Rotation
from scipy.special import ellipk

from sim.energy import elastic_energy
from sim.march.state import rigidities
from sim.scene import End, Load, Material, Motion
from sim.scene.shapes import helix

from .hard import (
    CLAMPED,
    PINNED,
    SOFT,
    energies,
    line,
    march_of,
    rod,
    show,
    watch,
)

R = 5e-3


def turn_element(march, element, vector):
    """Turn one element of the first rod by a rotation vector in its own frame [rad]."""
    state, i = march.state, march.state.first[0] + element
    q = np.array([[state.row(f"Q{a}{b}")[i] for b in range(3)] for a in range(3)])
    q = Rotation.from_rotvec(-np.asarray(vector)).as_matrix() @ q
    for a in range(3):
        for b in range(3):
            state.row(f"Q{a}{b}")[i] = q[a, b]


@pytest.mark.parametrize("axis", ["d1", "d3"])
def test_an_element_turned_by_175_degrees_against_its_neighbours_comes_back(axis):
    """Released undamped: all the energy of the turn stays in the rod.

    About d1 the turn shears the element by 200 % as well; such a rod whirls on past half a turn
    after some 2 ms, so only its first swings are watched.
    """
    march = march_of(rod(line([0, 0, 0], [1, 0, 0], 0.15, 10), R), safety=0.1)
    turn_element(march, 5, math.radians(175) * np.eye(3)[0 if axis == "d1" else 2])
    start = elastic_energy(march.state)
    seen = watch(march, 1e-3 if axis == "d1" else 0.03, looks=200)
    assert energies(march).sum() == pytest.approx(start, rel=0.02)
    show(f"element turned by 175 degrees about {axis}", seen)


def test_rod_folded_by_175_degrees_at_one_node_springs_open():
    """Straight at rest: the fold's energy B theta^2/2D becomes motion, no more; then it rests."""
    fold = math.radians(175)
    arm = np.linspace(0, 0.1, 9)[1:, None]
    folded = arm * [math.cos(fold), 0, math.sin(fold)]
    nodes = np.vstack([-arm[::-1] * [1, 0, 0], np.zeros((1, 3)), folded])
    march = march_of(rod(nodes, R, rest="straight"), drag=20)
    start = elastic_energy(march.state)
    bend, _ = rigidities(SOFT, R)
    assert start == pytest.approx(0.5 * bend * fold**2 / 0.0125, rel=1e-6)
    seen = watch(march, 0.8, looks=200)
    ends = march.state.strands()[0]
    assert np.linalg.norm(ends[-1] - ends[0]) == pytest.approx(0.2, rel=1e-3)
    assert energies(march).sum() < 1e-3 * start
    show("rod folded by 175 degrees at a node", seen)


def test_curved_rod_of_300_degrees_released_straightens():
    """Drawn as an arc, straight at rest: it ends straight, at its length, without energy."""
    angle = np.linspace(0, math.radians(300), 31)
    radius = 0.06
    arc = np.column_stack([radius * np.sin(angle), 0 * angle, radius * (1 - np.cos(angle))])
    march = march_of(rod(arc, R / 2, rest="straight"), drag=20)
    start = elastic_energy(march.state)
    bend, _ = rigidities(SOFT, R / 2)
    length = np.linalg.norm(np.diff(arc, axis=0), axis=1).sum()
    assert start == pytest.approx(0.5 * bend * length / radius**2, rel=0.05)
    seen = watch(march, 1.5, looks=200)
    nodes = march.state.strands()[0]
    assert np.linalg.norm(nodes[-1] - nodes[0]) == pytest.approx(length, rel=1e-3)
    assert energies(march).sum() < 1e-3 * start
    show("arc of 300 degrees, straight at rest, released", seen)


def test_rod_curved_by_nature_released_straight_becomes_its_arc():
    """Started straight with a rest curvature of 270 degrees in all: ends on that circle."""
    length, n, turn = 0.3, 30, math.radians(270)
    march = march_of(rod(line([0, 0, 0], [1, 0, 0], length, n), R / 2), drag=15)
    inner = march.state.row("INV_VORONOI")[march.state.nodes(0)] > 0
    march.state.row("K0")[march.state.nodes(0)] = np.where(inner, turn / length, 0.0)
    start = elastic_energy(march.state)
    seen = watch(march, 3.0, looks=100)
    nodes = march.state.strands()[0]
    # n chords of equal length, each turned by turn/n against the one before.
    chord = length / n * math.sin(turn / 2) / math.sin(turn / (2 * n))
    assert np.linalg.norm(nodes[-1] - nodes[0]) == pytest.approx(chord, rel=0.01)
    assert energies(march).sum() < 1e-3 * start
    show("rest curvature of 270 degrees, released straight", seen)


def test_suture_of_0p2_mm_by_10_cm_and_750_MPa_moved_at_one_node():
    """Its pinned end is led 2.5 mm sideways: there exactly, nowhere stretched by more than 1 %."""
    suture = Material(E=750e6, nu=0.4, density=1100)
    led = End(hold="pinned", motion=Motion(velocity=(0, 0.1, 0), ramp=5e-3, duration=0.03))
    march = march_of(
        rod(line([0.05, 0, 0], [1, 0, 0], 0.1, 25), 1e-4, suture, root=led), gravity=(0, 0, -9.81),
    )  # fmt: skip
    seen = watch(march, 0.04, looks=50)
    nodes = march.state.strands()[0]
    np.testing.assert_allclose(nodes[0], [0, 0.1 * 0.025, 0], atol=1e-9)
    stretch = np.linalg.norm(np.diff(nodes, axis=0), axis=1) / (0.1 / 25)
    assert np.abs(stretch - 1).max() < 0.01
    show("suture 0.2 mm x 10 cm, 750 MPa, moved at a node", seen)


def test_helix_of_6_turns_under_its_own_weight_sags_as_a_spring():
    """Under a weight w per length the end sinks by R^2 (cos^2 a/C + sin^2 a/B) w L^2/2.

    The moment F R of an axial force F = w (L - s) has the parts F R cos a about the wire and
    F R sin a across it (Love 1944, sec. 271); a is the angle to the plane normal to the axis.
    """
    radius, pitch, turns, r, g = 0.02, 0.015, 6, 2e-3, 0.01
    nodes = helix(radius, pitch, turns * pitch, 16 * turns)
    march = march_of(
        rod(nodes, r, root=CLAMPED), gravity=(0, 0, -g), drag=5, rotary_inertia="element"
    )
    tip = nodes[-1, 2]
    seen = watch(march, 6.0, looks=50)
    sag = tip - march.state.strands()[0][-1, 2]
    bend, twist = rigidities(SOFT, r)
    length, slope = (
        turns * math.hypot(2 * math.pi * radius, pitch),
        math.atan2(pitch, 2 * math.pi * radius),
    )
    weight = SOFT.density * math.pi * r**2 * g
    compliance = math.cos(slope) ** 2 / twist + math.sin(slope) ** 2 / bend
    expected = radius**2 * compliance * weight * length**2 / 2
    assert sag == pytest.approx(expected, rel=0.1)
    show("helix of 6 turns under its own weight", f"{seen}, sag {sag / expected:.3f} of theory")


def test_rod_of_1e4_slenderness_between_pins_hangs_as_a_catenary():
    """L/r = 10^4 between pins 0.8 L apart: the sag of an inextensible chain."""
    length, r = 0.5, 5e-5
    thread = Material(E=1e7, nu=0.4, density=1000)
    span = 0.8 * length
    half = 0.5 * span
    depth = math.sqrt((0.5 * length) ** 2 - half**2)
    x = np.linspace(-half, half, 41)
    start = np.column_stack([x, 0 * x, -depth * (1 - np.abs(x) / half)])
    march = march_of(
        rod(start, r, thread, root=PINNED, tip=PINNED, rest="straight"), gravity=(0, 0, -9.81),
        drag=8, rotary_inertia="element",
    )  # fmt: skip
    seen = watch(march, 2.0, looks=100)
    a = brentq(lambda a: 2 * a * math.sinh(half / a) - length, 0.05, 10)
    sag = -march.state.strands()[0][:, 2].min()
    assert sag == pytest.approx(a * (math.cosh(half / a) - 1), rel=5e-3)
    show(
        "L/r = 10^4, hung between pins", f"{seen}, sag {sag / (a * (math.cosh(half / a) - 1)):.4f}"
    )


def swing(march, amplitude):
    """Return the exact period of the discrete, stiff pendulum [s]."""
    state = march.state
    at = state.nodes(0)
    mass, x = state.row("MASS")[at], np.linalg.norm(state.strands()[0], axis=1)
    inverse = state.row("INV_J1")[at][:-1]
    inertia = np.sum(mass * x**2) + np.sum(1 / inverse)
    stiffness = 9.81 * np.sum(mass * x)
    return 4 * math.sqrt(inertia / stiffness) * ellipk(math.sin(amplitude / 2) ** 2)


def test_heavy_pendulum_for_100_swings_of_60_degrees():
    """Energy keeps within 0.1 % of what swings, and the 100th swing ends on time."""
    amplitude = math.radians(60)
    direction = [math.sin(amplitude), 0, -math.cos(amplitude)]
    nodes = line(0.1 * np.array(direction), direction, 0.2, 5)
    stiff = Material(E=1e7, nu=0.5, density=1000)
    march = march_of(rod(nodes, 0.01, stiff, root=PINNED), gravity=(0, 0, -9.81))
    period = swing(march, amplitude)
    books, tips = [energies(march).sum()], []
    for _ in range(500):
        march.advance(round(100 * period / 500 / march.dt))
        books.append(energies(march).sum())
        tips.append([march.time, *march.state.strands()[0][-1, [0, 2]]])
    t, x, z = np.array(tips).T
    angle = np.unwrap(np.arctan2(x, -z))
    down = np.flatnonzero((angle[:-1] > 0) & (angle[1:] <= 0))
    crossing = t[down] + angle[down] / (angle[down] - angle[down + 1]) * (t[1] - t[0])
    found = np.diff(crossing).mean()
    assert len(crossing) >= 99
    assert found == pytest.approx(period, rel=2e-3)
    swung = march.state.row("MASS").sum() * 9.81 * 0.1 * (1 - math.cos(amplitude))
    drift = np.abs(np.array(books) - books[0]).max() / swung
    assert drift < 1e-3
    show("heavy pendulum, 100 swings", f"energy within {drift:.1e}, period {found / period:.5f}")


@pytest.mark.parametrize("short", [1e-2, 1e-3])
def test_element_of_a_fraction_of_its_neighbours_length_leaves_the_cantilever_as_it_was(short):
    """The step shrinks with the element; the tip falls as with an even mesh."""

    def tip(nodes):
        march = march_of(rod(nodes, R, root=CLAMPED), gravity=(0, 0, -0.1), drag=20)
        seen = watch(march, 0.4)
        return march.state.strands()[0][-1, 2], seen

    even = line([0.1, 0, 0], [1, 0, 0], 0.2, 8)
    odd = np.insert(even, 4, even[3] + [short * 0.025, 0, 0], axis=0)
    (fall, seen), (reference, _) = tip(odd), tip(even)
    assert fall == pytest.approx(reference, rel=0.01)
    show(f"an element of {short:g} times its neighbours' length", seen)


def test_rod_stretched_by_50_percent_under_a_dead_load_holds_its_linear_law():
    """E A/2 on the tip stretches it by half: strain is per rest length and linear at any size."""
    pull = 0.5 * SOFT.E * math.pi * R**2
    tip = End(load=Load(force=(pull, 0, 0), ramp=0.02))
    march = march_of(rod(line([0.1, 0, 0], [1, 0, 0], 0.2, 10), R, root=CLAMPED, tip=tip), drag=150)
    seen = watch(march, 0.2)
    assert march.state.strands()[0][-1, 0] == pytest.approx(0.3, rel=1e-3)
    show("stretched by 50 % under a load", seen)


def test_rod_let_go_after_a_stretch_of_50_percent_keeps_its_energy():
    """Undamped: E A/2 (1/2)^2 L and no more, half a wave of it kinetic after L/c."""
    march = march_of(rod(line([0.1, 0, 0], [1, 0, 0], 0.2, 10), R), safety=0.4)
    march.state.row("X0")[march.state.nodes(0)] *= 1.5
    start = elastic_energy(march.state)
    assert start == pytest.approx(0.125 * SOFT.E * math.pi * R**2 * 0.2, rel=1e-9)
    seen = watch(march, 0.1, looks=200)
    assert energies(march).sum() == pytest.approx(start, rel=0.03)
    show("let go after a stretch of 50 %", seen)
