"""Thin lines in a picture: their points, which of them touch, and the paths along them."""

from collections.abc import Iterator

import cv2
import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components, depth_first_order
from skimage.morphology import skeletonize


def thinned(mask: np.ndarray) -> np.ndarray:
    """Skeleton (h, w) of a mask: each piece in a box of its own, as most of a picture is empty."""
    thin = np.zeros(mask.shape, bool)
    for box, own in blobs(mask):
        thin[box] |= skeletonize(own)
    return thin


def blobs(
    mask: np.ndarray, least: float = 0.0, rim: int = 0
) -> Iterator[tuple[tuple[slice, slice], np.ndarray]]:
    """Yield the pieces of a mask that hang together: a box around each, and where it is in that.

    Boxes are wider than the piece by `rim` px on each side, but at the picture's border. Pieces of
    up to `least` px, from corner to corner of what holds them, are left out.
    """
    seen = mask.view(np.uint8)
    outlines, nested = cv2.findContours(seen, cv2.RETR_CCOMP, cv2.CHAIN_APPROX_SIMPLE)
    for outline, (_, _, _, within) in zip(
        outlines, () if nested is None else nested[0], strict=True
    ):
        x, y, w, h = cv2.boundingRect(outline)
        if within < 0 and np.hypot(w, h) > least:  # no hole
            box = np.s_[max(y - rim, 0) : y + h + rim, max(x - rim, 0) : x + w + rim]
            number = cv2.connectedComponents(seen[box])[1]
            column, row = outline[0, 0]
            yield box, number == number[row - box[0].start, column - box[1].start]


def linked(skeleton: np.ndarray) -> tuple[np.ndarray, csr_array]:
    """Points x, y (n, 2) of a skeleton with an empty rim, and which of them touch (n, n)."""
    at = np.flatnonzero(skeleton)
    pairs = []
    for step in (1, skeleton.shape[1] - 1, skeleton.shape[1], skeleton.shape[1] + 1):
        beside = np.searchsorted(at, at + step).clip(max=len(at) - 1)
        near = np.flatnonzero(at[beside] == at + step)
        pairs.append([near, beside[near]])
    i, j = np.concatenate(pairs, axis=1)
    ones = np.ones(2 * len(i), np.int8)
    ends = np.concatenate([i, j]), np.concatenate([j, i])
    points = np.stack(np.divmod(at, skeleton.shape[1])[::-1], axis=1)
    return points, csr_array((ones, ends), shape=(len(at), len(at)))


def degrees(touching: csr_array) -> np.ndarray:
    """How many others each point touches (n,)."""
    return np.diff(touching.indptr)


def in_order(touching: csr_array) -> list[np.ndarray]:
    """Points of each simple path, from one end to the other; a ring starts anywhere.

    One walk takes them all, from a point more that leads to the first of each.
    """
    count = touching.shape[0]
    number = connected_components(touching, directed=False)[1]
    ends_first = np.argsort(degrees(touching), kind="stable")
    first = ends_first[np.unique(number[ends_first], return_index=True)[1]]
    i, j = touching.nonzero()
    leads = np.append(i, np.full(len(first), count)), np.append(j, first)
    graph = csr_array((np.ones(len(leads[0]), np.int8), leads), shape=(count + 1, count + 1))
    walk = depth_first_order(graph, count, return_predecessors=False)[1:]
    return np.split(walk, np.flatnonzero(np.diff(number[walk])) + 1)
