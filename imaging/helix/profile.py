"""Where an edge lies in the light across it: a blurred step between two straight slopes.

A tube is shaded: towards its outline its light falls, on the side away from the lamp to a fraction.
Before a dark ground half the light is then passed far inside the outline, by as much as a quarter
of the radius. The step itself is where it should be, so a step on a slope is fitted.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.ndimage import gaussian_filter1d
from scipy.special import ndtr

Array = np.ndarray
BLURS = (0.5, 0.7, 0.9, 1.1, 1.4, 1.8, 2.3, 3.0)  # px
STEP = 0.25  # px between places tried
OUTSIDE = 3.0  # px looked at beyond the edge
POOL = 3.0  # px along the edge over which light is averaged
CLEAR = 4.0  # times the scatter about the fit that a step must be high


@dataclass(frozen=True)
class Profiles:
    """Light across an edge, in sections along it.

    Attributes
    ----------
    x : (m,) array
        Places across the edge [px], outward > 0, 0 where the edge is expected.
    light : (n, m, c) array
        Light there.
    rows : (n,) int array
        Number of each section; those of successive numbers are neighbours.
    lit : bool
        Whether what lies beyond is shaded too (a strand), or even (the ground).
    """

    x: Array
    light: Array
    rows: np.ndarray
    lit: bool

    @cached_property
    def along(self) -> Array:
        """Light (n, m) along the colour in which the two sides differ, of neighbours together."""
        return _pooled(_contrast(self), self.rows)


def sampled_places(inside: float, gate: float) -> Array:
    """Places x [px] across an edge, outward > 0, for a search within ``gate`` of x = 0."""
    return np.arange(-inside - gate, OUTSIDE + gate + 0.25, 0.5)


def edge_places(
    profiles: Profiles, inside: float, blur: float, stride: int = 1
) -> tuple[Array, Array]:
    """Place of the edge in each profile [px], NaN where none is clear, and the least mean square.

    Parameters
    ----------
    profiles : Profiles
    inside : float
        How far inside the edge light is looked at [px].
    blur : float
        Standard deviation of the picture's blur [px].
    stride : int
        Look at one in so many profiles.
    """
    x, y = profiles.x, profiles.along[::stride]
    gate = float(x[-1]) - OUTSIDE - 0.25
    tried = np.arange(-gate, gate + STEP / 2, STEP)
    cost, height = np.empty((2, len(y), len(tried)))
    for k, place in enumerate(tried):
        u = x - place
        seen = slice(*np.searchsorted(u, [-inside - 0.01, OUTSIDE + 0.01]))
        cost[:, k], height[:, k] = _misfit(y[:, seen], u[seen], blur, profiles.lit)
    return _least(cost, height, tried), cost.min(axis=1)


def likely_blur(every: list[Profiles], inside: float) -> float:
    """Blur [px] with which steps fit typical edges best."""
    misfits = [
        np.median(np.concatenate([edge_places(p, inside, blur, int(POOL))[1] for p in every]))
        for blur in BLURS
    ]
    return BLURS[int(np.argmin(misfits))]


def _contrast(profiles: Profiles) -> Array:
    """Light (n, m) along the colour in which the two sides of the edge differ."""
    light, x = profiles.light, profiles.x
    sides = [light[:, (x > a) & (x < b)].mean(axis=1) for a, b in ((-3.5, -1.0), (1.0, 3.5))]
    way = _pooled(sides[0] - sides[1], profiles.rows)
    way /= np.maximum(np.linalg.norm(way, axis=1, keepdims=True), 1e-9)
    return np.einsum("nmc,nc->nm", light, way)


def _pooled(values: Array, rows: np.ndarray) -> Array:
    """Mean over neighbouring rows."""
    full, count = np.zeros((rows[-1] + 1, values.shape[1])), np.zeros((rows[-1] + 1, 1))
    full[rows], count[rows] = values, 1.0
    full, count = (gaussian_filter1d(v, POOL, axis=0, mode="constant") for v in (full, count))
    return (full / np.maximum(count, 1e-9))[rows]


def _misfit(y: Array, u: Array, blur: float, lit: bool) -> tuple[Array, Array]:
    """Mean square about the best blurred step at u = 0 between slopes, and the step's height."""
    step = ndtr(-u / blur)
    inwards = blur * np.exp(-0.5 * (u / blur) ** 2) / np.sqrt(2 * np.pi) - u * step
    columns = [step, np.ones_like(u), inwards] + ([inwards + u] if lit else [])
    q, r = np.linalg.qr(np.stack(columns, axis=1))
    found = y @ q
    # What orthogonal columns leave: the difference is exact to 1e-15 of y^2, noise is 1e-5 of it.
    left = np.einsum("ij,ij->i", y, y) - np.einsum("ij,ij->i", found, found)
    return np.maximum(left, 0.0) / len(u), found @ np.linalg.inv(r)[0]


def _least(cost: Array, height: Array, tried: Array) -> Array:
    """Place of the least cost, by a parabola; NaN at the ends and where the step is not clear."""
    k = cost.argmin(axis=1)
    inner = (k > 0) & (k < len(tried) - 1)
    k, i = np.clip(k, 1, len(tried) - 2), np.arange(len(k))
    before, here, after = cost[i, k - 1], cost[i, k], cost[i, k + 1]
    bend = before - 2 * here + after
    place = tried[k] + 0.5 * STEP * (before - after) / np.maximum(bend, 1e-15)
    clear = height[i, k] > CLEAR * np.sqrt(here)
    return np.where(inner & clear & (bend > 0), place, np.nan)
