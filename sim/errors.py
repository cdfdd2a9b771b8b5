"""What goes wrong in a simulation, said so that a lab user can act on it."""


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
    """

    def __init__(self, message: str, time: float, rod: int, element: int) -> None:
        super().__init__(message, time, rod, element)  # all of them, so that it can be pickled
        self.time, self.rod, self.element = time, rod, element

    def __str__(self) -> str:
        """Return the message alone."""
        return str(self.args[0])
