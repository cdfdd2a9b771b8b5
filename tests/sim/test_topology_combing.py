"""Lk = Tw + Wr where combing puts it to the test: corners, kinks, superhelices, slid strands."""

import numpy as np
import pytest

from sim import gauss_link, link_density, twist, writhe

from .ribbon import link_twist_writhe

PITCH = 18.0


def closed(points):
    return np.vstack([points, points[:1]])


def wound_around(centre, turns):
    """Strands of radius 1 wound around a curve, and the normal from it to the first, (n, 3) each.

    The frame is transported in parallel along the curve, so that the normal's twist is `turns`.
    """
    tangents = np.gradient(centre, axis=0)
    tangents /= np.linalg.norm(tangents, axis=1, keepdims=True)
    frame = np.zeros_like(centre)
    frame[0] = np.cross(tangents[0], [1.0, 0.2, 0.1])
    for i in range(1, len(centre)):
        frame[i] = frame[i - 1] - (frame[i - 1] @ tangents[i]) * tangents[i]
    frame /= np.linalg.norm(frame, axis=1, keepdims=True)
    steps = np.linalg.norm(np.diff(centre, axis=0), axis=1)
    angle = 2 * np.pi * turns * np.concatenate([[0], np.cumsum(steps)]) / steps.sum()
    normal = np.cos(angle)[:, None] * frame + np.sin(angle)[:, None] * np.cross(tangents, frame)
    return centre + normal, centre - normal, normal


def prolonged(curve, start, end, length=4000.0):
    return np.vstack([curve[0] - length * start, curve, curve[-1] + length * end])


@pytest.mark.parametrize("n", [4, 7, 30])
def test_link_of_a_close_ribbon_on_any_polygon_is_twist_plus_writhe(rng, n):
    """Normals in any direction: they lean along the chords, as those between kinked strands do."""
    for _ in range(20):
        curve = closed(rng.normal(size=(n, 3)))
        normals = closed(rng.normal(size=(n, 3)))
        link = gauss_link(curve, curve + 1e-7 * normals)
        assert link == pytest.approx(round(link), abs=1e-4)
        assert twist(curve, normals) + writhe(curve) == pytest.approx(link, abs=1e-4)


def test_superhelix_has_the_reference_twist_and_writhe(reference):
    expected = reference("topology")["superhelix"]
    turns, radius, length = 3, 8.0, 10 * PITCH
    rise = np.sqrt(length**2 - (2 * np.pi * turns * radius) ** 2)
    at = np.linspace(0, 1, 1201)
    angle = 2 * np.pi * turns * at
    centre = np.column_stack([radius * np.cos(angle), radius * np.sin(angle), rise * at])
    first, second, normal = wound_around(centre, 10)
    assert twist(centre, normal) == pytest.approx(expected["Tw"], abs=1e-3)
    along = np.array([0.0, 0.0, 1.0])
    assert writhe(prolonged(centre, along, along)) == pytest.approx(expected["Wr"], abs=5e-4)
    ends = [
        np.diff(centre, axis=0)[k] / np.linalg.norm(np.diff(centre, axis=0)[k]) for k in (0, -1)
    ]
    link = gauss_link(prolonged(first, *ends), prolonged(second, *ends))
    assert link == pytest.approx(expected["gauss"], abs=2e-3)
    total = twist(prolonged(centre, *ends), np.vstack([normal[:1], normal, normal[-1:]]))
    assert total + writhe(prolonged(centre, *ends)) == pytest.approx(link, abs=1e-3)


@pytest.mark.parametrize("degrees", [60, 90, 120])
def test_a_kink_changes_neither_link_nor_twist(degrees):
    """A plane kink, half a pitch long, in the middle of ten turns."""
    at = np.linspace(-1, 1, 2001)
    direction = np.radians(degrees) / 2 * np.tanh(at / 0.05)
    steps = np.column_stack([np.cos(direction), np.sin(direction), 0 * at])
    centre = np.cumsum(steps, axis=0) * 10 * PITCH / len(at)
    first, second, normal = wound_around(centre, 10)
    table = link_density(first, second, resolution=PITCH)
    assert table.attrs["total_link"] == pytest.approx(10, abs=1e-3)
    assert twist(centre, normal) == pytest.approx(10, abs=1e-3)
    assert writhe(centre) == pytest.approx(0, abs=1e-12)
    inside = table[(table.s > PITCH) & (table.s < 9 * PITCH)]
    np.testing.assert_allclose(inside.link * PITCH, 1, atol=0.04)


@pytest.mark.parametrize("slide", [0.0, 0.1, 0.25, 0.4], ids=lambda part: f"slid by {part} P")
def test_slid_strands_are_paired_so_that_link_is_twist_plus_writhe(slide):
    """Slid strands keep their ten turns; their straight ends lie nearer and nearer each other."""
    angle = np.linspace(0, 20 * np.pi, 501)
    later = angle + 2 * np.pi * slide
    first = np.column_stack([np.cos(angle), np.sin(angle), PITCH * angle / (2 * np.pi)])
    second = np.column_stack([-np.cos(later), -np.sin(later), PITCH * later / (2 * np.pi)])
    link, total_twist, total_writhe = link_twist_writhe(first, second)
    assert link == pytest.approx(10, abs=1e-6)
    assert total_twist + total_writhe == pytest.approx(link, abs=1e-6)
