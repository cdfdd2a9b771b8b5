"""Solve for unknowns that are coupled only to their neighbours along the axis, and to a few of all.

Splines overlap over four knots; unknowns sorted into cells of that length are coupled to those of
the same and of the next cell. Then only those parts of the inverse are computed that a sum over
neighbours needs, at a cost that grows with the axis' length, not with its cube.
"""

from itertools import pairwise

import numpy as np
from scipy.linalg import cholesky
from scipy.linalg.lapack import dpotri

Array = np.ndarray
Cells = list[np.ndarray]


def cells_of(place: Array, reach: float) -> Cells:
    """Sort unknowns into cells of length ``reach`` by their ``place``: indices of each cell."""
    number = ((place - place.min()) / reach).astype(int)
    return [np.flatnonzero(number == k) for k in np.unique(number)]


def solve(matrix: Array, right: Array, cells: Cells, shared: slice) -> tuple[Array, Array]:
    """Solve ``matrix @ x = right`` and invert the matrix where cells are neighbours.

    Strategy: eliminate cell after cell (block tridiagonal), treat the unknowns that all cells share
    as a border, and go back from the last cell (selected inversion; Takahashi, Fagan & Chen 1973).

    Parameters
    ----------
    matrix : (p, p) array
        Symmetric, positive definite; zero between cells that are not neighbours.
    right : (p,) array
    cells : list of int arrays
        Indices of the unknowns in each cell, as ``cells_of`` gives them.
    shared : slice
        Unknowns coupled to all cells.

    Returns
    -------
    x : (p,) array
    inverse : (p, p) array
        Zero between cells that are not neighbours, whatever the true inverse is there.
    """
    bordered = np.column_stack([matrix[:, shared], right])
    solved, near = _chain(matrix, bordered, cells)
    border, plain = solved[:, :-1], solved[:, -1]
    rest = bordered[shared] - matrix[shared] @ solved
    corner = inverse(rest[:, :-1])
    x = plain - border @ (corner @ rest[:, -1])
    x[shared] = corner @ rest[:, -1]
    _add_border(near, border, corner, cells)
    near[:, shared] = -border @ corner
    near[shared] = near[:, shared].T
    near[shared, shared] = corner
    return x, near


def inverse(matrix: Array) -> Array:
    """Inverse of a symmetric positive definite matrix."""
    lower = np.tril(dpotri(cholesky(matrix, lower=True, check_finite=False), lower=1)[0])
    return lower + np.tril(lower, -1).T


def _chain(matrix: Array, right: Array, cells: Cells) -> tuple[Array, Array]:
    """Solution for several right sides, and the inverse near the diagonal, without the border."""
    inverses, gains, reduced = [], [], [right[cells[0]]]
    block = matrix[np.ix_(cells[0], cells[0])]
    for here, there in pairwise(cells):
        coupling = matrix[np.ix_(here, there)]
        inverses.append(inverse(block))
        gains.append(inverses[-1] @ coupling)
        reduced.append(right[there] - gains[-1].T @ reduced[-1])
        block = matrix[np.ix_(there, there)] - coupling.T @ gains[-1]
    x, near = np.zeros_like(right), np.zeros_like(matrix)
    last, after = cells[-1], inverse(block)
    x[last], near[np.ix_(last, last)] = after @ reduced[-1], after
    for k in reversed(range(len(cells) - 1)):
        here, there, own, gain = cells[k], cells[k + 1], inverses[k], gains[k]
        x[here] = own @ reduced[k] - gain @ x[there]
        beside = -gain @ after
        near[np.ix_(here, there)], near[np.ix_(there, here)] = beside, beside.T
        after = own - beside @ gain.T
        near[np.ix_(here, here)] = after
    return x, near


def _add_border(near: Array, border: Array, corner: Array, cells: Cells) -> None:
    """Add what the shared unknowns take from certainty, to neighbouring cells."""
    uncertain = border @ corner
    for k, here in enumerate(cells):
        around = np.concatenate(cells[max(k - 1, 0) : k + 2])
        near[np.ix_(here, around)] += uncertain[here] @ border[around].T
