"""Tables and pictures of one photograph: metres, angles and what lies on top, against the truth."""

import cv2
import numpy as np
import pandas as pd
import pytest
from drawn.strands import Look, render

from imaging import Photo
from imaging.measure import Measured, measure
from imaging.report.imagej import write_rois
from imaging.report.overlay import few_points, labels_picture, overlay_svg
from imaging.report.tables import crossings_table, densities_table, strands_table
from imaging.scale import Request, parse_scale

SHAPE = (400, 500)
PIXEL = 2e-4  # m; of the plane seen from above
ENDS = np.array([[[60, 80], [440, 300]], [[60, 300], [440, 120]]], float)  # two straight strands
# Picture point -> point of the picture taken from straight above.
ASLANT = np.array([[0.95, 0.04, 8], [-0.03, 0.9, 14], [2.5e-4, -3e-4, 1]])


def seen_from_above() -> np.ndarray:
    lines = [np.linspace(*ends, 400) for ends in ENDS]
    heights = [np.full(400, 20.0 * i) for i in range(2)]
    colours = [(0.85, 0.1, 0.2), (0.1, 0.3, 0.8)]
    return render(lines, heights, colours, 5, SHAPE, look=Look(uneven=0.1), rng=1).pixels


def seen_aslant(pixels: np.ndarray, paper: tuple[int, ...]) -> np.ndarray:
    flags = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
    return cv2.warpPerspective(
        pixels, ASLANT, SHAPE[::-1], flags=flags, borderMode=cv2.BORDER_CONSTANT, borderValue=paper
    )


@pytest.fixture(scope="module")
def aslant(tmp_path_factory) -> Measured:
    """Measure two straight strands by a board that was photographed alone, from the same place."""
    dictionary = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_4X4_50)
    board = cv2.aruco.CharucoBoard((8, 6), 0.011, 0.008, dictionary)
    flat = np.full(SHAPE, 235, np.uint8)
    flat[30:360, 30:470] = board.generateImage((440, 330), marginSize=0)
    path = tmp_path_factory.mktemp("board") / "board.png"
    cv2.imwrite(str(path), seen_aslant(flat, (235,)))
    pixels = seen_from_above()
    paper = tuple(int(v) for v in pixels[5, 5])
    request = parse_scale(f"charuco:8x6,11mm,8mm@{path}")
    return measure(Photo(seen_aslant(pixels, paper), "aslant"), request)


def test_lengths_are_those_of_the_plane(aslant):
    table = strands_table(aslant, "aslant.png")
    true = PIXEL * np.hypot(*(ENDS[:, 1] - ENDS[:, 0]).T)
    for found, length in zip(
        sorted(table.groupby("strand")["s_m"].max()), sorted(true), strict=True
    ):
        assert found == pytest.approx(length, rel=0.02)  # the ends are round: one radius each
    in_pixels = table.groupby("strand")["s"].max() * aslant.scale.metres_per_pixel
    assert (in_pixels / sorted(true) - 1).abs().max() > 0.02  # what one scale would say


def test_lines_are_straight_and_widths_even_in_the_plane(aslant):
    for _, strand in strands_table(aslant, "aslant.png").groupby("strand"):
        inner = strand.iloc[20:-20]
        slope, _ = np.polyfit(inner["x_m"], inner["y_m"], 1)
        assert np.abs(np.polyval(np.polyfit(inner["x_m"], inner["y_m"], 1), inner["x_m"])
                      - inner["y_m"]).max() < PIXEL  # fmt: skip
        assert slope != 0
        third = len(inner) // 3
        first, last = inner["width_m"].iloc[:third], inner["width_m"].iloc[-third:]
        assert first.median() == pytest.approx(last.median(), rel=0.05)


def test_the_angle_is_that_of_the_plane(aslant):
    table = crossings_table(aslant, "aslant.png")
    directions = ENDS[:, 1] - ENDS[:, 0]
    angles = np.arctan2(directions[:, 1], directions[:, 0])
    true = abs(angles[1] - angles[0])
    assert len(table) == 1
    assert table["angle"][0] == pytest.approx(true, abs=np.radians(0.5))
    assert abs(aslant.crossings["angle"][0] - true) > np.radians(1)  # as the picture shows it
    roots = ENDS[[0, 1], ENDS[:, :, 1].argmin(axis=1)]
    far = sorted(PIXEL * np.hypot(*(_meeting() - roots).T))
    more = np.subtract(sorted([table["s_a_m"][0], table["s_b_m"][0]]), far)
    assert (more > -PIXEL).all()
    assert (more < 6 * PIXEL).all()  # strands have round ends, of a radius of 5 px


def _meeting() -> np.ndarray:
    """Where the two straight strands cross, seen from above [px]."""
    (p, q), (r, t) = ENDS
    along = np.linalg.solve(np.column_stack([q - p, r - t]), r - p)
    return p + along[0] * (q - p)


def test_densities_are_per_metre_of_the_plane(aslant):
    table = densities_table(aslant.densities, aslant, "aslant.png")
    twenty = table[table["rule"] == "20 sections"]
    length = twenty["count"] / twenty["density_per_m"]
    axis = PIXEL * np.ptp(ENDS.reshape(-1, 2) @ _axis())
    assert length.iloc[0] == pytest.approx(axis, rel=0.03)


def _axis() -> np.ndarray:
    directions = ENDS[:, 1] - ENDS[:, 0]
    # Roots are the upper ends: the second strand runs the other way.
    directions[1] *= -1
    mean = (directions / np.hypot(*directions.T)[:, None]).mean(axis=0)
    return mean / np.hypot(*mean)


def test_the_doubt_of_the_scale_widens_the_density():
    photo = Photo(seen_from_above(), "above")
    sure = measure(photo, Request("stated", (1 / PIXEL,)))
    doubtful = measure(photo, parse_scale("5px/mm+-20%"))
    assert doubtful.scale_sd == pytest.approx(0.2)
    rows = [densities_table(m.densities, m, "a").iloc[0] for m in (sure, doubtful)]
    assert rows[1]["density_per_m"] == rows[0]["density_per_m"]
    assert rows[1]["low_per_m"] < rows[0]["low_per_m"]
    assert rows[1]["high_per_m"] > rows[0]["high_per_m"]
    half = rows[0]["high_per_m"] - rows[0]["density_per_m"]
    wider = rows[1]["high_per_m"] - rows[1]["density_per_m"]
    assert wider == pytest.approx(np.hypot(half, 1.96 * 0.2 * rows[0]["high_per_m"]))


@pytest.fixture(scope="module")
def above() -> Measured:
    return measure(Photo(seen_from_above(), "above"))


def test_the_top_strand_wins_in_labels(above):
    labels = labels_picture(above.segmentation, above.strands)
    (row,) = above.crossings.to_dict("records")
    assert labels[round(row["y"]), round(row["x"])] == row["over"]
    assert {*np.unique(labels)} == {0, 1, 2}


def test_imagej_regions_are_half_a_pixel_from_pixel_centres(above, tmp_path):
    roifile = pytest.importorskip("roifile")
    write_rois(tmp_path / "rois.zip", above.strands, above.crossings)
    rois = roifile.roiread(tmp_path / "rois.zip")
    assert [roi.name for roi in rois] == ["strand-1", "strand-2", "crossing-1-strands-1-2"]
    np.testing.assert_allclose(rois[0].coordinates()[0], above.strands[0].line[0] + 0.5, atol=1e-4)
    np.testing.assert_allclose(
        rois[0].coordinates()[-1], above.strands[0].line[-1] + 0.5, atol=1e-4
    )
    place = above.crossings[["x", "y"]].to_numpy(float)[0]
    np.testing.assert_allclose(rois[2].coordinates()[0], place + 0.5, atol=1e-4)


def test_the_overlay_says_who_is_on_top(above):
    args = (above.photo, above.segmentation, above.strands)
    known = overlay_svg(*args, above.crossings)
    unknown = overlay_svg(*args, above.crossings.assign(over=pd.array([None], dtype="Int64")))
    assert known.count("<line ") == 1
    assert unknown.count("<line ") == 0
    assert "on top: unknown" in unknown


def test_lines_of_the_svg_have_few_points_and_stay_in_place():
    y = np.linspace(0, 900, 900)
    line = np.stack([50 * np.sin(y / 60), y], axis=1)
    few = few_points(line, 0.05)
    assert len(few) < len(line) / 4
    between = np.stack([np.interp(y, few[:, 1], few[:, 0]), y], axis=1)
    assert np.abs(between - line).max() < 0.08  # 0.05 across it
