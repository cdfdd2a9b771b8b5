"""Corners in pieces of a colour: there one strand's middle runs into another's, past a crossing."""

import numpy as np

ARM = 1.5  # strand widths before and after a point between which the turn is measured
SHARPEST = np.radians(75)  # of one strand; over these arms a bend of little more than its width


def without_corners(path: np.ndarray, width: float) -> list[np.ndarray]:
    """Cut a path where it turns as no strand does, and leave out an arm on both sides.

    Where the middle of a crossing is taken for another colour, what is left are four arms that may
    meet in pairs.

    Parameters
    ----------
    path : (n, 2) array
        Points about 1 px apart.
    width : float
        Strand width [px].

    Returns
    -------
    list of (m, 2) arrays
        The path itself where it has no corner.
    """
    arm = max(3, round(ARM * width))
    if len(path) <= 2 * arm:
        return [path]
    before, after = path[arm:-arm] - path[: -2 * arm], path[2 * arm :] - path[arm:-arm]
    cross = before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0]
    turn = np.abs(np.arctan2(cross, (before * after).sum(axis=1)))
    sharp = np.flatnonzero(turn > SHARPEST) + arm
    if len(sharp) == 0:
        return [path]
    runs = np.split(sharp, np.flatnonzero(np.diff(sharp) > arm) + 1)
    first = [0, *(int(run[-1]) + arm for run in runs)]
    last = [*(int(run[0]) - arm for run in runs), len(path)]
    parts = [path[a:b] for a, b in zip(first, last, strict=True) if b - a > 0]
    return [part for part in parts if len(part) > arm]
