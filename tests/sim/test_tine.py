"""Tines: their course in time, several of them, and what a strand wound round one feels."""

import numpy as np
import pytest

from sim.explicit import Explicit
from sim.kernels.tine import place, tine_forces, travelled
from sim.scene import Contact, Damping, End, Friction, Load, Material, Rod, Scene, Straight, Tine

DRAG = 30.0


def bar(root=(0.0, 0.0, 0.0), direction=(0.0, 0.0, -1.0), radius=0.004, E=1e6, **ends):
    shape = Straight(root=root, direction=direction, length=0.1)
    material = Material(E=E, nu=0.5, density=1000)
    return Rod(shape=shape, radius=radius, elements=24, material=material, **ends)


def program(tine):
    """Return the tine's course as the kernel takes it."""
    scene = Scene(rods=[bar(root=(1, 0, 0))], duration=1, tines=[tine])
    return Explicit(scene).tines.motion[0]


def test_a_tine_goes_there_dwells_and_comes_back():
    tine = Tine(position=(0, 0, 0), axis=(0, 1, 0), length=0.1, radius=0.005, insertion=0.1,
                ramp=0.02, speed=0.5, travel=0.1, dwell=0.3, retract=1.0)  # fmt: skip
    motion = program(tine)
    times = np.linspace(0, tine.duration + 0.1, 4001)
    place, speed = np.array([travelled(t, motion) for t in times]).T
    assert tine.duration == pytest.approx(0.1 + (0.2 + 0.02) + 0.3 + (0.1 + 0.02))
    assert np.all(place[times < 0.1] == 0)
    assert place.max() == pytest.approx(0.1)
    assert np.all(place[(times > 0.3201) & (times < 0.6199)] == pytest.approx(0.1))
    assert place[-1] == pytest.approx(0, abs=1e-12)
    assert speed.max() == pytest.approx(0.5)
    assert speed.min() == pytest.approx(-1.0)
    np.testing.assert_allclose(np.gradient(place, times), speed, atol=0.02)


def test_a_travel_shorter_than_the_ramp_still_ends_at_its_place():
    tine = Tine(position=(0, 0, 0), axis=(0, 1, 0), length=0.1, radius=0.005, insertion=0,
                ramp=10.0, speed=0.5, travel=0.001)  # fmt: skip
    place, speed = travelled(tine.duration, program(tine))
    assert place == pytest.approx(0.001)
    assert speed == pytest.approx(0, abs=1e-9)


@pytest.mark.parametrize("bounce", [0.1, 0.3, 0.6])
def test_a_strand_thrown_at_a_damped_tine_comes_back_as_a_dashpot_lets_it(bounce):
    """Along the tine, so that all of it meets a spring and a dashpot that push and never pull.

    Speeds after and before: exp(-z/sqrt(1 - z^2) atan2(2 z sqrt(1 - z^2), 2 z^2 - 1)), z of
    critical damping (Schwager & Poeschel, Granular Matter 9, 465 (2007)). The tine takes the
    change of momentum. A load that is the same all along is not so on the nodes next to a free end,
    which bends no further: the ends are left to quiver by 2 % of the speed.
    """
    rod = bar(root=(0.0091, 0, 0.05), E=1e7).model_copy(update={"root": End()})
    k, line_density = 1e5, 1000 * np.pi * 0.004**2
    tine = Tine(position=(0, 0, 0), axis=(0, 0, 1), length=0.5, radius=0.005, insertion=0)
    scene = Scene(
        rods=[rod], duration=1, contact=Contact(stiffness=k), tines=[tine],
        friction=Friction(forward=0.3, backward=0.3),
        damping=Damping(drag=1e-9, tine=2 * bounce * np.sqrt(line_density / k)),
    )  # fmt: skip
    march = Explicit(scene)
    at = march.state.nodes(0)
    march.state.row("V0")[at] = -0.5
    march.advance(int(4 * np.pi * np.sqrt(line_density / k) / march.dt))
    root = np.sqrt(1 - bounce**2)
    kept = np.exp(-bounce / root * np.arctan2(2 * bounce * root, 2 * bounce**2 - 1))
    after = march.state.row("V0")[at]
    mass = march.state.row("MASS")[at]
    assert np.average(after, weights=mass) == pytest.approx(0.5 * kept, rel=0.01)
    np.testing.assert_allclose(after, 0.5 * kept, rtol=0.03)
    gained = np.sum(mass * (after + 0.5))
    assert march.take_load()[0, 0] * march.dt == pytest.approx(-gained, rel=1e-9)


def test_a_dashpot_of_no_strength_presses_as_the_bare_spring(rng):
    """A strand that moves through a tine which grows, at T = 0."""
    tine = Tine(position=(0.009, 0, -0.05), axis=(0.1, 1, 0.2), length=0.1, radius=0.008,
                insertion=0.1)  # fmt: skip
    march = Explicit(Scene(rods=[bar()], duration=1, tines=[tine]))
    state, forces = march.state, []
    for name in ["X0", "X1", "X2", "V0", "V1", "V2"]:
        state.row(name)[state.nodes(0)] += rng.normal(0, 3e-4, 25)
    place(march.tines, 0.09)
    for viscous in [None, 0.0]:
        for name in ["F0", "F1", "F2"]:
            state.row(name)[:] = 0
        tine_forces(state.buf, state.n, march.dt, march.tines._replace(viscous=viscous), None)
        forces.append(state.rows("F0 F1 F2").copy())
    assert np.abs(forces[0]).max() > 0
    np.testing.assert_allclose(*forces, rtol=1e-12, atol=1e-14)


def test_two_tines_of_a_comb_feel_what_each_would_feel_alone():
    """Each bends a cantilever of its own; the forces are those of two scenes with one tine each."""

    def comb(places):
        tines = [
            Tine(position=(x + 0.0131, 0, -0.08), axis=(0, 1, 0), length=0.1, radius=0.008,
                 direction=(-1, 0, 0), insertion=0, ramp=0.01, speed=0.05, travel=0.005)
            for x in places
        ]  # fmt: skip
        rods = [bar(root=(x, 0, 0)) for x in (0.0, 0.2)]
        march = Explicit(Scene(rods=rods, duration=1, damping=Damping(drag=30.0), tines=tines))
        march.advance(int(0.2 / march.dt))
        march.take_load()
        march.advance(200)
        return march.take_load() / 200

    together = comb([0.0, 0.2])
    alone = np.vstack([comb([0.0]), comb([0.2])])
    assert together[0, 0] > 1e-3
    np.testing.assert_allclose(together, alone, rtol=1e-9, atol=1e-12)


def test_a_growing_tine_pushes_a_strand_aside():
    """Inserted beside a strand, off its centreline, the tine ends up touching: r + t apart."""
    tine = Tine(position=(0.002, 0, -0.05), axis=(0, 1, 0), length=0.1, radius=0.01, insertion=0.2)
    rod = bar(tip=End(hold="clamped"), radius=0.001)
    march = Explicit(Scene(rods=[rod], duration=1, damping=Damping(drag=30.0), tines=[tine]))
    march.advance(int(0.6 / march.dt))
    nodes = march.state.strands()[0]
    distance = np.hypot(nodes[:, 0] - 0.002, nodes[:, 2] + 0.05).min()
    assert nodes[:, 0].min() < -0.008
    assert distance == pytest.approx(0.011, rel=0.01)


@pytest.mark.parametrize(("force", "slides"), [(-1.0, False), (1.0, True)])
def test_friction_with_the_nap_and_against_it(force, slides):
    """A strand pressed on a tine by its weight: its own pull on the root or on the tip decides.

    Coefficients 0.1 root to tip, 0.5 tip to root; the pull is 0.3 of the weight.
    """
    weight = 1000 * np.pi * 0.004**2 * 0.1 * 9.81
    pull = Load(force=(0.3 * weight * force, 0, 0), ramp=0.1)
    # Stiff: a strand that sags slides downhill as it goes.
    rod = bar(root=(-0.05, 0, 0.104), direction=(1, 0, 0), E=1e8).model_copy(
        update={"root": End(), "tip": End(load=pull)}
    )
    tines = [
        Tine(position=(x, 0, 0.05), axis=(0, 1, 0), length=0.1, radius=0.05, insertion=0)
        for x in (-0.02, 0.02)
    ]
    scene = Scene(
        rods=[rod], duration=1, gravity=(0, 0, -9.81), damping=Damping(drag=DRAG),
        friction=Friction(forward=0.1, backward=0.5), tines=tines,
    )  # fmt: skip
    march = Explicit(scene)
    march.advance(int(0.15 / march.dt))
    before = motion_along_x(march)
    march.advance(int(0.1 / march.dt))
    place, speed = np.array(motion_along_x(march)) - before
    if slides:  # v' = a - drag v
        kept = np.exp(-DRAG * 0.1)
        terminal = 9.81 * (0.3 - 0.1) / DRAG
        assert speed == pytest.approx((terminal - before[1]) * (1 - kept), rel=0.05)
    else:
        assert abs(place) < 1e-6


def motion_along_x(march):
    """Return the mean place [m] and speed [m/s] of the strand."""
    at = march.state.nodes(0)
    return march.state.row("X0")[at].mean(), march.state.row("V0")[at].mean()
