"""Thin lines in a picture: their points, which of them touch, and the paths along them."""

import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components, depth_first_order


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
