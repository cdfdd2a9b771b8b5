"""Why a march became unstable: where, by which effect and mode, and what to change.

Position Verlet can be taken back by half a step, so the positions at which the last forces were
evaluated are known to rounding. There every effect is evaluated on its own; what remains of the
sums that the march has left in its rows is what depends on velocities.
"""

from __future__ import annotations

import copy
from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sim.energy import kinetic_energy
from sim.errors import Unstable
from sim.kernels.contact import Friction, contact_forces
from sim.kernels.ends import pull
from sim.kernels.march import Effects
from sim.kernels.plane import plane_forces
from sim.kernels.rod import clear_loads, drift, stretch_and_shear
from sim.kernels.tine import place, tine_forces
from sim.march import timestep
from sim.march.marching import Marching
from sim.march.state import State, empty_buffer
from sim.march.timestep import SPRING

Array = NDArray[np.float64]

ELASTIC, VISCOUS, WEIGHT, LOAD, MOTION, RODS, TINE, PLANE, RUBBING, DASHPOT = (
    "elasticity",
    "material damping",
    "gravity",
    "end load",
    "prescribed motion",
    "contact of rods",
    "contact with a tine",
    "contact with a plane",
    "friction",
    "damping of the contact with tines and planes",
)
REMEDY = {
    ELASTIC: "start closer to the shape at rest, or mesh finer where it bends sharply",
    VISCOUS: "lower damping.material or safety",
    WEIGHT: "make the rods stiffer or lighter, or gravity weaker",
    LOAD: "lower the load on this end, or let it grow over a longer ramp",
    MOTION: "lower the velocity of this end, or lengthen its ramp",
    RODS: "draw the rods with less overlap, or lower contact.stiffness",
    TINE: "lower the tine's speed, lengthen its insertion, or lower contact.stiffness",
    PLANE: "draw the rods clear of the plane, or lower contact.stiffness",
    RUBBING: "lower the coefficients of friction",
    DASHPOT: "lower damping.tine or safety",
}
NO_NUMBER = "not a number"
SHORTER = "leave time_step out, or lower safety"


def unstable(march: Marching) -> Unstable:
    """Return the error that says what went wrong in the step just taken."""
    state = march.state
    speed = np.linalg.norm(state.rows("V0 V1 V2"), axis=0)
    worst = int(np.argmax(np.where(np.isfinite(speed), speed, np.inf)))
    rod, element = state.place(worst)
    if np.isfinite(speed[worst]):
        effect, mode, why, remedy = _runaway(march, worst)
    else:
        effect, mode, remedy = _not_a_number(march), NO_NUMBER, "find the value in the scene"
        why = f"{effect} is not a number"
    return Unstable(
        f"unstable at t = {march.time:.6g} s: node {element} of rod {rod} moves at "
        f"{speed[worst]:.3g} m/s; {why}; {remedy}",
        march.time, rod, element, effect, mode,
    )  # fmt: skip


def _not_a_number(march: Marching) -> str:
    """Return the effect that brought in a value that is not finite; elasticity if none did."""
    effects = march.effects
    given = {
        WEIGHT: effects.gravity,
        LOAD: None if effects.pulled is None else effects.pulled.load[:, :6],
        MOTION: None if effects.driven is None else effects.driven.motion[:, :6],
        TINE: None if effects.tines is None else effects.tines.geometry,
    }
    broken = (name for name, values in given.items() if not np.isfinite(_numbers(values)).all())
    return next(broken, ELASTIC)


def _numbers(values: Any) -> Array:
    return np.zeros(0) if values is None else np.asarray(values)


def _runaway(march: Marching, node: int) -> tuple[str, str, str, str]:
    """Return effect, mode, the reason in words, and the remedy for a node that is too fast."""
    if march.state.row("INV_MASS")[node] == 0:
        return MOTION, MOTION, "its prescribed motion is that fast", REMEDY[MOTION]
    forces = {name: float(np.linalg.norm(force[:, node])) for name, force in by_effect(march)}
    touching = {name: forces[name] for name in (RODS, TINE, PLANE) if name in forces}
    near = any(touching.values()) or _has_neighbours(march, node)
    mode, limit, sustained = _local_limit(march, node, near)
    if march.step > limit:
        effect = max(touching, key=touching.__getitem__) if mode == SPRING else ELASTIC
        why = f"the time step of {march.step:.3g} s is above the {limit:.3g} s that {mode} allows"
        return effect, mode, why, SHORTER
    if march.step > sustained:
        sink = DASHPOT if march.effects.viscous is None else VISCOUS
        why = (
            f"{sink} shortens the longest time step to {sustained:.3g} s, below {march.step:.3g} s"
        )
        return sink, mode, why, REMEDY[sink]
    effect = max(forces, key=forces.__getitem__)
    why = f"the largest force there is that of {effect}, {forces[effect]:.3g} N"
    if effect == ELASTIC and (driver := _driver(march)) is not None:
        effect, why = driver, f"the energy came in by {driver}"
    own = SPRING if effect in (RODS, TINE, PLANE) else mode if effect == ELASTIC else effect
    return effect, own, why, REMEDY[effect]


def _driver(march: Marching) -> str | None:
    """Return what did most of the work, if that is half the motion there is: rods hand it on."""
    effects = march.effects
    sources = {TINE: effects.tines, MOTION: effects.driven, LOAD: effects.pulled}
    work = {name: float(each.work[0]) for name, each in sources.items() if each is not None}
    largest = max(work, key=work.__getitem__, default=None)
    if largest is None or work[largest] < 0.5 * kinetic_energy(march.state):
        return None
    return largest


def _has_neighbours(march: Marching, node: int) -> bool:
    """Tell whether an element beside a node is listed to touch another rod: it may just bounce."""
    contact = march.effects.contact
    if contact is None:
        return False
    return bool(np.isin(contact.pairs, (node - 1, node)).any())


def _local_limit(march: Marching, node: int, near: bool) -> tuple[str, float, float]:
    """Return the stiffest mode beside a node and the stability limit there, without and with
    damping [s].
    """
    effects = march.effects
    touched = effects.contact or effects.tines or effects.planes
    stiffness = touched.stiffness if near and touched is not None else None
    beside = [i for i in (node - 1, node) if march.state.row("LENGTH")[i] > 0]
    parts = {name: terms[beside] for name, terms in timestep.modes(march.state, stiffness).items()}
    total = timestep.together(parts)
    worst = int(np.argmax(total))
    limit = float(1 / np.sqrt(total[worst]))
    mode = max(parts, key=lambda name: float(parts[name][worst]))
    sinks = effects.viscous, limit, _touch_viscous(effects), float(parts[SPRING][worst])
    return mode, limit, limit * float(timestep.damped(*sinks))


def _touch_viscous(effects: Effects) -> float | None:
    bodies = effects.tines or effects.planes
    return None if bodies is None else bodies.viscous


def by_effect(march: Marching) -> Iterator[tuple[str, Array]]:
    """Yield every effect of the scene and its force on each node in the last step, (3, n) [N]."""
    state, effects = march.state, copy.deepcopy(march.effects)  # friction remembers: not ours
    n, dt, time = state.n, march.step, march.time - 0.5 * march.step
    inner, outer = internal(state), state.rows("F0 F1 F2")
    then = _half_a_step_back(march)
    stretch_and_shear(then.buf, n, None if effects.viscous is None else 0.0)
    elastic = internal(then)
    yield ELASTIC, elastic
    if effects.viscous is not None:
        yield VISCOUS, inner - elastic
    for name, force in _outer(then, effects, time, dt):
        outer = outer - force
        yield name, force
    rubs = effects.friction, effects.tine_friction, effects.plane_friction
    if any(each is not None for each in rubs):
        yield RUBBING, outer  # what is left
    elif _touch_viscous(effects) is not None:
        yield DASHPOT, outer


def internal(state: State) -> Array:
    """Return the force of its two elements on every node, (3, n) [N]."""
    normal = state.rows("N0 N1 N2")
    return normal - np.roll(normal, 1, axis=1)


def _half_a_step_back(march: Marching) -> State:
    """Return a copy of the rods with positions and frames as the last forces saw them."""
    state = march.state
    then = State(empty_buffer(), state.n, state.first, state.elements)
    then.used()[:] = state.used()
    drift(then.buf, then.n, -0.5 * march.step)
    return then


def _outer(then: State, effects: Effects, time: float, dt: float) -> Iterator[tuple[str, Array]]:
    """Yield every outer effect that depends on positions and its force, (3, n) [N]."""
    buf, n = then.buf, then.n
    if effects.gravity is not None:
        yield WEIGHT, np.outer(effects.gravity, then.row("MASS"))
    if effects.pulled is not None:
        clear_loads(buf, n)
        pull(buf, effects.pulled, time, dt)
        yield LOAD, then.rows("F0 F1 F2")
    if effects.contact is not None:
        clear_loads(buf, n)
        contact_forces(buf, n, dt, effects.contact, _smooth(effects.friction))
        yield RODS, then.rows("F0 F1 F2")
    if effects.tines is not None:
        clear_loads(buf, n)
        place(effects.tines, time)
        tine_forces(buf, n, dt, _undamped(effects.tines), _smooth(effects.tine_friction))
        yield TINE, then.rows("F0 F1 F2")

    if effects.planes is not None:
        clear_loads(buf, n)
        still = None if effects.plane_friction is None else 0 * effects.plane_friction
        plane_forces(buf, n, dt, _undamped(effects.planes), still, effects.ledger)
        yield PLANE, then.rows("F0 F1 F2")


def _undamped(bodies: Any) -> Any:
    """Return tines or planes without damping: the kernels are compiled for its type."""
    return bodies._replace(viscous=None if bodies.viscous is None else 0.0)


def _smooth(friction: Friction | None) -> Friction | None:
    """Return friction without coefficients: the kernels are compiled for its type."""
    return None if friction is None else friction._replace(forward=0.0, backward=0.0)
