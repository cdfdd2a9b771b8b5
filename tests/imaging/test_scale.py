"""Pixels to metres, recovered from pictures whose scale is known."""

import cv2
import numpy as np
import pytest

from imaging import Photo, Unmeasurable
from imaging.scale import from_marker, from_ruler, parse_scale, stated

SIDE = 0.02  # m
PIXELS = 120


def _with_marker(homography: np.ndarray | None = None, count: int = 1) -> Photo:
    dictionary = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_4X4_50)
    marker = cv2.aruco.generateImageMarker(dictionary, 7, PIXELS)
    picture = np.full((400, 600), 235, np.uint8)
    for i in range(count):
        picture[60 : 60 + PIXELS, 80 + 200 * i : 80 + 200 * i + PIXELS] = marker
    if homography is not None:
        picture = cv2.warpPerspective(picture, homography, (600, 400), borderValue=235)
    return Photo(np.repeat(cv2.GaussianBlur(picture, (0, 0), 0.8)[..., None], 3, axis=2))


def test_marker_gives_the_scale_and_hides_itself():
    scale, photo = from_marker(_with_marker(), SIDE)
    assert scale.metres_per_pixel == pytest.approx(SIDE / PIXELS, rel=0.005)
    assert abs(scale.metres_per_pixel * PIXELS / SIDE - 1) < 3 * scale.relative_sd
    assert photo.ignore is not None
    assert photo.ignore[60:180, 80:200].all()
    assert not photo.ignore[:, 300:].any()


def test_tilted_plane_is_measured_and_its_doubt_stated():
    tilt = np.array([[0.92, 0.0, 10], [0.05, 0.97, 4], [2.5e-4, 0, 1]])
    photo = _with_marker(tilt)
    flat, _ = from_marker(photo, SIDE)
    tilted, _ = from_marker(photo, SIDE, perspective=True)
    square = np.array([[80, 60], [200, 60], [200, 180], [80, 180]], float) - 0.5
    seen = cv2.perspectiveTransform(square[None], tilt)[0]
    sides = np.linalg.norm(np.diff(tilted.metres(seen), axis=0, append=0)[:3], axis=1)
    np.testing.assert_allclose(sides, SIDE, rtol=0.01)
    assert flat.relative_sd > 0.01  # the four sides differ


@pytest.mark.parametrize(("count", "reason"), [(0, "no ArUco marker"), (2, "2 ArUco markers")])
def test_no_marker_or_two_are_refused(count, reason):
    with pytest.raises(Unmeasurable, match=reason):
        from_marker(_with_marker(count=count), SIDE)


@pytest.mark.parametrize("other", ["DICT_5X5_50", "DICT_6X6_50", "DICT_ARUCO_ORIGINAL"])
def test_two_markers_of_two_dictionaries_are_named_and_refused(other):
    photo = _with_marker()
    known = cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, other))
    photo.pixels[220:320, 400:500] = cv2.aruco.generateImageMarker(known, 3, 100)[..., None]
    said = rf"2 ArUco markers \(DICT_4X4_50 at 140,120, {other} at 450,270\)"
    with pytest.raises(Unmeasurable, match=said):
        from_marker(photo, SIDE)


def test_ruler():
    scale = from_ruler((10, 20), (310, 420), 0.05)
    assert scale.metres_per_pixel == pytest.approx(1e-4)
    assert scale.relative_sd == pytest.approx(np.sqrt(2) * 0.7 / 500)


def test_stated_scale_carries_over():
    np.testing.assert_allclose(stated(1e4).metres(np.array([[100.0, 200.0]])), [[0.01, 0.02]])


@pytest.mark.parametrize(
    ("text", "kind", "numbers"),
    [
        ("40px/mm", "stated", (4e4,)),
        ("40.5 px/cm", "stated", (4050,)),
        ("marker:20mm", "marker", (0.02,)),
        ("plane:2cm", "plane", (0.02,)),
        ("filament:850um", "filament", (8.5e-4,)),
        ("ruler:1,2,3.5,4=50mm", "ruler", (1, 2, 3.5, 4, 0.05)),
        ("marker:1in", "marker", (0.0254,)),
    ],
)
def test_scale_is_read(text, kind, numbers):
    request = parse_scale(text)
    assert request.kind == kind
    assert request.numbers == pytest.approx(numbers)


@pytest.mark.parametrize(
    "text", ["", "40", "40mm", "px/mm", "marker:mm", "1-2px/mm", "ruler:1,2=3mm"]
)
def test_other_scales_are_refused(text):
    with pytest.raises(Unmeasurable, match="write it as"):
        parse_scale(text)
