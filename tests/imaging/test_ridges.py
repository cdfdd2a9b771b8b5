"""Ridges stand out from the ground's own texture; edges of areas and the texture itself do not."""

import numpy as np
import pytest
from drawn.tables import draw_table
from scipy import ndimage
from scipy.spatial import cKDTree

from imaging import Photo, segment, trace
from imaging.segment.ridges import HIGH, WAYS, find_ridges, strong

SHAPE = (200, 260)


def lab(*lines: tuple[int, int], noise: float = 0.0) -> np.ndarray:
    """Grey picture with upright bars, each from one column to another, 40 Lab units darker."""
    picture = np.full((*SHAPE, 3), (70, 0, 0), np.float32)
    for first, last in lines:
        picture[:, first:last, 0] -= 40
    return picture + noise * np.random.default_rng(1).normal(size=(*SHAPE, 1)).astype(np.float32)


@pytest.mark.parametrize("width", [5, 8, 12, 17])
def test_a_bar_is_a_ridge_along_itself(width):
    found = find_ridges(lab((100, 100 + width)))
    middle = 100 + width // 2
    assert (found.response[40:160, middle] > HIGH).all()
    assert set(found.way[40:160, middle].tolist()) <= {WAYS // 2 - 1, WAYS // 2, WAYS // 2 + 1}
    assert 0.5 < np.median(found.width[40:160, middle]) / width < 2


def test_the_edge_of_an_area_is_none():
    assert not strong(find_ridges(lab((130, 260)))).any()


def test_noise_is_none():
    assert strong(find_ridges(lab(noise=12.0))).mean() < 1e-3


def test_grain_raises_no_alarm_but_a_bar_across_it_does():
    rough = ndimage.gaussian_filter(np.random.default_rng(2).standard_normal(SHAPE), (30, 1))
    grain = lab()
    grain[..., 0] += (8 * rough / rough.std()).astype(np.float32)
    assert strong(find_ridges(grain)).mean() < 0.01
    grain[90:100, :, 0] -= 40
    assert strong(find_ridges(grain))[95, 20:-20].mean() > 0.9


@pytest.mark.parametrize("ground", ["wood", "cloth", "gravel", "sheet"])
def test_no_strand_is_made_of_a_table(ground):
    table = draw_table(ground, 3, makes=("plain", "glossy"))
    photo = Photo(table.pixels)
    strands = trace(segment(photo), photo)
    cables = cKDTree(np.concatenate(table.lines))
    on_cables = [(cables.query(s.line)[0] < 2 * max(table.radii)).mean() for s in strands]
    assert min(on_cables) > 0.5
    assert len(strands) > 0
