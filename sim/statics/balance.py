"""Rods that hang from clamps as a balance of couples: what is out of it, and how that changes.

A rod that is clamped at its root and otherwise free bears, across each element, all the load beyond
it: N_i = sum of F_j over the nodes j > i. With N known its shape follows from the frames alone,

    x_{i+1} = x_i + l Q_i^T t_i,     t_i = d3 + S^-1 Q_i N_i,

and what is left to be in balance are the couples on the elements,

    c_i = (bending and twist of both vertices) + l t_i x Q_i N_i + (loads).

Axial stiffness, a million times that of bending, appears nowhere. The derivative of c by rotations
of the elements is block tridiagonal for a rod on its own, A. Every pair that touches adds a few
directions u with a stiffness k each, and (A + U k U^T)^-1 follows from A^-1 (Woodbury); the signs
of 1/k + U^T A^-1 U tell whether the state is stable (Haynsworth).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from sim.kernels.contact import contact_forces
from sim.kernels.ends import pull
from sim.kernels.march import weigh
from sim.kernels.passing import haste
from sim.kernels.rod import bend_and_twist, clear_loads
from sim.kernels.stiffness import pair_stiffness, touching_pairs
from sim.marching import Marching
from sim.neighbours import rebuild
from sim.rest import scale

Array = NDArray[np.float64]

TURN = 0.5  # rad, most that an element turns in a step
NEAR, SLIDE = 0.6, 4.0  # of the contact distance: how near and how far strands move in a step
ROAM = 0.45  # of the skin, most that a node moves in a step: half may bring what is not listed
PROBE = 1e-5  # rad, of central differences; of a radius for contacts
SLIGHT = 1e-8  # of the stiffest contact: what is less is rounding
ROOM = 3e7  # numbers: most that the levers of all contacts may be
FOREVER = 1e30  # s: loads have grown


class Balance:
    """The balance of couples of a march's rods, and how it changes as they turn.

    Attributes
    ----------
    frames : (n, 3, 3)
        Directors of every element.
    strain : (n, 3)
        t, the tangent in the frame of its element, stretched and sheared.
    normal : (n, 3)
        N [N].
    couple : (n, 3)
        c [N m], in the frames of the elements.
    stiff, lever : (m,), (m, n, 3)
        k [N/m] and u [m] of all contacts, see `contacts`.
    """

    def __init__(self, march: Marching) -> None:
        self.march, state = march, march.state
        self.real = state.row("LENGTH") > 0
        self.length = state.row("LENGTH").copy()
        self.rod = state.rod_of_element()
        first = np.array(state.first)
        self._first = first[np.maximum(self.rod, 0)]
        self._past = self._first + np.array(state.elements)[np.maximum(self.rod, 0)] + 1
        self.stiffness = np.where(self.real, state.rows("SHEAR SHEAR STRETCH"), 1.0).T
        self._root = state.rows("X0 X1 X2").T[self._first]
        self.frames = self._now()
        edges = np.roll(state.rows("X0 X1 X2"), -1, axis=1).T - state.rows("X0 X1 X2").T
        self.strain = to_frame(self.frames, edges * state.row("INV_LENGTH")[:, None])
        self._thinnest = min(rod.radius for rod in march.scene.rods)
        self.stiff, self.lever = np.zeros(0), np.zeros((0, state.n, 3))
        self.evaluate(self.frames)

    def _now(self) -> Array:
        names = "Q00 Q01 Q02 Q10 Q11 Q12 Q20 Q21 Q22"
        return self.march.state.rows(names).T.reshape(-1, 3, 3).copy()

    def put(self, frames: Array) -> None:
        """Write frames into the march's state."""
        for axis in range(3):
            for k in range(3):
                self.march.state.row(f"Q{axis}{k}")[:] = frames[:, axis, k]

    def beyond(self, force: Array) -> Array:
        """Return the sum of nodal values over all nodes beyond each element, (..., n, 3)."""
        whole = np.zeros((*force.shape[:-2], len(self.real) + 1, 3))
        whole[..., :-1, :] = np.cumsum(force[..., ::-1, :], axis=-2)[..., ::-1, :]
        found = whole[..., 1:, :] - whole[..., self._past, :]
        return np.where(self.real[:, None], found, 0.0)

    def along(self, edges: Array) -> Array:
        """Return the sum of edges from the root to each node, (n, 3)."""
        edges = np.where(self.real[:, None], edges, 0.0)
        total = np.cumsum(edges, axis=0) - edges
        found = total - total[self._first]
        tips = np.unique(self._past[self.real]) - 1
        found[tips] = total[tips] - total[self._first[tips - 1]]
        return found

    def evaluate(self, frames: Array) -> None:
        """Lay the rods out with these frames and find N and c."""
        march, state = self.march, self.march.state
        self.frames = frames
        self.put(frames)
        nodes = self.along(self.length[:, None] * to_lab(frames, self.strain))
        inside = np.flatnonzero(state.row("MASS") > 0)
        root = self._root[np.where(self.rod[inside] < 0, inside - 1, inside)]
        for axis in range(3):
            state.row(f"X{axis}")[inside] = (nodes[inside] + root)[:, axis]
        clear_loads(state.buf, state.n)
        if march.effects.gravity is not None:
            weigh(state.buf, state.n, march.effects.gravity)
        if march.effects.pulled is not None:
            pull(state.buf, march.effects.pulled, FOREVER, 0.0)
        if march.contact is not None:
            contact_forces(state.buf, state.n, 0.0, march.contact, None)
        self.normal = self.beyond(state.rows("F0 F1 F2").T)
        for axis in range(3):
            state.row(f"N{axis}")[:] = self.normal[:, axis]
        self.couple = self.couples(frames)

    def couples(self, frames: Array) -> Array:
        """Return c for other frames, the forces and the strain as they are."""
        state = self.march.state
        self.put(frames)
        bend_and_twist(state.buf, state.n, None)
        right = np.roll(state.rows("L0 L1 L2"), -1, axis=1)
        given = (state.rows("C0 C1 C2") + state.rows("R0 R1 R2") + right).T
        arm = self.length[:, None] * self.strain
        total = given + np.cross(arm, to_frame(frames, self.normal))
        return np.where(self.real[:, None], total, 0.0)

    def restrain(self) -> None:
        """Take the strain that N makes, as it is now."""
        self.strain = to_frame(self.frames, self.normal) / self.stiffness + [0.0, 0.0, 1.0]
        self.evaluate(self.frames)

    def turning(self) -> Array:
        """Return the couple on every element over its length, over `rest.scale`, (n,)."""
        found = np.linalg.norm(self.couple, axis=1) * self.march.state.row("INV_LENGTH")
        return np.where(self.real, found, 0.0) / scale(self.march)

    def pulling(self) -> Array:
        """Return by how much the strain makes another force than N, over `rest.scale`, (n,)."""
        made = to_lab(self.frames, (self.strain - [0, 0, 1]) * self.stiffness)
        found = np.linalg.norm(made - self.normal, axis=1)
        return np.where(self.real, found, 0.0) / scale(self.march)

    def tridiagonal(self) -> Array:
        """Return -dc/d(rotations) with the forces fixed, symmetric, banded as LAPACK takes it."""
        n = len(self.real)
        diagonal, upper, lower = np.zeros((3, n, 3, 3))
        for colour in range(3):
            mine = np.arange(n) % 3 == colour
            for axis in range(3):
                turn = np.zeros((n, 3))
                turn[mine, axis] = PROBE
                change = self.couples(turned(self.frames, -turn)) - self.couples(
                    turned(self.frames, turn)
                )
                change /= 2 * PROBE
                diagonal[mine, :, axis] = change[mine]
                upper[np.roll(mine, -1), :, axis] = change[np.roll(mine, -1)]
                lower[np.roll(mine, 1), :, axis] = change[np.roll(mine, 1)]
        self.put(self.frames)
        beside = self.real[:-1] & self.real[1:]
        upper[:-1] = (upper[:-1] + lower[1:].transpose(0, 2, 1)) / 2 * beside[:, None, None]
        diagonal = (diagonal + diagonal.transpose(0, 2, 1)) / 2
        size = np.abs(diagonal[self.real]).max()
        diagonal[~self.real] = size * np.eye(3)
        return _banded(diagonal, upper)

    def contacts(self) -> bool:
        """List the pairs that may touch anew and find how stiff those are that do, and along what.

        Returns whether they are few enough.
        """
        march, state = self.march, self.march.state
        if march.contact is None:
            return True
        rebuild(march)
        contact_forces(state.buf, state.n, 0.0, march.contact, None)
        assert march.contact is not None  # noqa: S101 (rebuilt above)
        pairs = np.zeros_like(march.contact.pairs)
        count = touching_pairs(state.buf, march.contact, np.zeros(12), pairs)
        pairs = np.ascontiguousarray(pairs[:, :count])
        blocks, step = np.zeros((count, 12, 12)), PROBE * self._thinnest
        pair_stiffness(state.buf, march.contact, pairs, step, np.zeros((2, 12)), blocks)
        values, vectors = np.linalg.eigh((blocks + blocks.transpose(0, 2, 1)) / 2)
        pair, one = np.nonzero(np.abs(values) > SLIGHT * np.abs(values).max(initial=0.0))
        self.stiff = values[pair, one]
        if len(pair) * state.n > ROOM:
            return False
        nodes = np.zeros((len(pair), state.n, 3))
        which = np.stack([pairs[0], pairs[0] + 1, pairs[1], pairs[1] + 1], axis=1)[pair]
        nodes[np.arange(len(pair))[:, None], which] = vectors[pair, :, one].reshape(-1, 4, 3)
        arm = self.length[:, None] * self.strain
        self.lever = np.cross(arm, to_frame(self.frames, self.beyond(nodes)))
        return True

    def nodes_of(self, turns: Array) -> Array:
        """Return how nodes move as elements turn, T, (n, 3)."""
        return self.along(self.length[:, None] * to_lab(self.frames, np.cross(turns, self.strain)))

    def reach(self, turns: Array) -> Array:
        """Return by what part of these turns, one for each rod, the rods may turn at once."""
        rods = len(self.march.scene.rods)
        most = np.zeros(rods)
        np.maximum.at(most, self.rod[self.real], np.abs(turns[self.real]).max(axis=1) / TURN)
        contact = self.march.contact
        if contact is not None:
            moved = self.nodes_of(turns)
            free = np.linalg.norm(moved, axis=1).max() / (ROAM * contact.skin)
            most[:] = max(
                most.max(), free, haste(self.march.state.buf, contact, moved, NEAR, SLIDE)
            )
        return 1 / np.maximum(most, 1.0)


def _banded(diagonal: Array, upper: Array) -> Array:
    """Return the upper band, (6, 3 n), of a symmetric block tridiagonal matrix."""
    n = len(diagonal)
    band = np.zeros((6, 3 * n))
    for a in range(3):
        for b in range(3):
            if a <= b:
                band[5 + a - b, b::3] = diagonal[:, a, b]
            band[2 + a - b, 3 + b :: 3] = upper[:-1, a, b]
    return band


def to_frame(frames: Array, vectors: Array) -> Array:
    """Return vectors of the lab in the frames of elements."""
    return np.einsum("nij,...nj->...ni", frames, vectors)


def to_lab(frames: Array, vectors: Array) -> Array:
    """Return vectors in the frames of elements in the lab."""
    return np.einsum("nji,nj->ni", frames, vectors)


def turned(frames: Array, turns: Array) -> Array:
    """Return frames turned by rotation vectors in their own axes, exp(-[a]) Q."""
    angle = np.linalg.norm(turns, axis=1)[:, None, None]
    skew = np.zeros((len(turns), 3, 3))
    skew[:, 0, 1], skew[:, 0, 2], skew[:, 1, 2] = turns[:, 2], -turns[:, 1], turns[:, 0]
    skew -= skew.transpose(0, 2, 1)
    first, second = np.sinc(angle / np.pi), 0.5 * np.sinc(angle / (2 * np.pi)) ** 2
    return frames + first * (skew @ frames) + second * (skew @ (skew @ frames))
