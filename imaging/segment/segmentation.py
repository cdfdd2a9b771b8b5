"""What segmentation finds: which strand colour each pixel shows."""

from dataclasses import dataclass

import numpy as np

from imaging.segment.crests import Piece


@dataclass(frozen=True)
class Segmentation:
    """Which strand colour each pixel shows.

    Attributes
    ----------
    labels : (h, w) uint8 array
        0 = background, k = colour k - 1 of `colours`; the strand on top wins.
    membership : (k, h, w) float32 array in [0, 1]
        How much of the pixel is covered by each colour; 0.5 is a strand's edge.
    colours : (k, 3) float array
        Lab colour of each strand in its middle (L 0..100).
    width : float
        Typical strand width [px].
    contrast : (h, w, 3) float32 array, optional
        Lab colour above the background's, as it would be in even light.
    blocks : (h, w) bool array, optional
        What stands out but is too wide to be a strand: a clamp, a card, a thick tine.
    coverage : (h, w) float32 array, optional
        How much of the pixel is covered by any strand: the sum of `membership`.
    ruling : (h, w) bool array, optional
        Lines printed on the ground that were taken for ground.
    shadow : (h, w) bool array, optional
        What was taken for shadow on the ground.
    pieces : list of Piece, optional
        Pieces of ridges that stand out from the ground's texture (`imaging.segment.crests`), each
        with the number of its colour; None on a ground without texture.
    """

    labels: np.ndarray
    membership: np.ndarray
    colours: np.ndarray
    width: float
    contrast: np.ndarray | None = None
    blocks: np.ndarray | None = None
    coverage: np.ndarray | None = None
    ruling: np.ndarray | None = None
    shadow: np.ndarray | None = None
    pieces: list[Piece] | None = None
