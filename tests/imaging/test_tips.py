"""Tips of strands that show again beyond what hides them, and what is none."""

import numpy as np
from drawn.strands import render
from scipy.spatial import cKDTree

from imaging import Photo, crossings, segment, trace
from imaging.trace.tips import led_on

RED, GREEN = (0.85, 0.1, 0.2), (0.1, 0.6, 0.25)
SHAPE = (260, 320)
BAR = np.stack([np.linspace(20, 300, 400), np.full(400, 200.0)], axis=1)


def below_the_bar(down_to: float):
    """Draw a red strand that hangs down beneath a green bar of 8 px, and trace it."""
    y = np.linspace(20, down_to, 400)
    red = np.stack([150 + 0.2 * (y - 20), y], axis=1)
    flat = np.zeros(400)
    drawn = render([red, BAR], [flat, flat + 20], [RED, GREEN], 4, SHAPE, rng=3)
    found = segment(Photo(drawn.pixels))
    strands = trace(found)
    tree = cKDTree(red)
    own = min(strands, key=lambda s: float(np.median(tree.query(s.line)[0])))
    return own, red, crossings(strands, found)


def test_a_tip_beyond_another_strand_is_reached():
    strand, red, table = below_the_bar(207.0)
    assert 207 < strand.line[-1, 1] < 207 + 4  # the tube's round end reaches a radius farther
    assert cKDTree(red).query(strand.line[8:-8])[0].max() < 1
    assert len(table) == 1


def test_a_tip_that_does_not_show_again_is_not_made_up():
    strand, _, table = below_the_bar(199.0)
    assert strand.line[-1, 1] < 198
    assert strand.ends[1] == "hidden"
    assert len(table) == 0


def dot(*places: tuple[int, int]) -> np.ndarray:
    """Draw a strand down to (50, 40), 6 px wide, and 4 by 4 px of its colour at these places."""
    seen = np.zeros((120, 100), bool)
    seen[:40, 47:53] = True
    for x, y in places:
        seen[y - 2 : y + 2, x - 2 : x + 2] = True
    return seen


def reached(seen: np.ndarray, covered: np.ndarray) -> np.ndarray:
    """Last point of the strand of `dot`."""
    line = np.stack([np.full(41, 50.0), np.arange(41.0)], axis=1)
    return led_on({3: line}, [(3, True)], seen, covered, 6.0).get(3, line)[-1]


def test_specks_are_reached_one_after_another_under_cover_only():
    everywhere = np.ones((120, 100), bool)
    bare = everywhere.copy()
    bare[44:49] = False
    np.testing.assert_allclose(reached(dot((51, 55), (52, 75)), everywhere), [51.5, 74.5])
    np.testing.assert_allclose(reached(dot((51, 55)), bare), [50, 40])


def test_specks_aside_behind_and_far_ahead_are_left():
    everywhere = np.ones((120, 100), bool)
    np.testing.assert_allclose(reached(dot((75, 50), (60, 20)), everywhere), [50, 40])
    far = np.pad(dot(), ((0, 60), (0, 0)))
    far[150:154, 48:52] = True
    np.testing.assert_allclose(reached(far, np.ones_like(far)), [50, 40])
