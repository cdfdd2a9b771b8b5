"""The largest stable time step of the explicit march, from the scene's fastest modes."""

import numpy as np
from numpy.typing import NDArray

from sim.errors import SceneError
from sim.march.state import State
from sim.scene import Scene

Array = NDArray[np.float64]
SHEAR, AXIAL, BENDING, SPRING = "shear rotation", "axial wave", "bending", "contact spring"
TWIST = "twist wave"


def stable_step(
    state: State,
    stiffness: float | None = None,
    viscous: float | None = None,
    tine: float | None = None,
) -> float:
    """Return the stability limit of position Verlet for these rods [s].

    With 2/dt = omega the three stiffest motions of an element add up,

        1/dt^2 = alpha G/(rho r^2) + E/(rho l^2) + k/(rho A),

    shear rotation, the fastest wave of the mesh, axial, bending or twist, and a contact of line
    stiffness k on either side (all generalised to the inertia in use). Kelvin-Voigt damping of time
    T shortens it: with z = T/dt the damping of that mode, dt <- dt (sqrt(1 + z^2) - z). That of the
    contact with tines, of time T', adds T' dt k/(2 rho A) to z: an element between two of them.

    Parameters
    ----------
    state : State
        Rods laid out.
    stiffness : float or None
        Line stiffness k of contact [N/m^2].
    viscous : float or None
        Kelvin-Voigt time T [s].
    tine : float or None
        Kelvin-Voigt time T' of the contact with tines [s].
    """
    parts = modes(state, stiffness)
    total = together(parts)
    real = total > 0  # ghosts are not
    limits = 1 / np.sqrt(total[real])
    return float(np.min(limits * damped(viscous, limits, tine, parts[SPRING][real])))


def modes(state: State, stiffness: float | None = None) -> dict[str, Array]:
    """Return what each stiff motion of an element adds to 1/dt^2 [1/s^2], (n,) each."""
    length, inverse = state.row("LENGTH"), state.row("INV_LENGTH")
    line_density = np.full(state.n, np.inf)
    for rod, count in enumerate(state.elements):
        at = slice(state.first[rod], state.first[rod] + count)
        total = state.row("MASS")[state.nodes(rod)].sum()
        line_density[at] = total / length[at].sum()
    springs = state.row("BEND") * state.row("INV_VORONOI")
    # A clamp's spring is as short as half an element but stiffens one side only: measured, no worse
    # than an inner one (benchmarks/sim_stability.py).
    springs = np.where(state.row("INV_MASS") > 0, springs, 0.5 * springs)
    twists = springs * np.divide(
        state.row("TWIST"), state.row("BEND"), out=np.zeros(state.n), where=state.row("BEND") > 0
    )
    return {
        SHEAR: state.row("SHEAR") * length * state.row("INV_J1") / 4,
        AXIAL: state.row("STRETCH") * inverse**2 / line_density,
        BENDING: 0.5 * (springs + np.roll(springs, -1)) * state.row("INV_J1"),
        # Slower than the axial wave, unless that is slowed down (`sim.march.softness`).
        TWIST: 0.5 * (twists + np.roll(twists, -1)) * state.row("INV_J3"),
        SPRING: (stiffness or 0.0) / line_density,
    }


def together(parts: dict[str, Array]) -> Array:
    """Return 1/dt^2 of all modes at once [1/s^2]: the mesh's waves exclude each other."""
    waves = np.maximum(np.maximum(parts[AXIAL], parts[BENDING]), parts[TWIST])
    return parts[SHEAR] + waves + parts[SPRING]


def damped(
    viscous: float | None, dt: Array | float, tine: float | None, spring: Array | float
) -> Array | float:
    """Return the factor by which Kelvin-Voigt times [s] shorten stability limits dt [s].

    `spring` is what a contact adds to 1/dt^2 [1/s^2].
    """
    z = (viscous or 0.0) / dt + 0.5 * (tine or 0.0) * spring * dt
    return (1 + z * z) ** 0.5 - z


def choose_step(scene: Scene, limit: float) -> float:
    """Return the time step to use: the scene's own if it is below the limit, else safety * limit.

    Raises
    ------
    SceneError
        The scene asks for a step above the limit.
    """
    if scene.time_step is None:
        return scene.safety * limit
    if scene.time_step > limit:
        raise SceneError(
            f"time_step = {scene.time_step:g} s: above the stability limit {limit:.3g} s of this "
            "scene; leave it out and the program chooses"
        )
    return scene.time_step
