"""The colours of the strands: how many there are, and which one each pixel shows."""

import cv2
import numpy as np
from scipy import ndimage

CELL = 3.0  # side of a histogram cell, in units of 100 x (a, b)/(L + 16)
RIM = 5  # empty cells around the histogram, more than its smoothing reaches
LIGHTNESS_WEIGHT = 0.35  # of log(L + 16) beside (a, b)/(L + 16)
PROMINENCE = 0.5  # a mode of the histogram must rise this far above the pass to a higher one
SPREAD = 0.2  # strand widths; how far a pixel's vote reaches (sd)
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
    order = np.argsort(density, axis=None)[::-1]
    order = order[density.ravel()[order] > 3e-3 * density.max()]  # never the rim
    parent = [-1] * density.size
    value = density.ravel().tolist()
    steps = _neighbour_steps(density.shape).tolist()

    def root(cell: int) -> int:
        while parent[cell] != cell:
            parent[cell] = parent[parent[cell]]
            cell = parent[cell]
        return cell

    for cell in order.tolist():
        hills = {root(n) for n in (cell + step for step in steps) if parent[n] >= 0}
        if not hills:
            parent[cell] = cell
            continue
        highest = max(hills, key=value.__getitem__)
        parent[cell] = highest
        for hill in hills - {highest}:
            if value[hill] - value[cell] < PROMINENCE * value[hill]:
                parent[hill] = highest
    roots = np.full(density.size, -1)
    visited = order.tolist()
    roots[visited] = [root(cell) for cell in visited]
    _, numbered = np.unique(roots, return_inverse=True)
    return numbered.reshape(density.shape) - int(roots.min() < 0)


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
    (h, w) int32 array
        0 outside strands, else 1 + the index of the colour.
    """
    distance = np.stack([((features - centre) ** 2).sum(axis=1) for centre in centres])
    nearest = distance.argmin(axis=0)
    sigma = max(SPREAD * width, BLUR)
    votes = np.zeros(strand.shape, np.float32)
    tally = np.empty((len(centres), len(features)), np.float32)
    for colour in range(len(centres)):
        votes[strand] = np.where(nearest == colour, weight, 0)
        tally[colour] = cv2.GaussianBlur(votes, (0, 0), sigma)[strand]
    labels = np.zeros(strand.shape, np.int32)
    labels[strand] = tally.argmax(axis=0) + 1
    return labels
