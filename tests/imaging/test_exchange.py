"""Several strands of one colour that run together: how many, and which goes on as which."""

import numpy as np
import pytest
from drawn.strands import render
from scipy.spatial import cKDTree

from imaging import Photo, segment, trace
from imaging.trace.exchange import Course, Spline
from imaging.trace.lanes import graph_of

BROWN = (0.36, 0.22, 0.1)
SHAPE = (420, 240)
Y = np.linspace(15, 405, 800)
RADIUS = 3.0
SPLINE = Spline(stiffness=1e8, step=1.0)


def crossed() -> list[np.ndarray]:
    """Three that go through one place at small angles, and change sides there."""
    return [np.stack([120 + slope * (Y - 210), Y], axis=1) for slope in (-0.17, 0.02, 0.18)]


def touching() -> list[np.ndarray]:
    """Three that come together to lie side by side, and go apart again on their own sides."""
    apart = 0.0012 * (Y - 210) ** 2
    return [np.stack([120 + side * (1.02 * 2 * RADIUS + apart), Y], axis=1) for side in (-1, 0, 1)]


def drawn_segmentation(lines):
    heights = [np.full(len(line), 7.0 * i) for i, line in enumerate(lines)]
    return segment(Photo(render(lines, heights, [BROWN] * len(lines), RADIUS, SHAPE, rng=3).pixels))


@pytest.mark.parametrize("lines", [crossed(), touching()], ids=["crossed", "touching"])
def test_three_that_run_together_go_on_as_themselves(lines):
    strands = trace(drawn_segmentation(lines))
    assert len(strands) == 3
    for line in lines:
        off = [np.percentile(cKDTree(line).query(s.line)[0], 97) for s in strands]
        assert min(off) < 2.5


def test_as_many_strands_come_to_each_fork_as_leave_it():
    found = drawn_segmentation(crossed())
    graph = graph_of(found.labels == 1, found.membership[0], found.coverage, found.width)
    assert max(stretch.count for stretch in graph.stretches) == 3
    for fork in range(len(graph.forks)):
        meet = sum(s.count for s in graph.stretches for end in s.forks if end == fork)
        assert meet == 2 * len(graph.links[fork])
    ends = sum(s.count for s in graph.stretches for end in s.forks if end < 0)
    assert ends == 6
    assert abs(graph.width / (2 * RADIUS) - 1) < 0.2


def test_bundles_of_one_colour_are_no_block():
    found = drawn_segmentation(touching())
    assert found.blocks is None or not found.blocks.any()
    assert abs(found.width / (2 * RADIUS) - 1) < 0.25


def test_a_strand_goes_on_as_it_bends():
    x = np.arange(120.0)
    whole = np.stack([x, 0.004 * x**2], axis=1)
    sd = np.full(40, 0.3)
    before, after = (SPLINE.placed(Course(whole[part], sd)) for part in (slice(40), slice(80, 120)))
    hidden = Course(whole[40:80], np.full(40, np.nan))
    cost, line = SPLINE.through(before, hidden, after)
    kinked = SPLINE.placed(Course(whole[80:120] + [0, 8.0], sd))
    assert cost < 1
    assert SPLINE.through(before, hidden, kinked)[0] > cost + 100
    assert np.abs(line - whole[40:80]).max() < 0.5
