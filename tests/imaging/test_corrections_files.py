"""Files of corrections: JSON that says what is wrong with it, ImageJ's regions, label pictures."""

import json

import cv2
import numpy as np
import pytest
from drawn.waves import SHAPE, off, scene, waves
from hypothesis import given, settings
from hypothesis import strategies as st

from imaging import Corrections, Unmeasurable, crossings, read_corrections
from imaging.correct import beside, correct, written
from imaging.correct.schema import Anchor, Delete, Draw, Join, Only, Split, Top, parse_corrections
from imaging.correct.steps import ALREADY, APPLIED
from imaging.report.imagej import write_rois
from imaging.report.overlay import labels_picture

NUMBERS = st.floats(-1e4, 1e4, allow_nan=False)
POINTS = st.tuples(NUMBERS, NUMBERS)
LINES = st.lists(POINTS, min_size=2, max_size=5)
ANCHORS = st.builds(Anchor, at=POINTS, along=POINTS.filter(any))
STEPS = st.one_of(
    st.builds(Delete, line=LINES),
    st.builds(Split, here=ANCHORS),
    st.builds(lambda a, b, t: Join(start=a, to=b, through=t), ANCHORS, ANCHORS, LINES),
    st.builds(Draw, points=LINES),
    st.builds(Only, lines=st.lists(LINES, min_size=1, max_size=3)),
    st.builds(Top, at=POINTS, over=POINTS, under=POINTS, known=st.booleans()),
)


@given(st.lists(STEPS, max_size=6), st.none() | st.integers(1, 99))
@settings(max_examples=60, deadline=None)
def test_what_is_written_reads_back(steps, strands):
    said = Corrections(steps=steps, strands=strands, ground=["#a0b0c0"])
    assert parse_corrections(written(said), "x") == said


WRONG = {
    "[1, 2": r"line 1, column 6: not JSON",
    "[1, 2]": "corrections: ",
    '{"format": "combing corrections", "version": 2}': "version: Input should be 1, not 2",
    '{"strands": 0}': "strands: Input should be greater than 0, not 0",
    '{"stands": 3}': "stands: Extra inputs are not permitted, not 3",
    '{"colours": ["red"]}': r"colours\[0\]: .*, not 'red'",
    '{"steps": [{"do": "remove"}]}': r"steps\[0\]: .*'delete'",
    '{"steps": [{"do": "split", "here": {"at": [1, 2, 3], "along": [1, 0]}}]}': "here.at",
    '{"steps": [{"do": "split", "here": {"at": [1, 2], "along": [0, 0]}}]}': "direction",
    '{"steps": [{"do": "draw", "points": [[1, 2]]}]}': r"steps\[0\].points",
    '{"steps": [{"do": "draw", "points": [[1, NaN], [1, 2]]}]}': r"points\[0\]",
}


@pytest.mark.parametrize("text", WRONG)
def test_a_wrong_file_names_place_and_value(text, tmp_path):
    path = tmp_path / "a.jpg.corrections.json"
    path.write_text(text)
    with pytest.raises(Unmeasurable, match=WRONG[text]) as caught:
        read_corrections(path)
    assert str(caught.value).startswith(str(path))
    assert "\n" not in str(caught.value)


def test_other_files_are_refused_in_a_line(tmp_path):
    for name, content in (("a.json", b"\xff\xfe\x00"), ("a.zip", b"none"), ("a.png", b"none")):
        (tmp_path / name).write_bytes(content)
        with pytest.raises(Unmeasurable, match=name) as caught:
            read_corrections(tmp_path / name)
        assert "\n" not in str(caught.value)
    with pytest.raises(Unmeasurable, match=r"no\.json: no such file"):
        read_corrections(tmp_path / "no.json")


def test_the_file_beside_a_photograph_is_found(tmp_path):
    photo = tmp_path / "curl.jpg"
    assert beside(photo) is None
    short = tmp_path / "curl.corrections.json"
    short.write_text("{}")
    assert beside(photo) == short
    full = tmp_path / "curl.jpg.corrections.json"
    full.write_text("{}")
    assert beside(photo) == full
    assert beside(tmp_path / "curl.tif") == short
    assert beside("array") is None


def test_regions_of_imagej_are_read_back(tmp_path):
    pytest.importorskip("roifile")
    photo, segmentation, strands = scene()
    path = tmp_path / "rois.zip"
    write_rois(path, strands, crossings(strands))
    said = read_corrections(path)
    made, hand = correct(photo, segmentation, strands, said)
    assert [one.outcome for one in hand.outcomes] == [ALREADY]
    assert [id(s) for s in made] == [id(s) for s in strands]
    made, hand = correct(photo, segmentation, strands[1:], said)
    assert [one.outcome for one in hand.outcomes] == [APPLIED]
    assert off(made[hand.by.index("drawn")].line, waves()[0]).mean() < 0.4


def test_a_picture_of_labels_is_read_back(tmp_path):
    photo, segmentation, strands = scene()
    path = tmp_path / "labels.png"
    cv2.imwrite(str(path), labels_picture(segmentation, strands))
    said = read_corrections(path)
    lines = said.steps[0].lines
    assert len(lines) == 3
    for line, wave in zip(lines, waves(), strict=True):
        assert off(np.array(line), wave).max() < 4  # across what hides it, straight on
        assert off(wave, np.array(line)).max() < 10
    made, hand = correct(photo, segmentation, strands[:1], said)
    assert hand.by == ["", "drawn", "drawn"]
    assert all(off(s.line, w).mean() < 0.5 for s, w in zip(made, waves(), strict=True))


def test_labels_that_are_none_are_refused(tmp_path):
    coloured = np.zeros((*SHAPE, 3), np.uint8)
    coloured[50:60, :, 1] = 200
    for name, picture in (("colour.png", coloured), ("empty.png", np.zeros(SHAPE, np.uint8))):
        cv2.imwrite(str(tmp_path / name), picture)
        with pytest.raises(Unmeasurable, match="corrections are JSON"):
            read_corrections(tmp_path / name)
    straight = np.zeros(SHAPE, np.uint8)
    straight[20:200, 100] = 1
    cv2.imwrite(str(tmp_path / "straight.png"), straight)
    line = np.array(read_corrections(tmp_path / "straight.png").steps[0].lines[0])
    assert np.ptp(line[:, 1]) > 170
    json.loads(written(read_corrections(tmp_path / "straight.png")))
