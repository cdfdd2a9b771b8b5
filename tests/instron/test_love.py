import json
from pathlib import Path

import numpy as np
import pytest

from instron import Rig, RigError, love_force, theory_curve, wrench
from instron.love import blocked_radius, free_radius, pitch_angle

REFERENCE = Path(__file__).parents[3] / "shared" / "reference" / "love_helix.json"
B, C, R = 2.0, 1.5, 0.7
ALPHA = np.radians(60)


def energy(alpha1, radius):
    """Elastic energy per length of the helix held at (alpha1, radius)."""
    bend = np.cos(alpha1) ** 2 / radius - np.cos(ALPHA) ** 2 / R
    twist = np.sin(alpha1) * np.cos(alpha1) / radius - np.sin(ALPHA) * np.cos(ALPHA) / R
    return B * bend**2 / 2 + C * twist**2 / 2


def test_every_row_of_the_reference_table():
    if not REFERENCE.exists():
        pytest.skip(f"no reference table at {REFERENCE}")
    for row in json.loads(REFERENCE.read_text())["rows"]:
        a, a1 = np.radians([row["alpha_deg"], row["alpha1_deg"]])
        free = free_radius(row["B"], row["C"], a, row["R"], a1)
        force, couple = wrench(row["B"], row["C"], a, row["R"], a1, free)
        assert free == pytest.approx(row["R1_free"], abs=1e-8)
        assert force == pytest.approx(row["F_free"], abs=1e-8)
        assert couple == pytest.approx(0, abs=1e-12)
        blocked = blocked_radius(a, row["R"], a1)
        force, couple = wrench(row["B"], row["C"], a, row["R"], a1, blocked)
        assert blocked == pytest.approx(row["R1_blocked"], abs=1e-8)
        assert force == pytest.approx(row["F_blocked"], abs=1e-8)
        assert couple == pytest.approx(row["K_blocked"], abs=1e-8)


def test_the_unloaded_helix_needs_no_wrench():
    assert wrench(B, C, ALPHA, R, ALPHA, R) == pytest.approx((0, 0), abs=1e-12)
    assert free_radius(B, C, ALPHA, R, ALPHA) == pytest.approx(R)


@pytest.mark.parametrize("ends", ["free", "blocked"])
def test_force_is_the_derivative_of_the_energy(ends):
    """F = dU/dz at the held couple (free) or the held number of turns (blocked)."""

    def radius(a1):
        return free_radius(B, C, ALPHA, R, a1) if ends == "free" else blocked_radius(ALPHA, R, a1)

    a1, h = np.radians(65), 1e-6
    slope = (energy(a1 + h, radius(a1 + h)) - energy(a1 - h, radius(a1 - h))) / (
        np.sin(a1 + h) - np.sin(a1 - h)
    )
    assert love_force(B, C, ALPHA, R, a1, ends) == pytest.approx(slope, rel=1e-6)


def test_force_diverges_at_the_stretch_of_a_straight_wire():
    rig = Rig(r=4.25e-4, E=2.8e9, pitch=18 * 4.25e-4, helix_radius=4.25e-4)
    curve = theory_curve(rig, active_length=0.1, D=0.2)
    # 70.76 degrees: the wire is 1/sin = 5.9 % longer than the helix.
    assert np.degrees(curve.attrs["alpha"]) == pytest.approx(70.76, abs=0.01)
    assert curve.attrs["max_stretch"] == pytest.approx(0.0059, abs=1e-4)
    assert curve["d"].iloc[-1] == pytest.approx(curve.attrs["max_stretch"])
    assert curve["F"].iloc[-1] > 1000 * curve["F"].iloc[50]
    assert (np.diff(curve["F"]) > 0).all()


def test_theory_is_independent_of_rigidity_when_scaled():
    shape = {"r": 4.25e-4, "pitch": 0.02, "helix_radius": 1e-3}
    soft, stiff = (theory_curve(Rig(E=E, **shape), 0.1, 0.01) for E in (1e8, 3e9))
    np.testing.assert_allclose(soft["f"], stiff["f"], rtol=1e-9)


def test_active_length_decides_the_curve():
    rig = Rig(B=1e-4, pitch=0.02, helix_radius=1e-3)
    short, long = (theory_curve(rig, h, 0.1)["d"].iloc[-1] for h in (0.05, 0.1))
    assert long == pytest.approx(2 * short)


def test_pitch_angle_of_the_paper():
    for pi1, degrees in ((18, 70.76), (24, 75.33), (48, 82.54)):
        assert np.degrees(pitch_angle(pi1, 1.0)) == pytest.approx(degrees, abs=0.01)


def test_a_rig_without_helix_is_refused():
    with pytest.raises(RigError, match="pitch"):
        theory_curve(Rig(B=1e-4), 0.1, 0.1)
    with pytest.raises(RigError, match="must be positive"):
        theory_curve(Rig(B=1e-4, pitch=0.02, helix_radius=1e-3), -0.1, 0.1)
