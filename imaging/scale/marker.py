"""Scale from an ArUco marker in the plane of the strands; markers are no strands."""

from dataclasses import replace

import cv2
import numpy as np

from imaging.errors import Unmeasurable
from imaging.photo import Photo
from imaging.scale.plane import fit_plane
from imaging.scale.scale import Scale

DICTIONARIES = ("DICT_4X4_50", "DICT_5X5_50", "DICT_6X6_50", "DICT_ARUCO_ORIGINAL")
# Blur rounds a marker's corners: its sides come out 0.19, 0.25, 0.51 px short at a blur of 0.5,
# 0.8, 1.5 px. Cameras sharpen again by an unknown amount, so this is stated and not corrected.
SIDE_SD = 0.4  # px
WHITE_MARGIN = 0.35  # of a marker's side: its white rim, and what blur spreads of it
LONGEST = 2000  # px; longer pictures are shrunk to look for markers that only have to be hidden


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
        The same with the marker to be ignored.

    Raises
    ------
    Unmeasurable
        When no marker, or more than one, is found.
    """
    if not side > 0:
        raise Unmeasurable(f"marker side of {side:g} m; it must be positive")
    corners = find_marker(photo)
    sides = np.linalg.norm(corners - np.roll(corners, 1, axis=0), axis=1)
    mean = float(sides.mean())
    relative = float(np.hypot(SIDE_SD, sides.std()) / mean)
    square = side * np.array([[0, 0], [1, 0], [1, 1], [0, 1]])
    plane = None
    if perspective:
        plane = fit_plane(corners, square, photo.shape, SIDE_SD, lens=False)
    return Scale(side / mean, relative, "ArUco marker", plane), _without(photo, corners)


def find_marker(photo: Photo) -> np.ndarray:
    """Return the corners of the only ArUco marker, (4, 2) [px], clockwise from its top left."""
    grey = cv2.transform(photo.eight_bits(), np.full((1, 3), 1 / 3))
    settings = cv2.aruco.DetectorParameters()
    settings.cornerRefinementMethod = cv2.aruco.CORNER_REFINE_SUBPIX
    for name in DICTIONARIES:
        dictionary = cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, name))
        found, _, _ = cv2.aruco.ArucoDetector(dictionary, settings).detectMarkers(grey)
        if len(found) > 1:
            raise Unmeasurable(f"{photo.source}: {len(found)} ArUco markers; leave one to be seen")
        if len(found) == 1:
            return found[0].reshape(4, 2).astype(float)
    raise Unmeasurable(
        f"{photo.source}: no ArUco marker found ({', '.join(DICTIONARIES)}); "
        "show one whole and sharp, or state the scale in another way"
    )


def without_markers(photo: Photo) -> Photo:
    """Return the photograph with its ArUco markers, if any, to be ignored: they are no strands."""
    shrink = max(1.0, max(photo.shape) / LONGEST)
    size = [round(side / shrink) for side in photo.shape[::-1]]
    small = cv2.resize(photo.pixels, size, interpolation=cv2.INTER_AREA)
    grey = (small.mean(axis=2) * (255 / np.iinfo(photo.pixels.dtype).max)).astype(np.uint8)
    for name in DICTIONARIES:
        dictionary = cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, name))
        for corners in cv2.aruco.ArucoDetector(dictionary).detectMarkers(grey)[0]:
            photo = _without(photo, shrink * corners.reshape(4, 2).astype(float))
    return photo


def _without(photo: Photo, corners: np.ndarray) -> Photo:
    middle = corners.mean(axis=0)
    frame = middle + (1 + 2 * WHITE_MARGIN) * (corners - middle)
    mask = np.zeros(photo.shape, np.uint8)
    cv2.fillConvexPoly(mask, np.round(frame).astype(np.int32), 1)
    hidden = mask > 0 if photo.ignore is None else (mask > 0) | photo.ignore
    return replace(photo, ignore=hidden)
