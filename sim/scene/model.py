"""What a scene is: rods, the effects that act on them, what is recorded. SI units throughout."""

from __future__ import annotations

import math
from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field, model_validator

Positive = Annotated[float, Field(gt=0)]
NotNegative = Annotated[float, Field(ge=0)]
Vector = tuple[float, float, float]


class Part(BaseModel):
    """A part of a scene: fixed once made; unknown keys and infinite values are errors."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)


class Material(Part):
    """Elastic, solid round section: Young's modulus [Pa], Poisson ratio, density [kg/m^3].

    `G` [Pa] is the shear modulus of a fibre that is not isotropic; left out, E/(2 (1 + nu)).
    `shear_coefficient` is Timoshenko's alpha: 27/28 as in Gazzola et al. 2018, 0.886 for nu = 0.5
    after Cowper (1966).
    """

    E: Positive
    nu: Annotated[float, Field(gt=-1, le=0.5)] = 0.4
    G: Positive | None = None
    density: Positive
    shear_coefficient: Positive = 27 / 28

    @property
    def shear_modulus(self) -> float:
        """Shear modulus [Pa]."""
        return self.E / (2 * (1 + self.nu)) if self.G is None else self.G


class Helix(Part):
    """Helix hanging from z = 0 along -z: radius, pitch, height [m], phase [rad], handedness."""

    kind: Literal["helix"] = "helix"
    radius: Positive
    pitch: Positive
    height: Positive
    phase: float = 0.0
    handedness: Literal["right", "left"] = "right"


class Straight(Part):
    """Straight rod from `root` [m] along `direction`, `length` [m] long."""

    kind: Literal["straight"] = "straight"
    root: Vector = (0.0, 0.0, 0.0)
    direction: Vector = (0.0, 0.0, -1.0)
    length: Positive


class Points(Part):
    """Nodes given one by one [m]; the number of elements is one less."""

    kind: Literal["points"] = "points"
    nodes: list[Vector] = Field(min_length=3)


class RandomCurvature(Part):
    """Intrinsic curvature drawn at random: sd [1/m] of each component, correlation length [m].

    A process of arclength: the same seed is the same hair on every mesh. ``correlation = 0`` draws
    every node on its own, as the paper does; that depends on the mesh.
    """

    sd: NotNegative
    correlation: NotNegative = 0.01


class Motion(Part):
    """Prescribed motion of a held end: `velocity` [m/s] of its node, `spin` [rad/s] about it.

    Both rise smoothly over `ramp` [s] from `start` [s] on and fall again at the end of `duration`
    [s]; without a duration they last as long as the run. `spin` turns a clamp about a fixed axis.
    """

    velocity: Vector = (0.0, 0.0, 0.0)
    spin: Vector = (0.0, 0.0, 0.0)
    start: NotNegative = 0.0
    ramp: NotNegative = 0.01
    duration: Positive | None = None


class Load(Part):
    """Dead load on an end: `force` [N] and `couple` [N m] in fixed directions.

    The force acts at the end's node or, with `through`, along the line through that point [m]: it
    then turns the end about the line as well, as a wrench on the axis of a helix does. The load
    grows smoothly over `ramp` [s].
    """

    force: Vector = (0.0, 0.0, 0.0)
    couple: Vector = (0.0, 0.0, 0.0)
    through: Vector | None = None
    ramp: NotNegative = 0.0


class End(Part):
    """One end of a rod: how it is held, how it is moved, what pulls on it.

    A clamp holds position and direction, a pin the position alone; one that `slides` along a
    direction leaves the position along it free, and what pulls there counts.
    """

    hold: Literal["clamped", "pinned", "free"] = "free"
    slides: Vector | None = None
    motion: Motion | None = None
    load: Load | None = None

    @model_validator(mode="after")
    def _held_or_loaded(self) -> End:
        for name in ("motion", "slides"):
            if getattr(self, name) is not None and self.hold == "free":
                raise ValueError(f'{name} needs an end that is held: hold = "clamped" or "pinned"')
        if self.load is not None and self.hold == "clamped" and self.slides is None:
            raise ValueError('a load does nothing on a clamped end: hold = "free" or "pinned"')
        if self.slides is not None and not any(self.slides):
            raise ValueError("slides = (0, 0, 0): a direction needs a length")
        if self.slides is not None and self.motion is not None:
            along = sum(v * u for v, u in zip(self.motion.velocity, self.slides, strict=True))
            if abs(along) > 1e-9 * math.hypot(*self.motion.velocity) * math.hypot(*self.slides):
                raise ValueError(
                    f"motion.velocity = {self.motion.velocity} leads along slides = {self.slides}, "
                    "where the end is free: move it across that direction, or do not let it slide"
                )
        return self


class Rod(Part):
    """One strand. `rest` says which shape carries no bending: the drawn one, or a straight rod.

    `stretch` is the length of elements as drawn over the length without tension, one for all or
    one for each.
    """

    shape: Annotated[Helix | Straight | Points, Field(discriminator="kind")]
    radius: Positive
    elements: Annotated[int, Field(ge=2)]
    material: Material
    rest: Literal["drawn", "straight"] = "drawn"
    stretch: Positive | list[Positive] = 1.0
    curvature: RandomCurvature | None = None
    root: End = End(hold="clamped")
    tip: End = End()


class Contact(Part):
    """Contact between rods and with tines: line stiffness [N/m^2], skin of the neighbour list [m].

    Left out, the stiffness is 0.3 of the softest rod's Young's modulus and the skin the larger of
    half the largest radius and a quarter of the longest element. With `self_contact` a rod may
    touch itself. Rods that `overlap` as drawn are refused, or pushed apart by the contact.
    """

    stiffness: Positive | None = None
    skin: Positive | None = None
    self_contact: bool = False
    overlap: Literal["refuse", "push apart"] = "refuse"


class Friction(Part):
    """Coulomb coefficients of a strand that slides root to tip, and tip to root, over a body.

    `tine` is the coefficient on tines, either way, where it differs from that between strands.
    """

    forward: NotNegative
    backward: NotNegative
    tine: NotNegative | None = None


class Damping(Part):
    """What takes energy out: `drag` [1/s] of velocities, `material` [s] of strains, `tine` [s].

    Until all tines are inserted, `insertion` [1/s] is added to the drag: strands then give way
    without whirling, and what link is left does not depend on how fast the tines grew.

    `material` is the Kelvin-Voigt time: stress = modulus (strain + material strain rate). A motion
    of angular frequency w is damped by w material/2 of critical, so a time near a step of the march
    drains the fast modes that sliding contact feeds and leaves slow bending alone. `tine` is that
    of the contact with tines and planes, of line stiffness k: bouncing there is damped by
    tine/2 sqrt(k/(rho A)) of critical, 0.2 of which ends chatter under friction.
    """

    drag: NotNegative = 0.0
    insertion: NotNegative = 0.0
    material: NotNegative = 0.0
    tine: NotNegative = 0.0


class Tine(Part):
    """Rigid cylinder: inserted by growing to `radius` at `position`, then driven along `direction`.

    It travels at `speed` [m/s], which rises and falls over `ramp` [s], dwells [s], and retracts the
    way it came at the speed `retract` [m/s] if there is one. Without `travel` it stays in place.
    Lengths [m], `insertion` a time [s].
    """

    position: Vector
    axis: Vector
    length: Positive
    radius: Positive
    direction: Vector = (0.0, 0.0, -1.0)
    insertion: NotNegative = 0.05
    ramp: NotNegative = 0.02
    speed: NotNegative = 0.0
    travel: NotNegative = 0.0
    dwell: NotNegative = 0.0
    retract: NotNegative = 0.0

    @model_validator(mode="after")
    def _moves_or_stays(self) -> Tine:
        if (self.speed > 0) != (self.travel > 0):
            raise ValueError(
                f"speed = {self.speed:g} with travel = {self.travel:g}: a tine that moves needs "
                "both, one that stays neither"
            )
        for name in ("axis", "direction"):
            if not any(getattr(self, name)):
                raise ValueError(f"{name} = (0, 0, 0): a direction needs a length")
        return self

    @property
    def duration(self) -> float:
        """Time from the start of the insertion to the end of the last motion [s]."""
        total = self.insertion + self.dwell
        for speed in (self.speed, self.retract):
            if self.travel > 0 and speed > 0:
                total += self.travel / speed + self.ramp_at(speed)
        return total

    def ramp_at(self, speed: float) -> float:
        """Return the time to reach `speed` [s], short enough to fit twice into the travel."""
        return min(self.ramp, self.travel / speed)


class Plane(Part):
    """Rigid plane, a floor or a wall, through `point` [m]: rods stay where its `normal` leads.

    `friction` is Coulomb's coefficient of every rod on it.
    """

    point: Vector = (0.0, 0.0, 0.0)
    normal: Vector = (0.0, 0.0, 1.0)
    friction: NotNegative = 0.0

    @model_validator(mode="after")
    def _has_a_side(self) -> Plane:
        if not any(self.normal):
            raise ValueError("normal = (0, 0, 0): a direction needs a length")
        return self


class Output(Part):
    """What is recorded: force samples per second (each a mean over its window), snapshots.

    With `energy` also the ledger: what is stored, put in and lost, once a sample; steps then
    evaluate the contact twice and more. With `forces` the vector force on each tine and of the
    tines on each strand, and the reaction at each held end, once a sample; with `frames` the
    directors of every element, once a snapshot.
    """

    sample_rate: Positive = 1000.0
    snapshots: Annotated[int, Field(ge=1)] = 64
    energy: bool = False
    forces: bool = False
    frames: bool = False


class Scene(Part):
    """Rods and the effects that act on them; an effect that is left out costs nothing.

    With ``until = "rest"`` the run ends as soon as no node is out of balance by more than
    `rest_tolerance` of its weight (of the largest inner force without gravity), nor faster than
    that part of sqrt(g L); `duration` [s] is then the longest that it may take.
    """

    title: str = "scene"
    rods: list[Rod] = Field(min_length=1)
    duration: Positive
    until: Literal["duration", "rest"] = "duration"
    rest_tolerance: Positive = 1e-3
    gravity: Vector | None = None
    contact: Contact | None = None
    friction: Friction | None = None
    damping: Damping | None = None
    tines: list[Tine] = []
    planes: list[Plane] = []
    rotary_inertia: Literal["section", "element"] = "section"
    time_step: Positive | None = None
    safety: Annotated[float, Field(gt=0, le=1)] = 0.75
    output: Output = Output()
    seed: int = 0

    @model_validator(mode="after")
    def _forces_need_a_body(self) -> Scene:
        held = any(end.hold != "free" for rod in self.rods for end in (rod.root, rod.tip))
        if self.output.forces and not self.tines and not held:
            raise ValueError(
                "output.forces = true: no tine and no held end to record forces of; add one or "
                "leave it out"
            )
        return self

    @model_validator(mode="after")
    def _friction_needs_contact(self) -> Scene:
        if self.friction is not None and self.contact is None and not self.tines:
            raise ValueError("friction acts where bodies touch: add a [contact] table or a tine")
        return self
