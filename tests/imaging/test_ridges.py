"""Ridges stand out from the ground's own texture; edges of areas and the texture itself do not."""

import numpy as np
import pytest
from drawn.tables import draw_table
from imaging_curls import draw
from scipy import ndimage
from scipy.spatial import cKDTree

from imaging import Photo, segment, trace
from imaging.segment.crests import Piece, pieces_of, stands_out
from imaging.segment.ridges import WAYS, find_ridges

SHAPE = (200, 260)


def lab(*lines: tuple[int, int], noise: float = 0.0) -> np.ndarray:
    """Grey picture with upright bars, each from one column to another, 40 Lab units darker."""
    picture = np.full((*SHAPE, 3), (70, 0, 0), np.float32)
    for first, last in lines:
        picture[:, first:last, 0] -= 40
    return picture + noise * np.random.default_rng(1).normal(size=(*SHAPE, 1)).astype(np.float32)


def pieces(picture: np.ndarray) -> list[Piece]:
    """Pieces of ridges of which the ground's texture is no likely cause."""
    found = pieces_of(find_ridges(picture), picture)
    return [p for p in found if stands_out(p.response, len(p.line), p.width)]


@pytest.mark.parametrize("width", [5, 8, 12, 17])
def test_a_bar_is_a_ridge_along_itself(width):
    found = find_ridges(lab((100, 100 + width)))
    middle = 100 + width // 2
    assert (found.response[40:160, middle] > 7).all()
    assert set(found.way[40:160, middle].tolist()) <= {WAYS // 2 - 1, WAYS // 2, WAYS // 2 + 1}
    assert 0.5 < np.median(found.width[40:160, middle]) / width < 2


def test_the_edge_of_an_area_is_none():
    assert pieces(lab((130, 260))) == []


def test_noise_is_none():
    assert pieces(lab(noise=12.0)) == []


def test_grain_raises_no_alarm_but_a_bar_across_it_does():
    rough = ndimage.gaussian_filter(np.random.default_rng(2).standard_normal(SHAPE), (30, 1))
    grain = lab()
    grain[..., 0] += (8 * rough / rough.std()).astype(np.float32)
    assert pieces(grain) == []
    grain[90:100, :, 0] -= 40
    across = np.concatenate([piece.line for piece in pieces(grain)])
    assert len(across) > 0.9 * SHAPE[1]
    assert np.abs(across[:, 1] - 94.5).max() < 3


@pytest.mark.parametrize("ground", ["wood", "cloth", "gravel", "sheet"])
def test_no_strand_is_made_of_a_table(ground):
    table = draw_table(ground, 3, makes=("plain", "glossy"))
    photo = Photo(table.pixels)
    strands = trace(segment(photo), photo)
    cables = cKDTree(np.concatenate(table.lines))
    on_cables = [(cables.query(s.line)[0] < 2 * max(table.radii)).mean() for s in strands]
    assert min(on_cables) > 0.5
    assert len(strands) > 0


@pytest.mark.parametrize("seed", [1000, 1001, 1008])
def test_specks_of_a_like_colour_do_not_make_strands_banded(seed):
    """Noise gives specks of thin navy strands the colour of the blue ones."""
    found = segment(Photo(draw(seed).pixels))
    assert found.pieces is None
    assert len(found.colours) == 12


@pytest.mark.parametrize("seed", [0, 2, 1000])
def test_bands_of_unlike_colours_are_followed_by_ridges(seed):
    assert segment(Photo(draw_table("card", seed).pixels)).pieces is not None
