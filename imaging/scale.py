"""From pixels to metres: a stated scale, a ruler, an ArUco marker, or a known filament."""

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace

import cv2
import numpy as np

from imaging.errors import Unmeasurable
from imaging.photo import Photo
from imaging.plane import Plane, fit_plane
from imaging.trace import Strand

DICTIONARIES = ("DICT_4X4_50", "DICT_5X5_50", "DICT_6X6_50", "DICT_ARUCO_ORIGINAL")
CORNER_SD = 0.15  # px; refined corners of a board
# Blur rounds a marker's corners: its sides come out 0.19, 0.25, 0.51 px short at a blur of 0.5,
# 0.8, 1.5 px. Cameras sharpen again by an unknown amount, so this is stated and not corrected.
SIDE_SD = 0.4  # px
EDGE_BIAS = 0.15  # of the width; -15 % on white, +12 % on black, measured on rendered tubes
CLICK_SD = 0.7  # px; a ruler's end read off the screen
WHITE_MARGIN = 0.35  # of a marker's side: its white rim, and what blur spreads of it
LONGEST = 2000  # px; longer pictures are shrunk to look for markers that only have to be hidden
METRES = {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "um": 1e-6, "in": 0.0254}
FORMS = (
    "40px/mm, marker:20mm, plane:20mm, charuco:7x5,15mm,11mm, grid:5x7,20mm,5mm, filament:0.85mm "
    "or ruler:x0,y0,x1,y1=50mm, with +-1% behind it where the length is not exact, and "
    "@board.jpg at the end where marker or board stand in a photograph of their own"
)
NUMBER, UNIT = r"([-+]?[\d.]+(?:[eE][-+]?\d+)?)", "(" + "|".join(METRES) + ")"
PATTERNS = {
    "stated": rf"{NUMBER}\s*px/{UNIT}",
    "marker": rf"marker:{NUMBER}\s*{UNIT}",
    "plane": rf"plane:{NUMBER}\s*{UNIT}",
    "filament": rf"filament:{NUMBER}\s*{UNIT}",
    "charuco": rf"charuco:(\d+)x(\d+),{NUMBER}\s*{UNIT},{NUMBER}\s*{UNIT}",
    "grid": rf"grid:(\d+)x(\d+),{NUMBER}\s*{UNIT},{NUMBER}\s*{UNIT}",
    "ruler": rf"ruler:{NUMBER},{NUMBER},{NUMBER},{NUMBER}={NUMBER}\s*{UNIT}",
}
ON_A_BOARD = ("marker", "plane", "charuco", "grid")


@dataclass(frozen=True)
class Scale:
    """Metres per pixel in the plane of the strands.

    Attributes
    ----------
    metres_per_pixel : float
        Where perspective was measured: the mean over the picture.
    relative_sd : float
        Standard deviation of the scale over the scale; with perspective, over the whole picture.
    how : str
        Where it comes from, for the record.
    plane : Plane or None
        Lens and perspective, where they were measured.
    length_sd : float
        The part of `relative_sd` that comes from the length that was stated.
    """

    metres_per_pixel: float
    relative_sd: float
    how: str
    plane: Plane | None = None
    length_sd: float = 0.0

    def metres(self, points: np.ndarray) -> np.ndarray:
        """Carry picture points (n, 2) over to the plane of the strands [m]."""
        if self.plane is None:
            return np.asarray(points, float) * self.metres_per_pixel
        return self.plane.metres(points)

    def step(self, points: np.ndarray, directions: np.ndarray) -> np.ndarray:
        """Metres per pixel at `points` (n, 2) along the unit vectors `directions` (n, 2)."""
        half = np.asarray(directions, float) / 2
        return np.hypot(*(self.metres(points + half) - self.metres(points - half)).T)

    def sd_at(self, points: np.ndarray) -> np.ndarray:
        """Relative standard deviation of the scale at picture points (n, 2)."""
        if self.plane is None:
            return np.full(len(points), self.relative_sd)
        return np.hypot(self.plane.local(points)[1], self.length_sd)

    def with_doubt(self, length_sd: float) -> "Scale":
        """Return the same scale from a stated length that is known to this relative sd only."""
        total = float(np.hypot(self.relative_sd, length_sd))
        return replace(self, relative_sd=total, length_sd=length_sd)


def stated(pixels_per_metre: float, relative_sd: float = 0.0) -> Scale:
    """Take the user's word for the scale."""
    if not 0 < pixels_per_metre < np.inf:
        raise Unmeasurable(f"scale of {pixels_per_metre:g} pixels per metre; it must be positive")
    return Scale(1 / pixels_per_metre, relative_sd, "stated", length_sd=relative_sd)


def from_ruler(start: Sequence[float], end: Sequence[float], length: float) -> Scale:
    """Scale from two picture points a known length apart [m]."""
    pixels = float(np.hypot(*np.subtract(end, start)))
    if pixels < 2 or not length > 0:
        raise Unmeasurable(
            f"ruler from {tuple(start)} to {tuple(end)} of {length:g} m; "
            "give two different points and a positive length"
        )
    return Scale(length / pixels, np.sqrt(2) * CLICK_SD / pixels, "ruler")


def from_filament(strands: Sequence[Strand], diameter: float) -> Scale:
    """Scale from the strands' known diameter [m]; the scatter between strands gives the sd."""
    widths = np.array([np.median(s.width[s.edges == 2]) for s in strands if (s.edges == 2).any()])
    if len(widths) == 0 or not diameter > 0:
        raise Unmeasurable(
            f"filament of {diameter:g} m on {len(widths)} strands; "
            "at least one strand must be seen in full width"
        )
    mean = float(widths.mean())
    # sRGB's curve moves the half-contrast edge of a blurred tube out on black and in on white.
    scatter = float(widths.std(ddof=1)) / np.sqrt(len(widths)) if len(widths) > 1 else 0.0
    return Scale(diameter / mean, float(np.hypot(scatter / mean, EDGE_BIAS)), "filament diameter")


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


@dataclass(frozen=True)
class Request:
    """A scale as asked for on the command line.

    Attributes
    ----------
    kind : str
        One of PATTERNS.
    numbers : tuple of float
        Metres, pixels, counts, in the order they were written.
    length_sd : float
        Relative sd of the stated length.
    board : str or None
        Photograph of the marker or board, where it is not the one that is measured.
    """

    kind: str
    numbers: tuple[float, ...]
    length_sd: float = 0.0
    board: str | None = None


def parse_scale(text: str) -> Request:
    """Read a scale in one of the forms FORMS.

    Raises
    ------
    Unmeasurable
        When the text has none of these forms, or a length in it is not positive.
    """
    form, _, board = text.partition("@")
    form, _, doubt = form.partition("+-")
    kind, values = _match(form.strip())
    try:
        length_sd = float(doubt.strip().removesuffix("%")) / 100 if doubt else 0.0
    except ValueError:
        kind = None
    if kind is None or (doubt and "%" not in doubt) or (board and kind not in ON_A_BOARD):
        raise Unmeasurable(f"scale '{text}' is not understood; write it as {FORMS}")
    lengths = values[4:] if kind == "ruler" else values
    if not (np.isfinite(values).all() and min(lengths) > 0 and 0 <= length_sd < 1):
        raise Unmeasurable(f"scale '{text}': its lengths must be positive, its +- below 100 %")
    return Request(kind, values, length_sd, board or None)


def _match(form: str) -> tuple[str | None, tuple[float, ...]]:
    """Find the kind of a scale, and its numbers with lengths in metres."""
    for kind, pattern in PATTERNS.items():
        match = re.fullmatch(pattern, form)
        if match is None:
            continue
        numbers: list[float] = []
        try:
            for part in match.groups():
                if part in METRES:
                    numbers[-1] *= METRES[part] if kind != "stated" else 1 / METRES[part]
                else:
                    numbers.append(float(part))
        except ValueError:  # more than one point in a number
            break
        return kind, tuple(numbers)
    return None, ()
