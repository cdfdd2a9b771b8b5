"""A tine that combs a double helix, photograph by photograph."""

from pathlib import Path

import numpy as np
import pytest
from drawn.helix import draw_helix
from scipy.spatial import cKDTree

from imaging import Photo, Segmentation, Unmeasurable, read_photo
from imaging.helix import helix
from imaging.helix.sequence import (
    helix_sequence,
    jump_across,
    kymograph,
    link_before,
    link_jump,
)
from imaging.report.helix_pictures import (
    draw_helix_overlay,
    kymograph_figure,
    link_figure,
    sequence_figure,
)
from imaging.scale import from_marker

R = 6.0
PITCH = 18 * R
LENGTH = 9 * PITCH
GREEN = (60, 140, 60)


def combed(place, behind, ahead):
    """Draw strands spread around a tine at arclength ``place``, less wound behind than ahead."""

    def link(s):
        wound = np.where(s < place, behind, ahead) / PITCH
        return np.where(np.abs(s - place) < 0.4 * PITCH, 0.0, wound)

    def radius(s):
        return R * (1 + 2.2 * np.exp(-(((s - place) / (0.35 * PITCH)) ** 2)))

    side_by_side = -2 * np.pi * behind * (place / PITCH - 0.4)
    picture = draw_helix(
        R, link, LENGTH, helix_radius=radius, phase=side_by_side, tine=(place, 2 * R),
        colours=((200, 40, 40), (40, 70, 190), GREEN), rng=4,
    )  # fmt: skip
    return exact(picture)


def exact(picture):
    labels = np.where(
        picture.membership.sum(axis=0) > 0.5, picture.membership.argmax(axis=0) + 1, 0
    )
    colours = np.zeros((len(picture.membership), 3))
    return Segmentation(labels.astype(np.int32), picture.membership, colours, 2 * R)


@pytest.fixture(scope="module")
def sequence():
    rest = exact(draw_helix(R, lambda s: 1 / PITCH, LENGTH, rng=5))
    frames = [combed(0.4 * LENGTH, 0.8, 1.1), combed(0.6 * LENGTH, 0.7, 1.3)]
    return helix_sequence(frames, [0.4, 0.6], before=rest)


def test_the_tine_is_found(sequence):
    np.testing.assert_allclose(sequence.jumps["tine"], [0.4 * LENGTH, 0.6 * LENGTH], atol=1.5 * R)


def test_the_jump_across_the_tine(sequence):
    """Over a pitch beyond a quarter of one: the strands are spread, unwound, over 0.15 of it."""
    jumps = sequence.jumps
    for side, wound in (("behind", [0.8, 0.7]), ("ahead", [1.1, 1.3])):
        apart = jumps[side] * PITCH - 0.85 * np.array(wound)
        np.testing.assert_allclose(apart, 0, atol=0.15)  # half-turns: an sd of 0.2
        assert (apart.abs() < 1.96 * jumps[f"{side}_sd"] * PITCH).all()
    apart = jumps["jump"] - 0.85 * np.array([0.3, 0.6])
    np.testing.assert_allclose(apart, 0, atol=0.15)
    assert (apart.abs() < 1.96 * jumps["jump_sd"]).all()
    assert (jumps["jump_sd"] < 0.3).all()


def stepped(start, end):
    """Mean of 100/m up to 0.05 m, 500/m for 2 mm on either side of it, 150/m beyond."""
    edges = np.array([0.0, 0.048, 0.052, 0.2])
    turns = np.cumsum([0.0, 0.048 * 100, 0.004 * 500, 0.148 * 150])
    return float(np.diff(np.interp([start, end], edges, turns))[0]) / (end - start), 3.0


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_a_jump_is_that_of_the_means_over_a_pitch_beyond_the_tines_reach(sense):
    def mean(start, end):
        value, sd = stepped(start, end)
        return sense * value, sd

    found = jump_across(mean, 0.05, 0.2, (sense * 100.0, 2.0))
    assert found["reach"] == pytest.approx(0.0025)
    assert (found["behind"], found["ahead"]) == pytest.approx((100, 150))
    assert found["jump"] == pytest.approx(0.5)
    assert found["jump_sd"] == pytest.approx(np.sqrt(3**2 + 3**2 + (0.5 * 2) ** 2) / 100)
    nearer = jump_across(mean, 0.05, 0.2, (sense * 100.0, 2.0), reach=0.001)
    assert nearer["behind"] == pytest.approx((0.009 * 100 + 0.001 * 500) / 0.01)
    assert nearer["ahead"] == pytest.approx((0.009 * 150 + 0.001 * 500) / 0.01)


def test_no_jump_where_less_than_half_a_pitch_is_left():
    for tine, side in ((0.0070, "behind"), (0.1930, "ahead")):
        near = jump_across(stepped, tine, 0.2, (100.0, 1.0))
        assert np.isnan(near[side])
        assert np.isnan(near["jump"])
    there = jump_across(stepped, 0.0076, 0.2, (100.0, 1.0))
    assert there["jump"] == pytest.approx(0)


def test_the_link_before_leaves_a_pitch_out_at_either_end():
    def mean(start, end):
        edges, turns = [0.0, 0.01, 0.19, 0.2], np.cumsum([0.0, 0.4, 18.0, 0.2])
        return float(np.diff(np.interp([start, end], edges, turns))[0]) / (end - start), 1.0

    assert link_before(mean, 0.2) == pytest.approx((100.0, 1.0))


def test_where_the_strands_are_spread_the_mean_over_a_pitch_is_by_their_sides(sequence):
    for one, place, wound in zip(
        sequence.measurements, (0.4 * LENGTH, 0.6 * LENGTH), (0.8, 0.7), strict=True
    ):
        s, sides = one.phase["s"], one.phase["by"] == "sides"
        assert sides[(s - place).abs().between(3 * R, 0.3 * PITCH)].all()
        behind = sides & s.between(place - 0.6 * PITCH, place - 0.5 * PITCH)
        link, sd = (one.link_density[name][behind] * PITCH for name in ("link", "sd"))
        # Half a pitch that is wound and half of which 0.4 is not, cut at the tine.
        true = wound * (1 - (0.4 - (place - s[behind] - 0.5 * PITCH) / PITCH))
        assert ((link - true).abs() < 0.1).all()
        assert ((link - true).abs() < 1.96 * sd).all()


def test_kymograph_has_a_row_for_each_place(sequence):
    x, s, change = kymograph(sequence, points=50)
    assert x.tolist() == [0.4, 0.6]
    assert change.shape == (2, 50)
    assert s[0] == 0
    assert np.nanmin(change) < -0.15
    assert np.nanmax(change) > 0.25


def test_pictures_can_be_drawn(sequence, tmp_path):
    for number, figure in enumerate([sequence_figure(sequence), kymograph_figure(sequence)]):
        figure.savefig(tmp_path / f"{number}.png")
        assert (tmp_path / f"{number}.png").stat().st_size > 5000


def test_overlay_marks_the_strands():
    picture = draw_helix(R, lambda s: 1 / PITCH, 4 * PITCH, rng=5)
    found = helix(exact(picture))
    overlay = draw_helix_overlay(Photo(picture.pixels), found)
    assert overlay.shape[0] % picture.pixels.shape[0] == 0
    zoom = overlay.shape[0] // picture.pixels.shape[0]
    x, y = np.rint(zoom * (found.axis[5:-5] + 0.5) - 0.5).astype(int).T
    plain = np.repeat(np.repeat(picture.pixels, zoom, axis=0), zoom, axis=1)
    assert np.median(overlay[y, x].min(axis=1)) > np.median(plain[y, x].min(axis=1)) + 50
    assert link_figure(found).axes[0].get_title().startswith("right-handed")


def test_without_a_tine_there_is_no_jump():
    found = helix(exact(draw_helix(R, lambda s: -1 / PITCH, 4 * PITCH, rng=5)))
    jump = link_jump(found)
    assert np.isnan(jump["jump"])
    assert jump["lambda_0"] == pytest.approx(1 / PITCH, rel=0.01)


def test_as_many_positions_as_frames():
    with pytest.raises(Unmeasurable, match="1 tine positions for 2 photographs"):
        helix_sequence([None, None], [0.1])


def test_behind_a_kink_the_axis_stays_between_the_strands_that_are_seen():
    """The strands hang apart down to the tine and are wound beyond it, aslant."""
    place = 0.5 * LENGTH

    def link(s):
        return np.where(s < place, 0.0, 1 / PITCH)

    def radius(s):
        return R * (1 + 2 / (1 + np.exp((s - place) / (0.1 * PITCH))))

    def heading(s):
        return -1.2 * np.clip((s - place) / PITCH, 0, 1)

    picture = draw_helix(R, link, LENGTH, helix_radius=radius, heading=heading, rng=8)
    found = helix(exact(picture))
    # Where strands that lie apart are cut off, their midline is not known.
    behind = found.phase["s"].between(6 * R, place - PITCH).to_numpy()
    assert behind.sum() > 20
    truth = picture.truth[["x", "y"]].to_numpy()
    apart = cKDTree(truth).query(found.axis[behind])[0]
    assert apart.max() < R
    assert found.phase["s"].iloc[-1] == pytest.approx(LENGTH, rel=0.02)


def test_what_changes_beside_a_tine_makes_no_ripple_far_from_it():
    """Simulated strands, even from two pitches below the tine on: 128.5 1/m, +- 0.3."""
    picture = Path(__file__).parents[2] / "data" / "photos" / "synthetic_helix_4.jpg"
    scale, photo = from_marker(read_photo(picture), 0.008)
    table = helix(photo, scale=scale).link_density
    even = table["link"][(table["s"] > 0.08) & (table["s"] < 0.138)].dropna()
    assert len(even) > 100
    assert np.median(np.abs(even - 128.5)) < 0.4
