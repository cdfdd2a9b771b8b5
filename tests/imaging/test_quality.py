"""A ground whose texture hides strands is spoken of, a plain one is not."""

import numpy as np
import pytest
from drawn.strands import Look, render
from scipy import ndimage

from imaging import Photo, Strand, segment, trace
from imaging.measure.quality import edge_blur, notes_on

SHAPE = (260, 300)


@pytest.mark.parametrize(("grain", "said"), [(0.0, False), (0.2, True)])
def test_texture_of_the_ground_is_named(grain, said):
    streaks = ndimage.gaussian_filter(np.random.default_rng(1).standard_normal(SHAPE), (60, 2))
    colour = np.array([0.72, 0.55, 0.38])
    ground = np.clip(colour * (1 + grain * streaks / streaks.std())[..., None], 0, 1)
    y = np.linspace(15, 245, 300)
    lines = [np.stack([x + 20 * np.sin(y / 40), y], axis=1) for x in (80.0, 200.0)]
    colours = [(0.1, 0.2, 0.8), (0.9, 0.85, 0.1)]
    look = Look(background=ground)
    photo = Photo(render(lines, [np.zeros(300)] * 2, colours, 4, SHAPE, look=look, rng=2).pixels)
    found = segment(photo)
    notes = notes_on(photo, found, trace(found))
    assert any("ground varies" in note for note in notes) == said


def test_a_strand_none_of_whose_edges_is_seen_takes_no_note_down():
    """The rim of a half-black picture is followed, and shows both edges nowhere."""
    pixels = np.full((200, 300, 3), 255, np.uint8)
    pixels[:100] = 0
    photo = Photo(pixels)
    found = segment(photo)
    line = np.stack([np.linspace(20, 280, 200), np.full(200, 100.0)], axis=1)
    nothing = np.zeros(200, int)
    strand = Strand(line, np.full(200, 5.0), np.ones(200), nothing, nothing, ("free", "free"))
    assert edge_blur(photo, found.width, [strand]) == 0
    notes_on(photo, found, [strand])
