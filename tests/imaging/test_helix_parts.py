"""The pieces of the helix measurement: drawing, axis, half-turns, visible edges, the fit."""

import numpy as np
import pytest
from drawn.helix import (
    bent_axis,
    draw_helix,
    tilt_strands,
    twist_in_space,
    twist_strands,
)
from scipy.interpolate import BSpline
from scipy.ndimage import gaussian_filter1d

from imaging.helix.axis import _central_path, axis_through, find_axis
from imaging.helix.banded import Bordered, Rows, inverse, log_determinant, solve
from imaging.helix.count import HalfTurns, Look, first_phase, half_turns
from imaging.helix.counted import _lines, _near
from imaging.helix.edges import CONTACT, HIDDEN, OUTER, visible
from imaging.helix.fit import Fit, _correlation
from imaging.helix.lean import LEANING, is_told, length_sd, mean_lean, said_of_lean, upright
from imaging.helix.model import Layout, Model, feet, outlines, positions
from imaging.helix.pair import linear_light, twisted_pair
from imaging.helix.profile import Profiles, edge_places, likely_blur, sampled_places
from imaging.helix.space import in_space, link_beyond_phase, sine_of_lean, writhe_shares
from imaging.helix.splines import basis, curve, knots
from imaging.photo import Photo
from imaging.segment import Segmentation

PLACES = np.linspace(20.0, 380.0, 50)


def gauss_link(a, b):
    """Link of two open curves by the double sum of Gauss's integrand."""
    da, db = np.diff(a, axis=0), np.diff(b, axis=0)
    ma, mb = 0.5 * (a[1:] + a[:-1]), 0.5 * (b[1:] + b[:-1])
    r = ma[:, None] - mb[None]
    triple = np.einsum("ijk,ijk->ij", r, np.cross(da[:, None], db[None]))
    return float(np.sum(triple / np.linalg.norm(r, axis=2) ** 3) / (4 * np.pi))


@pytest.mark.parametrize("sign", [1, -1])
def test_drawn_strands_link_as_stated_in_space(sign):
    s = np.linspace(0, 100, 1500)
    phi = sign * 2 * np.pi * s / 10
    # x right, y down, z to the viewer is left-handed: mirror z for the right-handed formula.
    a, b = (p * [1, 1, -1] for p in twist_strands(bent_axis(s, 0 * s), phi, 1.0))
    assert gauss_link(a, b) == pytest.approx(sign * 10, abs=0.5)


def test_a_bent_axis_has_unit_speed():
    s = np.linspace(0, 50, 5000)
    axis = bent_axis(s, np.sin(s / 10))
    steps = np.linalg.norm(np.diff(axis, axis=0), axis=1)
    np.testing.assert_allclose(steps, np.diff(s), rtol=1e-5)


def test_tilting_shortens_by_the_cosine():
    points = np.column_stack([np.zeros(3), np.arange(3.0), np.zeros(3)])
    tilted = tilt_strands(points, np.radians(60))
    np.testing.assert_allclose(tilted[:, 1], 0.5 * points[:, 1])
    assert tilted[2, 2] < 0  # the tip moves away from the viewer


def test_drawn_coverage_is_the_area_of_the_tubes():
    drawn = draw_helix(5.0, lambda s: 0.0, 200.0, phase=0.0, blur=0.8, rng=0)
    area = 2 * (10.0 * 200.0 + np.pi * 25.0)  # straight, side by side, round ends
    assert drawn.membership.sum() == pytest.approx(area, rel=2e-3)


def test_axis_is_the_midline_whatever_the_phase():
    drawn = draw_helix(6.0, lambda s: 1 / 108, 500.0, rng=0)
    axis = find_axis(drawn.membership.sum(axis=0), 6.0)
    inner = axis.points[40:-40]
    middle = np.interp(inner[:, 1], drawn.truth["y"], drawn.truth["x"])
    assert np.abs(inner[:, 0] - middle).max() < 0.25


def test_axis_runs_from_the_root():
    drawn = draw_helix(6.0, lambda s: 1 / 108, 300.0, rng=0)
    pair = drawn.membership.sum(axis=0)
    assert find_axis(pair, 6.0).points[0, 1] < find_axis(pair, 6.0).points[-1, 1]
    down = find_axis(pair, 6.0, root="bottom").points
    assert down[0, 1] > down[-1, 1]


def test_a_central_path_is_that_of_the_body_wherever_it_lies():
    body = np.zeros((60, 90), bool)
    body[10:18, 5:80] = body[18:50, 70:80] = True
    path = _central_path(body)
    assert path.min(axis=0).tolist() >= [5, 10]
    moved = _central_path(np.pad(body, ((7, 300), (40, 9))))
    np.testing.assert_array_equal(moved, path + [40, 7])


def seen_of(phi):
    """Look at a touching pair of unit strands at phases phi, one section per unit of arclength."""
    d = 20 * np.cos(phi)
    return Look(np.arange(float(len(phi))), d, 15 * np.sin(phi))


@pytest.mark.parametrize("turns", [4.0, -4.0, 2.3])
def test_half_turns_are_counted_with_their_sense(turns):
    phi = 0.4 + 2 * np.pi * turns * np.linspace(0, 1, 800)
    found = half_turns(seen_of(phi), 10.0)
    truth = np.interp(found.s, np.arange(800.0), phi)
    offset = np.round((found.phase - truth)[0] / (2 * np.pi)) * 2 * np.pi
    np.testing.assert_allclose(found.phase - offset, truth, atol=0.05)
    assert set(found.sense) == {np.sign(turns)}


def test_a_twist_that_is_taken_back_has_no_net_link():
    s = np.linspace(0, 1, 1000)
    phi = 0.3 + 2 * np.pi * np.where(s < 0.5, 4 * s, 4 - 4 * s)
    found = half_turns(seen_of(phi), 10.0)
    assert found.sense.sum() == 0
    assert len(found.sense) == 8


def test_first_phase_continues_beyond_the_crossings():
    turns = HalfTurns(np.array([10.0, 20.0]), np.array([0.0, np.pi]), np.ones(2), np.ones(2))
    np.testing.assert_allclose(
        first_phase(turns, np.array([0.0, 15.0, 30.0])) / np.pi, [-1, 0.5, 2]
    )


def across(d_a, d_b, r=8.0):
    return np.array([[[d_a - r], [d_a + r]], [[d_b - r], [d_b + r]]])


def test_edges_of_a_strand_fully_in_front():
    border = visible(across(0.0, 0.0), np.array([True]))
    assert (border == HIDDEN).all()  # outlines coincide: whose edge it is cannot be told
    border = visible(across(-4.0, 4.0), np.array([True]))
    assert border[0, :, 0].tolist() == [OUTER, CONTACT]
    assert border[1, :, 0].tolist() == [HIDDEN, OUTER]


def test_edges_of_strands_apart():
    border = visible(across(-20.0, 20.0), np.array([True]))
    assert border[0, :, 0].tolist() == [OUTER, HIDDEN]
    assert border[1, :, 0].tolist() == [HIDDEN, OUTER]


def shaded_edge(place, rim, slope, ground, sections=40, blur=1.0, noise=0.004):
    """Light across a tube's edge at ``place``: ``rim`` there, rising inwards, even beyond."""
    x = sampled_places(5.0, 2.5)
    fine = np.arange(-20, 20, 0.02)
    light = np.where(fine < place, rim + slope * (place - fine), ground)
    light = np.interp(x, fine, gaussian_filter1d(light, blur / 0.02))
    seen = np.repeat(light[None, :, None], sections, axis=0)
    seen = seen + np.random.default_rng(1).normal(0, noise, seen.shape)
    return Profiles(x, seen, np.arange(sections), False)


@pytest.mark.parametrize("place", [-1.3, 0.0, 0.8])
@pytest.mark.parametrize(("rim", "slope", "ground"), [(0.1, 0.06, 0.005), (0.3, 0.02, 0.85)])
def test_an_edge_is_where_the_step_is_however_dim_the_rim(place, rim, slope, ground):
    """Half of the light inside is passed up to 1.5 px inside the rim of a shaded tube."""
    found, _ = edge_places(shaded_edge(place, rim, slope, ground), 5.0, 1.0)
    assert np.median(found) == pytest.approx(place, abs=0.1)


def test_the_blur_of_a_picture_is_that_of_its_edges():
    edges = [shaded_edge(0.3, 0.2, 0.03, 0.01, blur=b, noise=0.001) for b in (1.4, 1.4)]
    assert likely_blur(edges, 5.0) == 1.4


def test_where_there_is_no_step_there_is_no_edge():
    x = sampled_places(5.0, 2.5)
    even = np.random.default_rng(2).normal(0.3, 0.01, (30, len(x), 1))
    found, _ = edge_places(Profiles(x, even, np.arange(30), False), 5.0, 1.0)
    assert np.isnan(found).mean() > 0.9


def test_strands_wound_about_a_plane_axis_are_the_same_in_space():
    s = np.linspace(0, 300, 400)
    plane, phi = bent_axis(s, 0.6 * np.sin(s / 90)), 0.2 * s
    flat = twist_strands(plane, phi, 5.0)
    wound = twist_in_space(np.column_stack([plane, np.zeros(400)]), phi, 5.0)
    np.testing.assert_allclose(wound, flat, atol=1e-9)


def straight_model(length=400.0, r=6.0, pitch=100.0, lean=0.0):
    axis = axis_through(np.column_stack([np.full(50, 30.0), np.linspace(10, 10 + length, 50)]))
    layout = Layout(
        knots(0, length, 10.0),
        knots(0, length, 20.0),
        knots(0, length, 50.0),
        knots(0, length, 50.0),
    )
    beta = np.zeros(layout.size)
    beta[layout.blocks["phi"]] = 2 * np.pi * layout.phi[2:-2] / pitch
    beta[layout.blocks["R"]] = r
    beta[layout.blocks["radii"]] = r
    beta[layout.blocks["lean"]] = lean
    return Model(axis, layout, beta, np.array([30.0, 200.0]))


def test_splines_reproduce_a_line_and_its_slope():
    model = straight_model()
    s = np.linspace(0, 400, 77)
    np.testing.assert_allclose(model.at(s).phi, 2 * np.pi * s / 100, atol=1e-9)
    np.testing.assert_allclose(model.at(s).dphi, 2 * np.pi / 100, atol=1e-12)
    assert basis(model.layout.phi, s).sum(axis=1) == pytest.approx(1.0)


def test_a_spline_slope_is_that_of_its_curve():
    knot = knots(0.0, 90.0, 7.0)
    coefficients = np.random.default_rng(2).normal(size=len(knot) - 4)
    reference = BSpline(knot, coefficients, 3)
    s = np.linspace(-3, 95, 400)
    inside = np.clip(s, 0, 90)
    for order in (0, 1):
        wanted = reference(inside, nu=order)
        np.testing.assert_allclose(curve(knot, coefficients, s, order), wanted, atol=1e-12)
        np.testing.assert_allclose(basis(knot, s, order) @ coefficients, wanted, atol=1e-12)


def test_a_banded_matrix_is_solved_and_inverted_within_its_band():
    """Ninety unknowns coupled to at most six on either side, and three coupled to all."""
    rng = np.random.default_rng(3)
    columns = np.hstack(
        [
            rng.integers(0, 84, 400)[:, None] + np.arange(7),
            90 + np.arange(3) * np.ones((400, 1), int),
        ]
    )
    rows, precision = Rows(columns, rng.normal(size=(400, 10))), rng.uniform(0, 1, 400)
    design = np.zeros((400, 93))
    np.put_along_axis(design, columns, rows.values, axis=1)
    information = Bordered.zero(90, 3, 6).plus(rows, precision)
    np.testing.assert_allclose(information.dense(), design.T * precision @ design, atol=1e-12)
    matrix = information.on_diagonal(np.full(93, 0.1))
    whole, right = matrix.dense(), rng.normal(size=93)
    x, found = solve(matrix, right)
    np.testing.assert_allclose(x, np.linalg.solve(whole, right), atol=1e-10)
    wanted = np.linalg.inv(whole)
    np.testing.assert_allclose(inverse(whole), wanted, atol=1e-10)
    inside = found.dense() != 0
    np.testing.assert_allclose(found.dense()[inside], wanted[inside], atol=1e-10)
    np.testing.assert_allclose(
        found.row_products(information), np.diag(wanted @ information.dense()), atol=1e-9
    )
    assert log_determinant(matrix) == pytest.approx(np.linalg.slogdet(whole)[1])
    np.testing.assert_allclose(rows.times(x), design @ x)
    np.testing.assert_allclose(rows.transposed(precision, 93), design.T @ precision)
    some = Rows(columns[:, :7], rows.values[:, :7])
    spread = np.einsum("ij,jk,ik->i", design[:, :90], wanted[:90, :90], design[:, :90])
    np.testing.assert_allclose(some.spread(found), spread)


def test_outlines_lie_one_radius_from_the_centreline():
    model = straight_model()
    edges = outlines(model)
    rows = np.arange(60, 340)
    for k in (0, 1):
        for j in (0, 1):
            points = np.column_stack([30.0 + edges[k, j, rows], 10.0 + rows])
            strand = np.full(len(rows), k)
            foot = feet(model, strand, rows.astype(float), points)
            gap = np.linalg.norm(points - positions(model, strand, foot), axis=1)
            np.testing.assert_allclose(gap, 6.0, atol=0.02)


def test_feet_are_the_nearest_points_of_the_strand():
    model, rng = straight_model(lean=0.1), np.random.default_rng(6)
    table, strand = model.table, rng.integers(0, 2, 200)
    start = rng.uniform(20, 380, 200)
    points = positions(model, strand, start) + rng.normal(0, 4.0, (200, 2))
    found = feet(model, strand, start, points)
    reached = np.linalg.norm(points - positions(model, strand, found), axis=1)
    every = np.linalg.norm(points[:, None] - table.strands[strand], axis=2)
    near = np.abs(table.s - start[:, None]) < 12  # another turn may come nearer still
    nearest = np.where(near, every, np.inf).min(axis=1)
    assert (reached < nearest + 1e-3).mean() > 0.98


def test_lines_along_a_curve_are_those_of_least_squares():
    rng = np.random.default_rng(8)
    s, y = 3000 + np.cumsum(rng.uniform(0.5, 1.5, 60)), 400 + np.cumsum(rng.normal(size=60))
    known = np.ones(60, bool)
    known[30:33] = False
    first, end = _near(s, known, 6.0)
    slope, value = _lines(s, y, first, end)
    for i in np.flatnonzero(known):
        near = known & (np.abs(s - s[i]) <= 6.0) & ((np.arange(60) < 30) == (i < 30))
        wanted = np.polyfit(s[near] - s[i], y[near], 1)
        np.testing.assert_allclose((slope[i], value[i]), wanted, rtol=1e-9)


@pytest.mark.parametrize("kind", [np.uint8, np.uint16])
def test_light_is_the_code_undone(kind):
    pixels = np.random.default_rng(3).integers(0, np.iinfo(kind).max, (5, 7, 3)).astype(kind)
    photo = Photo(pixels)
    np.testing.assert_allclose(linear_light(photo), photo.rgb() ** 2.2, rtol=1e-6)


def test_correlated_noise_counts_for_fewer_points():
    rng = np.random.default_rng(0)
    white = rng.normal(size=20_000)
    smooth = np.convolve(white, np.ones(5) / 5, mode="valid")
    everyone = np.ones(len(white), bool)
    assert _correlation(white, everyone) == pytest.approx(1.0, abs=0.1)
    assert _correlation(smooth, everyone[:-4]) == pytest.approx(5.0, rel=0.15)


def test_the_pair_is_the_two_colours_that_touch_longest():
    labels = np.zeros((60, 60), np.int32)
    labels[:, 10:15], labels[:, 15:20], labels[20:26, 20:60] = 1, 3, 2
    membership = np.stack([(labels == k).astype(np.float32) for k in (1, 2, 3)])
    assert twisted_pair(Segmentation(labels, membership, np.zeros((3, 3)), 5.0)) == (0, 2)


def test_a_seam_of_mixed_light_is_no_strand():
    """Between two strands light mixes to the colour of a bar across them."""
    labels = np.zeros((120, 60), np.int32)
    labels[:, 10:20], labels[:, 20:22], labels[:, 22:32], labels[50:62] = 1, 3, 2, 3
    membership = np.stack([(labels == k).astype(np.float32) for k in (1, 2, 3)])
    assert twisted_pair(Segmentation(labels, membership, np.zeros((3, 3)), 10.0)) == (0, 1)


def superhelix(turns=6.0, slope=0.5, size=20.0):
    """Axis (n, 3) wound about the vertical: x right, y down, z away, right-handed."""
    a = 2 * np.pi * turns * np.linspace(0, 1, 1500)
    return np.column_stack([size * np.cos(a), size * a / slope, size * np.sin(a)])


def test_writhe_of_a_long_superhelix_is_its_solid_angle():
    """Wr = n (1 - cos(a)) in size for n turns at the angle a from the axis (Fuller 1971)."""
    for turns in (6.0, 12.0):
        points = superhelix(turns)
        wrapped = turns * (1 - np.cos(np.arctan(0.5)))
        whole = np.sum(writhe_shares(points))
        inner = np.sum(writhe_shares(points)[375:-375])
        assert np.sign(whole) == np.sign(np.sum(writhe_shares(points * [1, 1, -1]))) * -1
        assert abs(inner) == pytest.approx(0.5 * wrapped, rel=0.05)


def test_writhe_is_the_double_sum_over_segments():
    points = superhelix(2.0)[::20]
    chord, middle = np.diff(points, axis=0), 0.5 * (points[1:] + points[:-1])
    apart = middle[:, None] - middle[None]
    distance = np.linalg.norm(apart, axis=2)
    np.fill_diagonal(distance, np.inf)
    cross = np.cross(chord[:, None], chord[None])
    wanted = np.einsum("ijk,ijk->i", apart / distance[..., None] ** 3, cross) / (4 * np.pi)
    np.testing.assert_allclose(writhe_shares(points), wanted, rtol=1e-10)


def test_a_plane_axis_has_no_writhe_and_its_link_is_the_phase():
    model = straight_model()
    arc, points = in_space(model)
    assert arc[-1] == pytest.approx(400.0, rel=1e-6)
    np.testing.assert_allclose(writhe_shares(points), 0.0, atol=1e-12)
    np.testing.assert_allclose(link_beyond_phase(model), 0.0, atol=1e-9)


def test_a_leaning_axis_is_longer_by_the_cosine():
    arc, points = in_space(straight_model(lean=np.sin(np.radians(20))))
    assert arc[-1] == pytest.approx(400.0 / np.cos(np.radians(20)), rel=1e-4)
    assert points[-1, 2] == pytest.approx(400.0 * np.tan(np.radians(20)), rel=1e-4)


def leaning_fit(lean, sd=0.01):
    """Fit of a straight pair whose lean's coefficients are independent, of this sd."""
    model = straight_model(lean=lean)
    layout = model.layout
    nothing = Bordered.zero(layout.size - layout.shared, layout.shared, layout.width)
    certainty = nothing.on_diagonal(np.full(layout.size, 1 / sd**2))
    return Fit(model, certainty, None, {}, 0.1, 1.0, np.zeros(0))


def test_a_mean_lean_is_an_angle_and_its_sd_holds_what_lights_do():
    lean, sd = mean_lean(leaning_fit(np.sin(0.3)), PLACES)
    assert lean == pytest.approx(0.3)
    # sd of the sine over its slope; ten coefficients' own sd averages out to little.
    assert sd == pytest.approx(LEANING / np.cos(0.3), rel=0.02)
    assert mean_lean(leaning_fit(np.sin(0.3), sd=0.5), PLACES)[1] > 2 * sd


@pytest.mark.parametrize(
    ("lean", "r", "told"), [(0.17, 8.0, True), (-0.17, 8.0, True), (0.1, 8.0, False),
                            (0.17, 5.9, False)],
)  # fmt: skip
def test_a_lean_is_told_beyond_two_sd_by_strands_of_six_pixels(lean, r, told):
    assert is_told(lean, 0.07, r) is told


def test_upright_takes_out_the_mean_and_leaves_how_the_lean_varies():
    one = leaning_fit(0.0)
    beta = one.model.beta.copy()
    where = one.model.layout.blocks["lean"]
    beta[where] = 0.2 + 0.1 * np.sin(np.arange(where.stop - where.start))
    bent = Fit(one.model.moved(beta), one.certainty, None, {}, 0.1, 1.0, np.zeros(0))
    mean, _ = mean_lean(bent, PLACES)
    other = upright(bent, mean)
    assert mean_lean(other, PLACES)[0] == pytest.approx(0.0, abs=1e-12)
    before, after = (sine_of_lean(f.model, PLACES) for f in (bent, other))
    np.testing.assert_allclose(before - after, np.sin(mean), atol=1e-12)


@pytest.mark.parametrize(("lean", "sd"), [(0.0, 0.1), (0.17, 0.06), (0.3, 0.02)])
def test_the_error_of_a_length_is_that_of_drawn_leans(lean, sd):
    """Lengths in the picture are the true ones times the cosine of the true lean."""
    true = lean + sd * np.random.default_rng(4).normal(size=200_000)
    corrected = np.cos(true) / np.cos(lean) - 1
    left = np.cos(true) - 1
    for wanted, untold in ((corrected, None), (left, lean)):
        reached = length_sd(0.0 if untold is not None else lean, sd, untold)
        assert reached == pytest.approx(np.sqrt(np.mean(wanted**2)), rel=0.05)


def test_what_is_said_of_a_lean():
    none = np.zeros(5)
    assert said_of_lean(none, 0.0, 0.06, told=False) == []
    assert said_of_lean(none, 0.05, 0.06, told=False) == []
    (untold,) = said_of_lean(none, np.radians(7), np.radians(4), told=False)
    assert "may lean +7 +- 4 degrees" in untold
    assert "not corrected" in untold
    (told,) = said_of_lean(none + np.radians(10), np.radians(10), 0.06, told=True)
    assert "leans +10.0 degrees" in told
    assert "corrected by 1.54 %" in told
