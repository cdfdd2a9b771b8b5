"""What goes wrong in a simulation, said so that a lab user can act on it."""

from __future__ import annotations

from pathlib import Path
from typing import Any


class SceneError(ValueError):
    """A scene cannot be simulated as written; the message names the key, its value and the cure."""

    users_fault = True


class Unstable(RuntimeError):
    """A run left the range in which its time step resolves the motion.

    Attributes
    ----------
    time : float
        When it happened [s].
    rod, element : int
        Where the speed was largest.
    effect, mode : str
        What drove it there: an effect of the scene, and the motion of the mesh it excited.
    partner : (int, int) or None
        Rod and element on the other side, where two pass through each other.
    path : Path or None
        Where the run was written as far as it was good.
    """

    users_fault = True  # the message says what to change; a traceback says nothing

    def __init__(
        self,
        message: str,
        time: float,
        rod: int,
        element: int,
        effect: str,
        mode: str,
        partner: tuple[int, int] | None = None,
    ) -> None:
        # All of them, so that it can be pickled.
        super().__init__(message, time, rod, element, effect, mode, partner)
        self.time, self.rod, self.element = time, rod, element
        self.effect, self.mode, self.partner = effect, mode, partner
        self.path: Path | None = None

    def __str__(self) -> str:
        """Return the message, and where to look."""
        kept = "" if self.path is None else f"; recorded up to then: {self.path}"
        return f"{self.args[0]}{kept}"


class NotAtRest(RuntimeError):
    """A scene that should have come to rest within its duration has not.

    Attributes
    ----------
    run : Run
        What was recorded; its last snapshot is the state it came to.
    """

    users_fault = True

    def __init__(self, run: Any) -> None:
        super().__init__(run)
        self.run = run

    def __str__(self) -> str:
        """Return how far it is from rest, and where."""
        return f"{self.run.unrest()}; give it a longer duration or more drag"
