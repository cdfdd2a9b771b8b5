"""Kinetic and elastic energy of all rods, written with numpy apart from the kernels."""

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from sim.state import State

Array = NDArray[np.float64]


def kinetic_energy(state: State) -> float:
    """Return the kinetic energy of nodes and elements [J]."""
    velocity, spin = state.rows("V0 V1 V2"), state.rows("W0 W1 W2")
    inverse = state.rows("INV_J1 INV_J1 INV_J3")
    inertia = np.divide(1.0, inverse, out=np.zeros_like(inverse), where=inverse > 0)
    return float(0.5 * np.sum(state.row("MASS") * velocity**2) + 0.5 * np.sum(inertia * spin**2))


def elastic_energy(state: State) -> float:
    """Return the elastic energy of stretch, shear, bending and twist [J]."""
    rods = range(len(state.first))
    return sum(_stretch_energy(state, rod) + _bend_energy(state, rod) for rod in rods)


def directors(state: State, at: slice) -> Array:
    """Return the frames of elements, (n, 3, 3), rows d1, d2, d3."""
    rows = [[state.row(f"Q{a}{b}")[at] for b in range(3)] for a in range(3)]
    return np.array(rows).transpose(2, 0, 1)


def _stretch_energy(state: State, rod: int) -> float:
    at = state.nodes(rod)
    inside = slice(at.start, at.stop - 1)
    length = state.row("LENGTH")[inside]
    position = state.rows("X0 X1 X2").T[at]
    tangent = np.diff(position, axis=0) / length[:, None]
    strain = np.einsum("nij,nj->ni", directors(state, inside), tangent) - [0, 0, 1]
    stiffness = state.rows("SHEAR SHEAR STRETCH").T[inside]
    return float(0.5 * np.sum(stiffness * strain**2 * length[:, None]))


def _bend_energy(state: State, rod: int) -> float:
    at = state.nodes(rod)
    # The ghosts before the root and after the tip are the frames of clamps.
    frames = directors(state, slice(at.start - 1, at.stop))
    vertices = at
    inverse = state.row("INV_VORONOI")[vertices]
    turn = -Rotation.from_matrix(frames[1:] @ frames[:-1].transpose(0, 2, 1)).as_rotvec()
    strain = turn * inverse[:, None] - state.rows("K0 K1 K2").T[vertices]
    stiffness = state.rows("BEND BEND TWIST").T[vertices]
    voronoi = np.divide(1.0, inverse, out=np.zeros_like(inverse), where=inverse > 0)
    return float(0.5 * np.sum(stiffness * strain**2 * voronoi[:, None]))
