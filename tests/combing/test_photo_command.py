"""``combing photo`` as a user meets it."""

import hashlib
import json
from pathlib import Path

import cv2
import numpy as np
import pandas as pd
import pytest
from drawn.strands import render

from combing.cli import main
from combing.commands import photo as photo_command

FILES = {
    "strands.csv", "crossings.csv", "unresolved.csv", "interactions.csv", "densities.csv",
    "link.csv", "unassigned.csv", "labels.png",
    "overlay.jpg", "overlay.svg", "histogram.png", "histogram.svg", "DATA.md", "provenance.json",
}  # fmt: skip


@pytest.fixture(scope="module")
def pictures(tmp_path_factory) -> Path:
    """Two photographs of three strands, and three files that cannot be measured."""
    folder = tmp_path_factory.mktemp("photos")
    y = np.linspace(15, 225, 300)
    lines = [np.stack([100 + 40 * np.sin(y / 40 + 2.1 * i), y], axis=1) for i in range(3)]
    heights = [np.full(300, 20.0 * i) for i in range(3)]
    colours = [(0.85, 0.1, 0.2), (0.1, 0.6, 0.25), (0.1, 0.3, 0.8)]
    for name, seed in (("a.png", 1), ("b.png", 2)):
        drawn = render(lines, heights, colours, 4, (240, 200), rng=seed)
        cv2.imwrite(str(folder / name), drawn.pixels[..., ::-1])
    cv2.imwrite(str(folder / "black.png"), np.zeros((60, 60, 3), np.uint8))
    cv2.imwrite(str(folder / "dot.png"), np.zeros((1, 1, 3), np.uint8))
    (folder / "cut.jpg").write_bytes(
        cv2.imencode(".jpg", np.full((90, 90, 3), 99))[1].tobytes()[:300]
    )
    return folder


def test_one_photograph(pictures, tmp_path, capsys, run):
    out = tmp_path / "out"
    assert run("photo", pictures / "a.png", "-o", out, "--scale", "10px/mm", "--quiet") == 0
    assert {path.name for path in out.iterdir()} - {"rois.zip"} == FILES
    strands = pd.read_csv(out / "strands.csv")
    crossings = pd.read_csv(out / "crossings.csv")
    assert set(strands["strand"]) == {1, 2, 3}
    np.testing.assert_allclose(strands["x_m"], strands["x"] * 1e-4, rtol=1e-5)
    assert crossings["over"].notna().all()
    labels = cv2.imread(str(out / "labels.png"), cv2.IMREAD_UNCHANGED)
    assert labels.shape == (240, 200)
    assert set(np.unique(labels)) == {0, 1, 2, 3}
    middle = strands[(strands["strand"] == 2) & (strands["edges"] == 2)].iloc[5]
    assert labels[round(middle["y"]), round(middle["x"])] == 2
    interactions = pd.read_csv(out / "interactions.csv")
    assert interactions["section"].max() == 20
    assert f"3 strands, {len(crossings)} crossings" in capsys.readouterr().out


def test_without_a_scale_nothing_is_in_metres(pictures, tmp_path, run):
    assert run("photo", pictures / "a.png", "-o", tmp_path, "--n-sec", 5, "--quiet") == 0
    for name in ("strands.csv", "crossings.csv", "interactions.csv", "densities.csv"):
        table = pd.read_csv(tmp_path / name)
        assert not [column for column in table.columns if column.endswith("_m")]
    assert pd.read_csv(tmp_path / "interactions.csv")["section"].max() == 5


def test_every_column_is_explained(pictures, tmp_path, run):
    run("photo", pictures / "a.png", "-o", tmp_path, "--scale", "filament:0.8mm", "--quiet")
    explained = (tmp_path / "DATA.md").read_text()
    words = {word.strip(" ,") for word in explained.replace("|", " ").split()}
    for path in tmp_path.glob("*.csv"):
        for column in pd.read_csv(path).columns:
            assert column in words, column


def test_a_batch_goes_on_and_says_what_was_refused(pictures, tmp_path, capsys, run):
    assert run("photo", pictures, "-o", tmp_path, "--quiet", "--json") == 0
    rows = {row["photo"]: row for row in json.loads(capsys.readouterr().out)}
    assert rows["a.png"]["strands"] == rows["b.png"]["strands"] == 3
    assert "nothing stands out" in rows["black.png"]["refused"]
    assert "1 x 1 pixels" in rows["dot.png"]["refused"]
    assert "cannot be read" in rows["cut.jpg"]["refused"]
    assert {p.name for p in tmp_path.iterdir() if p.is_dir()} == {"a", "b"}
    assert set(pd.read_csv(tmp_path / "strands.csv")["photo"]) == {"a.png", "b.png"}
    assert (tmp_path / "kymograph.png").stat().st_size > 1000


def test_a_batch_takes_up_where_it_stopped(pictures, tmp_path, run):
    args = ("photo", pictures / "a.png", pictures / "b.png", "-o", tmp_path, "--quiet")
    assert run(*args) == 0
    first = {p: p.stat().st_mtime_ns for p in tmp_path.glob("*/strands.csv")}
    (tmp_path / "b" / "provenance.json").write_text("{ cut")
    assert run(*args) == 0
    again = {p: p.stat().st_mtime_ns for p in tmp_path.glob("*/strands.csv")}
    assert again[tmp_path / "a" / "strands.csv"] == first[tmp_path / "a" / "strands.csv"]
    assert again[tmp_path / "b" / "strands.csv"] > first[tmp_path / "b" / "strands.csv"]
    assert run(*args, "--n-sec", 7) == 0
    assert pd.read_csv(tmp_path / "a" / "interactions.csv")["section"].max() == 7


@pytest.mark.parametrize(
    ("name", "options", "reason"),
    [
        ("none.png", (), "no such file"),
        ("dot.png", (), "1 x 1 pixels"),
        ("black.png", (), "nothing stands out"),
        ("cut.jpg", (), "cannot be read as a picture"),
        ("a.png", ("--scale", "fast"), "write it as"),
        ("a.png", ("--scale", "marker:20mm"), "no ArUco marker"),
        ("a.png", ("--roi", "1,2,3"), "x0,y0,x1,y1 in whole pixels"),
        ("a.png", ("--roi", "0,0,9000,9"), "does not lie in the picture"),
    ],
)
def test_a_mistake_is_one_line_and_leaves_nothing(
    pictures, tmp_path, capsys, name, options, reason, run
):
    assert run("photo", pictures / name, "-o", tmp_path / "out", "--quiet", *options) == 2
    told = capsys.readouterr().err.strip()
    assert reason in told
    assert "\n" not in told
    assert not list((tmp_path / "out").glob("*")) if (tmp_path / "out").exists() else True


def test_help_shows_an_example(capsys, run):
    assert run("photo", "--help") == 0
    told = capsys.readouterr().out
    assert "\n    combing photo curl.jpg --scale marker:20mm -o out/\n" in told


def test_a_twisted_pair_beside_a_marker_is_two_strands(tmp_path, run):
    """The marker is no strand, whether or not the scale is taken from it."""
    photo = Path(__file__).parents[2] / "data" / "photos" / "synthetic_helix_before.jpg"
    assert run("photo", photo, "-o", tmp_path, "--quiet") == 0
    record = json.loads((tmp_path / "provenance.json").read_text())
    assert record["summary"]["strands"] == 2
    assert record["summary"]["colours"] == 2
    (wind,) = record["summary"]["wind"]
    assert wind["handedness"] == "right"
    link = pd.read_csv(tmp_path / "link.csv")
    inside = link["link_per_px"].dropna()
    assert len(inside) > 0.9 * len(link)
    assert inside.mean() == pytest.approx(
        wind["total_link"] / np.ptp(link["s"][inside.index]), rel=0.01
    )


def test_a_photograph_that_cannot_be_measured_leaves_no_folder(pictures, tmp_path, run):
    assert run("photo", pictures / "dot.png", "-o", tmp_path / "out") == 2
    assert not (tmp_path / "out").exists()


def test_another_mask_is_another_measurement(pictures, tmp_path, capsys, run):
    mask = tmp_path / "mask.png"
    args = ("photo", pictures / "a.png", "-o", tmp_path / "out", "--ignore", mask, "--json")
    kept = []
    for rows in (0, 0, 30):
        cv2.imwrite(
            str(mask), np.pad(np.full((rows, 200), 255, np.uint8), ((0, 240 - rows), (0, 0)))
        )
        assert run(*args) == 0
        kept.append(json.loads(capsys.readouterr().out)[0].get("kept", False))
    assert kept == [False, True, False]


def test_a_defect_of_ours_stops_no_batch_and_is_not_hidden(pictures, tmp_path, monkeypatch, capsys):
    true_measure = photo_command.measure

    def broken(photo, *rest, **more):
        return 1 / 0 if photo.source.endswith("a.png") else true_measure(photo, *rest, **more)

    monkeypatch.setattr(photo_command, "measure", broken)
    with pytest.raises(ZeroDivisionError):
        main(["photo", str(pictures), "-o", str(tmp_path / "out"), "--quiet"])
    told = capsys.readouterr().out
    assert "a.png: REFUSED, a defect of this program (ZeroDivisionError" in told
    assert "1 measured, 4 refused" in told
    assert (tmp_path / "out" / "b" / "provenance.json").exists()


def test_the_record_says_what_was_measured_and_how(pictures, tmp_path, run):
    photo = pictures / "a.png"
    assert run("photo", photo, "-o", tmp_path, "--scale", "10px/mm+-2%", "--n-sec", 8) == 0
    record = json.loads((tmp_path / "provenance.json").read_text())
    assert record["input"]["sha256"] == hashlib.sha256(photo.read_bytes()).hexdigest()
    assert record["input"]["options"] == {
        "scale": "10px/mm+-2%", "n_sec": 8, "roi": None, "ignore": None,
        "corrections": "beside", "strands": None, "colours": None,
    }  # fmt: skip
    assert {"combing", "python", "numpy", "scipy", "opencv"} <= set(record["input"]["versions"])
    assert record["summary"]["scale_relative_sd"] == pytest.approx(0.02)
    assert pd.read_csv(tmp_path / "strands.csv")["scale_sd"].unique() == [0.02]
