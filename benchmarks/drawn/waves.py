"""Three strands that wave across each other, and their measurement: what corrections act on."""

from functools import cache

import numpy as np
from scipy.spatial import cKDTree

from drawn.strands import render
from imaging import Photo, Segmentation, Strand, segment, trace

SHAPE, WIDTH = (260, 240), 7  # px
COLOURS = [(0.85, 0.1, 0.2), (0.1, 0.6, 0.25), (0.1, 0.3, 0.8)]


def waves() -> list[np.ndarray]:
    """Three centrelines that cross each other, root to tip."""
    y = np.linspace(15, 245, 300)
    return [np.stack([120 + 45 * np.sin(y / 45 + 2.1 * i), y], axis=1) for i in range(3)]


def photographed(seed: int = 3) -> Photo:
    """Draw the waves, with this seed's noise."""
    heights = [np.full(300, 20.0 * i) for i in range(3)]
    pixels = render(waves(), heights, COLOURS, WIDTH / 2, SHAPE, rng=seed).pixels
    return Photo(pixels, "waves.png")


@cache
def scene() -> tuple[Photo, Segmentation, list[Strand]]:
    """Return photograph, segmentation and the strands, in the waves' order."""
    photo = photographed()
    segmentation = segment(photo)
    found = trace(segmentation, photo)
    own = [min(found, key=lambda s, wave=wave: off(s.line, wave).mean()) for wave in waves()]
    assert len({id(strand) for strand in own}) == len(found) == 3
    return photo, segmentation, own


def off(line: np.ndarray, truth: np.ndarray) -> np.ndarray:
    """Distance of each point of a line to the nearest of another [px]."""
    return cKDTree(truth).query(line)[0]
