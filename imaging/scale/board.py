"""Scale, lens and perspective from a board of ArUco markers in the plane of the strands."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import cv2
import numpy as np

from imaging.errors import Unmeasurable
from imaging.photo import Photo
from imaging.scale.plane import fit_plane
from imaging.scale.scale import CORNER_SD, Scale

DICTIONARIES = (
    "DICT_4X4_250", "DICT_5X5_250", "DICT_6X6_250", "DICT_7X7_250", "DICT_ARUCO_ORIGINAL",
    "DICT_APRILTAG_36h11",
)  # fmt: skip
LEAST = 8  # corners; ten numbers are fitted to twice as many coordinates
FAR = 2.0  # px; corners that scatter more lie on no flat board of the stated size
GRID = 5  # places across the picture at which the scale is averaged
PLENTY = 4  # markers of one dictionary; so many are no chance
SLIP = 0.1  # relative difference of a marker from its stated side that is no print's error
RIM = 0.5  # of a square; the white rim of a board, hidden with it


class Markers(NamedTuple):
    """Markers found in a picture, all of one dictionary."""

    name: str
    dictionary: Any
    corners: Sequence[np.ndarray]
    ids: np.ndarray


class Corners(NamedTuple):
    """Corners of a board in the picture [px] and on the board [m], (n, 2) each."""

    points: np.ndarray
    places: np.ndarray


def from_charuco(
    photo: Photo, squares: tuple[int, int], side: float, marker_side: float
) -> tuple[Scale, Photo]:
    """Scale from a ChArUco board: a chessboard with ArUco markers in its white squares.

    Parameters
    ----------
    photo : Photo
    squares : (columns, rows)
        Of the chessboard.
    side, marker_side : float
        Of a square and of a marker [m].

    Returns
    -------
    scale : Scale
        With lens distortion and perspective.
    photo : Photo
        The same with the board to be ignored.

    Raises
    ------
    Unmeasurable
        When too few corners of the board are found, or they do not lie where they should.
    """
    columns, rows = squares
    if not (0 < marker_side < side and min(squares) > 1):
        raise Unmeasurable(
            f"ChArUco board of {columns} x {rows} squares of {side:g} m with markers of "
            f"{marker_side:g} m; markers must be smaller than squares, and squares 2 x 2 or more"
        )
    markers = _markers(photo)
    grey = _grey(photo)
    found = []
    for legacy in (False, True):  # OpenCV changed the pattern for even numbers of rows
        board = cv2.aruco.CharucoBoard(squares, side, marker_side, markers.dictionary)
        board.setLegacyPattern(legacy)
        detector = cv2.aruco.CharucoDetector(board)
        seen = detector.detectBoard(grey, markerCorners=markers.corners, markerIds=markers.ids)
        found.append(_matched(board, seen[0], seen[1]))
    what = f"ChArUco board of {columns} x {rows} squares"
    corners = max(found, key=lambda one: len(one.points))
    scale = _scale(photo, corners, what, (columns - 1) * (rows - 1), markers.name)
    _refuse_other_markers(photo, scale, markers, marker_side)
    return scale, _without(photo, corners, (columns * side, rows * side), RIM * side)


def from_grid(
    photo: Photo, markers: tuple[int, int], side: float, gap: float
) -> tuple[Scale, Photo]:
    """Scale from ArUco markers in columns and rows, `gap` [m] apart, as `from_charuco`."""
    found = _markers(photo)
    board = cv2.aruco.GridBoard(markers, side, gap, found.dictionary)
    corners = _matched(board, found.corners, found.ids)
    columns, rows = markers
    what = f"board of {columns} x {rows} ArUco markers"
    scale = _scale(photo, corners, what, 4 * columns * rows, found.name, alike=4)
    size = (columns * (side + gap) - gap, rows * (side + gap) - gap)
    return scale, _without(photo, corners, size, RIM * side)


def _grey(photo: Photo) -> np.ndarray:
    return cv2.transform(photo.eight_bits(), np.full((1, 3), 1 / 3))


def _markers(photo: Photo) -> Markers:
    """Find the markers of the first dictionary that shows plenty, else of the one with most."""
    settings = cv2.aruco.DetectorParameters()
    settings.cornerRefinementMethod = cv2.aruco.CORNER_REFINE_SUBPIX
    grey = _grey(photo)
    found = []
    for name in DICTIONARIES:
        dictionary = cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, name))
        corners, ids, _ = cv2.aruco.ArucoDetector(dictionary, settings).detectMarkers(grey)
        found.append(Markers(name, dictionary, corners, ids))
        if len(corners) >= PLENTY:
            break
    best = max(found, key=lambda one: len(one.corners))
    if len(best.corners) == 0:
        raise Unmeasurable(
            f"{photo.source}: no board found (no ArUco marker of {', '.join(DICTIONARIES)}); "
            "show it flat, whole and sharp, or state the scale in another way"
        )
    return best


def _matched(board: Any, found: Any, ids: Any) -> Corners:
    if ids is None or len(ids) == 0:
        return Corners(np.empty((0, 2)), np.empty((0, 2)))
    places, points = board.matchImagePoints(found, ids)
    if points is None:
        return Corners(np.empty((0, 2)), np.empty((0, 2)))
    flat = np.asarray(places, float).reshape(-1, 3)[:, :2]
    return Corners(np.asarray(points, float).reshape(-1, 2), flat)


def _scale(
    photo: Photo, corners: Corners, what: str, number: int, name: str, alike: int = 1
) -> Scale:
    seen = len(corners.points)
    if seen < LEAST or _on_a_line(corners.places):
        raise Unmeasurable(
            f"{photo.source}: {seen} of the {number} corners of a {what} found ({name}); "
            f"at least {LEAST} not on one line are needed: show more of it, or correct its numbers"
        )
    plane = fit_plane(
        corners.points, corners.places, photo.shape, CORNER_SD, lens=True, alike=alike
    )
    if plane.corner_sd > FAR:
        raise Unmeasurable(
            f"{photo.source}: the corners of the {what} scatter by {plane.corner_sd:.1f} px; "
            "lay it flat, or correct its numbers"
        )
    height, width = photo.shape
    x, y = np.meshgrid(np.linspace(0, width - 1, GRID), np.linspace(0, height - 1, GRID))
    local, sd = plane.local(np.stack([x.ravel(), y.ravel()], axis=1))
    mean = float(local.mean())
    relative = float(np.hypot(sd.mean(), local.std() / mean))
    return Scale(mean, relative, f"{what}, {seen} corners", plane)


def _refuse_other_markers(photo: Photo, scale: Scale, markers: Markers, side: float) -> None:
    """Check squares against markers: both lengths are stated, and one of them may be a slip."""
    places = [scale.metres(corners.reshape(4, 2)) for corners in markers.corners]
    sides = [np.hypot(*(p - np.roll(p, 1, axis=0)).T) for p in places]
    seen = float(np.median(sides))
    if abs(seen / side - 1) > SLIP:
        raise Unmeasurable(
            f"{photo.source}: by its squares the board's markers measure {1e3 * seen:.4g} mm, "
            f"not {1e3 * side:.4g} mm; correct the side of the squares or of the markers"
        )


def _on_a_line(places: np.ndarray) -> bool:
    longest, across = np.linalg.svd(places - places.mean(axis=0), compute_uv=False)
    return bool(across < 0.1 * longest)


def _without(photo: Photo, corners: Corners, size: tuple[float, float], rim: float) -> Photo:
    """Hide the whole board, `size` wide and high [m], and a rim round it [m]."""
    (x, y), (x0, y0) = size, (-rim, -rim)
    outline = np.array([[x0, y0], [x - x0, y0], [x - x0, y - y0], [x0, y - y0]])
    to_picture = cv2.findHomography(corners.places, corners.points)[0]
    drawn = cv2.perspectiveTransform(outline[None], to_picture)
    mask = np.zeros(photo.shape, np.uint8)
    cv2.fillConvexPoly(mask, np.round(drawn).astype(np.int32), 1)
    hidden = mask > 0 if photo.ignore is None else (mask > 0) | photo.ignore
    return replace(photo, ignore=hidden)
