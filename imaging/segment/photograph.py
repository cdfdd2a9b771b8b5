"""Photograph -> which strand colour each pixel shows, by colour on plain ground, else by ridges.

The ground is the smooth surface most pixels lie on (robust quadratic in Lab, then a local mean of
what is left); its brightness evens out the light.
"""

import cv2
import numpy as np

from imaging.errors import Unmeasurable
from imaging.photo import Photo, shrunk
from imaging.segment.by_colour import by_colour
from imaging.segment.by_ridge import by_ridge
from imaging.segment.coverage import MIN_CONTRAST, NOISE_FACTOR, around_all
from imaging.segment.depths import depth_of, places_of, summit
from imaging.segment.ground import Ground, contrast_of, ground_of
from imaging.segment.ruling import erase_ruling
from imaging.segment.segmentation import Segmentation

MEDIAN = 0.6745  # sds of a Gaussian; half of it lies within
SOME, ROWS = 7, 300  # of so many rows the noise is looked at in one, but in so many at least
LARGER = 4  # px; side of the pixels in which texture is told from noise
CHANGING = 0.06  # banded cables have 0.1 to 0.6, tangles of strands of one colour each up to 0.03
UNLIKE = 25.0  # Lab units; noise makes nearer colours (navy, blue) take turns along a strand
PAIR = 3  # colours; two or three may be of strands twisted together, which change places as often
SINGLE = 0.7  # of the breadth of what is covered, that strands of one colour have at least
THICK = 1.25  # times the usual depth; strands cross or touch
DOTS = "is made of black and white dots, in which no strand can be followed; save it in colour"
COVERED = 0.3  # of the picture; strands cover less, so that more is ground of another colour


def segment(photo: Photo) -> Segmentation:
    """Separate the strands of a photograph from its background and from each other by colour.

    Parameters
    ----------
    photo : Photo

    Returns
    -------
    Segmentation

    Raises
    ------
    Unmeasurable
        When nothing stands out from the background.
    """
    lab = photo.lab()
    ground = ground_of(lab, photo.ignore)
    contrast = contrast_of(lab, ground)
    ruling = erase_ruling(lab, contrast, ground)
    if _hides_strands(lab, ground):
        if len(np.unique(photo.pixels)) == 2:
            raise Unmeasurable(f"{photo.source}: {DOTS}")
        return by_ridge(photo, lab, ground, ruling)
    found = by_colour(photo, lab, ground, contrast, ruling)
    if len(found.colours) > PAIR and changing(found) > CHANGING:
        lab = photo.lab()
        erase_ruling(lab, contrast_of(lab, ground), ground)
        return by_ridge(photo, lab, ground, ruling)
    return found


def changing(found: Segmentation) -> float:
    """Tell how often single strands change to an unlike colour, in strand widths of border a width.

    Counted where what is covered is as broad as a single strand: not near crossings. Where it is
    broader than strands of one colour everywhere, strands lie beside each other; 0 then.
    """
    box = around_all(found.labels > 0)
    labels = found.labels[box]
    depth = depth_of(labels > 0)
    usual = float(np.median(depth.ravel()[summit(depth, 0.35 * found.width)]))
    if found.width < SINGLE * (2 * usual - 1):
        return 0.0
    reach = 2 * round(found.width) + 1
    thick = cv2.dilate((depth > THICK * usual).view(np.uint8), np.ones((reach, reach), np.uint8))
    alone = np.pad(np.where(thick == 0, labels, np.uint8(0)), 1).ravel()
    at = places_of(alone)
    unlike = np.zeros((len(found.colours) + 1,) * 2, bool)  # never the ground, 0
    apart = found.colours[:, None] - found.colours
    unlike[1:, 1:] = np.linalg.norm(apart, axis=-1) > UNLIKE
    beside = [alone[at + step] for step in (1, labels.shape[1] + 2)]
    borders = sum(np.count_nonzero(unlike[alone[at], other]) for other in beside)
    return float(borders * found.width / max(len(at), 1))


def _hides_strands(lab: np.ndarray, ground: Ground) -> bool:
    """Tell a ground whose texture, or patches, would hide strands or be taken for some.

    Looked at in larger pixels, over which a sensor's noise is averaged; what is left of it is
    known from how single pixels differ from those around them.
    """
    seen = shrunk(lab, LARGER)
    under = cv2.resize(ground.coarse, seen.shape[1::-1], interpolation=cv2.INTER_LINEAR)
    off = np.sqrt(((seen - under) ** 2) @ np.ones(3, np.float32))
    texture = max(float(np.median(off)) ** 2 - (_noise(lab) / LARGER) ** 2, 0) ** 0.5
    threshold = NOISE_FACTOR * texture
    return threshold > MIN_CONTRAST or float((off > MIN_CONTRAST).mean()) > COVERED


def _noise(lab: np.ndarray) -> float:
    """Sd of what differs from pixel to pixel [Lab units], all three channels together."""
    if min(lab.shape[:2]) < 3:
        return 0.0
    step = max(SOME, len(lab) // ROWS)
    above, here, below = (lab[row : len(lab) - 2 + row : step] for row in range(3))
    around = (here[:, :-2] + here[:, 2:] + above[:, 1:-1] + below[:, 1:-1]) / 4
    off = np.median(np.abs(here[:, 1:-1] - around).reshape(-1, 3), axis=0)
    return float(np.linalg.norm(off)) / (MEDIAN * 1.25**0.5)  # a mean of four adds a quarter
