"""From what a scene names to what the kernels take: a NamedTuple each, or None if not named."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from sim.kernels import contact as contact_kernel
from sim.kernels import ends as ends_kernel
from sim.kernels import ledger as ledger_kernel
from sim.kernels import march as march_kernel
from sim.kernels import plane as plane_kernel
from sim.kernels import tine as tine_kernel
from sim.march.state import State
from sim.scene import End, Motion, Scene, Tine

SOFTNESS = 0.3  # default line stiffness of contact as a fraction of Young's modulus


def stiffness(scene: Scene) -> float | None:
    """Return the line stiffness of contact [N/m^2], None where nothing can touch."""
    if scene.contact is None and not scene.tines and not scene.planes:
        return None
    given = scene.contact.stiffness if scene.contact is not None else None
    return given or SOFTNESS * min(rod.material.E for rod in scene.rods)


def gravity(scene: Scene) -> march_kernel.Gravity | None:
    """Return the acceleration, if any."""
    return None if scene.gravity is None else march_kernel.Gravity(*scene.gravity)


def damping(scene: Scene, dt: float, *, inserting: bool = False) -> float | None:
    """Return the factor by which drag lets velocities survive a step, if there is drag."""
    if scene.damping is None or scene.damping.drag + scene.damping.insertion == 0:
        return None
    return math.exp(-(scene.damping.drag + inserting * scene.damping.insertion) * dt)


def viscous(scene: Scene) -> float | None:
    """Return the Kelvin-Voigt time [s], if the material damps."""
    if scene.damping is None or scene.damping.material == 0:
        return None
    return scene.damping.material


def touch_viscous(scene: Scene) -> float | None:
    """Return the Kelvin-Voigt time of the contact with tines and planes [s], if that damps."""
    if scene.damping is None or scene.damping.tine == 0 or not (scene.tines or scene.planes):
        return None
    return scene.damping.tine


def friction(scene: Scene) -> contact_kernel.Friction | None:
    """Return the coefficients between rods, if any."""
    if scene.friction is None:
        return None
    return contact_kernel.Friction(scene.friction.forward, scene.friction.backward)


def tine_friction(scene: Scene) -> contact_kernel.Friction | None:
    """Return the coefficients on tines, if any."""
    if scene.friction is None or not scene.tines:
        return None
    if scene.friction.tine is None:
        return friction(scene)
    return contact_kernel.Friction(scene.friction.tine, scene.friction.tine)


def contact(scene: Scene, state: State) -> contact_kernel.Contact | None:
    """Return contact with an empty neighbour list of the right size, if the scene has it."""
    line_stiffness = stiffness(scene)
    if scene.contact is None or line_stiffness is None:
        return None
    radii = [rod.radius for rod in scene.rods]
    rod = state.rod_of_element()
    arc = np.concatenate([[0.0], np.cumsum(state.row("LENGTH"))[:-1]])
    # Along a strand bent as tightly as it can be, round its own radius, contact begins half a turn
    # away. With a longer gap the end loops of plectonemes slip through themselves.
    gap = math.pi * max(radii) if scene.contact.self_contact else math.inf
    state.row("OVERHANG")[:] = _overhang(state, 2 * max(radii))
    return contact_kernel.Contact(
        line_stiffness,
        scene.contact.skin or max(0.5 * max(radii), 0.25 * state.row("LENGTH").max()),
        rod,
        arc,
        gap,
        np.zeros((2, 0), np.int64),
        np.zeros((3, 0)),
        np.zeros((4, 1), np.int64),
        np.zeros((4, 1), np.int64),
        np.zeros(3),
        np.zeros(contact_kernel.WORK),
    )


def _overhang(state: State, reach: float) -> np.ndarray:
    """Return how far contact reaches beyond each node [m]: only beyond the two ends of a rod."""
    result = np.zeros(state.n)
    for first, count in zip(state.first, state.elements, strict=True):
        result[[first, first + count]] = reach
    return result


def tines(scene: Scene, state: State) -> tine_kernel.Tines | None:
    """Return all tines of the scene, if any."""
    line_stiffness = stiffness(scene)
    if not scene.tines or line_stiffness is None:
        return None
    m = len(scene.tines)
    geometry = np.array(
        [[*t.position, *_unit(t.axis), t.length / 2, t.radius] for t in scene.tines]
    )
    slip = np.zeros((m, state.n if scene.friction else 1, 3))
    return tine_kernel.Tines(
        line_stiffness, geometry, np.array([_program(t) for t in scene.tines]),
        np.zeros((m, 7)), np.zeros((m, 3)), np.zeros(1), slip, touch_viscous(scene),
        *((np.zeros((len(scene.rods), 3)), state.rod_of_element()) if scene.output.forces else ()),
    )  # fmt: skip


def planes(scene: Scene, state: State) -> plane_kernel.Planes | None:
    """Return all planes of the scene, if any."""
    line_stiffness = stiffness(scene)
    if not scene.planes or line_stiffness is None:
        return None
    geometry = np.array([[*plane.point, *_unit(plane.normal)] for plane in scene.planes])
    m = len(geometry)
    slip = np.zeros((m, state.n if plane_friction(scene) is not None else 1, 3))
    damped = touch_viscous(scene)
    return plane_kernel.Planes(line_stiffness, geometry, np.zeros((m, 3)), slip, damped)


def plane_friction(scene: Scene) -> np.ndarray | None:
    """Return the coefficient on every plane, (m,), None if none has any."""
    found = np.array([plane.friction for plane in scene.planes])
    return found if found.any() else None


def _program(tine: Tine) -> list[float]:
    there = [tine.travel, tine.speed, tine.ramp_at(tine.speed)] if tine.travel > 0 else [0.0] * 3
    back = [tine.retract, tine.ramp_at(tine.retract)] if tine.retract > 0 else [0.0] * 2
    return [*_unit(tine.direction), tine.insertion, *there, tine.dwell, *back]


def _ends(scene: Scene, state: State) -> Iterator[tuple[End, int, int, int]]:
    """Yield every end of every rod with its node, its element and the frame of its clamp."""
    for number, rod in enumerate(scene.rods):
        first, last = state.first[number], state.first[number] + state.elements[number]
        yield rod.root, first, first, first - 1
        yield rod.tip, last, last - 1, last


def driven(scene: Scene, state: State) -> ends_kernel.Driven | None:
    """Return the held ends with a prescribed motion or a direction to slide along, if any."""
    found = [each for each in _ends(scene, state) if each[0].motion or each[0].slides]
    if not found:
        return None
    node, ghost, slide = _holders(found)
    course = np.array([_course(end.motion or Motion()) for end, *_ in found])
    return ends_kernel.Driven(node, ghost, course, slide, np.zeros(1), np.zeros((len(found), 3)))


def held(scene: Scene, state: State) -> ends_kernel.Held | None:
    """Return the held ends, if there are any and their reactions are asked for."""
    found = [each for each in _ends(scene, state) if each[0].hold != "free"]
    if not found or not scene.output.forces:
        return None
    return ends_kernel.Held(*_holders(found), np.zeros((len(found), 6)))


def _holders(found: list[tuple[End, int, int, int]]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return node, clamp's frame (-1 for a pin) and direction to slide along of ends."""
    ghost = [ghost if end.hold == "clamped" else -1 for end, _, _, ghost in found]
    slide = [_unit(end.slides) if end.slides else np.zeros(3) for end, *_ in found]
    return np.array([node for _, node, _, _ in found]), np.array(ghost), np.array(slide)


def _course(motion: Motion) -> list[float]:
    end = math.inf if motion.duration is None else motion.start + motion.duration
    return [*motion.velocity, *motion.spin, motion.start, motion.ramp, end]


def pulled(scene: Scene, state: State) -> ends_kernel.Pulled | None:
    """Return the ends under dead loads, if any."""
    found = [each for each in _ends(scene, state) if each[0].load is not None]
    if not found:
        return None
    loads = [
        [*end.load.force, *end.load.couple, *(end.load.through or [math.nan] * 3), end.load.ramp]
        for end, *_ in found
        if end.load is not None
    ]
    return ends_kernel.Pulled(
        np.array([node for _, node, _, _ in found]), np.array([at for _, _, at, _ in found]),
        np.array(loads), np.zeros(1),
    )  # fmt: skip


def ledger(scene: Scene, state: State) -> ledger_kernel.Ledger | None:
    """Return an empty ledger of what drag, material and friction take, if it is asked for."""
    if not scene.output.energy:
        return None
    return ledger_kernel.Ledger(*np.zeros((3, 1)), *np.zeros((4, 6, state.n)))


def all_effects(scene: Scene, state: State, dt: float) -> march_kernel.Effects:
    """Return every effect that the scene names, for steps of dt [s]."""
    return march_kernel.Effects(
        keep=damping(scene, dt),
        viscous=viscous(scene),
        gravity=gravity(scene),
        contact=contact(scene, state),
        friction=friction(scene),
        tines=tines(scene, state),
        tine_friction=tine_friction(scene),
        planes=planes(scene, state),
        plane_friction=plane_friction(scene),
        driven=driven(scene, state),
        pulled=pulled(scene, state),
        ledger=ledger(scene, state),
        held=held(scene, state),
    )


def _unit(vector: tuple[float, float, float]) -> np.ndarray:
    return np.array(vector) / np.linalg.norm(vector)
