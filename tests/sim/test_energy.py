"""The ledger of energy: what is stored, put in and lost adds up, and keeping it changes nothing."""

import math

import numpy as np
import pytest

import sim
from sim.energy import books, elastic_energy, kinetic_energy
from sim.explicit import Explicit
from sim.kernels.ledger import contact_energy, tine_energy
from sim.march.effects import SOFTNESS
from sim.scene import (
    Contact,
    Damping,
    End,
    Load,
    Material,
    Motion,
    Rod,
    Scene,
    Straight,
    Tine,
)

RUBBER = Material(E=1e6, nu=0.5, density=1000)


def with_ledger(scene, **changes):
    output = scene.output.model_copy(update={"energy": True})
    return scene.model_copy(update={"output": output, **changes})


def largest_imbalance(scene, checks):
    """Return the largest change of the balance over the work put in by the end."""
    march = Explicit(scene)
    start = books(march)["balance"]
    worst = 0.0
    for _ in range(checks):
        march.advance(int(scene.duration / march.dt / checks))
        now = books(march)
        worst = max(worst, abs(now["balance"] - start))
    return worst / now["work_tines"], now


@pytest.mark.parametrize(
    ("turns", "friction", "bounce"),
    [
        (1.5, 0.3, 0.2),
        pytest.param(8, 0.0, 0.0, marks=pytest.mark.slow),
        pytest.param(8, 0.3, 0.0, marks=pytest.mark.slow),
        pytest.param(8, 0.3, 0.2, marks=pytest.mark.slow),
    ],
)
def test_ledger_closes_over_a_combing(turns, friction, bounce):
    """`bounce`: damping of the contact with the tine, of critical."""
    scene = sim.double_helix(
        pi1=18, turns=turns, friction=friction, elements_per_pitch=10, speed=0.4
    )
    rod, stiffness = scene.rods[0], SOFTNESS * scene.rods[0].material.E
    line_density = rod.material.density * math.pi * rod.radius**2
    sink = 2 * bounce * math.sqrt(line_density / stiffness)
    damping = scene.damping.model_copy(update={"tine": sink})
    scene = with_ledger(scene, gravity=(0, 0, -9.81), damping=damping)
    error, last = largest_imbalance(scene, 10)
    assert error < 0.01
    assert last["work_tines"] > 1e-4
    lost = last["lost_drag"] + last["lost_material"] + last["lost_friction"]
    assert lost > 0.5 * last["work_tines"]  # nearly all of it in the end


def test_keeping_the_ledger_changes_nothing_but_rounding():
    plain = sim.double_helix(pi1=18, turns=1, friction=0.2, elements_per_pitch=8)
    ends = []
    for scene in (plain, with_ledger(plain)):
        march = Explicit(scene)
        march.advance(3000)
        ends.append(np.concatenate(march.state.strands()))
    np.testing.assert_allclose(ends[0], ends[1], rtol=0, atol=1e-13)


def test_a_scene_without_a_ledger_says_so():
    with pytest.raises(ValueError, match="output.energy"):
        books(Explicit(sim.double_helix(pi1=18, turns=1)))


def test_work_of_loads_and_driven_ends_is_what_the_rod_stores():
    """Stretch a rod slowly by its tip, twist it by its root, pull another by a load."""
    rods = [
        Rod(shape=Straight(length=0.2), radius=0.01, elements=8, material=RUBBER,
            root=End(hold="clamped", motion=Motion(spin=(0, 0, 2.0), ramp=0.05, duration=0.3)),
            tip=End(hold="clamped", motion=Motion(velocity=(0, 0, -0.02), duration=0.3))),
        Rod(shape=Straight(root=(1, 0, 0), length=0.2), radius=0.01, elements=8, material=RUBBER,
            tip=End(load=Load(force=(0.01, 0, -1.0), couple=(0, 0, 1e-3), ramp=0.2))),
    ]  # fmt: skip
    scene = Scene(rods=rods, duration=1.0, damping=Damping(drag=20, material=1e-4))
    march = Explicit(with_ledger(scene))
    march.advance(int(scene.duration / march.dt))
    now = books(march)
    assert now["work_ends"] > 1e-3
    assert now["work_loads"] > 1e-4
    assert abs(now["balance"]) < 2e-3 * (now["work_ends"] + now["work_loads"])


def test_stored_energy_of_contact_has_the_contact_force_as_its_slope(rng):
    """Shift one of two tangled strands, and a strand over a tine: F = -dU/dx."""
    march = Explicit(crossing_with_tine())
    state, h = march.state, 1e-7
    march.advance(1)
    at = state.nodes(1)
    for k in range(3):
        x = state.row(f"X{k}")
        energies = []
        for shift in (h, -h):
            kept = x[at].copy()
            x[at] += shift
            energies.append(
                contact_energy(state.buf, state.n, march.contact)
                + tine_energy(state.buf, state.n, march.tines)
            )
            x[at] = kept
        slope = (energies[0] - energies[1]) / (2 * h)
        assert touching_force(march)[k] == pytest.approx(-slope, rel=1e-4, abs=1e-6)


def crossing_with_tine():
    def bar(direction, root):
        return Rod(shape=Straight(root=root, direction=direction, length=0.1), radius=0.005,
                   elements=6, material=RUBBER, root=End())  # fmt: skip

    tine = Tine(position=(0.02, 0, 0.0185), axis=(0, 1, 0), length=0.2, radius=0.005, insertion=0)
    rods = [bar((1, 0.2, 0.0), (-0.05, 0, 0)), bar((0.6, 1, 0.02), (-0.02, -0.05, 0.0092))]
    return Scene(rods=rods, duration=1, contact=Contact(overlap="push apart"), tines=[tine])


def touching_force(march):
    from sim.kernels.touch import touching_loads

    for name in ("F0", "F1", "F2"):
        march.state.row(name)[:] = 0
    touching_loads(
        march.state.buf, march.state.n, 1.0, march.dt, march.contact, None, march.tines, None
    )
    return march.state.rows("F0 F1 F2")[:, march.state.nodes(1)].sum(axis=1)


def test_energy_error_of_an_undamped_rod_stays_bounded_over_a_million_steps():
    errors = {}
    for factor in (1.0, 0.5):
        march = swinging(factor)
        start = kinetic_energy(march.state) + elastic_energy(march.state)
        drift = []
        for _ in range(100):
            march.advance(10_000)
            now = kinetic_energy(march.state) + elastic_energy(march.state)
            drift.append(now / start - 1)
        early, late = np.abs(drift[:50]).max(), np.abs(drift[50:]).max()
        assert late < 1.5 * early
        assert abs(np.mean(drift[50:]) - np.mean(drift[:50])) < 0.1 * early
        errors[factor] = np.std(drift)
    assert errors[1.0] / errors[0.5] == pytest.approx(4, rel=0.3)


def swinging(factor):
    """Return a strongly bent and twisting free rod, no damping."""
    rod = Rod(shape=Straight(length=0.1), radius=0.005, elements=10, material=RUBBER, root=End())
    scene = Scene(rods=[rod], duration=1)
    march = Explicit(scene, dt=factor * 0.5 * Explicit(scene).limit)
    s = np.linspace(-1, 1, 11)
    at = march.state.nodes(0)
    march.state.row("V0")[at] = 0.5 * (s**2 - np.mean(s**2))
    march.state.row("W2")[at.start : at.stop - 1] = 20 * np.sin(0.5 * math.pi * s[:-1])
    return march
