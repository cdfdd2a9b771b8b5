"""Exact topology against closed forms and independent numbers."""

from itertools import pairwise

import numpy as np
import pytest

from sim import average_crossing_number, gauss_link, link_density, twist, writhe
from sim.kernels import topology as kernels


def double_helix(pitch_over_radius, turns, per_turn=100, slide=0.0):
    """Right-handed strands of radius 1 that run the same way; b slid along by `slide` radians."""
    angle = np.linspace(0, 2 * np.pi * turns, round(turns * per_turn) + 1)

    def strand(phase, shift):
        at = angle + shift
        rise = pitch_over_radius * at / (2 * np.pi)
        return np.column_stack([np.cos(at + phase), np.sin(at + phase), rise])

    return strand(0.0, 0.0), strand(np.pi, slide)


def closed_curve(function, n=1200):
    t = np.linspace(0, 2 * np.pi, n + 1)
    return np.column_stack(function(t))


def pair_by_pair(first, second):
    """Return the link of every segment of `second` with `first`, one arc tangent after another."""
    a, b = ([kernels.point(curve, i) for i in range(len(curve))] for curve in (first, second))
    pairs = [[kernels.pair_link(*ab, *cd) for ab in pairwise(a)] for cd in pairwise(b)]
    return np.sum(pairs, axis=1)


def summed(first, second):
    sums = np.zeros(len(second) - 1)
    kernels.add_links(first, second, sums)
    return sums


@pytest.mark.parametrize("n", [2, 40, 129, 200])
def test_products_of_complex_numbers_add_up_to_the_link_of_all_pairs(rng, n):
    """Dense tangles, whose segments wind several times around the other curve."""
    a = np.cumsum(rng.normal(size=(n, 3)), axis=0)
    b = np.cumsum(rng.normal(size=(n + 5, 3)), axis=0)
    np.testing.assert_allclose(summed(a, b), pair_by_pair(a, b), atol=1e-12)


def test_a_segment_around_which_a_curve_winds_many_times_has_all_its_turns():
    """A long product passes the negative axis once a turn: 25 turns within one segment."""
    angle = np.linspace(0, 50 * np.pi, 1501)
    coil = np.column_stack([np.cos(angle), np.sin(angle), angle / 500])
    axis = np.array([[0, 0, -200.0], [0, 0, 200.0]])
    for second in (axis, axis[::-1]):
        total = summed(coil, second)
        np.testing.assert_allclose(total, pair_by_pair(coil, second), atol=1e-12)
        assert abs(total[0]) == pytest.approx(25, abs=1e-3)


def test_open_double_helices_have_the_reference_gauss_integral(reference):
    for row in reference("topology")["double_helix"]:
        a, b = double_helix(row["pitch_over_radius"], row["turns"], per_turn=60)
        assert gauss_link(a, b) == pytest.approx(row["gauss_open"], abs=1e-4)


def test_gauss_integral_converges_with_the_second_power_of_the_segment(reference):
    row = reference("topology")["double_helix"][1]
    errors = [
        abs(gauss_link(*double_helix(18.0, 5, per_turn=n)) - row["gauss_open"]) for n in (20, 40)
    ]
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.1)


def test_hopf_link_is_minus_one_and_an_orientation_reversed_one_plus_one():
    a = closed_curve(lambda t: (np.cos(t), np.sin(t), 0 * t))
    b = closed_curve(lambda t: (1 + np.cos(t), 0 * t, np.sin(t)))
    assert gauss_link(a, b) == pytest.approx(-1, abs=1e-12)
    assert gauss_link(a, b[::-1]) == pytest.approx(1, abs=1e-12)
    assert gauss_link(b, a) == pytest.approx(-1, abs=1e-12)


@pytest.mark.parametrize("k", [1, 2, 3, 5])
def test_parallel_strands_of_a_torus_link_have_link_k(k):
    def strand(phase):
        return closed_curve(
            lambda t: (
                (3 + np.cos(k * t + phase)) * np.cos(t),
                (3 + np.cos(k * t + phase)) * np.sin(t),
                -np.sin(k * t + phase),
            )
        )

    assert abs(gauss_link(strand(0), strand(np.pi))) == pytest.approx(k, abs=1e-10)


def test_borromean_rings_are_pairwise_unlinked():
    rings = [
        closed_curve(lambda t: (2 * np.cos(t), np.sin(t), 0 * t)),
        closed_curve(lambda t: (0 * t, 2 * np.cos(t), np.sin(t))),
        closed_curve(lambda t: (np.sin(t), 0 * t, 2 * np.cos(t))),
    ]
    for i in range(3):
        assert gauss_link(rings[i], rings[i - 1]) == pytest.approx(0, abs=1e-12)


def test_writhe_of_reference_curves(reference):
    trefoil, figure, polygon = reference("topology")["writhe"]
    first = closed_curve(
        lambda t: ((2 + np.cos(3 * t)) * np.cos(2 * t), (2 + np.cos(3 * t)) * np.sin(2 * t),
                   np.sin(3 * t)), 2400)  # fmt: skip
    second = closed_curve(
        lambda t: (np.sin(t) + 2 * np.sin(2 * t), np.cos(t) - 2 * np.cos(2 * t), -np.sin(3 * t)),
        2400,
    )
    assert writhe(first) == pytest.approx(trefoil["Wr"], abs=2e-5)
    assert writhe(second) == pytest.approx(figure["Wr"], abs=2e-5)
    corners = np.array(polygon["polygon"], float)
    assert writhe(np.vstack([corners, corners[:1]])) == pytest.approx(polygon["Wr"], abs=1e-12)


@pytest.mark.parametrize("row", [0, 1, 2])
def test_link_is_twist_plus_writhe_for_ribbons_on_a_trefoil(reference, row):
    expected = reference("topology")["white"][row]
    t = np.linspace(0, 2 * np.pi, 2401)
    radius = 2 + np.cos(3 * t)
    curve = np.column_stack([radius * np.cos(2 * t), radius * np.sin(2 * t), np.sin(3 * t)])
    tangent = np.roll(curve[:-1], -1, axis=0) - np.roll(curve[:-1], 1, axis=0)
    tangent = np.vstack([tangent, tangent[:1]])
    tangent /= np.linalg.norm(tangent, axis=1, keepdims=True)
    outward = np.column_stack(
        [np.cos(3 * t) * np.cos(2 * t), np.cos(3 * t) * np.sin(2 * t), np.sin(3 * t)]
    )
    outward -= np.sum(outward * tangent, axis=1, keepdims=True) * tangent
    outward /= np.linalg.norm(outward, axis=1, keepdims=True)
    angle = expected["k"] * t
    side = np.cross(tangent, outward)
    normal = np.cos(angle)[:, None] * outward + np.sin(angle)[:, None] * side
    assert twist(curve, normal) == pytest.approx(expected["Tw"], abs=1e-3)
    assert gauss_link(curve, curve + 0.05 * normal) == pytest.approx(expected["Lk"], abs=1e-3)
    assert twist(curve, normal) + writhe(curve) == pytest.approx(expected["Lk"], abs=1e-3)


def test_link_density_of_a_uniform_helix_is_one_turn_per_pitch():
    a, b = double_helix(18.0, 10, per_turn=25)
    table = link_density(a, b)
    middle = table[(table.s > 36) & (table.s < 144)]
    np.testing.assert_allclose(middle.link, 1 / 18, rtol=1e-3)
    assert table.attrs["total_link"] == pytest.approx(10, abs=1e-4)


def test_strands_slid_by_half_a_pitch_keep_their_link_density():
    a, b = double_helix(18.0, 10, per_turn=25, slide=np.pi)
    table = link_density(a, b)
    middle = table[(table.s > 36) & (table.s < 140)]
    np.testing.assert_allclose(middle.link, 1 / 18, rtol=2e-3)


def test_link_density_changes_sign_with_handedness_and_not_with_the_order_of_strands():
    a, b = double_helix(24.0, 6, per_turn=25)
    flip = np.array([1, 1, -1])
    right, left = link_density(a, b), link_density(a * flip, b * flip)
    np.testing.assert_allclose(left.link, -right.link, atol=1e-12)
    np.testing.assert_allclose(link_density(b, a).link, right.link, atol=1e-6)


def test_link_density_sees_a_step_of_the_pitch():
    angle = np.linspace(0, 2 * np.pi * 12, 301)
    rise = np.where(angle < 12 * np.pi, 18.0, 24.0) / (2 * np.pi)
    z = np.concatenate([[0], np.cumsum(rise[1:] * np.diff(angle))])
    a = np.column_stack([np.cos(angle), np.sin(angle), z])
    b = np.column_stack([-np.cos(angle), -np.sin(angle), z])
    table = link_density(a, b)
    np.testing.assert_allclose(table.link[(table.s > 30) & (table.s < 90)], 1 / 18, rtol=5e-3)
    np.testing.assert_allclose(table.link[(table.s > 126) & (table.s < 220)], 1 / 24, rtol=5e-3)


def test_average_crossing_number_bounds_the_link_from_above():
    a, b = double_helix(18.0, 5, per_turn=30)
    assert average_crossing_number(a, b) / 2 >= gauss_link(a, b)


def test_a_strand_of_wrong_shape_is_refused():
    with pytest.raises(ValueError, match=r"\(n, 3\)"):
        gauss_link(np.zeros((5, 2)), np.zeros((5, 3)))
