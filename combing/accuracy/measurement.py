"""What one solution of a problem gave and what it cost."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

from sim.scene import Scene


@dataclass(frozen=True)
class Measurement:
    """One measured quantity beside what it should be.

    Attributes
    ----------
    quantity : float or None
        What was measured; None where the run became unstable or showed no such thing.
    closed_form : float or None
        Its value for an infinitely fine mesh and step, where a closed form is known.
    textbook : float or None
        The simpler law found in textbooks, which leaves known corrections out.
    place : float or None
        Displacement at which the quantity was found [m].
    steps : int
        Time steps taken.
    seconds : float
        Processor time of one core, which is the wall time where nothing else runs [s].
    d, f : list of float
        A force curve [m], dimensionless, where the problem has one.
    """

    quantity: float | None
    closed_form: float | None = None
    textbook: float | None = None
    place: float | None = None
    steps: int = 0
    seconds: float = 0.0
    d: list[float] | None = None
    f: list[float] | None = None


class Problem(Protocol):
    """A problem with its knobs as fields of a frozen dataclass."""

    def scene(self) -> Scene:
        """Return the scene to be simulated."""

    def measure(self) -> Measurement:
        """Simulate and measure."""
