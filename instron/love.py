r"""Stretching a single helix: Love's wrench that takes one helix into another.

A thin rod, naturally a helix of pitch angle :math:`\alpha` (from the plane normal to the axis) and
radius :math:`R`, has :math:`\kappa = \cos^2\alpha / R` and :math:`\tau = \sin\alpha\cos\alpha / R`.
A force F and a couple K on the axis hold it as a helix :math:`(\alpha_1, R_1)`:

.. math::
    F = \frac{1}{R_1}[C \cos\alpha_1 (\tau_1 - \tau) - B \sin\alpha_1 (\kappa_1 - \kappa)], \quad
    K = C \sin\alpha_1 (\tau_1 - \tau) + B \cos\alpha_1 (\kappa_1 - \kappa)

(A. E. H. Love, *A Treatise on the Mathematical Theory of Elasticity*, 2nd ed., section 270-271.)
The rod is inextensible and unshearable, and the wrench acts on the axis: bare rods of few turns
held by the ends of their wire are softer.
"""

from typing import Literal

import numpy as np
import pandas as pd

from instron.errors import RigError
from instron.scaling.rig import Rig

Ends = Literal["free", "blocked"]


def wrench(
    B: float, C: float, alpha: float, R: float, alpha1: np.ndarray, R1: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return axial force F [N] and couple K [N m] that hold the helix at (alpha1, R1).

    Parameters
    ----------
    B, C
        Bending and twisting rigidity [N m^2].
    alpha, R
        Natural pitch angle [rad] and radius [m].
    alpha1, R1
        Held pitch angle and radius.
    """
    bend = np.cos(alpha1) ** 2 / R1 - np.cos(alpha) ** 2 / R
    twist = np.sin(alpha1) * np.cos(alpha1) / R1 - np.sin(alpha) * np.cos(alpha) / R
    force = (C * np.cos(alpha1) * twist - B * np.sin(alpha1) * bend) / R1
    couple = C * np.sin(alpha1) * twist + B * np.cos(alpha1) * bend
    return force, couple


def free_radius(B: float, C: float, alpha: float, R: float, alpha1: np.ndarray) -> np.ndarray:
    """Return the radius at which the couple vanishes: the ends turn freely (K = 0)."""
    s, c = np.sin(alpha1), np.cos(alpha1)
    kappa, tau = np.cos(alpha) ** 2 / R, np.sin(alpha) * np.cos(alpha) / R
    return c * (C * s**2 + B * c**2) / (C * s * tau + B * c * kappa)


def blocked_radius(alpha: float, R: float, alpha1: np.ndarray) -> np.ndarray:
    """Return the radius at which the number of turns is the natural one: the ends cannot turn."""
    return R * np.cos(alpha1) / np.cos(alpha)


def love_force(
    B: float, C: float, alpha: float, R: float, alpha1: np.ndarray, ends: Ends = "free"
) -> np.ndarray:
    """Return the axial force [N] that stretches the helix to pitch angle ``alpha1`` [rad]."""
    alpha1 = np.asarray(alpha1, dtype=float)
    R1 = free_radius(B, C, alpha, R, alpha1) if ends == "free" else blocked_radius(alpha, R, alpha1)
    return wrench(B, C, alpha, R, alpha1, R1)[0]


def pitch_angle(pitch: float, R: float) -> float:
    """Return the pitch angle [rad], ``tan(alpha) = P / (2 pi R)``."""
    return float(np.arctan2(pitch, 2 * np.pi * R))


def theory_curve(
    rig: Rig,
    active_length: float,
    D: float,
    *,
    ends: Ends = "free",
    f_limit: float = np.inf,
    points: int = 400,
) -> pd.DataFrame:
    """Return f(x) of stretching one helix by the tine's displacement.

    Parameters
    ----------
    rig
        Needs ``pitch`` and ``helix_radius`` besides the rigidity.
    active_length
        Natural height of the part of the helix that is stretched [m], e.g. pitch times turns. For
        nearly straight helices it decides the curve, so there is no default.
    D
        Displacement at x = 1 [m]: that of the experiment the curve is laid over.
    ends
        ``"free"`` to turn, or ``"blocked"``.
    f_limit
        The curve ends where f passes this; the force diverges as the helix straightens.
    points
        Rows.

    Returns
    -------
    DataFrame
        ``x``, ``f``, ``d`` [m], ``F`` [N]; ``attrs`` hold ``alpha``, ``max_stretch`` [m].

    Raises
    ------
    RigError
        When the rig does not describe a helix, or a length is not positive.
    """
    if rig.pitch is None or rig.helix_radius is None:
        raise RigError("the theory curve needs 'pitch' and 'helix_radius' in the rig")
    if active_length <= 0 or D <= 0:
        raise RigError(f"active length {active_length:g} m and D {D:g} m must be positive")
    alpha = pitch_angle(rig.pitch, rig.helix_radius)
    contour = active_length / np.sin(alpha)
    furthest = min(D, contour * (1 - np.sin(alpha)) * (1 - 1e-9))
    # Cluster the points where the force diverges.
    d = furthest * (1 - (1 - np.linspace(0, 1, points)) ** 3)
    alpha1 = np.arcsin(np.sin(alpha) + d / contour)
    F = love_force(rig.rigidity, rig.twisting, alpha, rig.helix_radius, alpha1, ends)
    f = rig.l0**2 / rig.rigidity * F
    curve = pd.DataFrame({"x": d / D, "f": f, "d": d, "F": F})[f <= f_limit]
    curve.attrs = {"alpha": alpha, "max_stretch": contour * (1 - np.sin(alpha)), "ends": ends,
                   "active_length": active_length, "D": D}  # fmt: skip
    return curve
