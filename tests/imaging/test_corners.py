"""Pieces cut where they turn as no strand does."""

import numpy as np
import pytest

from imaging.trace.centreline import resample
from imaging.trace.corners import without_corners

WIDTH = 5.0


@pytest.mark.parametrize("turn", [100, 140, 170])
def test_a_corner_is_cut_out_and_both_arms_keep_their_directions(turn):
    way = np.array([np.sin(np.radians(turn)), np.cos(np.radians(turn))])
    path = resample(np.array([[0, -60], [0, 0], 60 * way]))
    first, second = without_corners(path, WIDTH)
    np.testing.assert_allclose(first[:, 0], 0, atol=1e-9)
    assert -3 * WIDTH < first[-1, 1] < -WIDTH
    along = second[-1] - second[0]
    np.testing.assert_allclose(along / np.hypot(*along), way, atol=1e-9)
    assert WIDTH < np.hypot(*second[0]) < 3 * WIDTH


@pytest.mark.parametrize("radius", [1.5, 3, 10])
def test_a_bend_no_tighter_than_a_strand_is_left(radius):
    angle = np.linspace(0, 3 * np.pi / 2, 400)[:, None]
    path = resample(radius * WIDTH * np.hstack([np.cos(angle), np.sin(angle)]))
    (same,) = without_corners(path, WIDTH)
    np.testing.assert_array_equal(same, path)
