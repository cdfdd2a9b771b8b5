"""The colours of the strands: how many there are, and which one each pixel shows."""

import cv2
import numpy as np
from scipy import ndimage

CELL = 3.0  # side of a histogram cell, in units of 100 x (a, b)/(L + 16)
LIGHTNESS_WEIGHT = 0.35  # of log(L + 16) beside (a, b)/(L + 16)
PROMINENCE = 0.5  # a mode of the histogram must rise this far above the pass to a higher one
RIDGE_SHARE = 0.02  # of all ridge pixels, below which a colour is not a strand


def colour_features(lab: np.ndarray, background: np.ndarray) -> np.ndarray:
    """Return (h, w, 3) colour coordinates that uneven light and shading move little.

    With f = cube root, a = 500 (f(X) - f(Y)) and L + 16 = 116 f(Y), so a/(L + 16) and b/(L + 16)
    do not change when the light is scaled; log(L + 16) shifts by a third of its logarithm and is
    counted from the local background's brightness.
    """
    base = lab[..., 0] + 16
    level = background[..., 0] + 16
    even = np.log(base) - np.log(level / level.mean())
    return np.stack(
        [
            100 * lab[..., 1] / base,
            100 * lab[..., 2] / base,
            100 * LIGHTNESS_WEIGHT * even,
        ],
        axis=-1,
    )


def find_colours(
    features: np.ndarray, lab: np.ndarray, ridge: np.ndarray, width: float
) -> tuple[np.ndarray, np.ndarray]:
    """Find the dense places of the ridge pixels' colours.

    Parameters
    ----------
    features : (h, w, 3) array
        From `colour_features`.
    lab : (h, w, 3) array
    ridge : (h, w) bool array
        Pixels in the middle of strands.
    width : float
        Typical strand width [px].

    Returns
    -------
    centres : (k, 3) array
        Colours in feature space.
    colours : (k, 3) array
        Colours in Lab.
    """
    samples, shown = features[ridge], lab[ridge]
    origin = samples.min(axis=0)
    cells = np.floor((samples - origin) / CELL).astype(int) + 5  # an empty rim all round
    count = np.zeros(cells.max(axis=0) + 6, np.float32)
    np.add.at(count, tuple(cells.T), 1)
    density = ndimage.gaussian_filter(count, 1.0, mode="constant")
    which = _modes(density)[tuple(cells.T)]
    sizes = np.bincount(which[which >= 0], minlength=1)
    kept = np.flatnonzero(sizes >= max(RIDGE_SHARE * len(samples), 5 * width))
    centres = np.array([np.median(samples[which == k], axis=0) for k in kept])
    colours = np.array([np.median(shown[which == k], axis=0) for k in kept])
    return centres, colours


def _modes(density: np.ndarray) -> np.ndarray:
    """Cluster cells by climbing to modes, merging those of low prominence; -1 where empty.

    ToMATo (Chazal, Guibas, Oudot, Skraba, J. ACM 60 (6), 41, 2013): cells are visited from the
    densest; one that touches two hills joins the lower to the higher unless the lower rises above
    the pass by more than PROMINENCE of its height.
    """
    order = np.argsort(density, axis=None)[::-1]
    order = order[density.ravel()[order] > 1e-3 * density.max()]  # never the rim
    parent = np.full(density.size, -1)
    value = density.ravel()
    steps = _neighbour_steps(density.shape)

    def root(cell: int) -> int:
        while parent[cell] != cell:
            parent[cell] = parent[parent[cell]]
            cell = parent[cell]
        return cell

    for cell in order.tolist():
        hills = {root(n) for n in (cell + steps).tolist() if parent[n] >= 0}
        if not hills:
            parent[cell] = cell
            continue
        highest = max(hills, key=value.__getitem__)
        parent[cell] = highest
        for hill in hills - {highest}:
            if value[hill] - value[cell] < PROMINENCE * value[hill]:
                parent[hill] = highest
    roots = np.array([root(c) if parent[c] >= 0 else -1 for c in range(density.size)])
    _, numbered = np.unique(roots, return_inverse=True)
    return numbered.reshape(density.shape) - int(roots.min() < 0)


def _neighbour_steps(shape: tuple[int, ...]) -> np.ndarray:
    """Flat-index steps to the 26 neighbours of a cell."""
    grid = np.stack(np.meshgrid(*[[-1, 0, 1]] * 3, indexing="ij"), -1).reshape(-1, 3)
    grid = grid[np.any(grid != 0, axis=1)]
    return grid @ np.array([shape[1] * shape[2], shape[2], 1])


def vote(
    features: np.ndarray,
    coverage: np.ndarray,
    strand: np.ndarray,
    centres: np.ndarray,
    width: float,
) -> np.ndarray:
    """Label each strand pixel with the colour most of its neighbourhood shows.

    Well covered pixels vote for the nearest colour; votes are spread over a quarter of a strand
    width, so that highlights, noise and edge mixtures are outvoted.

    Returns
    -------
    (h, w) int32 array
        0 outside strands, else 1 + the index of the colour.
    """
    distance = np.stack([((features - c) ** 2).sum(axis=2) for c in centres])
    nearest = distance.argmin(axis=0)
    weight = np.where(strand, coverage**4, 0).astype(np.float32)
    best = np.zeros(strand.shape, np.float32)
    labels = np.zeros(strand.shape, np.int32)
    for colour in range(len(centres)):
        votes = np.where(nearest == colour, weight, 0)
        votes = cv2.GaussianBlur(votes, (0, 0), max(0.25 * width, 0.6))
        better = (votes > best) & strand
        labels[better] = colour + 1
        best[better] = votes[better]
    return labels
