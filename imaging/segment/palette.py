"""The colours of the strands: how many there are, and which one each pixel shows."""

from collections.abc import Iterator
from itertools import pairwise

import cv2
import numpy as np
from scipy import ndimage

from imaging.segment.depths import places_of

CELL = 3.0  # side of a histogram cell, in units of 100 x (a, b)/(L + 16)
RIM = 5  # empty cells around the histogram, more than its smoothing reaches
LIGHTNESS_WEIGHT = 0.35  # of log(L + 16) beside (a, b)/(L + 16)
PROMINENCE = 0.5  # a mode of the histogram must rise this far above the pass to a higher one
SPREAD = 0.2  # strand widths; how far a pixel's vote reaches (sd)
FARTHEST = 3.0  # of these; no vote reaches farther
BAND = 512  # rows in which votes are counted at once
BLUR = 0.9  # px; votes reach at least as far as a lens blurs
RIDGE_SHARE = 0.02  # of all ridge pixels, below which a colour is not a strand


def unmixed(lab: np.ndarray, background: np.ndarray, coverage: np.ndarray) -> np.ndarray:
    """Colour of what covers a pixel only in part: b + (p - b)/coverage, per row.

    The rim of a dark strand on a light ground looks like a lighter strand of another colour
    until the ground's share is taken out.
    """
    pure = background + (lab - background) / np.maximum(coverage, 0.3)[:, None]
    pure[:, 0] = np.clip(pure[:, 0], 0, 100)
    return pure


def colour_features(lab: np.ndarray, background: np.ndarray) -> np.ndarray:
    """Return (n, 3) colour coordinates that uneven light and shading move little.

    With f = cube root, a = 500 (f(X) - f(Y)) and L + 16 = 116 f(Y), so a/(L + 16) and b/(L + 16)
    do not change when the light is scaled; log(L + 16) shifts by a third of its logarithm and is
    counted from the local background's brightness.

    Parameters
    ----------
    lab, background : (n, 3) arrays
        Colour of each pixel and of the background under it.
    """
    base = lab[:, 0] + 16
    level = background[:, 0] + 16
    even = np.log(base) - np.log(level / level.mean())
    columns = [lab[:, 1] / base, lab[:, 2] / base, LIGHTNESS_WEIGHT * even]
    return 100 * np.stack(columns, axis=1)


def find_colours(
    features: np.ndarray, lab: np.ndarray, width: float
) -> tuple[np.ndarray, np.ndarray]:
    """Find the dense places among the colours of the strands' middles.

    Parameters
    ----------
    features : (n, 3) array
        From `colour_features`, for pixels in the middle of strands.
    lab : (n, 3) array
        The same pixels in Lab.
    width : float
        Typical strand width [px].

    Returns
    -------
    centres : (k, 3) array
        Colours in feature space; none where no colour is dense enough.
    colours : (k, 3) array
        Colours in Lab.
    """
    cells = np.floor((features - features.min(axis=0)) / CELL).astype(int)
    cells += RIM
    count = np.zeros(cells.max(axis=0) + RIM + 1, np.float32)
    np.add.at(count, tuple(cells.T), 1)
    density = ndimage.gaussian_filter(count, 1.0, mode="constant")
    which = _modes(density)[tuple(cells.T)]
    sizes = np.bincount(which[which >= 0], minlength=1)
    kept = np.flatnonzero(sizes >= max(RIDGE_SHARE * len(features), 5 * width))
    centres = [np.median(features[which == k], axis=0) for k in kept]
    colours = [np.median(lab[which == k], axis=0) for k in kept]
    return np.reshape(centres, (-1, 3)), np.reshape(colours, (-1, 3))


def _modes(density: np.ndarray) -> np.ndarray:
    """Cluster cells by climbing to modes, merging those of low prominence; -1 where empty.

    ToMATo (Chazal, Guibas, Oudot, Skraba, J. ACM 60 (6), 41, 2013): cells are visited from the
    densest; one that touches two hills joins the lower to the higher unless the lower rises above
    the pass by more than PROMINENCE of its height.
    """
    value = density.ravel()
    order = np.flatnonzero(value > 3e-3 * value.max())  # never the rim
    order = order[np.argsort(value[order])[::-1]]
    height = value[order].tolist()
    parent: list[int] = []  # of each cell visited so far, in the order of visits

    def root(cell: int) -> int:
        while parent[cell] != cell:
            parent[cell] = parent[parent[cell]]
            cell = parent[cell]
        return cell

    for cell, neighbours in enumerate(_denser_neighbours(order, density.shape)):
        hills = {root(above) for above in {parent[n] for n in neighbours}}  # few, of many cells
        highest = min(hills, default=cell)
        parent.append(highest)
        for hill in hills - {highest}:
            if height[hill] - height[cell] < PROMINENCE * height[hill]:
                parent[hill] = highest
    summits = order[[root(cell) for cell in range(len(order))]]
    which = np.full(density.size, -1)
    which[order] = np.unique(summits, return_inverse=True)[1]
    return which.reshape(density.shape)


def _denser_neighbours(order: np.ndarray, shape: tuple[int, ...]) -> Iterator[list[int]]:
    """Of each cell, those of its 26 neighbours that come before it in the order (their places)."""
    place = np.full(np.prod(shape), len(order))
    place[order] = np.arange(len(order))
    around = place[order[:, None] + _neighbour_steps(shape)]
    before = around < np.arange(len(order))[:, None]
    ends = np.cumsum(before.sum(axis=1)).tolist()
    flat = around[before].tolist()
    return (flat[start:end] for start, end in pairwise([0, *ends]))


def _neighbour_steps(shape: tuple[int, ...]) -> np.ndarray:
    """Flat-index steps to the 26 neighbours of a cell."""
    grid = np.stack(np.meshgrid(*[[-1, 0, 1]] * 3, indexing="ij"), -1).reshape(-1, 3)
    grid = grid[np.any(grid != 0, axis=1)]
    return grid @ np.array([shape[1] * shape[2], shape[2], 1])


def vote(
    features: np.ndarray,
    strand: np.ndarray,
    centres: np.ndarray,
    width: float,
    weight: np.ndarray,
) -> np.ndarray:
    """Label each strand pixel with the colour most of its neighbourhood shows.

    Each pixel votes for the nearest colour; votes are spread over a fifth of a strand width,
    so that highlights, noise and mixtures at edges are outvoted.

    Parameters
    ----------
    features : (n, 3) array
        Of the strand pixels, in the order of ``strand.nonzero()``.
    strand : (h, w) bool array
    centres : (k, 3) array
    width : float
        Typical strand width [px].
    weight : (n,) array
        What each pixel's vote counts.

    Returns
    -------
    (h, w) uint8 array
        0 outside strands, else 1 + the index of the colour.
    """
    nearest = _nearest(features, centres)
    y, x = np.divmod(places_of(strand), strand.shape[1])
    sigma = max(SPREAD * width, BLUR)
    reach = int(np.ceil(FARTHEST * sigma))
    labels = np.zeros(strand.shape, np.uint8)
    for top in range(0, len(strand), BAND):  # the box around a strand holds little else there
        low, high = max(top - reach, 0), min(top + BAND + reach, len(strand))
        near = slice(*np.searchsorted(y, [low, high]).tolist())
        shape = high - low, strand.shape[1]
        won = _most_votes(nearest[near], y[near] - low, x[near], weight[near], shape, sigma)
        labels[top : top + BAND] = won[top - low : top - low + BAND]
    return np.where(strand, labels, np.uint8(0))


def _most_votes(
    colours: np.ndarray,
    y: np.ndarray,
    x: np.ndarray,
    weight: np.ndarray,
    shape: tuple[int, int],
    sigma: float,
) -> np.ndarray:
    """1 + the colour of which most is seen around each pixel of a picture, 0 where none is."""
    labels = np.zeros(shape, np.uint8)
    most = np.zeros(shape, np.float32)
    for colour in np.unique(colours).tolist():
        own = colours == colour
        votes, box = _spread_out(y[own], x[own], weight[own], shape, sigma)
        np.copyto(labels[box], colour + 1, where=votes > most[box])
        np.maximum(votes, most[box], out=most[box])
    return labels


def _nearest(features: np.ndarray, centres: np.ndarray) -> np.ndarray:
    """Index of the centre nearest to each row, from |f - c|^2 = |f|^2 - 2 (f.c - |c|^2 / 2)."""
    centres = centres.astype(features.dtype)
    return (centres @ features.T - (centres**2).sum(axis=1)[:, None] / 2).argmax(axis=0)


def _spread_out(
    y: np.ndarray, x: np.ndarray, weight: np.ndarray, shape: tuple[int, ...], sigma: float
) -> tuple[np.ndarray, tuple[slice, slice]]:
    """Weights of pixels, blurred, and the rows and columns of the picture they reach."""
    reach = int(np.ceil(FARTHEST * sigma))
    top, left = max(int(y.min()) - reach, 0), max(int(x.min()) - reach, 0)
    bottom, right = min(int(y.max()) + reach + 1, shape[0]), min(int(x.max()) + reach + 1, shape[1])
    votes = np.zeros((bottom - top, right - left), np.float32)
    votes[y - top, x - left] = weight
    side = 2 * reach + 1
    return cv2.GaussianBlur(votes, (side, side), sigma), np.s_[top:bottom, left:right]
