"""From pixels to metres, and how well: a stated scale, a ruler, a known filament."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from imaging.errors import Unmeasurable
from imaging.scale.plane import Plane

CORNER_SD = 0.15  # px; refined corners of a board
EDGE_BIAS = 0.15  # of the width; -15 % on white, +12 % on black, measured on rendered tubes
CLICK_SD = 0.7  # px; a ruler's end read off the screen


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


def from_filament(widths: np.ndarray, diameter: float) -> Scale:
    """Scale from strands' diameter [m] and their widths [px], whose scatter gives the sd."""
    if len(widths) == 0 or not diameter > 0:
        raise Unmeasurable(
            f"filament of {diameter:g} m on {len(widths)} strands; "
            "at least one strand must be seen in full width"
        )
    mean = float(widths.mean())
    # sRGB's curve moves the half-contrast edge of a blurred tube out on black and in on white.
    scatter = float(widths.std(ddof=1)) / np.sqrt(len(widths)) if len(widths) > 1 else 0.0
    return Scale(diameter / mean, float(np.hypot(scatter / mean, EDGE_BIAS)), "filament diameter")
