"""Cubic splines with equally spaced knots: curves, and their designs as sparse matrices."""

import numba
import numpy as np
from scipy.sparse import csr_array

Array = np.ndarray


def knots(start: float, end: float, spacing: float) -> Array:
    """Knots of a uniform cubic spline over [start, end], with three more on either side."""
    count = max(int(np.ceil((end - start) / spacing)), 2)
    h = (end - start) / count
    return start + h * np.arange(-3, count + 4)


def basis(knot: Array, s: Array, derivative: int = 0) -> csr_array:
    """Cubic B-spline design (n, len(knot) - 4) or its first derivative.

    Where all knots are apart by the same, the four splines that are not zero are polynomials of
    the place between two knots (ten times as fast as the recurrence for any knots).
    """
    first, values = weights(knot, s, derivative)
    columns = first[:, None] + np.arange(4)
    rows = 4 * np.arange(len(first) + 1)
    shape = (len(first), len(knot) - 4)
    return csr_array((values.ravel(), columns.ravel(), rows), shape=shape)


def curve(knot: Array, coefficients: Array, s: Array, derivative: int = 0) -> Array:
    """Value or first derivative of a spline at arclengths ``s``."""
    value = np.empty(len(s))
    _along(knot, coefficients, np.asarray(s, float), derivative, value)
    return value


def weights(knot: Array, s: Array, derivative: int = 0) -> tuple[np.ndarray, Array]:
    """First of the four splines that are not zero, and their values (n, 4)."""
    first, values = np.empty(len(s), np.int64), np.empty((len(s), 4))
    _each(knot, np.asarray(s, float), derivative, first, values)
    return first, values


@numba.njit(cache=True)
def _four(knot, s, derivative):
    """First spline that is not zero at ``s``, and the values of it and the next three."""
    h = knot[1] - knot[0]
    place = (min(max(s, knot[3]), knot[-4]) - knot[3]) / h
    first = min(max(int(place), 0), len(knot) - 8)
    u = place - first
    v = 1 - u
    if derivative:
        w = 1 / (2 * h)
        return first, -v * v * w, (3 * u - 4) * u * w, v * (1 + 3 * u) * w, u * u * w
    one, two = (4 + u * u * (3 * u - 6)) / 6, (4 + v * v * (3 * v - 6)) / 6
    return first, v**3 / 6, one, two, u**3 / 6


@numba.njit(cache=True)
def _each(knot, s, derivative, first, values):
    """Fill in the splines that are not zero at every place."""
    for k in range(len(s)):
        first[k], values[k, 0], values[k, 1], values[k, 2], values[k, 3] = _four(
            knot, s[k], derivative
        )


@numba.njit(cache=True)
def _along(knot, c, s, derivative, value):
    """Fill in the spline of these coefficients at every place."""
    for k in range(len(s)):
        i, w, x, y, z = _four(knot, s[k], derivative)
        value[k] = w * c[i] + x * c[i + 1] + y * c[i + 2] + z * c[i + 3]
