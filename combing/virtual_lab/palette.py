"""Colours that stay apart under shading: what one would dye the strands of a curl with."""

import numpy as np
from numpy.typing import NDArray
from skimage.color import rgb2lab

LIGHTNESS_WEIGHT = 0.4


def palette(n: int) -> list[tuple[float, float, float]]:
    """Choose `n` colours far from each other and from a dark cloth.

    Strategy: farthest-point selection in CIE Lab over a grid of bright colours, with lightness
    weighed down because shading changes it along every strand.

    Returns
    -------
    list of (red, green, blue)
        0 to 1, the first ones farthest apart.
    """
    levels = np.linspace(0.05, 0.95, 9)
    candidates = np.stack(np.meshgrid(levels, levels, levels), axis=-1).reshape(-1, 3)
    lab = rgb2lab(candidates)
    bright = lab[:, 0] > 35
    chosen = _farthest(lab[bright] * [LIGHTNESS_WEIGHT, 1, 1], n)
    return [(float(r), float(g), float(b)) for r, g, b in candidates[bright][chosen]]


def _farthest(points: NDArray[np.float64], n: int) -> list[int]:
    chosen = [int(np.argmax(np.hypot(points[:, 1], points[:, 2])))]
    nearest = np.linalg.norm(points - points[chosen[0]], axis=1)
    while len(chosen) < n:
        chosen.append(int(np.argmax(nearest)))
        nearest = np.minimum(nearest, np.linalg.norm(points - points[chosen[-1]], axis=1))
    return chosen
