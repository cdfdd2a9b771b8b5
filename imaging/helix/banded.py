"""Solve for unknowns that are coupled only to near ones along the axis, and to a few of all.

Sorted by their place along the axis, splines that overlap make a band; the few that belong to the
whole axis are its border. Solving, and those parts of the inverse that lie in the band, then cost
time that grows with the axis' length, not with its cube.
"""

from dataclasses import dataclass, replace

import numba
import numpy as np
from scipy.linalg import cho_solve_banded, cholesky, cholesky_banded
from scipy.linalg.lapack import dpotri

Array = np.ndarray


@dataclass(frozen=True)
class Rows:
    """A design of few entries a row.

    Attributes
    ----------
    columns, values : (n, m) arrays
        Where in the sorted unknowns the entries stand, and what they are.
    """

    columns: np.ndarray
    values: Array

    def times(self, x: Array) -> Array:
        """Design times the sorted unknowns."""
        return np.einsum("ij,ij->i", self.values, x[self.columns])

    def transposed(self, y: Array, size: int) -> Array:
        """Transposed design times a value for each row."""
        return np.bincount(self.columns.ravel(), (self.values * y[:, None]).ravel(), size)

    def spread(self, covariance: "Bordered") -> Array:
        """Variance of each row's sum; a row's unknowns must lie within the band."""
        every = covariance.near(self.columns[:, :, None], self.columns[:, None, :])
        return np.einsum("ia,ib,iab->i", self.values, self.values, every)


@dataclass(frozen=True)
class Bordered:
    """A symmetric matrix whose band and border are kept.

    Attributes
    ----------
    band : (n, w + 1) array
        ``band[j, d]`` is the entry (j + d, j).
    border : (n, p) array
    corner : (p, p) array
    """

    band: Array
    border: Array
    corner: Array

    @classmethod
    def zero(cls, n: int, shared: int, width: int) -> "Bordered":
        """Nothing yet, of ``n`` unknowns in a band of this ``width`` and ``shared`` ones."""
        return cls(np.zeros((n, width + 1)), np.zeros((n, shared)), np.zeros((shared, shared)))

    @property
    def diagonal(self) -> Array:
        """Diagonal (n + p,)."""
        return np.concatenate([self.band[:, 0], np.diag(self.corner)])

    def near(self, i: np.ndarray, j: np.ndarray) -> Array:
        """Entries (i, j) of the band."""
        return self.band[np.minimum(i, j), np.abs(i - j)]

    def plus(self, rows: Rows, precision: Array) -> "Bordered":
        """Add Design' diag(precision) Design, which must lie within the band and border."""
        parts = self.band.copy(), self.border.copy(), self.corner.copy()
        _gather(rows.columns, rows.values, precision, *parts)
        return Bordered(*parts)

    def on_diagonal(self, values: Array) -> "Bordered":
        """Add to the diagonal."""
        n = len(self.band)
        band, corner = self.band.copy(), self.corner + np.diag(values[n:])
        band[:, 0] += values[:n]
        return replace(self, band=band, corner=corner)

    def row_products(self, other: "Bordered") -> Array:
        """Diagonal (n + p,) of this matrix times another, which is zero beyond its band."""
        n, each = len(self.band), self.band * other.band
        inner = each.sum(axis=1) + (self.border * other.border).sum(axis=1)
        for d in range(1, min(each.shape[1], n)):
            inner[d:] += each[: n - d, d]
        crossing = (self.border * other.border).sum(axis=0)
        return np.concatenate([inner, crossing + (self.corner * other.corner).sum(axis=0)])

    def dense(self) -> Array:
        """Return the matrix (n + p, n + p) with zeros outside the band and border."""
        n, wide = self.band.shape
        whole = np.zeros((n + len(self.corner),) * 2)
        for d in range(min(wide, n)):
            np.fill_diagonal(whole[d:n, : n - d], self.band[: n - d, d])
            np.fill_diagonal(whole[: n - d, d:n], self.band[: n - d, d])
        whole[:n, n:], whole[n:, :n], whole[n:, n:] = self.border, self.border.T, self.corner
        return whole


def solve(matrix: Bordered, right: Array) -> tuple[Array, Bordered]:
    """Solve ``matrix @ x = right`` and invert the matrix within its band and border.

    Strategy: Cholesky of the band, the border by its Schur complement, and back from the last
    unknown (selected inversion; Takahashi, Fagan & Chen 1973).

    Parameters
    ----------
    matrix : Bordered
        Positive definite.
    right : (n + p,) array

    Returns
    -------
    x : (n + p,) array
    inverse : Bordered
    """
    n = len(matrix.band)
    factor = cholesky_banded(matrix.band.T, lower=True, check_finite=False)
    bordered = np.column_stack([matrix.border, right[:n]])
    solved = cho_solve_banded((factor, True), bordered, check_finite=False)
    border, plain = np.ascontiguousarray(solved[:, :-1]), solved[:, -1]
    corner = inverse(matrix.corner - matrix.border.T @ border)
    last = corner @ (right[n:] - matrix.border.T @ plain)
    reach = border @ corner
    band = np.zeros_like(matrix.band)
    _select(np.ascontiguousarray(factor.T), border, reach, band)
    return np.concatenate([plain - border @ last, last]), Bordered(band, -reach, corner)


def log_determinant(matrix: Bordered) -> float:
    """Logarithm of the determinant of a positive definite matrix."""
    factor = cholesky_banded(matrix.band.T, lower=True, check_finite=False)
    solved = cho_solve_banded((factor, True), matrix.border, check_finite=False)
    corner = cholesky(matrix.corner - matrix.border.T @ solved, lower=True)
    return 2 * float(np.log(factor[0]).sum() + np.log(np.diag(corner)).sum())


def inverse(matrix: Array) -> Array:
    """Inverse of a symmetric positive definite matrix."""
    lower = np.tril(dpotri(cholesky(matrix, lower=True, check_finite=False), lower=1)[0])
    return lower + np.tril(lower, -1).T


@numba.njit(cache=True)
def _gather(columns, values, precision, band, border, corner):
    """Sum precision * row' row over the rows into the parts of a `Bordered`."""
    n = len(band)
    for k in range(len(columns)):
        if precision[k] == 0.0:
            continue
        for a in range(columns.shape[1]):
            i, x = columns[k, a], precision[k] * values[k, a]
            for b in range(columns.shape[1]):
                j = columns[k, b]
                if i >= n and j >= n:
                    corner[i - n, j - n] += x * values[k, b]
                elif i >= n:
                    border[j, i - n] += x * values[k, b]
                elif i >= j:
                    band[j, i - j] += x * values[k, b]


@numba.njit(cache=True, fastmath={"reassoc", "contract"})
def _select(factor, border, reach, band):
    """Fill a band with the inverse's, from the Cholesky factor and the border's share."""
    n, wide = factor.shape
    # Row i holds entries (i, i - wide + 1 .. i + wide - 1): what is summed lies side by side.
    both = np.zeros((n, 2 * wide - 1))
    for j in range(n - 1, -1, -1):
        most = min(wide, n - j)
        for d in range(most - 1, -1, -1):
            total = 0.0
            for k in range(1, most):
                total += factor[j, k] * both[j + d, wide - 1 - d + k]
            entry = ((1.0 / factor[j, 0] if d == 0 else 0.0) - total) / factor[j, 0]
            both[j, wide - 1 + d] = both[j + d, wide - 1 - d] = band[j, d] = entry
    for j in range(n):
        for d in range(min(wide, n - j)):
            for p in range(border.shape[1]):
                band[j, d] += reach[j + d, p] * border[j, p]
