"""A line drawn by hand -> the strand beneath it: centreline, width and what is seen of its edges.

Strategy: straighten the photograph along the line; there the strand is a level band, whose colour
is that of the picture's middle and whose ground is what lies to both sides; measure the band as
any strand is measured, and bend it back. Nothing of the segmentation is used: what a hand must draw
is most often what the colours did not show.
"""

import cv2
import numpy as np
from scipy import ndimage

from imaging.photo import Photo
from imaging.trace.centreline import Centreline, dense, normals, refine, resample, sample

ASIDE = 2.0  # strand widths to each side that are looked at
CORE = 0.25  # strand widths from the middle in which its own colour shows
BESIDE = (1.0, 1.8)  # strand widths from the middle in which the ground shows
ALONG = 8.0  # strand widths over which the colours of strand and ground are taken
FAINT = 3.0  # Lab units; a strand that differs less from what lies beside it is not seen
ROUNDED = 0.8  # strand widths, sd over which the corners of a hand's line are rounded
STAY = 1.2  # strand widths; a band farther from the line is another strand


def snap(photo: Photo, points: np.ndarray, width: float) -> tuple[Centreline, np.ndarray]:
    """Measure the strand beneath a hand's line.

    Parameters
    ----------
    photo : Photo
    points : (n, 2) array
        The line, within about half a width of the strand's middle [px].
    width : float
        Typical strand width [px].

    Returns
    -------
    Centreline
        Where no edge is seen it follows the hand.
    colour : (3,) array
        Median Lab colour of the strand's middle.
    """
    line = _rounded(np.asarray(points, float), width)
    normal = normals(line)
    half = int(np.ceil(ASIDE * width))
    straight = _straightened(photo, line, normal, half)
    own, covered, colour = _shares(straight, width, half)
    level = np.stack([np.arange(len(line)), np.full(len(line), float(half))], axis=1)
    found = dense(refine(level, own, covered, width), width)
    x, aside = found.line[:, 0].clip(0, len(line) - 1), found.line[:, 1] - half
    astray = (found.edges == 0) | (np.abs(aside) > STAY * width)
    aside = np.where(astray, 0.0, aside)
    aside = ndimage.gaussian_filter1d(aside, 0.5 * width, mode="nearest") if astray.any() else aside
    at = np.arange(len(line))
    bent = [np.interp(x, at, line[:, i]) + aside * np.interp(x, at, normal[:, i]) for i in (0, 1)]
    sd = np.where(astray, np.maximum(found.sd, 0.5 * width), found.sd)
    return (
        Centreline(np.stack(bent, axis=1), found.width, sd, np.where(astray, 0, found.edges)),
        colour,
    )


def _rounded(points: np.ndarray, width: float) -> np.ndarray:
    """Points a pixel apart along a line, its corners rounded and its ends kept."""
    line = resample(points)
    beyond = min(len(line) - 1, int(4 * ROUNDED * width))
    longer = np.pad(line, ((beyond, beyond), (0, 0)), mode="reflect", reflect_type="odd")
    smooth = ndimage.gaussian_filter1d(longer, ROUNDED * width, axis=0)
    return resample(smooth[beyond : len(smooth) - beyond])


def _straightened(photo: Photo, line: np.ndarray, normal: np.ndarray, half: int) -> np.ndarray:
    """Lab colours (2 half + 1, n, 3) across a line, as if it were level."""
    offset = np.arange(-half, half + 1)[:, None, None]
    at = line + offset * normal
    last = np.subtract(photo.shape[::-1], 1)
    full = np.float32(np.iinfo(photo.pixels.dtype).max)
    low = np.maximum(np.floor(at.min(axis=(0, 1))).astype(int) - 1, 0)
    high = np.minimum(np.ceil(at.max(axis=(0, 1))).astype(int) + 2, last + 1)
    crop = photo.pixels[low[1] : high[1], low[0] : high[0]].astype(np.float32) / full
    rgb = sample(np.ascontiguousarray(crop), at.clip(0, last) - low)
    return cv2.cvtColor(np.ascontiguousarray(rgb), cv2.COLOR_RGB2Lab)


def _shares(
    straight: np.ndarray, width: float, half: int
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """How much of each place the strand covers, and any strand; and the strand's colour."""
    offset = np.abs(np.arange(-half, half + 1))
    core = straight[offset <= max(CORE * width, 1)]
    rim = straight[(offset >= BESIDE[0] * width) & (offset <= BESIDE[1] * width)]
    mine = _running(np.median(core, axis=0), width)
    ground = _running(np.median(rim, axis=0), width)
    above = mine - ground
    strength = np.maximum((above**2).sum(axis=-1), FAINT**2)
    rise = straight - ground
    own = ((rise * above).sum(axis=-1) / strength).clip(0, 1)
    off = np.sqrt(np.maximum((rise**2).sum(axis=-1) - own**2 * strength, 0) / strength)
    own = np.where(off > 0.7, own * 0.3, own)  # of quite another colour
    covered = np.sqrt((rise**2).sum(axis=-1) / strength).clip(0, 1)
    colour = np.median(core.reshape(-1, 3), axis=0)
    return own.astype(np.float32), np.maximum(covered, own).astype(np.float32), colour


def _running(colours: np.ndarray, width: float) -> np.ndarray:
    """Take the running median of colours (n, 3) along a strand: what crosses it is lost."""
    many = min(int(ALONG * width) | 1, 2 * (len(colours) // 2) - 1)
    if many < 3:
        return np.broadcast_to(np.median(colours, axis=0), colours.shape)
    return ndimage.median_filter(colours, size=(many, 1), mode="nearest")
