"""The study's scenes by name: a double helix with a tine in it, a curl of hairs."""

from __future__ import annotations

import math
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Field, ValidationError, model_validator

from sim.errors import SceneError
from sim.scene.complaints import first_complaint
from sim.scene.model import (
    Contact,
    Damping,
    Friction,
    Helix,
    Material,
    NotNegative,
    Output,
    Part,
    Positive,
    RandomCurvature,
    Rod,
    Scene,
    Straight,
    Tine,
)

LONGEST = {"duration": 1.0, "rest": 10.0}  # s that a curl takes if it is not told
NYLON_SCALED = 0.078 * 2.8e9  # Pa; the paper scales its simulated filaments by 0.078


def material_time(r: float, E: float, density: float) -> float:
    """Return a Kelvin-Voigt time [s] that damps an element's shear rotation by about a tenth."""
    return 0.1 * r * math.sqrt(3 * density / E)


class DoubleHelix(Part):
    """Two helical strands, stress-free as drawn, clamped at the top, and a tine.

    `pi1` = P/r, `pi2` = R/r, `pi3` = t/r; right-handed unless `handedness` says "left". Give
    `height` [m] or `turns`. `q` is the number of pitches between the tine and the free end; left
    out, the tine starts one pitch below the clamp. `imperfection` adds a random intrinsic
    curvature, as a fraction of the helix's own.
    """

    pi1: Positive = 18.0
    pi2: Annotated[float, Field(ge=1)] = 1.0
    pi3: Positive = 2.0
    handedness: Literal["right", "left"] = "right"
    r: Positive = 4.25e-4
    height: Positive | None = None
    turns: Positive | None = None
    q: Positive | None = None
    E: Positive = NYLON_SCALED
    nu: Annotated[float, Field(gt=-1, le=0.5)] = 0.4
    density: Positive = 1140.0
    friction: NotNegative = 0.0
    elements_per_pitch: Annotated[float, Field(ge=3)] = 12.0
    speed: Positive = 0.2
    insertion: NotNegative = 0.025
    imperfection: NotNegative = 0.0
    samples_per_pitch: Positive = 200.0
    snapshots: Annotated[int, Field(ge=2)] = 64
    forces: bool = False
    frames: bool = False
    seed: int = 0

    @model_validator(mode="after")
    def _height_or_turns(self) -> DoubleHelix:
        if self.height is not None and self.turns is not None:
            raise ValueError(f"give height = {self.height} or turns = {self.turns}, not both")
        if self.q is not None and self.q * self.pitch > self.extent:
            raise ValueError(
                f"q = {self.q} pitches do not fit into a helix of {self.extent / self.pitch:.1f}"
            )
        if self.q is None and self.extent < 0.999 * self.pitch:
            raise ValueError(
                f"pi1 = {self.pi1:g}: {self.extent / self.pitch:.2g} of a pitch fits into the "
                f"height of {self.extent:g} m; the tine starts one pitch below the clamp"
            )
        return self

    @property
    def pitch(self) -> float:
        """Pitch P [m]."""
        return self.pi1 * self.r

    @property
    def extent(self) -> float:
        """Height h of the helix along its axis [m]."""
        if self.turns is not None:
            return self.turns * self.pitch
        return 0.15 if self.height is None else self.height

    def scene(self) -> Scene:
        """Return the scene with these parameters."""
        return Scene(
            title=f"double helix, P/r = {self.pi1:g}, R/r = {self.pi2:g}, t/r = {self.pi3:g}",
            rods=[self._rod(phase) for phase in (0.0, math.pi)],
            duration=self._tine().duration,
            contact=Contact(),
            friction=Friction(forward=self.friction, backward=self.friction)
            if self.friction > 0
            else None,
            damping=Damping(
                drag=50.0,
                insertion=2000.0,
                material=material_time(self.r, self.E, self.density),
            ),
            tines=[self._tine()],
            # Both only lengthen the time step, by 1.5: the first jam moves by 5e-6 of it.
            rotary_inertia="element",
            safety=0.95,
            output=Output(
                sample_rate=self.samples_per_pitch * self.speed / self.pitch,
                snapshots=self.snapshots,
                forces=self.forces,
                frames=self.frames,
            ),
            seed=self.seed,
        )

    def _rod(self, phase: float) -> Rod:
        radius = self.pi2 * self.r
        curvature = radius / (radius**2 + (self.pitch / (2 * math.pi)) ** 2)
        return Rod(
            shape=Helix(
                radius=radius,
                pitch=self.pitch,
                height=self.extent,
                phase=phase,
                handedness=self.handedness,
            ),
            radius=self.r,
            elements=max(2, round(self.elements_per_pitch * self.extent / self.pitch)),
            material=Material(E=self.E, nu=self.nu, density=self.density),
            curvature=RandomCurvature(sd=self.imperfection * curvature, correlation=self.pitch)
            if self.imperfection > 0
            else None,
        )

    def _tine(self) -> Tine:
        below = self.extent - self.pitch if self.q is None else self.q * self.pitch
        depth = max(self.extent - below, 0.0)
        angle = 2 * math.pi * depth / self.pitch * (1 if self.handedness == "right" else -1)
        radius = self.pi3 * self.r
        return Tine(
            position=(0.0, 0.0, -depth),
            # Between the strands: normal to the line that joins them at this depth.
            axis=(math.sin(angle), math.cos(angle), 0.0),
            length=max(0.1, 40 * radius),
            radius=radius,
            direction=(0.0, 0.0, -1.0),
            speed=self.speed,
            insertion=self.insertion,
            travel=below + self.pitch + radius,
        )


class Curl(Part):
    """`n` hairs clamped side by side, curved by nature, that hang and relax under gravity.

    `curvature` [1/m] is the standard deviation of the intrinsic curvature (10 straight, 40 wavy,
    100 curly), correlated over `correlation` [m]; `spread` [m] the radius of the clamped bundle.
    They hang `until` they are at rest, after 10 s or a `duration` at the latest; given a `duration`
    alone, until that is over.
    """

    n: Annotated[int, Field(ge=2)] = 12
    length: Positive = 0.2
    r: Positive = 7.5e-5
    E: Positive = 1e9
    nu: Annotated[float, Field(gt=-1, le=0.5)] = 0.4
    density: Positive = 1300.0
    curvature: NotNegative = 40.0
    correlation: NotNegative = 0.01
    spread: Positive = 2e-3
    friction: NotNegative = 0.0
    elements: Annotated[int, Field(ge=8)] = 60
    duration: Positive | None = None
    until: Literal["duration", "rest"] | None = None
    snapshots: Annotated[int, Field(ge=1)] = 8
    forces: bool = False
    frames: bool = False
    seed: int = 0

    def scene(self) -> Scene:
        """Return the scene with these parameters."""
        until = self.until or ("duration" if self.duration else "rest")
        duration = self.duration or LONGEST[until]
        return Scene(
            title=f"curl of {self.n} hairs",
            rods=[self._rod(root) for root in self._roots()],
            duration=duration,
            until=until,
            gravity=(0.0, 0.0, -9.81),
            # Hairs hardly press on each other: with soft contact, 1 N/m sinks in by r/75.
            contact=Contact(stiffness=1e-3 * self.E),
            friction=Friction(forward=self.friction, backward=self.friction)
            if self.friction > 0
            else None,
            # Near the critical damping of a hanging hair, 2 sqrt(g/L), so that it settles fastest.
            damping=Damping(
                drag=2 * math.sqrt(9.81 / self.length),
                material=material_time(self.r, self.E, self.density),
            ),
            rotary_inertia="element",
            output=Output(
                sample_rate=max(100.0, 2 * self.snapshots / duration),
                snapshots=self.snapshots,
                forces=self.forces,
                frames=self.frames,
            ),
            seed=self.seed,
        )

    def _rod(self, root: tuple[float, float, float]) -> Rod:
        return Rod(
            shape=Straight(root=root, length=self.length),
            radius=self.r,
            elements=self.elements,
            material=Material(E=self.E, nu=self.nu, density=self.density),
            curvature=RandomCurvature(sd=self.curvature, correlation=self.correlation),
        )

    def _roots(self) -> list[tuple[float, float, float]]:
        """Return roots drawn in the disc of the clamp, none closer than three radii to another."""
        rng = np.random.default_rng([self.seed, 1])
        roots: list[tuple[float, float, float]] = []
        for _ in range(1000 * self.n):
            radius, angle = self.spread * math.sqrt(rng.random()), 2 * math.pi * rng.random()
            x, y = radius * math.cos(angle), radius * math.sin(angle)
            if all(math.hypot(x - a, y - b) > 3 * self.r for a, b, _ in roots):
                roots.append((x, y, 0.0))
            if len(roots) == self.n:
                return roots
        raise SceneError(
            f"spread = {self.spread} m has no room for {self.n} hairs of radius {self.r} m"
        )


PRESETS: dict[str, type[DoubleHelix] | type[Curl]] = {"double_helix": DoubleHelix, "curl": Curl}


def preset_scene(name: str, parameters: dict[str, Any]) -> Scene:
    """Return a preset's scene by name.

    Raises
    ------
    SceneError
        There is no such preset, or a parameter is unknown or out of range.
    """
    if not isinstance(name, str) or name not in PRESETS:
        raise SceneError(f"preset = {name!r}: choose from {', '.join(PRESETS)}")
    try:
        return PRESETS[name](**parameters).scene()
    except ValidationError as error:
        raise SceneError(first_complaint(error, PRESETS[name])) from None


def double_helix(pi1: float = 18.0, pi2: float = 1.0, pi3: float = 2.0, **parameters: Any) -> Scene:
    """Return the scene of the paper's Figs. 2-4; parameters as in `DoubleHelix`.

    Raises
    ------
    SceneError
        A parameter is unknown or out of range.
    """
    return preset_scene("double_helix", {"pi1": pi1, "pi2": pi2, "pi3": pi3, **parameters})


def curl(n: int = 12, **parameters: Any) -> Scene:
    """Return the scene of the paper's Fig. 3a; parameters as in `Curl`.

    Raises
    ------
    SceneError
        A parameter is unknown or out of range.
    """
    return preset_scene("curl", {"n": n, **parameters})
