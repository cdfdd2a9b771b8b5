"""Where to look in a photograph: a region of interest and what to ignore in it."""

from pathlib import Path

import numpy as np

from imaging.errors import Unmeasurable
from imaging.photo.decode import Picture, decode

MIN_SIDE = 16  # pixels; nothing narrower holds a strand and its background
FORMS = "x0,y0,x1,y1 in whole pixels (x1 and y1 excluded), or a mask picture, white = look here"

Box = tuple[int, int, int, int]


def parse_region(text: str) -> Box | Path:
    """Read a region of interest as written on the command line: four numbers, or a mask's path.

    Raises
    ------
    Unmeasurable
        When it is neither.
    """
    parts = text.split(",")
    try:
        x0, y0, x1, y1 = map(int, parts)
    except ValueError:
        if len(parts) == 1 and Path(text).exists():
            return Path(text)
        raise Unmeasurable(f"region of interest '{text}': give {FORMS}") from None
    return x0, y0, x1, y1


def outside(
    picture: Picture, roi: Box | str | Path | np.ndarray, shape: tuple[int, int]
) -> np.ndarray:
    """Return what lies outside a region of interest, (h, w) bool.

    Parameters
    ----------
    picture : Picture
        The photograph, for messages.
    roi : (x0, y0, x1, y1), path or (h, w) array
        A box, upper left included, lower right excluded; or a mask, nonzero = look here.
    shape : (h, w)
        Of the upright photograph.
    """
    if not isinstance(roi, tuple):
        return ~mask_of(picture, roi, shape)
    x0, y0, x1, y1 = roi
    height, width = shape
    if not (0 <= x0 < x1 <= width and 0 <= y0 < y1 <= height):
        raise Unmeasurable(
            f"{picture}: region of interest {roi} does not lie in the picture "
            f"(0 <= x0 < x1 <= {width}, 0 <= y0 < y1 <= {height})"
        )
    if min(x1 - x0, y1 - y0) < MIN_SIDE:
        raise Unmeasurable(
            f"{picture}: region of interest {roi} is {x1 - x0} x {y1 - y0} pixels; "
            f"give at least {MIN_SIDE} x {MIN_SIDE}"
        )
    hidden = np.ones(shape, bool)
    hidden[y0:y1, x0:x1] = False
    return hidden


def mask_of(picture: Picture, mask: str | Path | np.ndarray, shape: tuple[int, int]) -> np.ndarray:
    """Return a mask as (h, w) bool; it must be as large as the upright photograph `picture`.

    A file counts where it is brighter than half, for JPEG smears; an array where it is not zero.
    """
    if isinstance(mask, np.ndarray):
        name, marked = "the mask", mask != 0
    else:
        name, marked = f"the mask {mask}", _bright(decode(Path(mask)).pixels)
    if marked.shape != shape:
        raise Unmeasurable(
            f"{picture}: {name} is {marked.shape[1]} x {marked.shape[0]} pixels, "
            f"the photograph (upright) {shape[1]} x {shape[0]}; they must agree"
        )
    return marked


def _bright(pixels: np.ndarray) -> np.ndarray:
    grey = pixels if pixels.ndim == 2 else pixels[..., :3].max(axis=2)
    return grey > np.iinfo(grey.dtype).max // 2
