"""Contact and friction: conservation, continuity, energy, and nothing missed."""

import math

import numpy as np
import pytest

from sim.energy import elastic_energy, kinetic_energy
from sim.explicit import Explicit
from sim.kernels import contact as kernels
from sim.kernels import overlap, runs
from sim.march import effects
from sim.march.neighbours import rebuild
from sim.march.state import build
from sim.scene import Contact, End, Friction, Material, Points, Rod, Scene, Straight, Tine

NYLON = Material(E=2e8, nu=0.4, density=1140)
R = 4e-4


def strand(nodes, radius=R, hold="free"):
    shape = Points(nodes=[tuple(map(float, p)) for p in nodes])
    return Rod(shape=shape, radius=radius, elements=2, material=NYLON, root=End(hold=hold))


def line(middle, direction, length, elements):
    unit = np.asarray(direction, float) / np.linalg.norm(direction)
    return np.asarray(middle, float) + np.linspace(-0.5, 0.5, elements + 1)[:, None] * length * unit


def scene(*rods, contact=Contact(overlap="push apart"), **others):  # noqa: B008  (it is frozen)
    return Scene(rods=list(rods), duration=1, contact=contact, **others)


def contact_only(march):
    """Fill the buffer's force and couple rows with contact and friction alone."""
    for name in ["F0", "F1", "F2", "C0", "C1", "C2"]:
        march.state.row(name)[:] = 0
    kernels.contact_forces(march.state.buf, march.state.n, march.dt, march.contact, march.friction)
    return march.state.rows("F0 F1 F2"), march.state.rows("C0 C1 C2")


def body_to_lab(state, couples):
    total = np.zeros(3)
    for i in np.flatnonzero(state.row("LENGTH") > 0):
        q = np.array([[state.row(f"Q{a}{b}")[i] for b in range(3)] for a in range(3)])
        total += q.T @ couples[:, i]
    return total


@pytest.mark.parametrize("friction", [None, Friction(forward=0.3, backward=0.1)])
def test_contact_makes_neither_momentum_nor_angular_momentum(rng, friction):
    for _ in range(20):
        a = np.cumsum(rng.normal(0, 0.3, (7, 3)) + [1, 0, 0], axis=0) * 1e-3
        b = np.cumsum(rng.normal(0, 0.3, (9, 3)) + [0.6, 0.7, 0], axis=0) * 8e-4
        b += a[3] - b[4] + rng.normal(0, 0.3e-3, 3)
        march = Explicit(scene(strand(a), strand(b, radius=2 * R), friction=friction))
        for name in ["V0", "V1", "V2"]:
            march.state.row(name)[:] = rng.normal(0, 0.1, march.state.n)
        for name in ["W0", "W1", "W2"]:
            march.state.row(name)[:] = rng.normal(0, 100, march.state.n)
        for _ in range(3):
            force, couple = contact_only(march)
        size = np.abs(force).max()
        assert size > 0
        position = march.state.rows("X0 X1 X2")
        moment = np.cross(position.T, force.T).sum(axis=0) + body_to_lab(march.state, couple)
        np.testing.assert_allclose(force.sum(axis=1), 0, atol=1e-14 * size)
        np.testing.assert_allclose(moment, 0, atol=1e-13 * size * np.abs(position).max())


def push_on_first(angle, shift, *, overlap=0.1, elements=10, length=10e-3):
    """Force between straight strands that cross at `angle`, the second slid along by `shift`."""
    gap = np.array([0, 0, 2 * R * (1 - overlap)])
    direction = np.array([math.cos(angle), math.sin(angle), 0])
    upper = line(gap + shift * direction, direction, length, elements)
    lower = line([0, 0, 0], [1, 0, 0], 12e-3, elements)
    march = Explicit(scene(strand(lower), strand(upper)))
    force, _ = contact_only(march)
    return force[:, march.state.nodes(0)].sum(axis=1)


@pytest.mark.parametrize("degrees", [0.06, 1, 10, 45, 90])
def test_force_stays_the_same_while_one_strand_slides_along_another(degrees):
    """The ripple that the paper's footnote blames on nodes: here below 1 %, over three nodes."""
    shifts = np.linspace(0, 3e-3, 61)
    if degrees < 2:
        shifts = shifts / 30  # nearly parallel: the strands' common length changes as they slide
    forces = np.array([push_on_first(math.radians(degrees), shift)[2] for shift in shifts])
    assert forces.max() < 0
    assert np.ptp(forces) / abs(forces.mean()) < 0.01


def test_force_is_continuous_across_a_corner_of_the_other_strand():
    """A strand slides over a bent one; halving the step halves the largest change of the force."""
    angle = np.radians(20)
    bent = np.array([[-2, 0, 0], [-1, 0, 0], [0, 0, 0],
                     [math.cos(angle), 0, -math.sin(angle)],
                     [2 * math.cos(angle), 0, -2 * math.sin(angle)]]) * 1e-3  # fmt: skip

    def largest_change(steps):
        forces = []
        for x in np.linspace(-0.5e-3, 0.5e-3, steps + 1):
            over = line([x, 0, 2 * R * 0.95], [0, 1, 0], 8e-3, 7)
            march = Explicit(scene(strand(bent), strand(over)))
            forces.append(contact_only(march)[0][:, march.state.nodes(1)].sum(axis=1))
        return np.linalg.norm(np.diff(forces, axis=0), axis=1).max()

    assert largest_change(80) < 0.6 * largest_change(40)


def crossing_force(gap):
    """U = int k/2 (2r - d)^2 ds with d^2 = gap^2 + s^2: the force is its derivative in gap."""
    half = math.sqrt((2 * R) ** 2 - gap**2)
    s = np.linspace(-half, half, 200001)
    d = np.sqrt(gap**2 + s**2)
    return np.trapezoid(effects.SOFTNESS * NYLON.E * (2 * R - d) * gap / d, s)


def test_force_between_crossed_strands_meets_the_integral():
    gap = 2 * R * 0.9
    assert -push_on_first(math.pi / 2, 0.0)[2] == pytest.approx(crossing_force(gap), rel=1e-3)


def test_force_between_parallel_strands_is_stiffness_times_overlap_times_length():
    """The shorter strand's round caps press on the longer one too, integrated to a third or so."""
    gap = 2 * R * 0.9
    cap = 0.5 * crossing_force(gap)
    for n in (4, 6, 10):
        force = -push_on_first(0.0, 0.0, length=n * 1e-3, elements=n)[2]
        along = effects.SOFTNESS * NYLON.E * (2 * R - gap) * n * 1e-3
        assert force == pytest.approx(along + 2 * cap, abs=2 * cap)
        assert force > along


@pytest.mark.parametrize("tilt", [0.0, 1e-6, 1e-3])
def test_parallel_and_exactly_crossing_strands_give_numbers(tilt):
    lower = line([0, 0, 0], [1, 0, 0], 10e-3, 10)
    for middle in ([0, 0, 0], [1e-4, 0, 1.5 * R]):
        upper = line(middle, [1, tilt, 0], 10e-3, 9)
        crossing = line(middle, [0, 1, tilt], 10e-3, 9)
        for other in (upper, crossing):
            march = Explicit(
                scene(strand(lower), strand(other), friction=Friction(forward=0.2, backward=0.2))
            )
            force, couple = contact_only(march)
            assert np.isfinite(force).all()
            assert np.isfinite(couple).all()


@pytest.mark.parametrize("degrees", [5, 30, 90])
def test_crossed_free_strands_bounce_without_gaining_energy(degrees):
    """Undamped; the peer's contact ends with 2.4 to 4.9 times the energy it began with."""
    angle = math.radians(degrees)
    lower = line([0, 0, 0], [1, 0, 0], 20e-3, 20)
    upper = line([0, 0, 2.2 * R], [math.cos(angle), math.sin(angle), 0], 20e-3, 20)
    march = Explicit(scene(strand(lower), strand(upper)))
    march.state.row("V2")[march.state.nodes(1)] = -0.5
    before = kinetic_energy(march.state)
    march.advance(int(2e-3 / march.dt))
    state = march.state
    apart = state.strands()[1][:, 2].mean() - state.strands()[0][:, 2].mean()
    assert apart > 2 * R
    assert kinetic_energy(state) + elastic_energy(state) == pytest.approx(before, rel=0.01)


def brute_force_pairs(march):
    """Pairs of elements of different rods that come within reach, by dense sampling."""
    state, rod = march.state, march.contact.rod
    t = np.linspace(0, 1, 12)[:, None]
    x = state.rows("X0 X1 X2").T
    inside = np.flatnonzero(rod >= 0)
    samples = {i: x[i] + t * (x[i + 1] - x[i]) for i in inside}
    pairs = set()
    for a in inside:
        for b in inside[inside > a]:
            if rod[a] != rod[b]:
                gap = samples[a][:, None] - samples[b][None]
                if np.linalg.norm(gap, axis=2).min() < 2 * R:
                    pairs.add((int(a), int(b)))
    return pairs


def test_neighbour_list_holds_every_pair_in_reach_of_random_tangles(rng):
    for _ in range(5):
        rods = []
        for _ in range(4):
            walk = np.cumsum(rng.normal(0, 1, (15, 3)), axis=0)
            rods.append(strand(walk * 6e-4 - walk.mean(axis=0) * 6e-4))
        march = Explicit(scene(*rods))
        listed = {(int(a), int(b)) for a, b in march.contact.pairs.T}
        assert brute_force_pairs(march) <= listed
        assert len(listed) == march.contact.pairs.shape[1]  # none twice


def test_no_contact_is_missed_while_strands_move(rng):
    """The lists of a run that rebuilds when it must hold what brute force finds at every check."""
    rods = [
        strand(line([0, 0, 3e-3 * k], rng.normal(size=3) * [1, 1, 0.1], 15e-3, 15))
        for k in range(4)
    ]
    march = Explicit(scene(*rods, gravity=None))
    for k in range(4):
        march.state.row("V2")[march.state.nodes(k)] = -2.0 * k
    for _ in range(20):
        march.advance(200)
        listed = {(int(a), int(b)) for a, b in march.contact.pairs.T}
        assert brute_force_pairs(march) <= listed


def forces_pair_by_pair(march):
    """Add up all listed pairs, one after another, as batches of pairs in play must."""
    state, contact = march.state, march.contact
    kernels.wedges(state.buf, state.n)
    x, force = state.rows("X0 X1 X2").T, np.zeros((state.n, 3))
    for a, b in contact.pairs.T:
        reach = state.row("RADIUS")[a] + state.row("RADIUS")[b]
        low, high = kernels.contact_interval(state.buf, a, b, reach)
        if low < high:
            ends = [tuple(x[i]) for i in (a, a + 1, b, b + 1)]
            line = contact.stiffness * state.row("LENGTH")[a]
            push, by_s, by_t, *_ = overlap.press(*ends, low, high, reach, line)
            force[a] += np.subtract(push, by_s)
            force[a + 1] += by_s
            force[b] -= np.subtract(push, by_t)
            force[b + 1] -= by_t
    return force.T


def pairs_in_play(contact):
    """Count the pairs of all runs; one of no length ends them."""
    lengths = contact.runs[runs.LENGTH_OF]
    return int(lengths[: np.argmin(lengths)].sum())


def test_pairs_pressed_in_batches_are_all_that_touch(rng):
    """While nodes move within the skin: the pairs in play are kept for a while, then found anew."""
    rods = []
    for _ in range(6):
        walk = np.cumsum(rng.normal(0, 1, (25, 3)), axis=0)
        rods.append(strand(walk * 5e-4 - walk.mean(axis=0) * 5e-4))
    march = Explicit(scene(*rods, contact=Contact(self_contact=True, overlap="push apart")))
    home, drift = march.state.rows("X0 X1 X2"), rng.normal(0, 1, (3, march.state.n))
    drift *= 0.45 * march.contact.skin / np.linalg.norm(drift, axis=0).max()
    pressed = []
    for phase in [0, 0.01, 0.02, 0.03, 0.1, 0.5, 0.52, 0.54, 1.0, 0.97, 0.94, 0.3]:
        for axis in range(3):
            march.state.row(f"X{axis}")[:] = home[axis] + phase * drift[axis]
        force, _ = contact_only(march)
        expected = forces_pair_by_pair(march)
        assert np.abs(expected).max() > 0
        np.testing.assert_allclose(force, expected, atol=1e-13 * np.abs(expected).max())
        pressed.append(pairs_in_play(march.contact))
    assert max(pressed) < march.contact.pairs.shape[1]  # the second sieve holds something back
    assert len(set(pressed)) > 1


def test_forces_do_not_depend_on_the_history_of_the_neighbour_list(rng):
    """Bitwise: a list built here and one that has come a long way."""
    rods = [strand(line([0, 0, 1.9 * R * k], [1, 0.05 * k, 0], 15e-3, 15)) for k in range(4)]
    old = Explicit(scene(*rods))
    for name in ["V0", "V1", "V2"]:
        old.state.row(name)[:] = rng.normal(0, 0.3, old.state.n)
    old.advance(700)
    fresh = Explicit(scene(*rods))
    for name in ["X0", "X1", "X2"]:
        fresh.state.row(name)[:] = old.state.row(name)
    rebuild(fresh)
    np.testing.assert_array_equal(contact_only(fresh)[0], contact_only(old)[0])


def sliding(mu, slope):
    """Let a strand lie along a held one, gravity inclined by `slope`; return its acceleration."""
    held = strand(line([0, 0, 0], [1, 0, 0], 12e-3, 12))
    g, softness = 9.81, effects.SOFTNESS * NYLON.E
    weight = NYLON.density * math.pi * R**2 * g * math.cos(slope)
    free = strand(line([0, 0, 2 * R - weight / softness], [1, 0, 0], 6e-3, 7))
    march = Explicit(
        scene(
            held, free, friction=Friction(forward=mu, backward=mu),
            gravity=(g * math.sin(slope), 0, -g * math.cos(slope)),
        )
    )  # fmt: skip
    at = march.state.nodes(0)
    march.state.row("INV_MASS")[at] = 0
    march.state.row("INV_J1")[at] = march.state.row("INV_J3")[at] = 0
    duration = 2e-3
    march.advance(int(duration / march.dt))
    return march.state.row("V0")[march.state.nodes(1)].mean() / march.time


def test_friction_holds_below_its_angle_and_lets_slide_above_it():
    mu = 0.3
    angle = math.atan(mu)
    assert abs(sliding(mu, 0.8 * angle)) < 0.02 * 9.81
    for factor in (1.5, 3.0):
        slope = factor * angle
        expected = 9.81 * (math.sin(slope) - mu * math.cos(slope))
        assert sliding(mu, slope) == pytest.approx(expected, rel=0.03)


def sliding_over_a_tine(mu, slope):
    """Let a strand lie across a tine, gravity inclined by `slope`; return its acceleration."""
    tine = Tine(position=(0, 0, 0), axis=(0, 1, 0), length=0.02, radius=4 * R, direction=(0, 1, 0),
                insertion=0.0, speed=1e-9, travel=1.0)  # fmt: skip
    # Long, so that it hardly pitches under friction, which acts a radius below its middle.
    free = strand(line([0, 0, 5 * R], [1, 0, 0], 10e-3, 20))
    gravity = (9.81 * math.sin(slope), 0, -9.81 * math.cos(slope))
    march = Explicit(
        scene(free, tines=[tine], gravity=gravity, friction=Friction(forward=mu, backward=mu))
    )
    march.advance(int(1e-3 / march.dt))  # until it bears on the tine
    at, start = march.state.nodes(0), march.time
    before = march.state.row("V0")[at].mean()
    march.advance(int(3e-3 / march.dt))
    return (march.state.row("V0")[at].mean() - before) / (march.time - start)


def test_friction_on_a_tine_holds_below_its_angle_and_lets_slide_above_it():
    mu = 0.3
    angle = math.atan(mu)
    assert abs(sliding_over_a_tine(mu, 0.5 * angle)) < 0.1 * 9.81 * math.sin(0.5 * angle)
    slope = 3 * angle
    expected = 9.81 * (math.sin(slope) - mu * math.cos(slope))
    assert sliding_over_a_tine(mu, slope) == pytest.approx(expected, rel=0.1)


def test_tine_feels_what_it_gives():
    """Reaction on the tine = rate of change of the momentum of a free strand it hits."""
    tine = Tine(position=(0, 0, 0), axis=(0, 1, 0), length=0.02, radius=2 * R, direction=(0, 0, -1),
                insertion=0.0, ramp=1e-6, speed=0.5, travel=1.0)  # fmt: skip
    march = Explicit(scene(strand(line([0, 0, -3.05 * R], [1, 0, 0], 8e-3, 8)), tines=[tine]))
    march.advance(int(3e-4 / march.dt))
    impulse = march.take_load()[0] * march.dt
    momentum = (march.state.row("MASS") * march.state.rows("V0 V1 V2")).sum(axis=1)
    assert momentum[2] < 0
    np.testing.assert_allclose(impulse, -momentum, atol=1e-9 * abs(momentum[2]))


def test_a_strand_that_only_passes_is_not_touched():
    rods = [Rod(shape=Straight(root=(x, 0, 0), length=0.01), radius=R, elements=10, material=NYLON,
                root=End(hold="free")) for x in (0, 2.001 * R)]  # fmt: skip
    state = build(scene(*rods))
    march = Explicit(scene(*rods))
    march.advance(100)
    np.testing.assert_array_equal(march.state.rows("X0 X1 X2"), state.rows("X0 X1 X2"))
