"""What goes wrong in a simulation, said so that a lab user can act on it."""

from pathlib import Path


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
    path : Path or None
        Where the run was written as far as it was good.
    """

    users_fault = True  # the message says what to change; a traceback says nothing

    def __init__(self, message: str, time: float, rod: int, element: int) -> None:
        super().__init__(message, time, rod, element)  # all of them, so that it can be pickled
        self.time, self.rod, self.element = time, rod, element
        self.path: Path | None = None

    def __str__(self) -> str:
        """Return the message, and where to look."""
        kept = "" if self.path is None else f"; recorded up to then: {self.path}"
        return f"{self.args[0]}{kept}"
