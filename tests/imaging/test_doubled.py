"""Strands of one colour that cross, and what is said where they could have gone on otherwise."""

import cv2
import numpy as np
import pytest
from drawn.strands import render
from scipy.spatial import cKDTree

from imaging import Photo, segment, trace
from imaging.measure.doubts import doubt_notes
from imaging.trace.branches import ends_of
from imaging.trace.doubled import BROAD, SIDE_BY_SIDE, broad_parts, stems
from imaging.trace.matching import doubtful

BLUE = (0.1, 0.3, 0.8)
SHAPE = (320, 260)
MIDDLE = np.array([130.0, 160])


def straight(angle: float, length: float = 270.0) -> np.ndarray:
    """Line through the middle, `angle` degrees from the vertical."""
    along = np.linspace(-length / 2, length / 2, 600)[:, None]
    return MIDDLE + along * [np.sin(np.radians(angle)), np.cos(np.radians(angle))]


def traced(lines, radius=2.6):
    heights = [np.full(len(line), 8.0 * i) for i, line in enumerate(lines)]
    drawn = render(lines, heights, [BLUE] * len(lines), radius, SHAPE, rng=5)
    return trace(segment(Photo(drawn.pixels)))


@pytest.mark.parametrize("angle", [15, 18, 22, 26, 30, 45, 70, 90])
def test_strands_of_one_colour_that_cross_go_straight_on(angle):
    lines = [straight(20 - angle / 2), straight(20 + angle / 2)]
    strands = traced(lines)
    assert len(strands) == 2
    for line in lines:
        assert min(np.percentile(cKDTree(line).query(s.line)[0], 97) for s in strands) < 1.2


def test_a_short_arm_between_crossings_is_followed():
    """Three strands of one colour cross within a few widths of each other."""
    lines = [straight(angle) + [shift, 0] for angle, shift in ((-35, 0), (5, 12), (40, 24))]
    strands = traced(lines)
    assert len(strands) == 3
    for line in lines:
        assert min(np.percentile(cKDTree(line).query(s.line)[0], 97) for s in strands) < 1.2


@pytest.mark.parametrize("together", [3, 5, 8])
def test_strands_that_touch_side_by_side_and_part_have_not_crossed(together):
    """For so many widths their outline is that of two, although straight on would cross.

    There both may be drawn along their common middle, half a width from their own.
    """
    y = np.linspace(20, 300, 600)
    away = (np.abs(y - 160) - together * 2.6).clip(0)
    apart = 2.5 + 0.45 * (np.hypot(away, 15) - 15)
    lines = [np.stack([130 + side * apart, y], axis=1) for side in (-1, 1)]
    strands = traced(lines)
    assert len(strands) == 2
    for line in lines:
        assert min(np.percentile(cKDTree(line).query(s.line)[0], 97) for s in strands) < 2.6


def drawing(*paths):
    """Return the ends of straight pieces given by their first and last points."""
    return ends_of([np.linspace(a, b, 12) for a, b in paths], width=5.0)


def test_the_stem_of_a_crossing_is_told_from_a_single_strand():
    stem = ((0, -8), (0, 8))
    arms = [((x, 20 * side), (3 * x, 50 * side)) for x in (-3, 3) for side in (-1, 1)]
    assert stems(drawing(stem, *arms), 5.0).tolist() == [True, False, False, False, False]
    assert not stems(drawing(stem, *arms[:3]), 5.0).any()


def test_a_link_between_two_crossings_is_no_stem():
    """Two strands cross a third: whichever piece of it lies ahead, it is alone."""
    third = [((0, -40), (0, -17)), ((0, -8), (0, 8)), ((0, 17), (0, 40))]
    across = [((sx * 5, y), (sx * 30, y)) for sx in (-1, 1) for y in (-12.5, 12.5)]
    assert not stems(drawing(*third, *across), 5.0).any()


def test_joins_are_guesses_where_exchanged_partners_cost_little_more():
    joins = [(1, 2), (5, 6)]
    clear = [(1, 2, 30.0), (5, 6, 30.0), (1, 6, 20.0), (2, 5, 28.0)]
    assert doubtful(joins, clear) == set()
    close = [(1, 2, 30.0), (5, 6, 30.0), (1, 6, 30.0), (2, 5, 29.0)]
    assert doubtful(joins, close) == set(joins)
    assert doubtful([(1, 2)], [(1, 2, 30.0), (1, 4, 29.5)]) == {(1, 2)}


def test_strands_that_run_on_each_other_are_guesses_and_clean_crossings_are_not():
    y = np.linspace(20, 300, 600)
    apart = 0.2 + 25 * ((np.abs(y - 160) - 40).clip(0) / 100) ** 2
    along = traced([np.stack([130 + side * apart, y], axis=1) for side in (-1, 1)])
    assert len(along) == 2
    assert all(len(strand.doubts) for strand in along)
    (note,) = doubt_notes(along)
    assert "1 at" in note
    assert "2 at" in note
    across = traced([straight(-30), straight(40)])
    assert doubt_notes(across) == []


@pytest.mark.parametrize("apart", [0, 6, 11])
@pytest.mark.parametrize("angle", [0, 20, 45, 90])
def test_broad_parts_are_where_the_whole_masks_depth_says(angle, apart):
    width, mask = 10.0, np.zeros((200, 240), np.uint8)
    rotation = cv2.getRotationMatrix2D((120, 100), angle, 1)
    for aside in (-apart / 2, apart / 2):
        ends = np.array([[[20, 100 + aside], [190, 100 + aside]]])
        first, last = np.rint(cv2.transform(ends, rotation)[0]).astype(int).tolist()
        cv2.line(mask, first, last, 1, 10)
    cv2.line(mask, (120, 0), (120, 199), 1, 10)
    depth = cv2.distanceTransform(np.pad(mask, 1), cv2.DIST_L2, 5)[1:-1, 1:-1]
    core = depth > 0.5 * (BROAD * width + 1)
    _, number, stats, _ = cv2.connectedComponentsWithStats(core.view(np.uint8))
    long = np.hypot(*stats[:, [cv2.CC_STAT_WIDTH, cv2.CC_STAT_HEIGHT]].T) > SIDE_BY_SIDE * width
    core &= long[number]
    away = cv2.distanceTransform((~core).view(np.uint8), cv2.DIST_L2, 5)
    near = (away < 0.75 * width) & core.any()
    x, y, w, h = cv2.boundingRect(mask)
    truth = np.zeros_like(near)
    truth[y : y + h, x : x + w] = near[y : y + h, x : x + w]
    np.testing.assert_array_equal(broad_parts(mask.view(bool), width), truth)
