"""Several lines worked on together: an array of all their points takes hardly longer than one."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np


class Bundle(NamedTuple):
    """Lines of at least two points each, one after the other.

    Attributes
    ----------
    points : (n, 2) array
    sizes : (k,) int array
        Points of each line.
    """

    points: np.ndarray
    sizes: np.ndarray

    @property
    def first(self) -> np.ndarray:
        """Place (k,) of the first point of each line."""
        return np.cumsum(self.sizes) - self.sizes

    def parted(self, values: np.ndarray) -> list[np.ndarray]:
        """Cut what belongs to the points (n, ...) into what belongs to each line."""
        return np.split(values, self.first[1:])


def bundled(lines: Sequence[np.ndarray]) -> Bundle:
    """Put lines (n, 2) one after the other."""
    return Bundle(np.concatenate(lines), np.array([len(line) for line in lines]))


def resampled(lines: Bundle, step: float) -> Bundle:
    """Place points at equal distances (about `step`) along each line, as `centreline.resample`."""
    points, sizes = lines
    first, last = lines.first, np.cumsum(sizes) - 1
    ahead = np.hypot(*np.diff(points, axis=0).T)
    ahead[last[:-1]] = 1  # from each line to the next
    s = np.concatenate([[0.0], np.cumsum(ahead)])
    length = s[last] - s[first]
    many = np.maximum(np.rint(length / step).astype(int) + 1, 2)
    number = np.arange(many.sum()) - np.repeat(np.cumsum(many) - many, many)
    even = np.repeat(s[first], many) + number * np.repeat(length / (many - 1), many)
    even = np.minimum(even, np.repeat(s[last], many))
    along = [np.interp(even, s, points[:, i]) for i in (0, 1)]
    return Bundle(np.stack(along, axis=1), many)


def normals_of(lines: Bundle) -> np.ndarray:
    """Return unit normals (n, 2) of each line, as `centreline.normals`."""
    points, sizes = lines
    along = np.empty_like(points)
    along[1:-1] = points[2:] - points[:-2]
    first, last = lines.first, np.cumsum(sizes) - 1
    along[first] = points[first + 1] - points[first]
    along[last] = points[last] - points[last - 1]
    along /= np.maximum(np.hypot(*along.T), 1e-9)[:, None]
    return np.stack([-along[:, 1], along[:, 0]], axis=1)
