"""Accuracy ladder: light, lens, sensor and surface far from ideal leave the strands as they are."""

import numpy as np
import pytest
from drawn.strands import Look, render
from scipy.spatial import cKDTree

from imaging import Photo, crossings, segment, trace
from imaging.trace.centreline import resample

SHAPE = (260, 300)
BRIGHT = [(0.85, 0.1, 0.2), (0.1, 0.6, 0.25), (0.1, 0.3, 0.8), (0.95, 0.8, 0.1)]


def scene() -> tuple[list[np.ndarray], list[np.ndarray]]:
    """Three wavy strands and a straight one over all of them."""
    y = np.linspace(15, 245, 400)
    waves = [80 + 25 * np.sin(y / 50), 140 - 35 * np.sin(y / 45), 230 + 30 * np.sin(y / 50 + 2)]
    lines = [np.stack([x, y], axis=1) for x in waves]
    lines.append(np.stack([np.linspace(20, 280, 400), np.linspace(60, 210, 400)], axis=1))
    return lines, [np.full(400, height) for height in (0.0, 20.0, 10.0, 30.0)]


def lamp(pixels: np.ndarray) -> np.ndarray:
    """Take 30 % of the green and 60 % of the blue: light of a warm bulb."""
    return (pixels * [1, 0.7, 0.4]).astype(np.uint8)


LADDER = {
    "even light": (Look(uneven=0), BRIGHT, None, 0.2),
    "a fifth of the light left in a corner": (Look(uneven=0.8), BRIGHT, None, 0.2),
    "mirror-like highlights": (Look(highlight=1.0), BRIGHT, None, 0.2),
    "blur of 1.5 px": (Look(blur=1.5), BRIGHT, None, 0.3),
    "noise of 5 %": (Look(noise=0.05), BRIGHT, None, 0.2),
    "noise of 8 %": (Look(noise=0.08), BRIGHT, None, 0.3),
    "colour cast": (Look(), BRIGHT, lamp, 0.2),
}


@pytest.mark.parametrize("rung", LADDER)
def test_every_strand_is_found_from_end_to_end(rung):
    look, colours, spoil, limit = LADDER[rung]
    lines, heights = scene()
    pixels = render(lines, heights, colours, 4, SHAPE, look=look, rng=5).pixels
    found = segment(Photo(pixels if spoil is None else spoil(pixels)))
    strands = trace(found)
    assert len(strands) == 4
    for truth in lines:
        tree = cKDTree(resample(truth, 0.1))
        strand = min(strands, key=lambda s, tree=tree: np.median(tree.query(s.line)[0]))
        error = tree.query(strand.line[8:-8])[0]
        assert np.sqrt((error**2).mean()) < limit
        assert (cKDTree(strand.line).query(truth)[0] < 2).mean() > 0.97
    table = crossings(strands, found)
    assert (table["kind"] == "inter").sum() == len(crossings(lines))
