"""A strand beside its shadow is one, in its own width; grey strands beside others are kept."""

import cv2
import numpy as np
import pytest
from drawn.tables import draw_table
from scipy.spatial import cKDTree

from imaging import Photo, segment, trace
from imaging.measure import measure
from imaging.photo import read_photo

SHAPE = (260, 340)
PAPER = np.array([0.72, 0.71, 0.68])


def lit(colour: tuple[float, ...], lee: float, *, depth: float = 0.93, blur: float = 3.0) -> Photo:
    """Draw a slanting strand 12 px wide on rough card, its shadow `lee` px below it."""
    rng = np.random.default_rng(2)
    grain = cv2.GaussianBlur(rng.normal(size=SHAPE), (0, 0), 2)
    picture = PAPER * (1 + 0.08 * grain / grain.std())[..., None]
    shade = cv2.GaussianBlur(strip(lee), (0, 0), blur)[..., None]
    own = cv2.GaussianBlur(strip(0), (0, 0), 0.7)[..., None]
    picture = (1 - own) * picture * (1 - depth * shade) + own * np.array(colour)
    coded = np.clip(picture, 0, 1) ** (1 / 2.2) + rng.normal(0, 0.008, (*SHAPE, 3))
    return Photo(np.round(255 * np.clip(coded, 0, 1)).astype(np.uint8))


def strip(down: float) -> np.ndarray:
    mask = np.zeros(SHAPE, np.float32)
    ends = np.rint(16 * np.array([[30, 60 + down], [310, 160 + down]])).astype(int)
    cv2.line(mask, *map(tuple, ends.tolist()), 1, 12, cv2.LINE_AA, 4)
    return mask


@pytest.mark.parametrize("lee", [16, 30])
@pytest.mark.parametrize("colour", [(0.75, 0.3, 0.03), (0.45, 0.02, 0.03)])
def test_a_strand_with_a_dark_shadow_is_one(colour, lee):
    photo = lit(colour, lee)
    found = measure(photo)
    (strand,) = found.strands
    true = np.stack([np.linspace(30, 310, 300), np.linspace(60, 160, 300)], axis=1)
    assert cKDTree(true).query(strand.line[10:-10])[0].max() < 4
    assert np.median(strand.width) == pytest.approx(12, rel=0.3)


def test_a_sharp_grey_strand_in_the_lee_is_kept():
    photo = lit((0.75, 0.3, 0.03), 30, depth=0.7, blur=0.7)
    assert len(trace(segment(photo))) == 2


def test_no_strand_is_made_of_shadows_under_one_lamp():
    table = draw_table("sheet", 4002, hard=True)
    photo = Photo(table.pixels)
    found = segment(photo)
    cables = cKDTree(np.concatenate(table.lines))
    for strand in trace(found, photo):
        near = cables.query(strand.line)[0] < 1.3 * max(table.radii)
        assert near.mean() > 0.5
    assert found.shadow is not None


def test_two_pipe_cleaners_are_two(shared):
    found = measure(read_photo(shared / "real" / "cc0" / "two_singles.jpg"))
    assert len(found.strands) == 2
    assert any("shadows" in note for note in found.notes)
