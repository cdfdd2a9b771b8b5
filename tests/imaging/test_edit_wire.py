"""Where a line drawn by hand is led: along strands, not along borders of areas."""

import numpy as np
import pytest
from drawn.strands import render
from drawn.waves import photographed, waves

from imaging import Photo
from imaging.edit.wire import CHEAPEST, wire_cost


def at(cost, scale, line):
    column, row = np.rint((line + 0.5) / scale - 0.5).astype(int).T
    return cost[row, column]


@pytest.mark.parametrize("width", [4.0, 6.0, 9.0])
def test_strands_are_cheap_in_their_middle(width):
    cost, scale = wire_cost(photographed(), width)
    for wave in waves():
        on = at(cost, scale, wave[5:-5])
        aside = at(cost, scale, wave[5:-5] + [5, 0])
        assert np.median(on) < 5 * CHEAPEST
        assert np.median(aside) > 3 * np.median(on)


def test_the_border_of_an_area_is_no_ridge():
    y = np.linspace(10, 190, 200)
    line = np.stack([np.full(200, 60.0), y], axis=1)
    pixels = render([line], [np.zeros(200)], [(0.8, 0.1, 0.1)], 3, (200, 240), rng=1).pixels.copy()
    pixels[:, 150:] = (90, 110, 160)
    cost, scale = wire_cost(Photo(pixels), 6.0)
    border = np.stack([np.full(200, 150.0), y], axis=1)
    beside = np.min([at(cost, scale, border + [d, 0]) for d in range(-8, 9)], axis=0)
    assert np.median(at(cost, scale, line[5:-5])) < 5 * CHEAPEST
    assert np.median(beside) > 150


def test_a_large_photograph_gives_a_small_picture():
    cost, scale = wire_cost(Photo(np.full((3000, 4000, 3), 90, np.uint8)), 3.0)
    assert cost.size <= 1.21e6
    np.testing.assert_allclose(np.multiply(cost.shape[::-1], scale), (4000, 3000))
