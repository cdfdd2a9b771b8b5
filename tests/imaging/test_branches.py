"""Skeletons of wide strands are drawn in larger pixels: they must lie where the strand does."""

import numpy as np
import pytest

from imaging.branches import branches
from imaging.centreline import arclength


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
