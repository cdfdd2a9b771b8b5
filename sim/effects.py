"""From what a scene names to what the kernels take: a NamedTuple each, or None if not named."""

from __future__ import annotations

import math

import numpy as np

from sim.kernels import contact as contact_kernel
from sim.kernels import march as march_kernel
from sim.kernels import tine as tine_kernel
from sim.scene import Scene
from sim.state import State

SOFTNESS = 0.3  # default line stiffness of contact as a fraction of Young's modulus
SLIP_DAMPING = 0.2  # of critical, for the spring that stands for sticking


def stiffness(scene: Scene) -> float | None:
    """Return the line stiffness of contact [N/m^2], None without contact."""
    if scene.contact is None:
        return None
    return scene.contact.stiffness or SOFTNESS * min(rod.material.E for rod in scene.rods)


def gravity(scene: Scene) -> march_kernel.Gravity | None:
    """Return the acceleration, if any."""
    return None if scene.gravity is None else march_kernel.Gravity(*scene.gravity)


def damping(scene: Scene, dt: float) -> float | None:
    """Return the factor by which drag lets velocities survive a step, if there is drag."""
    if scene.damping is None or scene.damping.drag == 0:
        return None
    return math.exp(-scene.damping.drag * dt)


def viscous(scene: Scene) -> float | None:
    """Return the Kelvin-Voigt time [s], if the material damps."""
    if scene.damping is None or scene.damping.material == 0:
        return None
    return scene.damping.material


def friction(scene: Scene) -> contact_kernel.Friction | None:
    """Return the coefficients, if any."""
    if scene.friction is None:
        return None
    line_density = min(rod.material.density * math.pi * rod.radius**2 for rod in scene.rods)
    viscous = 2 * SLIP_DAMPING * math.sqrt(line_density)
    return contact_kernel.Friction(scene.friction.forward, scene.friction.backward, viscous)


def contact(scene: Scene, state: State) -> contact_kernel.Contact | None:
    """Return contact with an empty neighbour list of the right size, if the scene has it."""
    line_stiffness = stiffness(scene)
    if scene.contact is None or line_stiffness is None:
        return None
    radii = [rod.radius for rod in scene.rods]
    rod = state.rod_of_element()
    arc = np.concatenate([[0.0], np.cumsum(state.row("LENGTH"))[:-1]])
    # Along a strand bent to its own diameter, contact begins half a turn away.
    gap = math.pi * 2 * max(radii) if scene.contact.self_contact else math.inf
    state.row("OVERHANG")[:] = _overhang(state, 2 * max(radii))
    return contact_kernel.Contact(
        line_stiffness,
        scene.contact.skin or max(0.5 * max(radii), 0.25 * state.row("LENGTH").max()),
        rod,
        arc,
        gap,
        np.zeros(state.n + 1, np.int64),
        np.zeros(8 * state.n, np.int64),
        np.zeros((8 * state.n, 3)),
    )


def _overhang(state: State, reach: float) -> np.ndarray:
    """Return how far contact reaches beyond each node [m]: only beyond the two ends of a rod."""
    result = np.zeros(state.n)
    for first, count in zip(state.first, state.elements, strict=True):
        result[[first, first + count]] = reach
    return result


def tines(scene: Scene, state: State) -> tine_kernel.Tines | None:
    """Return all tines of the scene, if any."""
    if not scene.tines:
        return None
    m = len(scene.tines)
    geometry = np.array(
        [[*t.position, *_unit(t.axis), t.length / 2, t.radius] for t in scene.tines]
    )
    motion = np.array(
        [[*_unit(t.direction), t.insertion, t.ramp, t.speed, t.travel] for t in scene.tines]
    )
    line_stiffness = stiffness(scene) or SOFTNESS * min(rod.material.E for rod in scene.rods)
    slip = np.zeros((m, state.n if scene.friction else 1, 3))
    return tine_kernel.Tines(
        line_stiffness, geometry, motion, np.zeros((m, 8)), np.zeros((m, 3)), slip
    )


def _unit(vector: tuple[float, float, float]) -> np.ndarray:
    return np.array(vector) / np.linalg.norm(vector)
