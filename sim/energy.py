"""Energy of all rods, that of the rods themselves written with numpy apart from the kernels."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from sim.kernels.ledger import contact_energy, tine_energy
from sim.kernels.plane import Planes
from sim.march.marching import Marching
from sim.march.state import State

Array = NDArray[np.float64]


def kinetic_energy(state: State) -> float:
    """Return the kinetic energy of nodes and elements that are free to move [J]."""
    velocity, spin = state.rows("V0 V1 V2"), state.rows("W0 W1 W2")
    inverse = state.rows("INV_J1 INV_J1 INV_J3")
    inertia = np.divide(1.0, inverse, out=np.zeros_like(inverse), where=inverse > 0)
    mass = np.where(state.row("INV_MASS") > 0, state.row("MASS"), 0.0)
    return float(0.5 * np.sum(mass * velocity**2) + 0.5 * np.sum(inertia * spin**2))


def elastic_energy(state: State) -> float:
    """Return the elastic energy of stretch, shear, bending and twist [J]."""
    rods = range(len(state.first))
    return sum(_stretch_energy(state, rod) + _bend_energy(state, rod) for rod in rods)


def weight_energy(state: State, gravity: tuple[float, float, float]) -> float:
    """Return the potential energy of all weight [J], zero at the origin."""
    return -float(np.array(gravity) @ state.rows("X0 X1 X2") @ state.row("MASS"))


def plane_energy(state: State, planes: Planes) -> float:
    """Return the energy stored in the contact with planes [J]."""
    total = 0.0
    for x, y, z, *normal in planes.geometry:
        height = np.array(normal) @ (state.rows("X0 X1 X2") - [[x], [y], [z]])
        near, far = (state.row("RADIUS") - h for h in (height, np.roll(height, -1)))
        squares = np.maximum(near, 0) ** 2 + np.maximum(far, 0) ** 2
        total += float(0.25 * planes.stiffness * np.sum(state.row("LENGTH") * squares))
    return total


def books(march: Marching) -> dict[str, float]:
    """Return what is stored, what was put in and what was lost since the start [J].

    `balance` is stored + lost - put in, a constant but for the error of the march. Friction's loss
    holds the little that its elastic slips store.

    Raises
    ------
    ValueError
        The scene does not record energies (``output.energy``).
    """
    state, effects = march.state, march.effects
    if effects.ledger is None:
        raise ValueError("output.energy = false: this scene keeps no ledger")
    stored = {
        "kinetic": kinetic_energy(state),
        "elastic": elastic_energy(state),
        "weight": weight_energy(state, effects.gravity) if effects.gravity else 0.0,
        "contact": contact_energy(state.buf, state.n, effects.contact) if effects.contact else 0.0,
        "tine_contact": tine_energy(state.buf, state.n, effects.tines) if effects.tines else 0.0,
        "plane_contact": plane_energy(state, effects.planes) if effects.planes else 0.0,
    }
    put_in = {
        "work_tines": effects.tines.work[0] if effects.tines else 0.0,
        "work_ends": effects.driven.work[0] if effects.driven else 0.0,
        "work_loads": effects.pulled.work[0] if effects.pulled else 0.0,
    }
    lost = {
        "lost_drag": effects.ledger.drag[0],
        "lost_material": effects.ledger.material[0],
        "lost_friction": effects.ledger.friction[0],
    }
    balance = sum(stored.values()) + sum(lost.values()) - sum(put_in.values())
    return {**stored, **put_in, **lost, "balance": balance}


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
    inverse = state.row("INV_VORONOI")[at]
    turn = -Rotation.from_matrix(frames[1:] @ frames[:-1].transpose(0, 2, 1)).as_rotvec()
    strain = turn * inverse[:, None] - state.rows("K0 K1 K2").T[at]
    stiffness = state.rows("BEND BEND TWIST").T[at]
    voronoi = np.divide(1.0, inverse, out=np.zeros_like(inverse), where=inverse > 0)
    return float(0.5 * np.sum(stiffness * strain**2 * voronoi[:, None]))
