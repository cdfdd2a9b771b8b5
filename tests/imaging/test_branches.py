"""Skeletons cut into simple paths: every way of branching, and where wide strands lie."""

import cv2
import numpy as np
import pytest

from imaging.trace.branches import branches
from imaging.trace.centreline import arclength

WIDTH = 6


@pytest.mark.parametrize("width", [8, 10, 16, 23])
@pytest.mark.parametrize("left", [20, 21, 22])
def test_a_bar_has_one_branch_along_its_middle(width, left):
    mask = np.zeros((203, 91), bool)
    mask[11:190, left : left + width] = True
    (path,) = branches(mask, width)
    inner = path[(path[:, 1] > 11 + 2 * width) & (path[:, 1] < 190 - 2 * width)]
    middle = left + (width - 1) / 2
    assert np.abs(inner[:, 0] - middle).max() < max(1.0, 0.15 * width)
    np.testing.assert_allclose(np.diff(arclength(path)), 1, atol=0.45)
    assert path[:, 1].min() > 10
    assert path[:, 1].max() < 190


def drawn(*lines: list[tuple[int, int]], closed: bool = False) -> np.ndarray:
    picture = np.zeros((200, 200), np.uint8)
    for line in lines:
        cv2.polylines(picture, [np.array(line, np.int32)], closed, 1, WIDTH)
    return picture > 0


def is_simple(path: np.ndarray) -> bool:
    """Whether each point touches the next, and no point comes twice."""
    steps = np.abs(np.diff(path, axis=0)).max(axis=1)
    return bool((steps == 1).all()) and len(np.unique(path, axis=0)) == len(path)


def test_a_cross_has_four_arms_that_stop_short_of_its_middle():
    found = branches(drawn([(20, 100), (180, 100)], [(100, 20), (100, 180)]), WIDTH)
    assert len(found) == 4
    assert all(is_simple(path) for path in found)
    for path in found:
        near, far = sorted(np.hypot(*(path[[0, -1]] - 100).T))
        assert 0.8 * WIDTH < near < 2 * WIDTH
        assert far > 70


def test_a_ring_is_one_path_all_the_way_round():
    t = np.linspace(0, 2 * np.pi, 60, endpoint=False)
    corners = np.stack([100 + 60 * np.cos(t), 100 + 60 * np.sin(t)], axis=1).round().astype(int)
    (path,) = branches(drawn(corners.tolist(), closed=True), WIDTH)
    assert is_simple(path)
    assert arclength(path)[-1] > 0.9 * 2 * np.pi * 60
    np.testing.assert_allclose(np.hypot(*(path - 100).T), 60, atol=1.5)


def test_a_stump_shorter_than_a_strand_is_wide_parts_nothing():
    bar = drawn([(20, 100), (180, 100)])
    bar[100:107, 97:103] = True
    (path,) = branches(bar, WIDTH)
    assert is_simple(path)
    assert np.ptp(path[:, 0]) > 140


def test_specks_and_nothing_have_no_branch():
    assert branches(np.zeros((50, 50), bool), WIDTH) == []
    assert branches(drawn([(100, 100), (102, 100)]), WIDTH) == []
