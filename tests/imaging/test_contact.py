"""Strands that hide each other along many widths, against what was drawn."""

import numpy as np
import pytest
from drawn.strands import render
from scipy.spatial import cKDTree

from imaging import Photo, crossings, segment, trace
from imaging.trace.branches import ends_of
from imaging.trace.centreline import resample
from imaging.trace.contact import Known, place
from imaging.trace.matching import join, refund, within_colour

RED, GREEN = (0.85, 0.1, 0.2), (0.1, 0.6, 0.25)
SHAPE = (260, 160)


def bars(hidden_at: float, width: int = 8) -> tuple[np.ndarray, Known, Known]:
    """One upright bar in front of another of the same width, `hidden_at` px aside; no blur."""
    picture = np.zeros((60, 60, 3), np.float32)
    x = np.arange(60) - 30
    picture[:, np.abs(x - hidden_at) < width / 2] = (0, 40, 10)
    picture[:, np.abs(x) < width / 2] = (30, 0, 0)
    upright = np.stack([np.full(50, 30.0), np.arange(5, 55)], axis=1)
    normal = np.tile([-1.0, 0.0], (50, 1))
    wide = np.full(50, float(width))
    front = Known(cKDTree(upright), normal, np.tile([30.0, 0, 0], (50, 1)), wide)
    rear = Known(cKDTree(upright), normal, np.tile([0, 40.0, 10], (50, 1)), wide)
    return picture, front, rear


@pytest.mark.parametrize("aside", [-5, -3, 0, 2, 4])
def test_a_hidden_bar_is_placed_by_its_sliver(aside):
    picture, front, rear = bars(aside)
    line = rear.points.data
    offset, sd = place(line, np.ones(50, bool), own=rear, others=[front], picture=picture)
    # The normal of a line that runs down the picture points to the left.
    np.testing.assert_allclose(-offset[10:-10], aside, atol=0.6)
    assert (sd[10:-10] < 4).all()


def touching(excursion: float) -> tuple[list[np.ndarray], list[np.ndarray]]:
    """Draw a straight strand on top of one that dips under it and comes out by `excursion` px."""
    y = np.linspace(20, 240, 500)
    straight = np.stack([np.full(500, 80.0), y], axis=1)
    dip = 80 - 25 + (25 + excursion) * np.exp(-(((y - 130) / 55) ** 2))
    return [straight, np.stack([dip, y], axis=1)], [np.full(500, 20.0), np.zeros(500)]


@pytest.mark.parametrize("excursion", [1.5, 2.5])
def test_a_strand_that_comes_out_on_the_other_side_crosses_twice(excursion):
    lines, heights = touching(excursion)
    found = segment(Photo(render(lines, heights, [RED, GREEN], 3, SHAPE, rng=2).pixels))
    strands = trace(found)
    table, truth = crossings(strands, found), crossings(lines)
    assert len(strands) == 2
    assert len(truth) == len(table) == 2
    np.testing.assert_allclose(np.sort(table["y"]), np.sort(truth["y"]), atol=8)
    rear = max(strands, key=lambda s: np.ptp(s.line[:, 0]))
    off = cKDTree(resample(lines[1], 0.05)).query(rear.line)[0]
    assert np.percentile(off, 95) < 0.7


@pytest.mark.parametrize("excursion", [-6.5, -8])
def test_a_strand_that_only_touches_does_not_cross(excursion):
    lines, heights = touching(excursion)
    found = segment(Photo(render(lines, heights, [RED, GREEN], 3, SHAPE, rng=2).pixels))
    assert len(crossings(lines)) == 0
    assert len(crossings(trace(found), found)) == 0


def test_a_strand_does_not_end_in_a_speck():
    """Two long pieces are joined, although each could be joined to a speck of its own instead."""
    y = np.arange(100.0)
    pieces = [
        np.stack([np.full(100, 50.0), y], axis=1),
        np.stack([np.full(4, 46.0), 112 + y[:4]], axis=1),
        np.stack([np.full(4, 62.0), 120 + y[:4]], axis=1),
        np.stack([np.full(100, 58.0), 136 + y], axis=1),
    ]
    covered, own = np.ones((260, 100), bool), np.zeros((260, 100), bool)
    ends = ends_of(pieces, 5)
    gains = within_colour(ends, covered, own, 5.0)
    refunds = [refund(length, False, 5.0) for length in (99.0, 3.0, 3.0, 99.0)]
    joins = join(ends, refunds, gains)
    assert joins == [(1, 6)]
