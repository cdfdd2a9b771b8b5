"""Read a photograph without losing bits, colours or its orientation."""

from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

import cv2
import numpy as np

from imaging.errors import Unmeasurable
from imaging.photo.decode import Picture, decode
from imaging.photo.region import MIN_SIDE, Box, mask_of, outside

BAND = 2**17  # pixels worked on at once, whole rows: they stay in the processor's cache
# EXIF orientation -> (mirror left-right first, then quarter turns anticlockwise)
_UPRIGHT = {
    1: (False, 0),
    2: (True, 0),
    3: (False, 2),
    4: (True, 2),
    5: (True, 1),
    6: (False, 3),
    7: (True, 3),
    8: (False, 1),
}


def bands(shape: tuple[int, ...]) -> Iterator[slice]:
    """Cut the rows of a picture into bands of about as many pixels."""
    height, width = shape[:2]
    rows = max(BAND // width, 1)
    return (slice(top, min(top + rows, height)) for top in range(0, height, rows))


def shrunk(picture: np.ndarray, step: int) -> np.ndarray:
    """Picture in pixels `step` times as large; what is left over at its far sides is left out.

    Means over whole pixels take a fifth of the time of others.
    """
    step = min(step, *picture.shape[:2])
    size = picture.shape[1] // step, picture.shape[0] // step
    whole = picture[: size[1] * step, : size[0] * step]
    return cv2.resize(whole, size, interpolation=cv2.INTER_AREA)


@dataclass(frozen=True)
class Photo:
    """A photograph, upright, in sRGB.

    Attributes
    ----------
    pixels : (h, w, 3) uint8 or uint16 array
        sRGB-coded red, green, blue. Pixel centres lie at integer coordinates, x right, y down.
    source : str
        Where it was read from.
    ignore : (h, w) bool array or None
        True where the picture says nothing (transparent, outside the region of interest).
    exif : dict
        Camera, lens, time and so on, as strings.
    """

    pixels: np.ndarray
    source: str = "array"
    ignore: np.ndarray | None = None
    exif: dict[str, str] = field(default_factory=dict)

    @property
    def shape(self) -> tuple[int, int]:
        """Height and width [px]."""
        return self.pixels.shape[0], self.pixels.shape[1]

    def rgb(self) -> np.ndarray:
        """Return sRGB-coded float32 in [0, 1], shape (h, w, 3)."""
        return self._rgb(slice(None))

    def _rgb(self, rows: slice) -> np.ndarray:
        full = np.float32(np.iinfo(self.pixels.dtype).max)
        return np.divide(self.pixels[rows], full, dtype=np.float32)

    def lab(self) -> np.ndarray:
        """Return CIE Lab (D65, L from 0 to 100) float32, shape (h, w, 3)."""
        colour = np.empty((*self.shape, 3), np.float32)
        for band in bands(self.shape):
            cv2.cvtColor(self._rgb(band), cv2.COLOR_RGB2Lab, dst=colour[band])
        return colour

    def eight_bits(self) -> np.ndarray:
        """Return sRGB-coded uint8, shape (h, w, 3); not a copy where the photograph is that."""
        if self.pixels.dtype == np.uint8:
            return self.pixels
        return np.round(self.pixels / np.float32(257)).astype(np.uint8)


def read_photo(
    path: str | Path,
    *,
    roi: Box | str | Path | np.ndarray | None = None,
    ignore: str | Path | np.ndarray | None = None,
    page: int | None = None,
) -> Photo:
    """Read one photograph: JPEG, PNG, TIFF (8 or 16 bits), and HEIC or camera RAW with the extra.

    The EXIF orientation is applied. Transparent pixels and those outside `roi` are marked to be
    ignored. Grey pictures become RGB with equal channels; CMYK is converted to RGB.

    Parameters
    ----------
    path : path
        The picture's file.
    roi : (x0, y0, x1, y1) in pixels, or path or (h, w) array, optional
        Region of interest, upper left included, lower right excluded; or a mask of the same size
        as the upright picture (file: brighter than half, array: not zero) = look here.
    ignore : path or (h, w) array, optional
        The same; do not look here.
    page : int, optional
        Page of a TIFF of several, from 1 (`imaging.photo.pages.pages_of` lists them).

    Returns
    -------
    Photo

    Raises
    ------
    Unmeasurable
        When the file is not a picture, is damaged, holds several pictures and no page is named, or
        is too small or too large; when a region or mask does not fit it or leaves nothing to look
        at.
    """
    picture = Picture(Path(path), page)
    stored = decode(*picture)
    mirror, turns = _UPRIGHT.get(stored.orientation, (False, 0))
    upright = np.rot90(stored.pixels[:, ::-1] if mirror else stored.pixels, turns)
    colour, hidden = _rgb_and_hidden(upright)
    height, width = hidden.shape
    if min(height, width) < MIN_SIDE:
        raise Unmeasurable(
            f"{picture}: {width} x {height} pixels; "
            f"a photograph needs at least {MIN_SIDE} x {MIN_SIDE}"
        )
    if roi is not None:
        hidden = hidden | outside(picture, roi, (height, width))
    if ignore is not None:
        hidden = hidden | mask_of(picture, ignore, (height, width))
    if hidden.all():
        raise Unmeasurable(
            f"{picture}: transparency, region of interest and mask leave nothing to look at"
        )
    pixels = np.ascontiguousarray(colour)
    return Photo(pixels, str(picture), hidden if hidden.any() else None, stored.exif)


def _rgb_and_hidden(pixels: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Colour (h, w, 3) and the transparent pixels (h, w)."""
    if pixels.ndim == 2:
        pixels = pixels[..., None]
    channels = pixels.shape[2]
    hidden = np.zeros(pixels.shape[:2], bool)
    if channels in (2, 4):
        hidden = pixels[..., -1] < np.iinfo(pixels.dtype).max // 2
        channels -= 1
    colour = pixels[..., :3] if channels == 3 else np.repeat(pixels[..., :1], 3, axis=2)
    return colour, hidden
