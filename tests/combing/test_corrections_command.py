"""`combing photo` with corrections by hand: beside the photograph, named, refused, on record."""

import json
from pathlib import Path

import cv2
import pandas as pd
import pytest
from drawn.waves import photographed, waves

from combing.compare.curl import measure_curl
from combing.study import CurlSet


@pytest.fixture
def photo(tmp_path) -> Path:
    path = tmp_path / "photos" / "waves.png"
    path.parent.mkdir()
    cv2.imwrite(str(path), photographed().pixels[..., ::-1])
    return path


def deleting(which: int, **more) -> str:
    line = [tuple(point) for point in waves()[which][::20]]
    step = {"do": "delete", "line": line}
    return json.dumps({"format": "combing corrections", "version": 1, "steps": [step], **more})


def test_the_file_beside_is_picked_up_and_told(photo, tmp_path, capsys, run):
    out = tmp_path / "out"
    assert run("photo", photo, "-o", out, "--quiet") == 0
    assert pd.read_csv(out / "strands.csv")["strand"].max() == 3
    assert "corrections" not in pd.read_csv(out / "interactions.csv")
    said = photo.with_name("waves.png.corrections.json")
    said.write_text(deleting(1))
    capsys.readouterr()
    assert run("photo", photo, "-o", out, "--quiet") == 0  # measured anew, without --again
    assert "corrected by hand: 1 delete" in capsys.readouterr().out
    tables = ("strands", "crossings", "unresolved", "interactions", "densities")
    for table in (pd.read_csv(out / f"{name}.csv") for name in tables):
        assert (table["corrections"] == 1).all()
    assert pd.read_csv(out / "strands.csv")["strand"].max() == 2
    record = json.loads((out / "provenance.json").read_text())
    assert record["corrections"]["file"] == said.name
    assert record["corrections"]["said"]["steps"] == json.loads(said.read_text())["steps"]
    assert [one["outcome"] for one in record["corrections"]["outcomes"]] == ["applied"]
    assert record["summary"]["corrections"] == {"applied": 1}
    assert run("photo", photo, "-o", out, "--quiet", "--no-corrections") == 0
    assert pd.read_csv(out / "strands.csv")["strand"].max() == 3


def test_another_file_the_number_and_colours(photo, tmp_path, capsys, run):
    other = tmp_path / "other.json"
    other.write_text(deleting(0, strands=3))
    assert run("photo", photo, "-o", tmp_path / "out", "--corrections", other, "--quiet") == 0
    said = capsys.readouterr().out
    assert "2 strands" in said
    assert "no longer fits: strands 3" in said
    run("photo", photo, "-o", tmp_path / "out", "--corrections", other, "--strands", 2, "--quiet")
    assert "no longer fits" not in capsys.readouterr().out
    run("photo", photo, "-o", tmp_path / "out", "--colours", "#c02030,#10a040", "--quiet")
    assert "2 strands" in capsys.readouterr().out


def test_wrong_requests_end_in_one_line(photo, tmp_path, capsys, run):
    said = photo.with_name("waves.png.corrections.json")
    said.write_text(deleting(0).replace("delete", "remove"))
    other = photo.with_name("b.png")
    other.write_bytes(photo.read_bytes())
    out = ("-o", tmp_path / "out", "--quiet")
    for request, message in (
        ((photo, *out), "waves.png.corrections.json: steps[0]"),
        ((photo, *out, "--corrections", tmp_path / "no.json"), "no.json: no such file"),
        ((photo, *out, "--corrections", said, "--no-corrections"), "give one of them"),
        ((photo, other, *out, "--corrections", said), "is of one photograph, not of 2"),
        ((other, *out, "--colours", "red"), "colours[0]"),
    ):
        assert run("photo", *request) == 2
        error = capsys.readouterr().err
        assert message in error
        assert error.count("\n") == 1
    assert not (tmp_path / "out" / "provenance.json").exists()


def test_a_study_picks_it_up(photo):
    chosen = CurlSet(name="waves", photos=[], pixel_size=1e-4, strands=2)
    photo.with_name("waves.png.corrections.json").write_text(deleting(1))
    found = measure_curl(photo, chosen, 5)
    assert found.attrs["strands"] == 2
    assert "corrected by hand: 1 delete" in found.attrs["notes"]
