"""What stands out from the ground and belongs to no strand is listed."""

from dataclasses import replace

import numpy as np
import pytest
from drawn.tables import draw_table
from scipy.spatial import cKDTree

from imaging import Photo, segment, trace
from imaging.measure import measure
from imaging.measure.unassigned import unassigned, unassigned_notes, unassigned_table
from imaging.report.overlay import draw_overlay, overlay_svg
from imaging.report.tables import unassigned_table as report_table
from imaging.scale import parse_scale


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
    photo = two_bars()
    segmentation = segment(photo)
    strands = trace(segmentation, photo)
    assert unassigned(segmentation, strands) == []
    (lost,) = unassigned(segmentation, strands[:1])
    assert len(lost) > 160
    other = strands[1].line[:, 0].mean()
    assert np.abs(lost[:, 0] - other).max() < 3


def test_an_empty_list_has_the_types_of_others():
    empty = unassigned_table([])
    assert list(empty.dtypes) == [np.dtype(float)] * 3
    assert unassigned_notes(empty) == []


def two_bars() -> Photo:
    pixels = np.full((200, 300, 3), 240, np.uint8)
    pixels[10:190, 140:150] = (200, 30, 40)
    pixels[10:190, 40:50] = (20, 30, 140)
    return Photo(pixels)


def test_what_is_left_is_in_metres_too_and_dashed_in_the_overlay():
    whole = measure(two_bars(), parse_scale("10px/mm"))
    assert len(report_table(whole, "a.png")) == 0
    (line,) = unassigned(whole.segmentation, whole.strands[:1])
    found = replace(whole, strands=whole.strands[:1], unassigned=[line])
    (row,) = report_table(found, "a.png").to_dict("records")
    assert row["length_m"] == pytest.approx(row["length"] * 1e-4, rel=0.02)
    assert row["x_m"] == pytest.approx(row["x"] * 1e-4)
    shown = (found.photo, found.segmentation, found.strands, found.crossings[:0])
    plain, dashed = draw_overlay(*shown), draw_overlay(*shown, unassigned=[line])
    y, x = np.nonzero((plain != dashed).any(axis=-1))
    assert np.abs(x - line[:, 0].mean()).max() < 4
    assert 0.3 < len(np.unique(y)) / len(line) < 0.7
    assert overlay_svg(*shown, unassigned=[line]).count("<title>unassigned</title>") == 1
