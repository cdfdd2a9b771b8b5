"""What the presets promise: geometry, damping and imperfection, computed apart."""

import math

import numpy as np
import pytest

import sim
from sim.scene import End, Output, Straight
from sim.scene.shapes import random_curvature

R = 4.25e-4


def test_lengths_of_the_double_helix_are_multiples_of_the_filament_radius():
    scene = sim.double_helix(24, 2, 3, height=0.1)
    first, second = (rod.shape for rod in scene.rods)
    assert (first.pitch, first.radius, first.height) == pytest.approx((24 * R, 2 * R, 0.1))
    assert second.phase - first.phase == pytest.approx(math.pi)
    assert scene.tines[0].radius == pytest.approx(3 * R)
    assert scene.rods[0].elements == round(12 * 0.1 / (24 * R))
    assert sim.double_helix(24).rods[0].shape.height == 0.15  # the paper's
    assert sim.double_helix(24, turns=7).rods[0].shape.height == pytest.approx(7 * 24 * R)


@pytest.mark.parametrize("q", [2, 7.5])
def test_the_tine_starts_q_pitches_above_the_free_end_and_leaves_it_behind(q):
    scene = sim.double_helix(24, height=0.15, q=q)
    (tine,) = scene.tines
    start = -tine.position[2]
    assert 0.15 - start == pytest.approx(q * 24 * R)
    assert start + tine.travel == pytest.approx(0.15 + 24 * R + tine.radius)


def test_a_rod_that_falls_with_the_presets_damping_sinks_at_g_over_50():
    """Under gravity and drag c: z = -(g/c) (t - (1 - exp(-c t))/c)."""
    preset = sim.double_helix(18)
    rod = preset.rods[0].model_copy(
        update={"shape": Straight(length=0.02), "elements": 4, "root": End(hold="free")}
    )
    falling = sim.Scene(
        rods=[rod], duration=0.1, gravity=(0, 0, -9.81), damping=preset.damping,
        output=Output(sample_rate=100, snapshots=5),
    )  # fmt: skip
    run = sim.simulate(falling)
    drop = np.array([run.strands(i)[0][0, 2] for i in range(5)]) - run.strands(0)[0][0, 2]
    t = run.times - run.times[0]
    np.testing.assert_allclose(drop, -9.81 / 50 * (t - (1 - np.exp(-50 * t)) / 50), rtol=0.01)


def test_damping_of_a_curl_is_near_critical_for_a_hanging_hair():
    assert sim.curl(12, length=0.3).damping.drag == pytest.approx(2 * math.sqrt(9.81 / 0.3))


def test_filaments_are_nylon_scaled_by_the_papers_factor():
    assert pytest.approx(0.078 * 2.8e9) == sim.double_helix(18).rods[0].material.E


@pytest.mark.parametrize("size", [0.02, 0.1])
def test_imperfection_is_the_share_of_the_helix_own_curvature(size):
    (rod, _) = sim.double_helix(18, 1.5, height=0.15, imperfection=size).rods
    # Curvature of x = R cos t, y = R sin t, z = c t is |x' x x''| / |x'|^3.
    t, radius, climb = 0.7, 1.5 * R, 18 * R / (2 * math.pi)
    speed = np.array([-radius * math.sin(t), radius * math.cos(t), climb])
    bend = np.array([-radius * math.cos(t), -radius * math.sin(t), 0.0])
    kappa = np.linalg.norm(np.cross(speed, bend)) / np.linalg.norm(speed) ** 3
    assert rod.curvature.sd == pytest.approx(size * kappa, rel=1e-9)
    assert rod.curvature.correlation == pytest.approx(18 * R)
    lengths = np.full(200000, 0.01 * rod.curvature.correlation)
    drawn = random_curvature(
        lengths, rod.curvature.sd, rod.curvature.correlation, rng=np.random.default_rng(1)
    )
    assert drawn.std() == pytest.approx(size * kappa, rel=0.05)


def test_the_curl_is_as_wavy_as_asked():
    scene = sim.curl(5, curvature=70, correlation=0.02, length=0.1)
    assert [rod.curvature.sd for rod in scene.rods] == [70] * 5
    assert scene.rods[0].curvature.correlation == 0.02
    assert scene.gravity == (0.0, 0.0, -9.81)
    assert scene.rods[0].shape.length == 0.1


def test_a_left_handed_helix_is_combed_as_the_mirror_image_of_a_right_handed_one():
    """Mirrored in y = 0: the same force, the opposite link, as long as rounding stays small."""
    runs = {}
    for handedness in ("right", "left"):
        scene = sim.double_helix(
            pi1=24, turns=3, elements_per_pitch=8, insertion=2e-3, handedness=handedness
        )
        runs[handedness] = sim.simulate(scene.model_copy(update={"duration": 6e-3}))
    right, left = runs["right"], runs["left"]
    assert right.data.attrs["link_drawn"] == pytest.approx(3, abs=0.01)
    assert left.data.attrs["link_drawn"] == pytest.approx(-right.data.attrs["link_drawn"], rel=1e-9)
    mirrored = [strand * [1, -1, 1] for strand in left.strands(-1)]
    np.testing.assert_allclose(mirrored, right.strands(-1), atol=1e-7)
    force = right.force_log().force
    np.testing.assert_allclose(left.force_log().force, force, atol=1e-3 * abs(force).max())
    assert abs(force).max() > 1e-5


@pytest.mark.parametrize("preset", [sim.double_helix, sim.curl])
def test_presets_record_forces_and_frames_when_asked(preset):
    plain, asked = preset().output, preset(forces=True, frames=True).output
    assert (plain.forces, plain.frames, asked.forces, asked.frames) == (False, False, True, True)


@pytest.mark.parametrize("handedness", ["right", "left"])
def test_the_tine_passes_between_the_strands_and_a_pitch_has_its_samples(handedness):
    """Its axis is normal to the line that joins the strands at its depth, from their shapes."""
    scene = sim.double_helix(24, height=0.15, q=7.3, handedness=handedness, samples_per_pitch=150)
    (tine,) = scene.tines
    turn = 2 * math.pi * -tine.position[2] / (24 * R) * (1 if handedness == "right" else -1)
    joins = np.array([math.cos(turn), -math.sin(turn), 0.0])  # along -z a right hand turns back
    assert np.dot(tine.axis, joins) == pytest.approx(0, abs=1e-9)
    assert np.linalg.norm(tine.axis) == pytest.approx(1)
    assert scene.output.sample_rate * (24 * R / tine.speed) == pytest.approx(150)
