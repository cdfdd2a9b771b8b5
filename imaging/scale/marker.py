"""Scale from an ArUco marker in the plane of the strands; markers are no strands."""

from dataclasses import replace

import cv2
import numpy as np

from imaging.errors import Unmeasurable
from imaging.photo import Photo, shrunk
from imaging.scale.plane import fit_plane
from imaging.scale.scale import Scale

DICTIONARIES = ("DICT_4X4_50", "DICT_5X5_50", "DICT_6X6_50", "DICT_ARUCO_ORIGINAL")
# Blur rounds a marker's corners: its sides come out 0.19, 0.25, 0.51 px short at a blur of 0.5,
# 0.8, 1.5 px. Cameras sharpen again by an unknown amount, so this is stated and not corrected.
SIDE_SD = 0.4  # px
WHITE_MARGIN = 0.35  # of a marker's side: its white rim, and what blur spreads of it
LONGEST = 2000  # px; pictures twice as long, or more, are shrunk to look where markers are
WINDOW = 13  # px of theirs, over which light is taken to be even there
EVERYWHERE = np.s_[:, :]
Seen = dict[str, list[np.ndarray]]  # dictionary -> corners (4, 2) of its markers [px]


def from_marker(photo: Photo, side: float, *, perspective: bool = False) -> tuple[Scale, Photo]:
    """Scale from the ArUco marker in the plane of the strands.

    Parameters
    ----------
    photo : Photo
    side : float
        Side of the black square [m].
    perspective : bool
        Also measure the tilt of the plane. Far from a small marker this adds more noise than it
        removes bias: use it when the camera visibly looks at an angle.

    Returns
    -------
    scale : Scale
        Its sd holds what blur does to the sides, and their inequality (tilt).
    photo : Photo
        The same with this marker to be ignored.

    Raises
    ------
    Unmeasurable
        When no marker, or more than one, of whatever dictionaries, is found.
    """
    if not side > 0:
        raise Unmeasurable(f"marker side of {side:g} m; it must be positive")
    seen = seen_small(photo)
    corners = find_marker(photo, seen)
    sides = np.linalg.norm(corners - np.roll(corners, 1, axis=0), axis=1)
    mean = float(sides.mean())
    relative = float(np.hypot(SIDE_SD, sides.std()) / mean)
    square = side * np.array([[0, 0], [1, 0], [1, 1], [0, 1]])
    plane = None
    if perspective:
        plane = fit_plane(corners, square, photo.shape, SIDE_SD, lens=False)
    return Scale(side / mean, relative, "ArUco marker", plane), _without(
        without_markers(photo, seen), corners
    )


def find_marker(photo: Photo, seen: Seen | None = None) -> np.ndarray:
    """Return the corners of the only ArUco marker, (4, 2) [px], clockwise from its top left.

    Looked for at full resolution around where it is `seen` in a smaller picture, if it is alone
    there, else everywhere, in all dictionaries: whose side is stated, of two, is not for us to say.
    """
    seen = seen_small(photo) if seen is None else seen
    if [len(places) for places in seen.values()] == [1]:
        ((name, (rough,)),) = seen.items()
        found = _sharp(photo, name, _around(rough))
        if len(found) == 1:
            return found[0]
    every = [(name, one) for name in DICTIONARIES for one in _sharp(photo, name, EVERYWHERE)]
    every = [one for n, one in enumerate(every) if not any(_same(one[1], e[1]) for e in every[:n])]
    if len(every) > 1:
        middles = [(name, *one.mean(axis=0)) for name, one in every]
        places = ", ".join(f"{name} at {x:.0f},{y:.0f}" for name, x, y in middles)
        raise Unmeasurable(
            f"{photo.source}: {len(every)} ArUco markers ({places}); leave one to be seen"
        )
    if every:
        return every[0][1]
    raise Unmeasurable(
        f"{photo.source}: no ArUco marker found ({', '.join(DICTIONARIES)}); "
        "show one whole and sharp, or state the scale in another way"
    )


def _same(corners: np.ndarray, others: np.ndarray) -> bool:
    """Tell whether two readings are of one marker: its middle lies nearer than half a side."""
    apart = np.linalg.norm(corners.mean(axis=0) - others.mean(axis=0))
    return bool(apart < np.linalg.norm(others[1] - others[0]) / 2)


def _sharp(photo: Photo, name: str, window: tuple[slice, slice]) -> list[np.ndarray]:
    """Corners (4, 2) [px] of the markers of a dictionary in a window, to a fraction of a pixel."""
    settings = cv2.aruco.DetectorParameters()
    settings.cornerRefinementMethod = cv2.aruco.CORNER_REFINE_SUBPIX
    part = replace(photo, pixels=photo.pixels[window], ignore=None)
    grey = cv2.transform(part.eight_bits(), np.full((1, 3), 1 / 3))
    corner = [cut.start or 0 for cut in window[::-1]]
    found = _detector(name, settings).detectMarkers(grey)[0]
    return [corners.reshape(4, 2).astype(float) + corner for corners in found]


def _around(corners: np.ndarray) -> tuple[slice, slice]:
    """Window that holds a marker and as much again on every side."""
    (left, top), (right, bottom) = corners.min(axis=0), corners.max(axis=0)
    reach = max(right - left, bottom - top)
    return np.s_[
        max(int(top - reach), 0) : int(bottom + reach),
        max(int(left - reach), 0) : int(right + reach),
    ]


def _detector(name: str, settings: cv2.aruco.DetectorParameters) -> cv2.aruco.ArucoDetector:
    dictionary = cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, name))
    return cv2.aruco.ArucoDetector(dictionary, settings)


def seen_small(photo: Photo) -> Seen:
    """Rough corners (4, 2) [px] of the markers of each dictionary, in a smaller picture."""
    shrink = max(1, max(photo.shape) // LONGEST)
    small = shrunk(photo.pixels, shrink)
    grey = cv2.transform(small, np.full((1, 3), 255 / 3 / np.iinfo(photo.pixels.dtype).max))
    settings = cv2.aruco.DetectorParameters()
    settings.adaptiveThreshWinSizeMin = settings.adaptiveThreshWinSizeMax = WINDOW
    seen = {}
    for name in DICTIONARIES:
        if found := _detector(name, settings).detectMarkers(grey.astype(np.uint8))[0]:
            seen[name] = [shrink * corners.reshape(4, 2).astype(float) for corners in found]
    return seen


def without_markers(photo: Photo, seen: Seen | None = None) -> Photo:
    """Return the photograph with its ArUco markers, if any, to be ignored: they are no strands."""
    for places in (seen_small(photo) if seen is None else seen).values():
        for corners in places:
            photo = _without(photo, corners)
    return photo


def _without(photo: Photo, corners: np.ndarray) -> Photo:
    middle = corners.mean(axis=0)
    frame = middle + (1 + 2 * WHITE_MARGIN) * (corners - middle)
    mask = np.zeros(photo.shape, np.uint8)
    cv2.fillConvexPoly(mask, np.round(frame).astype(np.int32), 1)
    hidden = mask > 0 if photo.ignore is None else (mask > 0) | photo.ignore
    return replace(photo, ignore=hidden)
