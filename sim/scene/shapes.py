"""Centrelines of rods and the frames and rest curvatures that go with them."""

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

Array = NDArray[np.float64]

KNOTS = 16  # of a random curvature to a correlation length


def straight(root: Array, direction: Array, length: float, elements: int) -> Array:
    """Return the (elements + 1, 3) nodes [m] of a straight rod."""
    unit = np.asarray(direction, float) / np.linalg.norm(direction)
    return np.asarray(root, float) + np.linspace(0, length, elements + 1)[:, None] * unit


def helix(
    radius: float,
    pitch: float,
    height: float,
    elements: int,
    phase: float = 0.0,
    *,
    left: bool = False,
) -> Array:
    """Return nodes [m] of a right-handed helix that hangs from z = 0 down to z = -height.

    The nodes lie a little outside `radius`, where the chords between them have `radius` as their
    mean distance from the axis; with the nodes on the helix two strands in contact would overlap.

    Parameters
    ----------
    radius, pitch, height : float
        Radius and pitch of the helix and its extent along the axis [m].
    elements : int
        Number of chords.
    phase : float
        Angle of the root about the axis [rad].
    left : bool
        Left-handed instead: the mirror image in the plane y = 0.
    """
    turns = np.linspace(0, height / pitch, elements + 1)
    step = 2 * np.pi * turns[1]
    # Mean of sqrt(1 - 4 s (1 - s) sin^2(step/2)) over the chord, to second order in step.
    outside = radius * (1 + step**2 / 12)
    angle = 2 * np.pi * turns + phase
    across = (1 if left else -1) * outside * np.sin(angle)
    return np.column_stack([outside * np.cos(angle), across, -pitch * turns])


def frames(nodes: Array) -> Array:
    """Return the (n, 3, 3) frames of a polyline without twist, rows d1, d2, d3 = tangent.

    Each frame is the one before, turned by the smallest rotation that takes one tangent to the
    next (parallel transport; Bishop, Am. Math. Mon. 82, 246 (1975)).
    """
    tangents = np.diff(nodes, axis=0)
    tangents /= np.linalg.norm(tangents, axis=1, keepdims=True)
    seed = np.eye(3)[np.argmin(np.abs(tangents[0]))]
    first = np.cross(tangents[0], seed)
    first /= np.linalg.norm(first)
    result = np.empty((len(tangents), 3, 3))
    result[0] = first, np.cross(tangents[0], first), tangents[0]
    for i in range(1, len(tangents)):
        result[i] = result[i - 1] @ smallest_turn(tangents[i - 1], tangents[i]).T
    return result


def smallest_turn(a: Array, b: Array) -> Array:
    """Return the rotation matrix that takes unit vector a to unit vector b the short way."""
    axis, cosine = np.cross(a, b), float(a @ b)
    skew = np.array([[0, -axis[2], axis[1]], [axis[2], 0, -axis[0]], [-axis[1], axis[0], 0]], float)
    return np.eye(3) + skew + skew @ skew / max(1 + cosine, 1e-12)


def curvature(directors: Array, voronoi: Array) -> Array:
    """Return (n - 1, 3) curvatures and twist [1/m] in the body frame, log(Q_i Q_{i-1}^T)/D.

    Parameters
    ----------
    directors : (n, 3, 3)
        Rows d1, d2, d3 of every element.
    voronoi : (n - 1,)
        Length that belongs to each inner vertex [m].
    """
    turns = directors[1:] @ directors[:-1].transpose(0, 2, 1)
    return -Rotation.from_matrix(turns).as_rotvec() / voronoi[:, None]


def random_curvature(
    lengths: Array, sd: float, correlation: float, *, rng: np.random.Generator
) -> Array:
    """Draw (n + 1, 2) intrinsic curvatures about d1 and d2 [1/m] for the nodes of a rod.

    A stationary Gaussian process of arclength with correlation exp(-|s|/correlation), drawn at
    `KNOTS` to a correlation length from the root on (Ornstein-Uhlenbeck, exact update) and linear
    between them. A node has its mean over the part of the rod that is nearest, half an element at
    the ends: the same draws are the same hair on every mesh. With ``correlation=0`` every inner
    node is drawn on its own, as in the paper; that is another hair on another mesh.

    Parameters
    ----------
    lengths : (n,)
        Lengths of the elements [m].
    sd : float
        Standard deviation of each component, over the whole process [1/m].
    correlation : float
        Correlation length [m].
    rng : numpy.random.Generator
    """
    if correlation == 0:
        inner = sd * rng.standard_normal((len(lengths) - 1, 2))
        return np.concatenate([np.zeros((1, 2)), inner, np.zeros((1, 2))])
    ends = np.concatenate([[0.0], np.cumsum(lengths)])
    parts = np.concatenate([[0.0], 0.5 * (ends[1:] + ends[:-1]), ends[-1:]])
    knots = np.arange(int(np.ceil(KNOTS * ends[-1] / correlation)) + 2) * correlation / KNOTS
    keep = np.exp(-1 / KNOTS)
    draws = rng.standard_normal((len(knots), 2))
    for i in range(1, len(draws)):
        draws[i] = keep * draws[i - 1] + np.sqrt(1 - keep**2) * draws[i]
    # Between knots the variance sags: (2 + keep)/3 of theirs is its mean.
    turned = sd / np.sqrt((2 + keep) / 3) * np.stack([_integral(parts, knots, x) for x in draws.T])
    return (np.diff(turned) / np.diff(parts)).T


def _integral(at: Array, knots: Array, values: Array) -> Array:
    """Return the integral from the first of evenly spaced knots of what is linear between."""
    before = np.concatenate([[0.0], np.cumsum(np.diff(knots) * (values[1:] + values[:-1]) / 2)])
    k = np.minimum((at / knots[1]).astype(int), len(knots) - 2)
    return before[k] + (at - knots[k]) * (values[k] + np.interp(at, knots, values)) / 2
