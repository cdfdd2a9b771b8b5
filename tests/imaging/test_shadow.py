"""A shadow on the ground is no strand, and a grey strand is no shadow."""

import cv2
import numpy as np
import pytest
from drawn.strands import Look, render
from scipy import ndimage

from imaging import Photo, segment, trace
from imaging.measure.quality import notes_on

SHAPE = (300, 340)
COLOURS = [(0.9, 0.1, 0.3), (0.5, 0.5, 0.5), (0.08, 0.08, 0.08)]
GROUND = np.array([0.9, 0.9, 0.88])


def lines() -> list[np.ndarray]:
    y = np.linspace(15, 285, 400)
    return [np.stack([x + 20 * np.sin(y / 45 + x), y], axis=1) for x in (60.0, 150.0, 245.0)]


def photo(shadow: float, fall: tuple[float, float], softness: float, ground=GROUND) -> Photo:
    """Red, grey and black strands that keep so much light from the ground beside them."""
    hidden = np.zeros(SHAPE, np.float32)
    for line in lines():
        points = np.round((line + fall) * 8).astype(np.int32)
        cv2.polylines(hidden, [points], False, 1.0, 8, cv2.LINE_AA, 3)
    light = 1 - shadow * ndimage.gaussian_filter(hidden, softness)
    look = Look(background=ground * light[..., None] ** (1 / 2.2))
    flat = [np.zeros(400)] * 3
    return Photo(render(lines(), flat, COLOURS, 4, SHAPE, look=look, rng=3).pixels)


@pytest.mark.parametrize(
    ("shadow", "fall", "softness"),
    [(0.6, (18, 20), 6), (0.6, (16, 4), 3.5), (0.8, (14, 6), 4)],
)
def test_a_shadow_beside_its_strand_is_ground(shadow, fall, softness):
    seen = photo(shadow, fall, softness)
    found = segment(seen)
    strands = trace(found)
    assert len(found.colours) == len(strands) == 3
    assert any("shadow" in note for note in notes_on(seen, found, strands))


def test_a_grey_strand_is_no_shadow():
    found = segment(photo(0, (0, 0), 1))
    assert found.shadow is None
    assert len(found.colours) == len(trace(found)) == 3


@pytest.mark.parametrize("grey", [0.65, 0.7])
def test_a_grey_strand_little_darker_than_the_ground_is_no_shadow(grey):
    found = segment(photo(0, (0, 0), 1, np.full(3, grey)))
    assert found.shadow is None
    assert len(found.colours) == len(trace(found)) == 3
