"""The two intervals: a prediction of one more member, and what is left of the mesh."""

import numpy as np
from scipy.special import stdtrit

LEVEL = 0.95
ORDER = 2.0  # of the error over the length of an element; measured: docs/accuracy.md
SAFETY = 1.25  # of the error of the mesh, for a band that holds it in 95 of 100 cases


def prediction(members: np.ndarray, *, level: float = LEVEL) -> tuple[np.ndarray, np.ndarray]:
    """Return mean and half-width of the interval that holds one more member.

    Student's t with n - 1 degrees of freedom, times sd sqrt(1 + 1/n): exact for normal draws.

    Parameters
    ----------
    members : ndarray
        One row a member, (n, ...), n >= 2.
    level : float
        Share of further members that it holds.

    Returns
    -------
    (ndarray, ndarray)
        Mean and half-width, shaped as a member.
    """
    n = len(members)
    widen = float(stdtrit(n - 1, (1 + level) / 2)) * np.sqrt(1 + 1 / n)
    return members.mean(axis=0), widen * members.std(axis=0, ddof=1)


def mesh_error(
    value: np.ndarray | float, coarse: np.ndarray | float, ratio: float, order: float = ORDER
) -> np.ndarray:
    """Return the half-width that holds the value of an infinitely fine mesh.

    The grid convergence index, SAFETY |value - coarse|/(ratio^order - 1): Richardson's estimate of
    the error, which goes as the order-th power of the element's length, with a margin (Roache,
    J. Fluids Eng. 116, 405 (1994)).

    Parameters
    ----------
    value, coarse : ndarray or float
        Of a mesh, and of one with elements `ratio` times as long.
    ratio, order : float
    """
    return SAFETY * np.abs(np.asarray(value) - np.asarray(coarse)) / (ratio**order - 1)


def around(error: np.ndarray, width: int) -> np.ndarray:
    """Return the largest error within `width` entries of each: two curves that cross still differ.

    Parameters
    ----------
    error : (n,)
    width : int
        Entries on either side.
    """
    from scipy.ndimage import maximum_filter1d

    return maximum_filter1d(error, 2 * width + 1, mode="nearest")
