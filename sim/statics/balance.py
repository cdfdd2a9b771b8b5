"""Rods at rest as a balance of forces and couples: what is out of it, and steps towards it.

A state is the frames of all elements and the strain t in them; nodes follow from the roots on,

    x_{i+1} = x_i + l Q_i^T t_i.

A step (dx, a) turns elements, Q <- exp(-[a]) Q, and changes the strain by what it makes to first
order, t x a + Q (dx_{i+1} - dx_i)/l: so a step that is right to first order leaves lengths right to
all orders. In nodes alone it would stretch rods by a^2/2, which axial stiffness, a million times
that of bending, does not forgive. Forces are the march's own; inner ones are taken from the strain,
which is exact where differences of positions are lost to rounding (1e-6 of a node's weight).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from sim.kernels.contact import contact_forces
from sim.kernels.ends import pull
from sim.kernels.march import weigh
from sim.kernels.passing import haste
from sim.kernels.rod import bend_and_twist, clear_loads
from sim.march.marching import Marching

Array = NDArray[np.float64]

TURN = 0.5  # rad, most that an element turns in a step
NEAR, SLIDE = 0.6, 4.0  # of the contact distance: how near and how far strands move in a step
ROAM = 0.45  # of the skin, most that a node moves in a step: half may bring what is not listed
FOREVER = 1e30  # s: loads have grown


class Balance:
    """The forces and couples on a march's rods.

    Attributes
    ----------
    frames, strain : (n, 3, 3), (n, 3)
        Directors of every element, and t in them; ghosts included.
    free : (n, 6)
        Whether a node and its element may move along and turn about each axis.
    net : (n, 6)
        Force on nodes [N] and couple on elements, in their frames [N m]; zero where not free.
    """

    def __init__(self, march: Marching, soft: float = 1.0) -> None:
        self.march, state = march, march.state
        self.real = state.row("LENGTH") > 0
        self.length = state.row("LENGTH").copy()
        self.stiffness = state.rows("SHEAR SHEAR STRETCH").T.copy()
        self.rod = state.rod_of_element()
        inverse = state.rows("INV_MASS INV_MASS INV_MASS INV_J1 INV_J1 INV_J3").T
        self.free = inverse > 0
        self.free[:, 3:] &= self.real[:, None]
        self.inertia = np.divide(1.0, inverse, out=np.zeros_like(inverse), where=self.free)
        frames = state.rows("Q00 Q01 Q02 Q10 Q11 Q12 Q20 Q21 Q22").T.reshape(-1, 3, 3)
        # A long march leaves them orthogonal to 1e-11 only, which moves nodes to and fro.
        frames = 1.5 * frames - 0.5 * frames @ frames.transpose(0, 2, 1) @ frames
        strain = to_frame(frames, self.along(state.rows("X0 X1 X2").T))
        strain = np.where(self.real[:, None], soft * strain + [0, 0, 1 - soft], [0, 0, 1])
        self.put(frames, strain)

    def along(self, nodes: Array) -> Array:
        """Return the change of nodal values along every element over its length, (n, 3)."""
        inverse = self.march.state.row("INV_LENGTH")[:, None]
        return np.where(self.real[:, None], np.roll(nodes, -1, axis=0) - nodes, 0.0) * inverse

    def put(self, frames: Array, strain: Array) -> None:
        """Lay the rods out with these frames and strains and find what is out of balance."""
        state = self.march.state
        self.frames, self.strain = frames, strain
        self.put_frames(frames)
        edges = self.length[:, None] * to_lab(frames, strain)
        for first, count in zip(state.first, state.elements, strict=True):
            path = np.cumsum(edges[first : first + count], axis=0)
            for axis in range(3):
                row = state.row(f"X{axis}")
                row[first + 1 : first + count + 1] = row[first] + path[:, axis]
        self.evaluate()

    def put_frames(self, frames: Array) -> None:
        """Write frames into the march's rows."""
        for axis in range(3):
            for k in range(3):
                self.march.state.row(f"Q{axis}{k}")[:] = frames[:, axis, k]

    def evaluate(self) -> None:
        """Fill `net`, and the march's rows of inner forces and couples as a march would."""
        march, state = self.march, self.march.state
        clear_loads(state.buf, state.n)
        if march.effects.gravity is not None:
            weigh(state.buf, state.n, march.effects.gravity)
        if march.effects.pulled is not None:
            pull(state.buf, march.effects.pulled, FOREVER, 0.0)
        if march.contact is not None:
            contact_forces(state.buf, state.n, 0.0, march.contact, None)
        inner = np.where(self.real[:, None], (self.strain - [0, 0, 1]) * self.stiffness, 0.0)
        normal, shear = to_lab(self.frames, inner), np.cross(self.strain, inner)
        for axis in range(3):
            state.row(f"N{axis}")[:] = normal[:, axis]
            state.row(f"E{axis}")[:] = self.length * shear[:, axis]
        force = state.rows("F0 F1 F2").T + normal - np.roll(normal, 1, axis=0)
        couple = state.rows("C0 C1 C2").T + state.rows("E0 E1 E2").T + self.bent()
        self.net = np.where(self.free, np.concatenate([force, couple], axis=1), 0.0)

    def bent(self) -> Array:
        """Return the couples of bending and twist on every element, (n, 3)."""
        state = self.march.state
        bend_and_twist(state.buf, state.n, None)
        return (state.rows("R0 R1 R2") + np.roll(state.rows("L0 L1 L2"), -1, axis=1)).T

    def step(self, frames: Array, strain: Array, move: Array, share: Array) -> None:
        """Go from a state by a part, (n,), of a step, (n, 6)."""
        part = share[:, None] * move
        change = np.cross(strain, part[:, 3:]) + to_frame(frames, self.along(part[:, :3]))
        self.put(turned(frames, part[:, 3:]), strain + change)

    def reach(self, move: Array) -> Array:
        """Return by what part of this step each rod may go at once, (rods,)."""
        most = np.zeros(len(self.march.scene.rods))
        np.maximum.at(most, self.rod[self.real], np.abs(move[self.real, 3:]).max(axis=1) / TURN)
        contact = self.march.contact
        if contact is not None:
            moved = np.ascontiguousarray(move[:, :3])
            free = np.linalg.norm(moved, axis=1).max() / (ROAM * contact.skin)
            hasty = haste(self.march.state.buf, contact, moved, NEAR, SLIDE)
            most[:] = max(most.max(), free, hasty)
        return 1 / np.maximum(most, 1.0)

    def by_rod(self, values: Array) -> Array:
        """Return the sum over each rod of values of elements and their first nodes, (rods,).

        Over all rods where strands may touch: these go together.
        """
        found = np.zeros(len(self.march.scene.rods))
        np.add.at(found, self._owner(), values)
        return found if self.march.contact is None else np.full(len(found), found.sum())

    def of_rod(self, values: Array) -> Array:
        """Return the value of its rod for every node and element, (n,)."""
        found: Array = values[self._owner()]
        return found

    def _owner(self) -> NDArray[np.int64]:
        return (
            np.searchsorted(self.march.state.first, np.arange(len(self.real)), "right").clip(1) - 1
        )


def to_frame(frames: Array, vectors: Array) -> Array:
    """Return vectors of the lab in the frames of elements."""
    return np.einsum("nij,nj->ni", frames, vectors)


def to_lab(frames: Array, vectors: Array) -> Array:
    """Return vectors in the frames of elements in the lab."""
    return np.einsum("nji,nj->ni", frames, vectors)


def skew(vectors: Array) -> Array:
    """Return [v] with [v] w = v x w, (n, 3, 3)."""
    found = np.zeros((len(vectors), 3, 3))
    found[:, 2, 1], found[:, 0, 2], found[:, 1, 0] = vectors.T
    return found - found.transpose(0, 2, 1)


def turned(frames: Array, turns: Array) -> Array:
    """Return frames turned by rotation vectors in their own axes, exp(-[a]) Q."""
    angle, back = np.linalg.norm(turns, axis=1)[:, None, None], skew(-turns)
    first, second = np.sinc(angle / np.pi), 0.5 * np.sinc(angle / (2 * np.pi)) ** 2
    return frames + first * (back @ frames) + second * (back @ (back @ frames))
