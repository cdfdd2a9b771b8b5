"""What in a photograph makes its numbers doubtful, and where: notes for its owner."""

from collections.abc import Sequence

import cv2
import numpy as np
from scipy.ndimage import map_coordinates

from imaging.photo import Photo
from imaging.segment import Segmentation
from imaging.segment.coverage import NOISE_FACTOR
from imaging.trace import Strand
from imaging.trace.centreline import normals

THIN = 4.0  # px; narrower strands have no inside
SOFT = 0.26  # of the width, sd of the blur; a strand that is nothing but blur has 0.28
REACH, STEP = 1.5, 0.15  # strand widths from the middle outwards, along which edges are looked at
ROUGH = 3.6  # Lab units; ground that varies more hides strands of fifteen units' contrast
BURNT = 0.995  # of full scale in every channel
NEAR = 2.0  # strand widths between a strand's end and the glare that cuts it
DARK = 0.2  # of full scale; a photograph with nothing brighter is underexposed
RISE = 2.563  # sds of a Gaussian blur between a tenth and nine tenths of an edge's contrast


def notes_on(photo: Photo, segmentation: Segmentation, strands: Sequence[Strand]) -> list[str]:
    """Say what makes the measurement of a photograph doubtful; nothing when it is good."""
    notes = [exposure(photo)]
    if segmentation.width < THIN:
        notes.append(
            f"strands are {segmentation.width:.1f} px wide; at least {THIN:.0f} px are needed to "
            "tell neighbours apart: go closer"
        )
    blur = edge_blur(photo, segmentation.width, strands)
    if blur > SOFT * segmentation.width:
        notes.append(
            f"blurred: edges are soft over {RISE * blur:.1f} px (strands {segmentation.width:.1f} "
            "px wide); crossings may be missed and widths are off: focus, or hold still"
        )
    if (level := grain(segmentation)) > ROUGH:
        notes.append(
            f"the ground varies by {level:.0f} Lab units, by texture or noise; strands that differ "
            f"from it by less than {NOISE_FACTOR * level:.0f} are lost, and its marks may be taken "
            "for strands: use plain ground, more light"
        )
    if segmentation.ruling is not None:
        notes.append(
            "lines of a grid printed on the ground were left out; strands of their colour may be "
            "interrupted there: use plain ground"
        )
    if segmentation.shadow is not None:
        notes.append(
            "shadows on the ground (its own hue in less light, with soft edges) were left out; a "
            "grey strand out of focus would be too: light from all sides"
        )
    notes += _ends(photo, segmentation, strands)
    return [note for note in notes if note]


def grain(segmentation: Segmentation) -> float:
    """Median distance of the picture's colours from the ground's [Lab units]; 0 = unknown.

    Half of a picture is ground, so that this is what texture and noise make of it.
    """
    if segmentation.contrast is None:
        return 0.0
    return float(np.median(np.linalg.norm(segmentation.contrast[::13, ::11], axis=-1)))


def exposure(photo: Photo) -> str:
    """Say so when a photograph is nearly black."""
    full = np.iinfo(photo.pixels.dtype).max
    brightest = float(np.percentile(photo.pixels[::4, ::4], 99.9)) / full
    if brightest > DARK:
        return ""
    return f"dark: its brightest part has {100 * brightest:.0f} % of full scale; expose longer"


def edge_blur(photo: Photo, width: float, strands: Sequence[Strand]) -> float:
    """Sd of the blur of the strands' edges [px], from the steepest slope across them; 0 = unknown.

    An ideal edge of contrast c blurred by sd sigma rises at most by c / (sigma sqrt(2 pi)) a
    pixel. The shading of a tube counts as blur too, so this is an upper bound; a strand blurred
    by its own width or more is a Gaussian, whose ratio of this to its half-contrast width is 0.28.
    """
    full = np.float32(np.iinfo(photo.pixels.dtype).max)
    steps = width * np.arange(0, REACH, STEP)[:, None]
    found = []
    for strand in strands:
        rows = np.flatnonzero(strand.edges == 2)[::5]
        if len(rows) == 0:
            continue
        points, across = strand.line[rows], normals(strand.line)[rows]
        for side in (-1, 1):
            at = [points[:, i] + side * steps * across[:, i] for i in (1, 0)]
            rgb = [map_coordinates(photo.pixels[..., c], at, np.float32, order=1, mode="nearest")
                   for c in range(3)]  # fmt: skip
            colour = cv2.cvtColor(np.stack(rgb, axis=-1) / full, cv2.COLOR_RGB2Lab)
            contrast = np.linalg.norm(colour - colour[-1:], axis=-1)
            slope = -np.diff(contrast, axis=0).min(axis=0) / (STEP * width)
            found.append(contrast.max(axis=0) / np.maximum(slope, 1e-6))
    rise = np.concatenate(found) if found else np.empty(0)
    return float(np.median(rise)) / np.sqrt(2 * np.pi) if len(rise) else 0.0


def _ends(photo: Photo, segmentation: Segmentation, strands: Sequence[Strand]) -> list[str]:
    """Strands that leave the picture, or end where it is burnt out."""
    bright_ground = _burnt(photo.pixels[::4, ::4]) > 0.3  # white at full scale hides no strand
    reach = int(np.ceil(NEAR * segmentation.width))
    notes, leaving = [], []
    for number, strand in enumerate(strands, start=1):
        for end, point in zip(strand.ends, (strand.line[0], strand.line[-1]), strict=True):
            x, y = np.maximum(np.round(point).astype(int), 0)
            around = np.s_[max(y - reach, 0) : y + reach + 1, max(x - reach, 0) : x + reach + 1]
            if end == "clipped":
                leaving.append(str(number))
            elif _burnt(photo.pixels[around]) > 0.2 and not bright_ground:
                notes.append(f"strand {number} ends in glare at x = {x}, y = {y}: light it softly")
    if leaving:
        which = ", ".join(dict.fromkeys(leaving))
        plural = "s leave" if len(set(leaving)) > 1 else " leaves"
        notes.append(f"strand{plural} the picture: {which}")
    return notes


def _burnt(pixels: np.ndarray) -> float:
    """Share of pixels (h, w, 3) of which every channel is at full scale."""
    return float((pixels.min(axis=2) >= BURNT * np.iinfo(pixels.dtype).max).mean())
