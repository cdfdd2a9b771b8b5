"""Intersections drawn by hand, and who is on top in rendered pictures."""

import numpy as np
import pytest
from drawn.strands import random_curl, render

from imaging import Photo, Strand, crossing_matrix, crossings, segment, trace


def test_right_angle():
    a = np.array([[0, 0], [10, 10]], float)
    b = np.array([[0, 10], [10, 0]], float)
    row = crossings([a, b]).iloc[0]
    assert (row["strand_a"], row["strand_b"], row["kind"]) == (1, 2, "inter")
    assert (row["x"], row["y"]) == pytest.approx((5, 5))
    assert (row["s_a"], row["s_b"]) == pytest.approx((np.sqrt(50), np.sqrt(50)))
    assert row["angle"] == pytest.approx(np.pi / 2)


def test_the_matrix_counts_the_crossings_of_every_two_strands_and_of_each_with_itself():
    loop = np.array([[0, 0], [10, 10], [10, 0], [0, 10]], float)
    across = np.array([[0, 8], [12, 8]], float)
    aside = across + [100, 0]
    found = crossing_matrix(crossings([loop, across, aside]), 3)
    assert found.tolist() == [[1, 3, 0], [3, 0, 0], [0, 0, 0]]


@pytest.mark.parametrize("degrees", [5, 30, 60, 85])
def test_angle_does_not_depend_on_direction(degrees):
    way = np.array([np.cos(np.radians(degrees)), np.sin(np.radians(degrees))])
    a = np.array([[-5.0, 0], [5, 0]])
    for b in (np.array([-5 * way, 6 * way]), np.array([6 * way, -5 * way])):
        assert crossings([a, b])["angle"].item() == pytest.approx(np.radians(degrees))


def test_crossing_at_a_vertex_counts_once():
    a = np.array([[0, 5], [5, 5], [10, 5]], float)
    b = np.array([[5, 0], [5, 5], [5, 10]], float)
    assert len(crossings([a, b])) == 1


def test_touching_without_crossing_of_parallel_lines_counts_nothing():
    a = np.stack([np.arange(10.0), np.zeros(10)], axis=1)
    assert crossings([a, a + [0, 1]]).empty


def test_figure_of_eight_crosses_itself_once():
    t = np.linspace(0.3, 2 * np.pi - 0.1, 200)
    line = np.stack([np.sin(2 * t) / 2, np.cos(t)], axis=1)
    table = crossings([line])
    assert table["kind"].tolist() == ["self"]
    assert (table["x"].item(), table["y"].item()) == pytest.approx((0, 0), abs=1e-3)


def test_uneven_sampling_finds_the_same():
    rng = np.random.default_rng(5)
    x = np.linspace(0, 30, 400)
    fine = np.stack([x, np.sin(x)], axis=1)
    coarse = fine[np.sort(rng.choice(400, 150, replace=False))]
    straight = np.array([[0, 0.2], [30, 0.25]])
    assert abs(len(crossings([fine, straight])) - len(crossings([coarse, straight]))) <= 1
    assert len(crossings([fine, straight])) == 10


@pytest.mark.parametrize("shift", [0.1, 0.5, 0.9])
def test_a_touch_is_one_contact_wherever_the_points_lie(shift):
    """Two lines overlap from x = -3.95 to 3.95, one has a point at -3.99: its next is at -2.99."""

    def strand(shift, height, bend):
        x = np.arange(-40, 40.0) + shift
        flat = np.ones(80)
        line = np.stack([x, height + bend * 0.01 * x**2], axis=1)
        return Strand(line, 5 * flat, 0.6 * flat, 0 * flat, flat.astype(int), ("free", "free"))

    below = strand(shift, 0.0, 1)
    assert len(crossings([below, strand(0.01, 2 * 0.01 * 3.95**2, -1)])) == 0
    assert len(crossings([below, strand(0.01, 2 * 0.01 * 6.95**2, -1)])) == 2


def test_over_and_under_in_rendered_curls():
    colours = [(0.85, 0.1, 0.2), (0.1, 0.6, 0.25), (0.1, 0.3, 0.8), (0.95, 0.85, 0.1)]
    right = answered = unknown = 0
    for seed in range(4):
        rng = np.random.default_rng(seed)
        lines, heights = random_curl(4, 500, 60, slope=0.7, correlation=50, rng=rng)
        lines = [line + [200, 20] for line in lines]
        found = segment(Photo(render(lines, heights, colours, 4, (540, 400), rng=rng).pixels))
        strands = trace(found)
        assert len(strands) == 4
        truth = [int(np.argmin([_gap(s.line, t) for t in lines])) for s in strands]
        for row in crossings(strands, found).query("kind == 'inter'").itertuples():
            pair = (truth[row.strand_a - 1], truth[row.strand_b - 1])
            level = [_height(lines[k], heights[k], row.x, row.y) for k in pair]
            if abs(level[0] - level[1]) < 8:  # tubes that pass through each other have no answer
                continue
            if row.over is None or row.over != row.over:
                unknown += 1
                continue
            answered += 1
            right += row.over == (row.strand_a if level[0] > level[1] else row.strand_b)
    assert answered > 15
    assert unknown <= 0.05 * answered
    assert right >= 0.97 * answered


def _gap(line: np.ndarray, truth: np.ndarray) -> float:
    return float(np.median(np.abs(np.interp(line[:, 1], truth[:, 1], truth[:, 0]) - line[:, 0])))


def _height(line: np.ndarray, height: np.ndarray, x: float, y: float) -> float:
    return float(height[np.hypot(*(line - [x, y]).T).argmin()])
