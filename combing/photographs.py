"""Photographs with their scale: the marker is found, measured, and kept out of the strands."""

from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

import imaging
from combing.errors import UserError

DICTIONARIES = {
    "4x4": cv2.aruco.DICT_4X4_50,
    "5x5": cv2.aruco.DICT_5X5_50,
    "6x6": cv2.aruco.DICT_6X6_50,
    "original": cv2.aruco.DICT_ARUCO_ORIGINAL,
}
MARGIN = 0.35  # of the side: the white border and what the blur spreads of it


def read_to_scale(
    path: Path, *, marker_side: float | None = None, pixel_size: float | None = None
) -> tuple[imaging.Photo, float]:
    """Read a photograph and the size of its pixels.

    Parameters
    ----------
    path : Path
        The photograph.
    marker_side : float, optional
        Side of the ArUco marker that lies in the plane of the strands [m].
    pixel_size : float, optional
        Size of a pixel in the plane of the strands [m], where there is no marker.

    Returns
    -------
    photo : imaging.Photo
        The marker, if any, is ignored.
    pixel_size : float
        In metres.

    Raises
    ------
    UserError
        If a marker is to be measured and there is none, or more than one.
    imaging.Unmeasurable
        If the file is not a photograph.
    """
    return to_scale(imaging.read_photo(path), marker_side=marker_side, pixel_size=pixel_size)


def to_scale(
    photo: imaging.Photo, *, marker_side: float | None = None, pixel_size: float | None = None
) -> tuple[imaging.Photo, float]:
    """Find the size of a photograph's pixels as `read_to_scale` does."""
    if marker_side is None:
        if pixel_size is None:
            raise UserError(f"{photo.source}: give marker_side or pixel_size, in metres")
        return photo, pixel_size
    corners = find_marker(photo)
    edges = np.linalg.norm(corners - np.roll(corners, 1, axis=0), axis=1)
    mask = _covered(corners, photo.shape)
    if photo.ignore is not None:
        mask |= photo.ignore
    return replace(photo, ignore=mask), float(marker_side / edges.mean())


def find_marker(photo: imaging.Photo) -> NDArray[np.float32]:
    """Corners of the only ArUco marker in a photograph, (4, 2) [px], clockwise from top left."""
    rgb = np.round(255 * photo.rgb()).astype(np.uint8)
    settings = cv2.aruco.DetectorParameters()
    settings.cornerRefinementMethod = cv2.aruco.CORNER_REFINE_SUBPIX
    for dictionary in DICTIONARIES.values():
        finder = cv2.aruco.ArucoDetector(cv2.aruco.getPredefinedDictionary(dictionary), settings)
        found, _, _ = finder.detectMarkers(rgb)
        if len(found) > 1:
            raise UserError(f"{photo.source}: {len(found)} ArUco markers; keep one in the picture")
        if found:
            return found[0][0]
    raise UserError(
        f"{photo.source}: no ArUco marker found (dictionaries {', '.join(DICTIONARIES)}); show it "
        "whole and sharp, or give pixel_size in metres instead of marker_side"
    )


def _covered(corners: NDArray[np.float32], shape: tuple[int, int]) -> NDArray[np.bool_]:
    middle = corners.mean(axis=0)
    frame = middle + (1 + 2 * MARGIN) * (corners - middle)
    mask = np.zeros(shape, np.uint8)
    cv2.fillConvexPoly(mask, np.round(frame).astype(np.int32), 1)
    return mask.astype(bool)
