"""A highlight is no strand of its own, and a white strand about a black one is no highlight."""

import numpy as np
import pytest
from drawn.helix import draw_helix
from drawn.strands import Look, render

from imaging import Photo, segment, trace

BLACK, RED, BLUE = (0.08, 0.08, 0.08), (0.9, 0.1, 0.3), (0.0, 0.35, 0.8)


@pytest.mark.parametrize("radius", [6, 8])
def test_glossy_strands_keep_one_colour_each(radius):
    y = np.linspace(30, 570, 700)
    lines = [np.stack([x + 15 * np.sin(y / 60), y], axis=1) for x in (60.0, 130.0, 200.0)]
    look = Look(highlight=0.6, light=(-0.4, -0.1, 0.85))
    flat = [np.zeros(700)] * 3
    pixels = render(lines, flat, [BLACK, RED, BLUE], radius, (600, 260), look=look, rng=2).pixels
    found = segment(Photo(pixels))
    assert len(found.colours) == 3
    strands = trace(found)
    assert len(strands) == 3
    for strand in strands:
        truth = min(lines, key=lambda line, x=strand.line[0, 0]: abs(line[0, 0] - x))
        x, y = strand.line[20:-20].T
        error = x - np.interp(y, truth[:, 1], truth[:, 0])
        assert np.sqrt((error**2).mean()) < 0.15 * radius  # the highlight lies 0.22 aside


def test_black_and_white_twisted_stay_two():
    black, white = (25, 25, 25), (240, 240, 240)
    scene = draw_helix(
        8,
        lambda s: np.full_like(s, 1 / 144),
        900,
        colours=(black, white, black),
        background=(90, 130, 160),
    )
    assert len(segment(Photo(scene.pixels)).colours) == 2
