"""Rods under loads and prescribed ends against the closed forms of mechanics."""

import math

import numpy as np
import pytest
from scipy.optimize import brentq
from scipy.special import ellipe, ellipk

from sim.explicit import Explicit
from sim.march.effects import SOFTNESS
from sim.march.state import rigidities
from sim.scene import (
    Damping,
    End,
    Friction,
    Load,
    Material,
    Motion,
    Points,
    Rod,
    Scene,
    Straight,
    Tine,
)
from sim.scene.shapes import curvature, frames

RUBBER = Material(E=1e6, nu=0.5, density=1000)


def relaxed(scene, seconds):
    """March a scene for a time and return the march."""
    march = Explicit(scene)
    march.advance(int(seconds / march.dt))
    return march


def tip_of(march):
    return march.state.strands()[0][-1]


@pytest.mark.parametrize(("alpha", "key"), [(4 / 3, "4_3"), (27 / 28, "27_28")])
def test_timoshenko_cantilever_under_an_end_load(reference, alpha, key):
    """A hundredth of the reference's load, where large deflections change nothing: 1e-5."""
    case = reference("rods")["timoshenko_cantilever"]
    material = Material(E=case["E"], G=case["G"], density=5000, shear_coefficient=alpha)
    load = Load(force=(0, 0, -0.01 * case["F"]))
    errors = []
    for n in (8, 16):
        rod = Rod(shape=Straight(direction=(1, 0, 0), length=case["L"]), radius=case["r"],
                  elements=n, material=material, tip=End(load=load))  # fmt: skip
        tip = tip_of(relaxed(Scene(rods=[rod], duration=1, damping=Damping(drag=1.5)), 150))[2]
        errors.append(abs(100 * tip / case[f"tip_y_alpha_c_{key}"] - 1))
    assert errors[1] < 1.5e-3
    assert errors[0] / errors[1] == pytest.approx(4, rel=0.15)


def elastica_tip(ratio):
    """Return how far (sideways, along) the tip of a buckled cantilever of length 1 is.

    With P over Euler's load = (2 K/pi)^2, K of modulus k = sin(tip angle/2): 2k/K and 2E/K - 1
    (Love, Treatise on Elasticity, art. 262-263).
    """
    k = brentq(lambda k: (2 * ellipk(k * k) / math.pi) ** 2 - ratio, 1e-6, 0.999)
    return 2 * k / ellipk(k * k), 2 * ellipe(k * k) / ellipk(k * k) - 1


@pytest.mark.parametrize("ratio", [0.95, 1.1, 1.5])
def test_euler_strut_buckles_at_its_load_and_follows_the_elastica(ratio):
    length, radius = 0.5, 0.005
    bend, _ = rigidities(RUBBER, radius)
    load = ratio * math.pi**2 * bend / (4 * length**2)
    rod = Rod(shape=Straight(length=length), radius=radius, elements=32, material=RUBBER,
              tip=End(load=Load(force=(0, 0, load))))  # fmt: skip
    scene = Scene(rods=[rod], duration=1, damping=Damping(drag=1), rotary_inertia="element")
    march = Explicit(scene)
    march.state.row("V0")[march.state.nodes(0)] = 0.02 * np.linspace(0, 1, 33)
    march.advance(int(200 / march.dt))
    sideways, along = abs(tip_of(march)[0]) / length, -tip_of(march)[2] / length
    if ratio < 1:
        assert sideways < 1e-3
        return
    exact = elastica_tip(ratio)
    assert sideways == pytest.approx(exact[0], rel=6e-3)
    assert along == pytest.approx(exact[1], abs=4e-3)


def test_twist_waves_run_at_their_speed():
    """omega_n = (n - 1/2) pi c/L, c = sqrt(G/rho) of a round rod, n = 2."""
    length, n = 0.3, 2
    rod = Rod(shape=Straight(length=length), radius=0.005, elements=60, material=RUBBER)
    march = Explicit(Scene(rods=[rod], duration=1))
    wave = (n - 0.5) * math.pi / length
    omega = wave * math.sqrt(RUBBER.shear_modulus / RUBBER.density)
    at = march.state.nodes(0)
    middles = (np.arange(60) + 0.5) * length / 60
    spin = march.state.row("W2")[at.start : at.stop - 1]
    spin[:] = 0.1 * np.sin(wave * middles)
    shape, seen = spin.copy(), []
    steps = int(0.02 * 2 * math.pi / omega / march.dt)
    for _ in range(150):
        march.advance(steps)
        seen.append(spin @ shape)
    seen = np.array(seen)
    times = march.dt * steps * np.arange(1, 151)
    rises = np.flatnonzero(np.diff(np.sign(seen)))
    zeros = times[rises] - seen[rises] * np.diff(times)[rises] / np.diff(seen)[rises]
    assert math.pi / np.mean(np.diff(zeros)) == pytest.approx(omega, rel=1e-3)


def ring(n, twist):
    """Return a straight rod of length 2 pi bent into a ring, both ends in one clamp, twisted.

    Holding one section of a closed ring takes only its motion as a whole away.
    """
    material = Material(E=4 / math.pi / 0.02**4, nu=0.5, density=1 / (math.pi * 0.02**2))
    angle = np.linspace(0, 2 * math.pi, n + 1)
    nodes = np.column_stack([np.cos(angle), np.sin(angle), 0 * angle])
    rod = Rod(shape=Points(nodes=[tuple(p) for p in nodes]), radius=0.02, elements=n,
              rest="straight", material=material, tip=End(hold="clamped"))  # fmt: skip
    march = Explicit(
        Scene(rods=[rod], duration=1, damping=Damping(drag=0.3), rotary_inertia="element")
    )
    at = march.state.nodes(0)
    middle = np.arange(n) + 0.5
    for i, share in [*zip(range(at.start, at.stop - 1), middle / n, strict=True),
                     (at.start - 1, 0.0), (at.stop - 1, 1.0)]:  # fmt: skip
        set_frame(march.state, i, share, twist)
    march.state.row("V2")[at] = 1e-3 * np.sin(2 * angle)  # Michell's mode
    return march


def set_frame(state, i, share, twist):
    """Set the frame at a fraction of the ring: d3 along it, d1 turned by its part of the twist."""
    angle, turn = 2 * math.pi * share, twist * share
    outward = np.array([math.cos(angle), math.sin(angle), 0])
    along = np.array([-math.sin(angle), math.cos(angle), 0])
    first = math.cos(turn) * outward + math.sin(turn) * np.cross(along, outward)
    for a, d in enumerate((first, np.cross(along, first), along)):
        for k in range(3):
            state.row(f"Q{a}{k}")[i] = d[k]


@pytest.mark.parametrize(("excess", "buckles"), [(0.95, False), (1.05, True)])
def test_michell_ring_writhes_beyond_its_critical_twist(reference, excess, buckles):
    """Total twist 2 sqrt(3) pi B/C; C/B = 2/3 for nu = 1/2."""
    critical = reference("rods")["michell_ring_critical_twist"]["C_over_B_2_3"]
    march = ring(60, excess * critical)
    height = []
    for _ in range(80):
        march.advance(int(2 / march.dt))
        height.append(np.abs(march.state.row("X2")[march.state.nodes(0)]).max())
    assert height[0] < 0.02
    assert (max(height) > 0.3) == buckles


@pytest.mark.parametrize("angles", [(30.0, 35.0), (45.0, 50.0), (45.0, 55.0), (70.76, 75.76)])
@pytest.mark.parametrize("rotation", ["free", "blocked"])
def test_loves_helix_under_a_wrench_on_its_axis(reference, rotation, angles):
    """Opposite wrenches on both ends of a free wire take (alpha, R) to (alpha1, R1), stretching."""
    rows = reference("love_helix")["rows"]
    row = next(row for row in rows if (row["alpha_deg"], row["alpha1_deg"]) == angles)
    march = stretched_helix(row, rotation)
    alpha1, radius1 = helix_of(march.state.strands()[0])
    assert math.degrees(alpha1) == pytest.approx(angles[1], abs=0.15)
    assert radius1 == pytest.approx(row[f"R1_{rotation}"], rel=6e-3)


def stretched_helix(row, rotation, turns=3, per_turn=24):
    radius, alpha = row["R"], math.radians(row["alpha_deg"])
    thin = 0.02
    material = Material(E=4 * row["B"] / math.pi / thin**4, density=1 / (math.pi * thin**2),
                        G=2 * row["C"] / math.pi / thin**4)  # fmt: skip
    pitch = 2 * math.pi * radius * math.tan(alpha)
    angle = np.linspace(0, 2 * math.pi * turns, turns * per_turn + 1)
    nodes = np.column_stack(
        [radius * np.cos(angle), radius * np.sin(angle), pitch * angle / (2 * math.pi)]
    )
    force = row[f"F_{rotation}"]
    couple = row["K_blocked"] if rotation == "blocked" else 0.0
    ends = [
        End(load=Load(force=(0, 0, sign * force), couple=(0, 0, sign * couple),
                      through=(0, 0, 0), ramp=20))
        for sign in (-1, 1)
    ]  # fmt: skip
    rod = Rod(shape=Points(nodes=[tuple(p) for p in nodes]), radius=thin, elements=len(nodes) - 1,
              material=material, root=ends[0], tip=ends[1])  # fmt: skip
    scene = Scene(rods=[rod], duration=1, damping=Damping(drag=0.3), rotary_inertia="element")
    return relaxed(scene, 600)


def helix_of(nodes):
    """Return pitch angle and radius of the middle turn of a helix about z."""
    third = len(nodes) // 3
    frame = frames(nodes)
    tangents = frame[third : 2 * third, 2]
    alpha = math.asin(np.mean(tangents[:, 2]))
    steps = np.linalg.norm(np.diff(nodes, axis=0), axis=1)
    bending = curvature(frame, 0.5 * (steps[1:] + steps[:-1]))[third : 2 * third, :2]
    return alpha, math.cos(alpha) ** 2 / np.mean(np.linalg.norm(bending, axis=1))


def test_driven_end_follows_its_course_and_stops():
    """Velocity times (duration - ramp) of travel; the spin turns the tip's frame as far."""
    motion = Motion(velocity=(0.1, 0, 0), spin=(0, 0, 2.0), start=0.1, ramp=0.1, duration=0.5)
    rod = Rod(shape=Straight(length=0.1), radius=0.005, elements=6, material=RUBBER,
              root=End(hold="clamped", motion=motion))  # fmt: skip
    scene = Scene(rods=[rod], duration=1, damping=Damping(drag=5.0))
    march = relaxed(scene, 1.0)
    root = march.state.strands()[0][0]
    np.testing.assert_allclose(root, [0.1 * 0.4, 0, 0], atol=1e-6)
    ghost = march.state.first[0] - 1
    before, after = Explicit(scene).state.rows("Q00 Q01")[:, ghost], march.state.rows("Q00 Q01")
    turned = math.atan2(*after[::-1, ghost]) - math.atan2(*before[::-1])
    assert turned % (2 * math.pi) == pytest.approx(2.0 * 0.4, abs=1e-5)


def test_a_pinned_rod_hangs_straight_and_turns_freely():
    """A pendulum of a stiff rod: omega^2 = g sum(m x)/sum(m x^2), masses on the nodes."""
    length = 0.1
    stiff = Material(E=1e7, nu=0.5, density=1000)
    rod = Rod(shape=Straight(direction=(0.05, 0, -1), length=length), radius=0.005, elements=6,
              material=stiff, root=End(hold="pinned"))  # fmt: skip
    march = Explicit(Scene(rods=[rod], duration=1, gravity=(0, 0, -9.81)))
    mass, x = march.state.row("MASS")[march.state.nodes(0)], np.linspace(0, length, 7)
    inertia = mass @ x**2 + mass.sum() * 0.005**2 / 4
    omega = math.sqrt(9.81 * (mass @ x) / inertia)
    side = []
    for _ in range(400):
        march.advance(int(2 * math.pi / omega / 100 / march.dt))
        side.append(tip_of(march)[0])
    side, step = np.array(side), march.time / 400
    at = np.flatnonzero(np.diff(np.sign(side)))
    zeros = step * (at + side[at] / (side[at] - side[at + 1]))
    swing = 0.05  # of amplitude: slower by swing^2/16
    assert math.pi / np.mean(np.diff(zeros)) == pytest.approx(omega * (1 - swing**2 / 16), rel=5e-4)


@pytest.mark.slow
def test_helical_buckling_meets_its_localised_solution_with_second_order(reference):
    """Ends turned by 27 turns and brought 3 nearer: van der Heijden & Thompson's envelope."""
    case = reference("rods")["helical_buckling"]
    meshes = np.array([90, 135, 200])
    errors = [np.abs(envelope_of(buckled_helix(case, n), case)).max() for n in meshes]
    assert errors[-1] < 0.006
    order = -np.diff(np.log(errors)) / np.diff(np.log(meshes))
    np.testing.assert_allclose(order, 2.0, atol=0.15)


def buckled_helix(case, n):
    """Return the relaxed nodes; the ends come nearer by the slack less what tension stretches."""
    length, turns, radius = case["L"], 27, 0.05
    slack = case["slack_D"] - length * case["tension"] * radius**2 / (4 * case["bending"])
    second_moment = math.pi * radius**4 / 4
    material = Material(E=case["bending"] / second_moment, G=case["twisting"] / 2 / second_moment,
                        density=1 / (math.pi * radius**2))  # fmt: skip
    half = 500.0
    moving = [
        Motion(velocity=(0, 0, -sign * slack / 2 / half), ramp=100, duration=half + 100,
               spin=(0, 0, sign * turns * math.pi / half))
        for sign in (-1, 1)
    ]  # fmt: skip
    rod = Rod(shape=Straight(length=length, direction=(0, 0, 1)), radius=radius, elements=n,
              material=material, root=End(hold="clamped", motion=moving[0]),
              tip=End(hold="clamped", motion=moving[1]))  # fmt: skip
    scene = Scene(rods=[rod], duration=1, damping=Damping(drag=0.02), rotary_inertia="element")
    march = Explicit(scene)
    s = np.linspace(0, 1, n + 1)
    march.state.row("V0")[march.state.nodes(0)] = 1e-4 * np.sin(math.pi * s) ** 2
    march.advance(int(3000 / march.dt))
    return march.state.strands()[0]


def envelope_of(nodes, case):
    """Return measured minus exact cosine of the angle between the rod and its ends' line."""
    m, t, length = case["m_h"], case["t_h"], case["L"]
    steps = np.diff(nodes, axis=0)
    cosine = steps[:, 2] / np.linalg.norm(steps, axis=1)
    s = (np.arange(len(steps)) + 0.5) * length / len(steps) - length / 2
    rate = 2 * math.pi * math.sqrt(t - m * m / 4) / length
    return cosine - (1 - 2 * (1 - m * m / (4 * t)) / np.cosh(rate * s) ** 2)


def rolling(angle, mu):
    """Return the acceleration of a cylinder over g sin(angle), on a slope of that angle.

    The slope is a tine of 100 m radius, so that it hardly bends away over the way rolled.
    """
    radius, big = 0.005, 100.0
    rod = Rod(shape=Straight(root=(0, -0.02, 0), direction=(0, 1, 0), length=0.04), radius=radius,
              elements=4, material=Material(E=1e6, nu=0.5, density=1000), root=End())  # fmt: skip
    weight = 1000 * math.pi * radius**2 * 9.81 * math.cos(angle)
    sunk = weight / (SOFTNESS * 1e6)  # where it rests, so that it does not bounce
    slope = Tine(
        position=(0, 0, sunk - big - radius), axis=(0, 1, 0), length=1, radius=big, insertion=0
    )
    gravity = (9.81 * math.sin(angle), 0, -9.81 * math.cos(angle))
    scene = Scene(rods=[rod], duration=1, gravity=gravity, tines=[slope],
                  friction=Friction(forward=mu, backward=mu))  # fmt: skip
    march = Explicit(scene)
    march.advance(int(0.01 / march.dt))
    began, speed = march.time, speed_of(march)
    march.advance(int(0.05 / march.dt))
    return (speed_of(march) - speed) / (march.time - began) / (9.81 * math.sin(angle))


def speed_of(march):
    return float(np.mean(march.state.row("V0")[march.state.nodes(0)]))


@pytest.mark.parametrize("share", [0.85, 1.15])
def test_a_cylinder_rolls_below_its_threshold_and_slips_beyond(reference, share):
    """tan(angle) = 3 mu parts rolling, a = 2/3 g sin, from slipping, a = g (sin - mu cos)."""
    case = reference("rods")["rolling_cylinder_slip"]
    assert math.tan(math.radians(case["angle_deg"])) == pytest.approx(3 * case["mu_s"])
    angle = math.atan(3 * case["mu_s"] * share)
    rolls, slips = 2 / 3, 1 - case["mu_s"] / math.tan(angle)
    assert rolling(angle, case["mu_s"]) == pytest.approx(max(rolls, slips), rel=0.01)
