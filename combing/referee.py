"""The solver as `cosseratbench` runs it: a public benchmark of rods, ropes and cables.

``pip install combing[referee]``, then ``cosseratbench run --solver combing``; beside others:
``benchmarks/referee.py``. The package finds this solver by its entry point.
"""

from __future__ import annotations

import math
from importlib.metadata import version
from typing import Any, Literal

import numpy as np
from cosseratbench import Capability, Cylinder, Diverged, Motion, Scenario, Trajectory
from cosseratbench import End as Side
from cosseratbench import EndCondition as Condition
from cosseratbench import Rod as Rope
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

import sim
from sim.energy import directors
from sim.explicit import Explicit, explicit
from sim.march.effects import SOFTNESS, stiffness
from sim.scene import (
    Contact,
    Damping,
    End,
    Friction,
    Load,
    Material,
    Output,
    Plane,
    Points,
    Rod,
    Scene,
    Tine,
)
from sim.scene import Motion as Course

Array = NDArray[np.float64]
HOLDS: dict[Condition, Literal["free", "pinned", "clamped"]] = {
    Condition.FREE: "free",
    Condition.PINNED: "pinned",
    Condition.CLAMPED: "clamped",
}


class CombingSolver:
    """Position Verlet of discrete Cosserat rods, `sim`, behind the benchmark's interface."""

    name = "combing"
    backend_version = version("combing")
    capabilities = frozenset(Capability)

    def __init__(self, time_step_scale: float = 1.0) -> None:
        self.safety = 0.75 * time_step_scale

    def settings(self, scenario: Scenario, *, n_elements: int, n_frames: int) -> dict[str, Any]:
        """Return the numerical choices for a scenario, as JSON values."""
        scene = self.scene(scenario, n_elements, n_frames)
        damping = scene.damping or Damping()
        return {
            "integrator": "position Verlet (explicit)",
            "time_step": explicit(scene).dt,
            "damping_rate": damping.drag,
            "contact_stiffness_per_length": stiffness(scene),
            "contact_damping_time": damping.tine,
        }

    def run(self, scenario: Scenario, *, n_elements: int, n_frames: int) -> Trajectory:
        """March through a scenario and return `n_frames` evenly spaced frames.

        Raises
        ------
        Diverged
            The motion left the range that the time step resolves.
        NotImplementedError
            Rods of different coefficients of friction.
        """
        march = explicit(self.scene(scenario, n_elements, n_frames))
        start = [rod.directors(n_elements) for rod in scenario.rods]
        own = [np.einsum("nij,nj->ni", frames, d1)
               for frames, d1 in zip(_frames(march), start, strict=True)]  # fmt: skip
        shown = [(march.state.strands(), start)]
        steps = round(scenario.duration / (n_frames - 1) / march.dt)
        try:
            for _ in range(n_frames - 1):
                _advance(march, scenario, steps)
                now = [np.einsum("nji,nj->ni", frames, parts)
                       for frames, parts in zip(_frames(march), own, strict=True)]  # fmt: skip
                shown.append((march.state.strands(), now))
        except sim.Unstable as error:
            raise Diverged(str(error), time=error.time) from error
        positions, turned = (tuple(map(np.stack, zip(*each, strict=True)))
                             for each in zip(*shown, strict=True))  # fmt: skip
        times = np.linspace(0.0, scenario.duration, n_frames)
        return Trajectory(times, positions, turned)

    def scene(self, scenario: Scenario, n_elements: int, n_frames: int) -> Scene:
        """Return a scenario as a scene, a window of its time steps one frame long."""
        bodies = scenario.obstacles
        return Scene(
            rods=[_rod(rope, n_elements) for rope in scenario.rods],
            duration=scenario.duration,
            gravity=scenario.gravity if any(scenario.gravity) else None,
            contact=Contact(self_contact=scenario.self_contact) if _touch(scenario) else None,
            friction=_friction(scenario),
            damping=_damping(scenario),
            tines=[_tine(each) for each in bodies if isinstance(each, Cylinder)],
            planes=[
                Plane(point=each.point, normal=each.normal,
                      friction=max(each.friction, *(rope.friction for rope in scenario.rods), 0.0))
                for each in bodies if not isinstance(each, Cylinder)
            ],
            safety=min(self.safety, 1.0),
            output=Output(sample_rate=(n_frames - 1) / scenario.duration),
        )  # fmt: skip


def _touch(scenario: Scenario) -> bool:
    """Tell whether rods may touch each other or themselves."""
    return len(scenario.rods) > 1 or scenario.self_contact


def _rod(rope: Rope, elements: int) -> Rod:
    nodes, stuff = rope.nodes(elements), rope.material
    drawn = np.linalg.norm(np.diff(nodes, axis=0), axis=1)
    return Rod(
        shape=Points(nodes=[tuple(node) for node in nodes.tolist()]),
        radius=rope.radius,
        elements=elements,
        material=Material(
            E=stuff.youngs_modulus, G=stuff.shear_modulus, density=stuff.density
        ),
        rest="straight",
        stretch=(drawn * elements / rope.length).tolist(),
        root=_end(rope, Side.START),
        tip=_end(rope, Side.END),
    )  # fmt: skip


def _end(rope: Rope, side: Side) -> End:
    hold, motion = rope.condition(side), rope.motion(side)
    slides = None if motion is None else motion.slides_along
    force = np.sum([load.force for load in rope.loads if load.at is side], axis=0)
    held = hold is Condition.CLAMPED and slides is None
    return End(
        hold=HOLDS[hold],
        slides=slides,
        motion=None if motion is None else Course(),
        load=Load(force=tuple(force.tolist())) if np.any(force) and not held else None,
    )


def _friction(scenario: Scenario) -> Friction | None:
    """Return what rods feel on each other and on cylinders: of two, the larger coefficient."""
    ropes = {rope.friction for rope in scenario.rods}
    bodies = {each.friction for each in scenario.obstacles if isinstance(each, Cylinder)}
    if len(ropes) > 1 or len(bodies) > 1:
        raise NotImplementedError("bodies of different coefficients of friction")
    own, tine = max(ropes), max(ropes | bodies)
    if tine == 0 or not (bodies or _touch(scenario)):
        return None
    return Friction(forward=own, backward=own, tine=tine)


def _damping(scenario: Scenario) -> Damping | None:
    """Return critical drag of the slowest mode and 0.2 of it for bounces, where rest is asked."""
    if not scenario.quasi_static:
        return None
    softest = min(scenario.rods, key=lambda rope: rope.material.youngs_modulus)
    line = softest.material.density * softest.area
    bounce = 0.4 * math.sqrt(line / (SOFTNESS * softest.material.youngs_modulus))
    drag = 2.0 * scenario.slowest_frequency()
    return Damping(drag=drag, tine=bounce if scenario.obstacles else 0.0)


def _tine(body: Cylinder) -> Tine:
    return Tine(
        position=body.center, axis=body.axis, length=body.length, radius=body.radius, insertion=0.0
    )


def _frames(march: Explicit) -> list[Array]:
    """Return the frames of all elements of every rod, (n, 3, 3) each, rows d1, d2, d3."""
    state = march.state
    return [
        directors(state, slice(first, first + count))
        for first, count in zip(state.first, state.elements, strict=True)
    ]


def _advance(march: Explicit, scenario: Scenario, steps: int) -> None:
    """March on by a frame, every driven end at even speed between the times of its course."""
    courses = [
        motion for rope in scenario.rods for side in (Side.START, Side.END)
        if (motion := rope.motion(side)) is not None
    ]  # fmt: skip
    finest = min((np.diff(motion.times).min() for motion in courses), default=math.inf)
    pieces = min(steps, max(1, round(steps * march.dt / finest)))
    for piece in range(pieces):
        taken = (piece + 1) * steps // pieces - piece * steps // pieces
        rows = () if march.effects.driven is None else march.effects.driven.motion
        for row, motion in zip(rows, courses, strict=True):
            _steer(row, motion, march.time, taken * march.dt)
        march.advance(taken)


def _steer(course: Array, motion: Motion, start: float, duration: float) -> None:
    """Give an end the steady velocity and spin that lead it to its pose after `duration`."""
    (here, turned), (there, turning) = (motion.pose(t) for t in (start, start + duration))
    course[:3] = (there - here) / duration
    course[3:6] = Rotation.from_matrix(turning @ turned.T).as_rotvec() / duration
    course[7] = 0.0  # at once, without a ramp
