"""A strand that changes its colour is one strand; two strands that meet are two."""

import numpy as np
import pytest
from drawn.strands import render
from scipy.spatial import cKDTree

from imaging import Photo, Segmentation, Strand, crossings, segment, trace
from imaging.measure.doubts import doubt_notes
from imaging.report.overlay import labels_picture

RED, GREEN, BLUE = np.array([(0.85, 0.1, 0.2), (0.1, 0.6, 0.25), (0.1, 0.3, 0.8)])
SHAPE = (360, 220)
Y = np.linspace(20, 340, 640)
FLAT = np.zeros(len(Y))


def wave(phase: float = 0.0, amplitude: float = 30.0) -> np.ndarray:
    return np.stack([110 + amplitude * np.sin(Y / 40 + phase), Y], axis=1)


def dyed(first: np.ndarray, second: np.ndarray, at: float, blend: float = 0.1) -> np.ndarray:
    """Colours (n, 3) that pass from one to another around y = at, over about 4 blend px."""
    return first + (second - first) / (1 + np.exp(np.clip((at - Y) / blend, -50, 50)))[:, None]


def traced(lines, heights, colours, radius=4.0):
    found = segment(Photo(render(lines, heights, colours, radius, SHAPE, rng=3).pixels))
    return trace(found), found


def off(line: np.ndarray, truth: np.ndarray) -> np.ndarray:
    return cKDTree(truth).query(line)[0]


@pytest.mark.parametrize("blend", [0.1, 5.0, 30.0], ids=["sharp", "soft", "gradual"])
@pytest.mark.parametrize("radius", [2.5, 4, 8])
def test_a_strand_of_two_colours_is_one(radius, blend):
    line = wave(amplitude=15 if radius > 4 else 30)  # no tighter than six widths
    (strand,), found = traced([line], [FLAT], [dyed(RED, BLUE, 180, blend)], radius)
    assert np.ptp(strand.line[:, 1]) > 315
    assert np.percentile(off(strand.line, line), 95) < 0.1 * radius + 0.25
    (change,) = np.flatnonzero(np.diff(strand.tones))
    assert strand.line[change, 1] == pytest.approx(180, abs=2 * radius + 2 * blend)
    assert (np.delete(strand.edges, [0, -1]) == 2).mean() > 0.95
    assert set(np.unique(labels_picture(found, [strand]))) == {0, 1}


def test_it_crosses_another_in_both_its_colours():
    lines, colours = [wave(), wave(np.pi)], [dyed(RED, BLUE, 185), GREEN]
    strands, found = traced(lines, [FLAT + 20, FLAT], colours)
    assert len(strands) == 2
    table, truth = crossings(strands, found), crossings(lines)
    np.testing.assert_allclose(table["y"].sort_values(), truth["y"].sort_values(), atol=1)
    (on_top,) = {int(number) for number in table["over"]}
    assert set(strands[on_top - 1].tones) != set(strands[2 - on_top].tones)
    assert len(set(strands[on_top - 1].tones)) == 2


def test_a_crossing_at_its_very_root_has_the_colour_of_the_root():
    """A red and blue strand that begins on the axis of a green one, on top of it."""
    along = np.arange(0.0, 41.0)
    a, b = np.stack([50 + along, 50 + 0 * along], 1), np.stack([50 + 0 * along, 30 + along], 1)
    tones = np.where(along < 20, 0, 1)
    strands = [
        Strand(line, np.full(41, 8.0), np.full(41, 0.1), np.full(41, 2), own, ("free", "free"))
        for line, own in ((a, tones), (b, np.full(41, 2)))
    ]
    labels = np.zeros((100, 110), np.int32)
    labels[30:71, 46:55], labels[46:55, 46:71], labels[46:55, 71:91] = 3, 1, 2
    found = Segmentation(labels, np.zeros((3, 100, 110), np.float32), np.zeros((3, 3)), 8.0)
    row = crossings(strands, found).iloc[0]
    assert row["s_a"] == 0
    assert row["over"] == 1


def test_a_strand_of_one_of_its_colours_stays_apart():
    strands, _ = traced([wave(), wave(np.pi)], [FLAT, FLAT + 20], [dyed(RED, BLUE, 190), BLUE])
    assert sorted(len(set(strand.tones)) for strand in strands) == [1, 2]
    for strand in strands:
        assert (
            min(np.percentile(off(strand.line, truth), 97) for truth in (wave(), wave(np.pi))) < 1
        )


def test_a_change_beneath_another_strand_is_a_guess():
    at = crossings([wave(), wave(np.pi)])["y"].iloc[0]
    strands, _ = traced([wave(), wave(np.pi)], [FLAT, FLAT + 20], [dyed(RED, BLUE, at), GREEN])
    changed, plain = sorted(strands, key=lambda strand: -len(set(strand.tones)))
    assert [len(set(strand.tones)) for strand in (changed, plain)] == [2, 1]
    assert np.percentile(off(changed.line, wave()), 97) < 1
    (doubt,) = changed.doubts
    np.testing.assert_allclose(doubt, [110, at], atol=4)
    assert len(plain.doubts) == 0
    (note,) = doubt_notes(strands)
    assert f"(110, {at:.0f})" in note or f"({doubt[0]:.0f}, {doubt[1]:.0f})" in note


@pytest.mark.parametrize("step", [0, 9])
def test_two_strands_that_end_beneath_a_third_out_of_line_are_two(step):
    """Upper and lower ends lie under one bar, turned or moved against each other."""
    above = np.stack([FLAT + 90, np.linspace(20, 180, len(Y))], axis=1)
    turn = 0 if step else 1.0
    along = np.linspace(0, 130, len(Y))
    below = [90.0 + step, 182] + along[:, None] * np.array([np.sin(turn), np.cos(turn)])
    bar = np.stack([np.linspace(20, 200, len(Y)), FLAT + 181], axis=1)
    strands, _ = traced([above, below, bar], [FLAT, FLAT, FLAT + 20], [RED, BLUE, GREEN])
    assert len(strands) == 3
    assert all(len(set(strand.tones)) == 1 for strand in strands)


@pytest.mark.parametrize(
    ("gap", "step", "turn"),
    [(9, 0, 0), (-2, 3, 0), (0, 4, 0), (0, 0, 40), (-2, 0, 90)],
    ids=["apart", "a step aside", "half a width aside", "a corner", "a right angle"],
)
def test_two_strands_that_meet_are_two(gap, step, turn):
    """Ends are round: tubes whose lines end 8 px apart touch."""
    above = np.stack([FLAT + 110, np.linspace(20, 180 - gap / 2, len(Y))], axis=1)
    along = np.linspace(gap / 2, 130, len(Y))
    way = np.array([np.sin(np.radians(turn)), np.cos(np.radians(turn))])
    below = np.array([110.0 + step, 180]) + along[:, None] * way
    strands, _ = traced([above, below], [FLAT, FLAT + 3], [RED, BLUE])
    assert len(strands) == 2


def test_roots_that_meet_are_two_strands():
    """Two strands hang from one point, their upper ends together."""
    ways = [np.stack([110 + side * 0.35 * (Y - 20), Y], axis=1) for side in (-1, 1)]
    strands, _ = traced(ways, [FLAT, FLAT + 3], [RED, BLUE])
    assert len(strands) == 2
