"""A cantilever under an end load against Timoshenko's closed form."""

from __future__ import annotations

import math
import time
from dataclasses import dataclass

from combing.accuracy.measurement import Measurement
from sim.explicit import Explicit
from sim.march.state import rigidities
from sim.scene import Damping, End, Load, Material, Rod, Scene, Straight

LENGTH, RADIUS = 0.1, 0.02  # m; so short that shear is a tenth of the deflection
RUBBER = Material(E=1e6, nu=0.5, density=1000.0)
SLOPE = 1e-4  # deflection over length: the closed form is linear, its error the square of this
SETTLED = 25.0  # in 1/omega of the first mode, critically damped: exp(-25) is left


@dataclass(frozen=True)
class Cantilever:
    """Straight rod clamped at its root, a force across its tip, at rest in the end."""

    elements: int = 16
    safety: float = 0.75

    def scene(self) -> Scene:
        """Return the scene; drag damps the first mode critically."""
        omega = 1.8751041**2 * math.sqrt(bending() / (line_density() * LENGTH**4))
        rod = Rod(
            shape=Straight(direction=(1.0, 0.0, 0.0), length=LENGTH),
            radius=RADIUS,
            elements=self.elements,
            material=RUBBER,
            tip=End(load=Load(force=(0.0, 0.0, -SLOPE * LENGTH / compliance(shear=True)))),
        )
        return Scene(
            title="cantilever",
            rods=[rod],
            duration=SETTLED / omega,
            damping=Damping(drag=2 * omega),
            safety=self.safety,
        )

    def measure(self) -> Measurement:
        """Return the deflection of the tip [m] once the rod has come to rest."""
        scene = self.scene()
        march = Explicit(scene)
        began = time.process_time()
        march.advance(math.ceil(scene.duration / march.dt))
        force = SLOPE * LENGTH / compliance(shear=True)
        return Measurement(
            quantity=-float(march.state.strands()[0][-1, 2]),
            closed_form=force * compliance(shear=True),
            textbook=force * compliance(shear=False),
            steps=march.steps,
            seconds=time.process_time() - began,
        )


def compliance(*, shear: bool) -> float:
    """Return tip deflection over force [m/N]: L^3/(3 E I) + L/(alpha G A), or Euler's first term.

    Timoshenko, Phil. Mag. 41, 744 (1921).
    """
    area = math.pi * RADIUS**2
    slide = LENGTH / (RUBBER.shear_coefficient * RUBBER.shear_modulus * area) if shear else 0.0
    return LENGTH**3 / (3 * bending()) + slide


def bending() -> float:
    """Return B = E I [N m^2]."""
    return rigidities(RUBBER, RADIUS)[0]


def line_density() -> float:
    """Return rho A [kg/m]."""
    return RUBBER.density * math.pi * RADIUS**2
