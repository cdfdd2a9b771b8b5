"""How forces and couples change with nodes and elements: the sparse matrix of Newton's method.

Stretch and shear have a closed form. Bending and twist, and contact, are central differences of the
march's own kernels, of many columns at once: those that share no row (Curtis, Powell & Reid, IMA J.
Appl. Math. 13, 117 (1974)). So contact may be whatever `contact_forces` makes of it.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import scipy.sparse as sparse
from numpy.typing import NDArray

from sim.kernels.contact import contact_forces
from sim.kernels.passing import near_pairs
from sim.statics.balance import Balance, skew, turned

Array = NDArray[np.float64]
Index = NDArray[np.int64]
Entries = tuple[NDArray[Any], NDArray[Any], NDArray[Any]]  # rows, columns, values

PROBE = 1e-5  # rad, of central differences; of a radius for contact
_PROBES = PROBE * np.concatenate([-np.eye(3), np.eye(3)])  # rotation vectors about each axis
CLOSE = 1.05  # of the contact distance: whatever is nearer may touch within a probe
BESIDE = np.arange(-1, 3)  # nodes that the contact of an element hangs on, seen from it
NODE, TURN = 0, 3  # where a node's and an element's unknowns begin among the six of an index


def stiffness(balance: Balance) -> sparse.csc_matrix:
    """Return the symmetric part of -d(net)/d(step) of what is free."""
    parts = [*_stretch(balance), *_bend(balance), *_contact(balance)]
    rows, columns, values = (np.concatenate(each) for each in zip(*parts, strict=True))
    place = np.cumsum(balance.free.ravel()) - 1
    free = balance.free.ravel()
    kept = free[rows] & free[columns]
    where = place[rows[kept]], place[columns[kept]]
    size = np.count_nonzero(free)
    found = sparse.csc_matrix((values[kept], where), shape=(size, size))
    return ((found + found.T) / 2).tocsc()


def _block(row: Index, at: int, column: Index, beside: int, values: Array) -> Entries:
    """Return (m, 3, 3) blocks, of unknowns `at` of indices `row` and `beside` of `column`."""
    rows = (6 * row + at)[:, None, None] + np.arange(3)[:, None]
    columns = (6 * column + beside)[:, None, None] + np.arange(3)
    whole = (np.broadcast_to(each, values.shape).ravel() for each in (rows, columns))
    return next(whole), next(whole), values.ravel()


def _both(row: Index, at: int, column: Index, beside: int, values: Array) -> list[Entries]:
    """Return blocks and their mirror images, which `stiffness` takes half of."""
    return [_block(row, at, column, beside, 2 * values)]


def _stretch(balance: Balance) -> list[Entries]:
    """Return the second derivative of l/2 (t - d3) S (t - d3), t' = t x a + Q dx/l."""
    i = np.flatnonzero(balance.real)
    q, t, s = balance.frames[i], balance.strain[i], balance.stiffness[i]
    length, unit = balance.length[i][:, None, None], np.eye(3)
    n, weigh, cross = s * (t - [0, 0, 1]), s[:, :, None] * unit, skew(t)
    back = q.transpose(0, 2, 1)
    drawn = back @ weigh @ q / length
    mixed = back @ (weigh @ cross - skew(n))
    turn = cross.transpose(0, 2, 1) @ weigh @ cross + n[:, :, None] * t[:, None, :]
    turn -= np.einsum("ni,ni->n", n, t)[:, None, None] * unit
    return [
        _block(i, NODE, i, NODE, drawn),
        _block(i + 1, NODE, i + 1, NODE, drawn),
        _block(i, TURN, i, TURN, length * turn),
        *_both(i, NODE, i + 1, NODE, -drawn),
        *_both(i, NODE, i, TURN, -mixed),
        *_both(i + 1, NODE, i, TURN, mixed),
    ]


def _bend(balance: Balance) -> list[Entries]:
    """Return how the couples of bending and twist change, element by element."""
    n = len(balance.real)
    change = np.zeros((3, n, 3, 3))  # of the element before, the same and the next one
    index, probes = np.arange(n), turned(np.eye(3)[None].repeat(6, 0), _PROBES)
    for colour in range(3):
        mine = index[index % 3 == colour]
        for axis in range(3):
            couples = []
            for probe in (probes[axis], probes[axis + 3]):
                frames = balance.frames.copy()
                frames[mine] = probe @ frames[mine]
                balance.put_frames(frames)
                couples.append(balance.bent())
            slope = (couples[0] - couples[1]) / (2 * PROBE)
            for k in range(3):
                change[k, mine, :, axis] = slope[(mine + k - 1) % n]
    balance.put_frames(balance.frames)
    i = np.flatnonzero(balance.real)
    return [_block((i + k - 1) % n, TURN, i, TURN, change[k, i]) for k in range(3)]


def _contact(balance: Balance) -> list[Entries]:
    """Return how contact forces change."""
    march, state = balance.march, balance.march.state
    pairs = close_pairs(balance)
    if len(pairs) == 0:
        return []
    near = _pattern(pairs, state.n)
    colour = coloured(near)
    row, column = near.nonzero()
    probe = PROBE * min(rod.radius for rod in march.scene.rods)
    nodes, found = state.rows("X0 X1 X2"), []
    for number in range(colour.max() + 1):
        own = colour[column] == number
        i, j = row[own], column[own]
        for axis in range(3):
            place, forces = state.row(f"X{axis}"), []
            for side in (-1, 1):
                place[:] = nodes[axis] + side * probe * (colour == number)
                forces.append(_pressed(balance))
            place[:] = nodes[axis]
            slope = (forces[0] - forces[1]) / (2 * probe)
            found += [(6 * i + k, 6 * j + axis, slope[k, i]) for k in range(3)]
    return found


def close_pairs(balance: Balance) -> Index:
    """Return the pairs of elements that touch or nearly do, (m, 2)."""
    march = balance.march
    if march.contact is None:
        return np.zeros((0, 2), np.int64)
    found = np.zeros((march.contact.pairs.shape[1], 2), np.int64)
    return found[: near_pairs(march.state.buf, march.state.n, march.contact, CLOSE, found)]


def _pressed(balance: Balance) -> Array:
    """Return the contact forces on nodes, (3, n)."""
    march, state = balance.march, balance.march.state
    for axis in range(3):
        state.row(f"F{axis}")[:] = 0.0
    contact_forces(state.buf, state.n, 0.0, march.contact, None)
    return state.rows("F0 F1 F2")


def _pattern(pairs: Index, n: int) -> sparse.csr_matrix:
    """Return which nodes feel which, (n, n)."""
    nodes = (pairs[:, :, None] + BESIDE).reshape(len(pairs), -1).clip(0, n - 1)
    which = np.repeat(np.arange(len(pairs)), nodes.shape[1])
    of_pair = sparse.csr_matrix((np.ones(nodes.size), (which, nodes.ravel())), (len(pairs), n))
    return (of_pair.T @ of_pair).tocsr()


def coloured(near: sparse.csr_matrix) -> Index:
    """Return a colour for every node, -1 for those alone; two of a colour have no common row."""
    common = (near @ near).tocsr()
    found = np.full(near.shape[0], -1)
    for node in np.flatnonzero(np.diff(common.indptr)):
        taken = found[common.indices[common.indptr[node] : common.indptr[node + 1]]]
        found[node] = np.setdiff1d(np.arange(len(taken) + 1), taken)[0]
    return found
