"""Cubic splines with equally spaced knots: curves, and their designs as sparse matrices."""

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
    first, values = weights(knot, s, derivative)
    return np.einsum("ij,ij->i", values, coefficients[first[:, None] + np.arange(4)])


def weights(knot: Array, s: Array, derivative: int = 0) -> tuple[np.ndarray, Array]:
    """First of the four splines that are not zero, and their values (n, 4)."""
    h = knot[1] - knot[0]
    place = (np.clip(s, knot[3], knot[-4]) - knot[3]) / h
    first = np.clip(place.astype(int), 0, len(knot) - 8)
    u = place - first
    v = 1 - u
    if derivative:
        parts = [-v * v, (3 * u - 4) * u, v * (1 + 3 * u), u * u]
        return first, np.stack(parts, axis=1) / (2 * h)
    parts = [v**3, 4 + u * u * (3 * u - 6), 4 + v * v * (3 * v - 6), u**3]
    return first, np.stack(parts, axis=1) / 6
