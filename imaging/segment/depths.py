"""Depths in masks that cover little of a picture: only what they cover is visited."""

import numba
import numpy as np

SIDE, SLANT, KNIGHT = (np.float32(step) for step in (1.0, 1.4, 2.1969))  # Borgefors 1986, 5 x 5
BEFORE = ((0, 1), (1, -2), (1, -1), (1, 0), (1, 1), (1, 2), (2, -1), (2, 1))  # rows, columns
FAR = np.float32(1e6)  # px
FIRST = np.float32(1e3)  # px; how close a ridge is to itself, so that all covered has more than 0
FLAT = np.float32(0.3)  # px by which what lies around a summit may be deeper


def places_of(mask: np.ndarray) -> np.ndarray:
    """Places (n,) in the flattened picture that a mask (h, w) covers."""
    flat = np.ascontiguousarray(mask).reshape(-1).view(np.uint8)
    at = np.empty(np.count_nonzero(flat), np.int64)
    whole = len(flat) // 8 * 8
    _covered(flat, flat[:whole].view(np.uint64), at)
    return at


def depth_of(mask: np.ndarray) -> np.ndarray:
    """Return the distance to the outside of a mask [px], 0 outside: (h, w) float32."""
    depth = np.zeros(mask.shape, np.float32)
    _deepened(places_of(mask), depth)
    return depth


def summit(depth: np.ndarray, least: float = 0.0) -> np.ndarray:
    """Medial axis deeper than `least`: places in the flattened picture of the deepest around."""
    at = places_of(depth > least)
    return at[_is_summit(at, depth)]


def nearest_level(
    at: np.ndarray, ridge: np.ndarray, level: np.ndarray, shape: tuple[int, int]
) -> np.ndarray:
    """Level of the ridge that is nearest to each place, on a way within what is covered.

    Parameters
    ----------
    at : (n,) array
        Places in the flattened picture that are covered, in order.
    ridge, level : (m,) arrays
        Places among them, at least one in every piece, and their levels.
    shape : (h, w)

    Returns
    -------
    (n,) float32 array
    """
    close, spread = np.zeros((2, *shape), np.float32)
    close.ravel()[ridge], spread.ravel()[ridge] = FIRST, level
    while _carried(at, close, spread, 1) | _carried(at[::-1], close, spread, -1):
        pass
    return spread.ravel()[at]


@numba.njit(cache=True)
def _covered(flat, words, at):
    """Fill in where a mask is not zero, eight pixels at a time."""
    n = 0
    for k in range(len(words)):
        if words[k] != 0:
            for i in range(8 * k, 8 * k + 8):
                if flat[i] != 0:
                    at[n] = i
                    n += 1
    for i in range(8 * len(words), len(flat)):
        if flat[i] != 0:
            at[n] = i
            n += 1


@numba.njit(cache=True)
def _from(depth, i, row, way):
    """Depth that the neighbours before a pixel allow, those behind it where ``way`` is -1."""
    up, back = i - way * row, i - way
    side = min(depth[back], depth[up]) + SIDE
    slant = min(depth[up - 1], depth[up + 1]) + SLANT
    knight = min(depth[up - way * row - 1], depth[up - way * row + 1])
    knight = min(knight, min(depth[up - 2], depth[up + 2])) + KNIGHT
    return min(side, min(slant, knight))


@numba.njit(cache=True)
def _near_rim(depth, y, x, way):
    """Do the same near the picture's rim, beyond which nothing is known."""
    height, across = depth.shape
    least = FAR
    for v, u in BEFORE:
        far = SIDE if v * u == 0 else (SLANT if abs(v * u) == 1 else KNIGHT)
        if 0 <= y - way * v < height and 0 <= x - way * u < across:
            least = min(least, depth[y - way * v, x - way * u] + far)
    return least


@numba.njit(cache=True)
def _deepened(at, depth):
    """Fill in the depths of the places covered, which are in order."""
    height, across = depth.shape
    flat = depth.ravel()
    for way in (1, -1):
        for i in at[::way]:
            y = i // across
            x = i - y * across
            if 2 <= y < height - 2 and 2 <= x < across - 2:
                found = _from(flat, i, across, way)
            else:
                found = _near_rim(depth, y, x, way)
            flat[i] = found if way == 1 else min(flat[i], found)


@numba.njit(cache=True)
def _is_summit(at, depth):
    """Tell (n,) whether no pixel around a place is deeper by more than FLAT."""
    height, across = depth.shape
    found = np.empty(len(at), np.bool_)
    for k in range(len(at)):
        y = at[k] // across
        x = at[k] - y * across
        top = np.float32(0)
        for v in range(max(y - 1, 0), min(y + 2, height)):
            for u in range(max(x - 1, 0), min(x + 2, across)):
                top = max(top, depth[v, u])
        found[k] = depth[y, x] >= top - FLAT
    return found


@numba.njit(cache=True)
def _carried(at, close, spread, way):
    """Carry levels on to pixels that are now closer to their ridge; tell whether any is."""
    height, across = close.shape
    changed = False
    for i in at:
        y = i // across
        x = i - y * across
        for v, u in BEFORE:
            down, right = y - way * v, x - way * u
            if 0 <= down < height and 0 <= right < across:
                far = SIDE if v * u == 0 else (SLANT if abs(v * u) == 1 else KNIGHT)
                if close[down, right] - far > close[y, x]:
                    close[y, x], spread[y, x] = close[down, right] - far, spread[down, right]
                    changed = True
    return changed
