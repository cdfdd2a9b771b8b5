"""The list of pairs that may touch, made anew from where the rods are now."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from sim.kernels import neighbours as kernels
from sim.kernels.contact import Contact
from sim.kernels.runs import fill_runs
from sim.march.marching import Marching
from sim.march.state import State


def rebuild(march: Marching) -> None:
    """List the pairs that may touch, and hand their slip on; nothing without contact."""
    old = march.contact
    if old is None:
        return
    pairs = _pairs(march.state, old)
    slip = old.slip if march.friction is None else _slip(march.state, old, pairs)
    runs = np.zeros((4, pairs.shape[1] + 1), np.int64)  # room for as many as may be in play
    listed = runs[:, : fill_runs(pairs, runs) + 1].copy()
    contact = old._replace(pairs=pairs, listed=listed, runs=runs, slip=slip)
    march.effects = march.effects._replace(contact=contact)


def _pairs(state: State, contact: Contact) -> NDArray[np.int64]:
    """Return the pairs that may touch, (2, m), in the order that makes the longest runs."""
    heads = np.zeros(1 << int(np.ceil(np.log2(2 * state.n))), np.int64)
    following = np.zeros(state.n, np.int64)
    count, pairs = 8 * state.n, np.zeros((2, 0), np.int64)
    while count > pairs.shape[1]:
        pairs = np.zeros((2, count), np.int64)
        count = kernels.build_list(state.buf, state.n, contact, heads, following, pairs)
    a, b = pairs[:, :count]
    order = np.lexsort((a, b - a, contact.rod[b], contact.rod[a]))
    return np.take(pairs[:, :count], order, axis=1)


def _slip(state: State, old: Contact, pairs: NDArray[np.int64]) -> NDArray[np.float64]:
    """Return the elastic slip of the pairs: what it was where they were listed before."""
    before, now = (state.n * each[0] + each[1] for each in (old.pairs, pairs))
    _, then, here = np.intersect1d(before, now, assume_unique=True, return_indices=True)
    slip = np.zeros((3, pairs.shape[1]))
    slip[:, here] = old.slip[:, then]
    return slip
