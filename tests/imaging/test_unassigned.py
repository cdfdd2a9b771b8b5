"""What stands out from the ground and belongs to no strand is listed."""

import numpy as np
import pytest
from drawn.tables import draw_table
from scipy.spatial import cKDTree

from imaging import Photo, segment, trace
from imaging.measure.unassigned import unassigned, unassigned_notes, unassigned_table


@pytest.fixture(scope="module")
def table():
    drawn = draw_table("wood", 3, makes=("plain", "glossy"))
    photo = Photo(drawn.pixels)
    segmentation = segment(photo)
    return segmentation, trace(segmentation, photo)


def test_a_strand_that_is_not_followed_is_listed_where_it_lies(table):
    segmentation, strands = table
    lost = max(strands, key=lambda strand: len(strand.line))
    others = [strand for strand in strands if strand is not lost]
    before, after = (unassigned_table(unassigned(segmentation, s)) for s in (strands, others))
    near = cKDTree(lost.line).query(after[["x", "y"]])[0] < segmentation.width
    gained = after["length"].sum() - before["length"].sum()
    assert after["length"][near].sum() > 0.7 * len(lost.line)
    assert 0.7 < gained / len(lost.line) < 1.1
    assert f"{len(after)} ridges" in unassigned_notes(after)[0]


def test_of_strands_that_are_followed_nothing_is_left(table):
    segmentation, strands = table
    left = unassigned_table(unassigned(segmentation, strands))
    on_strands = cKDTree(np.concatenate([s.line for s in strands]))
    assert (on_strands.query(left[["x", "y"]])[0] > segmentation.width).all()


def test_on_plain_ground_too():
    pixels = np.full((200, 300, 3), 240, np.uint8)
    pixels[:, 140:150] = (200, 30, 40)
    pixels[:, 40:50] = (20, 30, 140)
    photo = Photo(pixels)
    segmentation = segment(photo)
    strands = trace(segmentation, photo)
    assert unassigned(segmentation, strands) == []
    (lost,) = unassigned(segmentation, strands[:1])
    assert len(lost) > 180
    other = strands[1].line[:, 0].mean()
    assert np.abs(lost[:, 0] - other).max() < 3


def test_an_empty_list_has_the_types_of_others():
    empty = unassigned_table([])
    assert list(empty.dtypes) == [np.dtype(float)] * 3
    assert unassigned_notes(empty) == []
