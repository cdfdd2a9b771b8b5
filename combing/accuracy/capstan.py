"""A strand pulled over a fixed tine against the law of the capstan."""

from __future__ import annotations

import math
import time
from dataclasses import dataclass

import numpy as np

from combing.accuracy.measurement import Measurement
from sim.explicit import Explicit
from sim.march.state import rigidities
from sim.scene import (
    Contact,
    Damping,
    End,
    Friction,
    Load,
    Material,
    Motion,
    Points,
    Rod,
    Scene,
    Tine,
)

TINE, THIN = 1e-2, 0.004  # tine radius t [m], strand radius over it
RADIUS = THIN * TINE
PATH = TINE + RADIUS  # radius of the wrapped centreline [m]
SOFT = Material(E=1e8, nu=0.4, density=1000.0)
STRAIN = 1e-3  # of the strand under the dead load
DRAG = 2000.0  # 1/s, to let the strand settle soon
# Friction feeds vibrations of a strand that is held by contact alone: bouncing needs a sink.
BOUNCE = 0.2  # of critical
RAMP = 0.01  # time over which load and then speed rise [s]
SLIDE = 5e-4  # shortest sliding before and during the measurement [m]


@dataclass(frozen=True)
class Capstan:
    """Strand wrapped on a tine, its root drawn away at a constant speed, a dead load on its tip.

    `elements` per radian of wrap, pulling `speed` [m/s], contact `stiffness` as a fraction of E:
    the strand sinks into the tine by STRAIN pi r^2/((t + r) stiffness), 0.3 r under the dead load.
    """

    friction: float = 0.3
    wrap: float = math.pi
    elements: int = 20
    safety: float = 0.75
    speed: float = 0.01
    stiffness: float = 4e-5

    @property
    def element_length(self) -> float:
        """Length of an element [m]."""
        return PATH / self.elements

    @property
    def span(self) -> float:
        """Sliding distance of the measurement [m]: whole elements, each of which ripples once."""
        return max(1, round(SLIDE / self.element_length)) * self.element_length

    @property
    def free(self) -> float:
        """Straight strand before and after the tine at the start [m]: some is left at the end."""
        return 0.25 * TINE + self.span

    @property
    def settling(self) -> float:
        """Time until the strand slides evenly [s]."""
        return 2 * RAMP + SLIDE / self.speed

    def scene(self) -> Scene:
        """Return the scene; `duration` covers settling and measurement."""
        nodes, leaving, arriving = self.path()
        rod = Rod(
            shape=Points(nodes=[(x, y, 0.0) for x, y in nodes.tolist()]),
            radius=RADIUS,
            elements=2,
            material=SOFT,
            rest="straight",
            root=End(
                hold="pinned",
                motion=Motion(velocity=_space(self.speed * leaving), start=RAMP, ramp=RAMP),
            ),
            tip=End(load=Load(force=_space(tension() * arriving), ramp=RAMP)),
        )
        tine = Tine(
            position=(0.0, 0.0, 0.0), axis=(0.0, 0.0, 1.0), length=0.05, radius=TINE, insertion=0.0
        )
        return Scene(
            title="capstan",
            rods=[rod],
            duration=self.settling + self.span / self.speed,
            contact=Contact(stiffness=self.stiffness * SOFT.E),
            friction=Friction(forward=self.friction, backward=self.friction),
            damping=Damping(drag=DRAG, tine=self.sink()),
            tines=[tine],
            rotary_inertia="element",
            safety=self.safety,
        )

    def sink(self) -> float:
        """Return the Kelvin-Voigt time of the contact that damps bouncing by BOUNCE [s]."""
        line_density = SOFT.density * math.pi * RADIUS**2
        return 2 * BOUNCE * math.sqrt(line_density / (self.stiffness * SOFT.E))

    def path(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return nodes (n, 2) [m] from root to tip, and the unit vectors out of both ends."""
        angle = np.linspace(0, self.wrap, max(2, round(self.wrap * self.elements)) + 1)
        arc = PATH * np.column_stack([np.cos(angle), np.sin(angle)])
        leaving = np.array([0.0, -1.0])
        arriving = np.array([-math.sin(self.wrap), math.cos(self.wrap)])
        count = max(1, round(self.free / self.element_length))
        distance = np.linspace(0, self.free, count + 1)[1:, None]
        nodes = [arc[0] + distance[::-1] * leaving, arc, arc[-1] + distance * arriving]
        return np.vstack(nodes), leaving, arriving

    def measure(self) -> Measurement:
        """Return the ratio of the tensions at root and tip, a mean over whole elements."""
        scene = self.scene()
        march = Explicit(scene)
        driven = march.effects.driven
        assert driven is not None
        began = time.process_time()
        march.advance(math.ceil(self.settling / march.dt))
        driven.reaction[:] = 0.0
        steps = round(self.span / self.speed / march.dt)
        march.advance(steps)
        _, leaving, _ = self.path()
        pull = -float(driven.reaction[0, :2] @ leaving) / steps
        return Measurement(
            quantity=pull / tension(),
            closed_form=self.closed_form(),
            textbook=math.exp(self.friction * self.wrap),
            steps=march.steps,
            seconds=time.process_time() - began,
        )

    def closed_form(self) -> float:
        """Return T2/T1 with everything known of this strand (docs/accuracy.md).

        Friction acts at the tine's surface, r inside of the centreline; bending takes b = B/2a^2
        off the tension that presses; drag adds g = drag rho A v per length.
        """
        drag = DRAG * SOFT.density * math.pi * RADIUS**2 * self.speed
        bend = rigidities(SOFT, RADIUS)[0] / (2 * PATH**2)
        slid = SLIDE + 0.5 * self.span
        rate = exponent(self.friction)
        arc = math.expm1(rate * self.wrap) / rate if rate > 0 else self.wrap
        arriving = tension() + drag * (self.free - slid) - bend
        leaving = arriving * math.exp(rate * self.wrap) + drag * PATH * arc + bend
        return (leaving + drag * (self.free + slid)) / tension()


def exponent(friction: float) -> float:
    """Return m in T2/T1 = exp(m phi): m = mu t/(t + r)/(1 + mu m r/(t + r))."""
    m = friction
    for _ in range(50):
        m = friction * TINE / PATH / (1 + friction * m * RADIUS / PATH)
    return m


def tension() -> float:
    """Return the dead load T1 [N]."""
    return STRAIN * SOFT.E * math.pi * RADIUS**2


def _space(vector: np.ndarray) -> tuple[float, float, float]:
    return (float(vector[0]), float(vector[1]), 0.0)
