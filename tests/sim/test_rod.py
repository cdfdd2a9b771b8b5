"""The bare rod: statics and dynamics against closed forms, conservation, symmetry."""

import math

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from sim.energy import elastic_energy, kinetic_energy
from sim.explicit import Explicit
from sim.kernels import layout, rod
from sim.march.state import build, rigidities
from sim.scene import Contact, Damping, End, Friction, Material, Points, Rod, Scene, Straight, Tine
from sim.scene.shapes import frames

RUBBER = Material(E=1e6, nu=0.5, density=1000)


def straight_rod(elements, *, length=0.5, radius=0.01, direction=(1.0, 0.0, 0.0), hold="clamped"):
    shape = Straight(direction=direction, length=length)
    return Rod(shape=shape, radius=radius, elements=elements, material=RUBBER, root=End(hold=hold))


def crumple(state, *, rng, size=0.3):
    """Turn every element and move every node at random."""
    for number, (first, count) in enumerate(zip(state.first, state.elements, strict=True)):
        for k in range(3):
            at = state.nodes(number)
            length = state.row("LENGTH")[first]
            state.row(f"X{k}")[at] += 0.1 * size * length * rng.standard_normal(count + 1)
        for i in range(first, first + count):
            q = np.array([[state.row(f"Q{a}{b}")[i] for b in range(3)] for a in range(3)])
            q = Rotation.from_rotvec(size * rng.standard_normal(3)).as_matrix() @ q
            for a in range(3):
                for b in range(3):
                    state.row(f"Q{a}{b}")[i] = q[a, b]


def internal_loads(state):
    """Return force on every node and couple (body frame) on every element."""
    rod.stretch_and_shear(state.buf, state.n + 1, None)
    rod.bend_and_twist(state.buf, state.n + 1, None)
    n = state.rows("N0 N1 N2")
    force = n - np.roll(n, 1, axis=1)
    left = np.roll(state.rows("L0 L1 L2"), -1, axis=1)
    return force, state.rows("E0 E1 E2") + left + state.rows("R0 R1 R2")


@pytest.mark.parametrize("size", [0.05, 0.3, 1.0])
def test_forces_and_couples_are_the_gradient_of_the_elastic_energy(rng, size):
    state = build(Scene(rods=[straight_rod(5, hold="free")], duration=1))
    crumple(state, rng=rng, size=size)
    force, couple = internal_loads(state)
    scale, h = np.abs(couple).max(), 1e-6
    for i in range(state.first[0], state.first[0] + 6):
        for k in range(3):
            x = state.row(f"X{k}")
            x[i] += h * 0.01
            up = elastic_energy(state)
            x[i] -= 2 * h * 0.01
            down = elastic_energy(state)
            x[i] += h * 0.01
            slope = (up - down) / (2 * h * 0.01)
            assert force[k, i] == pytest.approx(-slope, abs=2e-6 * np.abs(force).max())
    for i in range(state.first[0], state.first[0] + 5):
        for k in range(3):
            slope = (_turned(state, i, k, h) - _turned(state, i, k, -h)) / (2 * h)
            assert couple[k, i] == pytest.approx(-slope, abs=2e-6 * scale)


def _turned(state, i, axis, angle):
    """Return the elastic energy with element i turned about its own director `axis`."""
    q = np.array([[state.row(f"Q{a}{b}")[i] for b in range(3)] for a in range(3)])
    turned = Rotation.from_rotvec(-angle * np.eye(3)[axis]).as_matrix() @ q
    for source in (turned, q):
        for a in range(3):
            for b in range(3):
                state.row(f"Q{a}{b}")[i] = source[a, b]
        if source is turned:
            energy = elastic_energy(state)
    return energy


@pytest.mark.parametrize("below_pi", [3.0, 1.0, 1e-2, 1e-4, 1e-6, 1e-8])
def test_logarithm_is_exact_up_to_half_a_turn(rng, below_pi):
    state = build(Scene(rods=[straight_rod(2, hold="free")], duration=1))
    first = state.first[0]
    axis = rng.standard_normal(3)
    vector = (math.pi - below_pi) * axis / np.linalg.norm(axis)
    q0 = Rotation.random(random_state=1).as_matrix()
    q1 = Rotation.from_rotvec(-vector).as_matrix() @ q0
    for i, q in ((first, q0), (first + 1, q1)):
        for a in range(3):
            for b in range(3):
                state.row(f"Q{a}{b}")[i] = q[a, b]
    np.testing.assert_allclose(rod.logarithm(state.buf, first + 1), vector, atol=4e-15)


@pytest.mark.parametrize("angle", [1e-9, 1e-4, 0.1, 0.489])
def test_series_of_the_logarithm_meets_the_closed_form(angle):
    z = math.sin(angle / 2) ** 2
    assert rod.theta_over_sine(z) == pytest.approx(angle / math.sin(angle), rel=3e-16)


def test_second_order_coefficient_meets_its_closed_form():
    for angle in (0.05, 0.2, 0.48):
        z = math.sin(angle / 2) ** 2
        exact = (1 - angle / 2 / math.tan(angle / 2)) / angle**2
        found = rod.second_order(2 * z, rod.theta_over_sine(z))
        assert found == pytest.approx(exact, abs=1e-12)


def settled_tip(elements):
    """Return the deflection of a cantilever under its own weight, where damping has left it."""
    scene = Scene(
        rods=[straight_rod(elements, length=0.2, radius=0.02)],
        duration=1,
        gravity=(0, 0, -0.01),
        damping=Damping(drag=30),
    )
    march = Explicit(scene)
    march.advance(int(1.0 / march.dt))
    return march.state.strands()[0][-1, 2]


def test_cantilever_under_its_weight_meets_timoshenko_with_second_order():
    bend, _ = rigidities(RUBBER, 0.02)
    area = math.pi * 0.02**2
    weight = RUBBER.density * area * 0.01
    shear = RUBBER.shear_coefficient * RUBBER.E / 3 * area
    exact = -weight * 0.2**4 / (8 * bend) - weight * 0.2**2 / (2 * shear)
    errors = [abs(settled_tip(n) / exact - 1) for n in (8, 16, 32)]
    assert errors[-1] < 2e-3
    assert errors[0] / errors[1] == pytest.approx(4, rel=0.15)
    assert errors[1] / errors[2] == pytest.approx(4, rel=0.15)


def first_mode(nodes):
    """Return the first bending mode of a clamped-free beam (Euler-Bernoulli), (nodes,)."""
    root = 1.8751041
    x = root * np.linspace(0, 1, nodes)
    ratio = (math.cosh(root) + math.cos(root)) / (math.sinh(root) + math.sin(root))
    return np.cosh(x) - np.cos(x) - ratio * (np.sinh(x) - np.sin(x))


def test_cantilever_swings_at_its_first_frequency():
    length, radius = 0.5, 0.005
    march = Explicit(Scene(rods=[straight_rod(40, length=length, radius=radius)], duration=1))
    bend, _ = rigidities(RUBBER, radius)
    omega = 1.8751041**2 * math.sqrt(bend / (RUBBER.density * math.pi * radius**2 * length**4))
    at = march.state.nodes(0)
    march.state.row("V2")[at] = 1e-4 * first_mode(41)
    steps = int(0.05 * 2 * math.pi / omega / march.dt)
    times, tips = [], []
    for _ in range(60):
        march.advance(steps)
        times.append(march.time)
        tips.append(march.state.row("X2")[at][-1])
    crossings = np.flatnonzero(np.diff(np.sign(tips)))
    zeros = [
        times[i] - tips[i] * (times[i + 1] - times[i]) / (tips[i + 1] - tips[i]) for i in crossings
    ]
    assert math.pi / np.mean(np.diff(zeros)) == pytest.approx(omega, rel=5e-3)


def test_material_damping_takes_energy_from_a_slow_mode_as_kelvin_and_voigt_say():
    """Energy of a mode decays as exp(-w^2 T t): T w/2 of critical damping."""
    length, radius, time = 0.1, 0.004, 3e-4
    rods = [straight_rod(20, length=length, radius=radius)]
    march = Explicit(Scene(rods=rods, duration=1, damping=Damping(material=time)))
    bend, _ = rigidities(RUBBER, radius)
    omega = 1.8751041**2 * math.sqrt(bend / (RUBBER.density * math.pi * radius**2 * length**4))
    at = march.state.nodes(0)
    march.state.row("V2")[at] = 1e-3 * first_mode(21)

    def energy():
        return kinetic_energy(march.state) + elastic_energy(march.state)

    march.advance(int(0.2 / march.dt))  # until the faster modes in the start are gone
    start, before = march.time, energy()
    march.advance(int(1.0 / march.dt))
    rate = math.log(before / energy()) / (march.time - start)
    assert rate == pytest.approx(omega**2 * time, rel=0.05)


def free_tumbling(rng):
    angle = np.linspace(0, 4, 13)
    nodes = 0.1 * np.column_stack([np.cos(angle), np.sin(angle), 0.3 * angle])
    shape = Points(nodes=[tuple(p) for p in nodes])
    scene = Scene(
        rods=[Rod(shape=shape, radius=0.005, elements=12, material=RUBBER, root=End(hold="free"))],
        duration=1,
    )
    march = Explicit(scene)
    at = march.state.nodes(0)
    for k in range(3):
        march.state.row(f"V{k}")[at] = 0.1 * rng.standard_normal(13)
        march.state.row(f"W{k}")[at.start : at.stop - 1] = 2 * rng.standard_normal(12)
    return march


def momenta(state):
    """Return momentum and angular momentum of everything [kg m/s], [kg m^2/s]."""
    x, v, mass = state.rows("X0 X1 X2"), state.rows("V0 V1 V2"), state.row("MASS")
    momentum = (mass * v).sum(axis=1)
    angular = np.cross(x.T, (mass * v).T).sum(axis=0)
    for i in np.flatnonzero(state.row("LENGTH") > 0):
        q = np.array([[state.row(f"Q{a}{b}")[i] for b in range(3)] for a in range(3)])
        w = np.array([state.row(f"W{k}")[i] for k in range(3)])
        j = 1 / np.array([state.row(n)[i] for n in ("INV_J1", "INV_J1", "INV_J3")])
        angular = angular + q.T @ (j * w)
    return momentum, angular


def test_free_rod_keeps_momentum_angular_momentum_and_energy(rng):
    march = free_tumbling(rng)
    state = march.state
    energy = kinetic_energy(state) + elastic_energy(state)
    momentum, angular = momenta(state)
    drift = []
    for _ in range(20):
        march.advance(500)
        drift.append((kinetic_energy(state) + elastic_energy(state)) / energy - 1)
    after, turned = momenta(state)
    np.testing.assert_allclose(after, momentum, atol=1e-12 * np.abs(momentum).max())
    np.testing.assert_allclose(turned, angular, atol=1e-5 * np.abs(angular).max())
    assert np.abs(drift).max() < 2e-2
    assert abs(np.mean(drift[10:]) - np.mean(drift[:10])) < 2e-3


def test_energy_error_shrinks_with_the_square_of_the_time_step(rng):
    errors = []
    for factor in (1.0, 0.5):
        march = free_tumbling(np.random.default_rng(3))
        march.dt *= factor
        energy = kinetic_energy(march.state) + elastic_energy(march.state)
        worst = 0.0
        for _ in range(40):
            march.advance(round(50 / factor))
            now = kinetic_energy(march.state) + elastic_energy(march.state)
            worst = max(worst, abs(now / energy - 1))
        errors.append(worst)
    assert errors[0] / errors[1] == pytest.approx(4, rel=0.25)


def moved_scene(turn, shift):
    """Return two crossing strands, a tine that drives through them, friction and weight."""

    def place(p):
        return tuple(map(float, turn @ np.asarray(p, float) + shift))

    def direct(v):
        return tuple(map(float, turn @ np.asarray(v, float)))

    s = np.linspace(0, 1, 13)[:, None]
    first = 0.1 * np.hstack([s, 0.1 * np.sin(6 * s), 0 * s])
    second = 0.1 * np.hstack([0.5 + 0 * s, s - 0.5, 0.02 * s + 0.09])
    rods = [
        Rod(
            shape=Points(nodes=[place(p) for p in nodes]),
            radius=0.005,
            elements=12,
            material=RUBBER,
        )
        for nodes in (first, second)
    ]
    tine = Tine(position=place((0.03, 0, 0.0155)), axis=direct((0, 1, 0)), length=0.2, radius=0.01,
                direction=direct((0, 0, -1)), insertion=0, speed=1.0, travel=1.0)  # fmt: skip
    return Scene(
        rods=rods, duration=1, gravity=direct((0, 0, -9.81)), contact=Contact(), tines=[tine],
        friction=Friction(forward=0.3, backward=0.2), damping=Damping(drag=3.0, material=1e-5),
    )  # fmt: skip


def test_moving_and_turning_the_whole_scene_changes_nothing():
    turn = Rotation.from_rotvec([0.3, -1.1, 0.7]).as_matrix()
    shift = np.array([0.2, -0.1, 0.4])
    ends = []
    for each in ((np.eye(3), np.zeros(3)), (turn, shift)):
        march = Explicit(moved_scene(*each))
        march.advance(1500)
        ends.append((np.concatenate(march.state.strands()), march.take_load()[0]))
    (plain, load), (moved, turned) = ends
    assert np.linalg.norm(load) > 0
    assert np.abs(march.contact.slip).max() > 0
    np.testing.assert_allclose(moved, plain @ turn.T + shift, atol=1e-9)
    np.testing.assert_allclose(turned, turn @ load, atol=1e-9 * np.abs(load).max() + 1e-9)


def test_frames_are_orthonormal_untwisted_and_tangent(rng):
    nodes = np.cumsum(rng.standard_normal((30, 3)) + [0, 0, 2], axis=0)
    q = frames(nodes)
    np.testing.assert_allclose(
        q @ q.transpose(0, 2, 1), np.broadcast_to(np.eye(3), q.shape), atol=1e-13
    )
    tangent = np.diff(nodes, axis=0)
    tangent /= np.linalg.norm(tangent, axis=1, keepdims=True)
    np.testing.assert_allclose(q[:, 2], tangent, atol=1e-13)
    turn = Rotation.from_matrix(q[1:] @ q[:-1].transpose(0, 2, 1)).as_rotvec()
    np.testing.assert_allclose(turn[:, 2], 0, atol=1e-13)


def test_rows_of_the_buffer_do_not_overlap():
    offsets = [layout.ROW[name] for name in layout.ROW]
    assert sorted(offsets) == list(range(layout.ROWS))


def test_two_drifts_in_one_go_are_two_drifts(rng):
    """Turns of up to two radians each: far beyond those of a step."""
    strand = Rod(
        shape=Straight(length=0.1), radius=1e-3, elements=9, material=Material(E=1e7, density=1000)
    )
    state = build(Scene(rods=[strand], duration=1))
    for name in ["V0", "V1", "V2", "W0", "W1", "W2"]:
        state.row(name)[:] = rng.normal(0, 1, state.n)
    before = state.used().copy()
    rod.drift(state.buf, state.n, 1.0)
    rod.drift(state.buf, state.n, 1.0)
    one_by_one = state.used().copy()
    state.used()[:] = before
    rod.drift_twice(state.buf, state.n, 1.0)
    assert np.abs(one_by_one - before).max() > 1
    np.testing.assert_allclose(state.used(), one_by_one, rtol=0, atol=2e-14)
