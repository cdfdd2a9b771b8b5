"""Phase behind a tine, where the strands hang apart: how far, on which side, and who is in front.

Half the vector from strand b to strand a has two parts. h = R cos(phi) lies in the picture: half
the distance between the strands' middles. v = R sin(phi) points to the viewer and is not seen, but
its sign is, where they overlap, and both are known where edges are followed. No view is special, so
v bends as h does: both are cubic smoothing splines (integrated Brownian motion) of the scale of h.
Draws of them, pushed out where the strands would run into each other (R < r), give phase and sd.
"""

from dataclasses import dataclass, replace

import numpy as np

from imaging.helix.axis import Axis, sample
from imaging.helix.count import Look, look, strand_radius
from imaging.helix.measurement import BY_SIDES, DRAWN_SD, HelixMeasurement

Array = np.ndarray
Mask = np.ndarray
REACH = 10.0  # strand radii to either side that are looked at
DRAWS = 200
OVERLAP = 0.7  # strand radii of h; strands nearer to each other show who is in front
CLEAR = 0.2  # of a strand's width, by which the front one must show more
CLOSE = (1.7, 0.7)  # strand radii; R and its sd where strands overlap
BESIDE = (3.0, 1.5)  # strand radii; |v| and its sd where something hides the rear strand
PARTED = (
    1.5,
    0.45,
)  # rad, and pitches before a tine; the phase's sd there beside that of its draws
SEEN = 0.05  # strand radii; error of h where both are seen
WOUND = 1.5  # times as many turns a length as before combing, ahead of a tine
HIDDEN = 0.5  # pitch; over more than that whole turns may be hidden


@dataclass(frozen=True)
class Held:
    """What is known of one part of the vector: values (n,) [px] and their weights [1/px^2]."""

    value: Array
    weight: Array


def with_sides(found: HelixMeasurement, membership: np.ndarray, axis: Axis) -> HelixMeasurement:
    """Fill in lambda from the root to the tine and on to where edges or counts resolve it.

    Each value is the mean over a pitch that is cut at the tine; `phase` says ``by`` sides. Where
    more than half a pitch shows nothing, what was found is returned as it is.

    Parameters
    ----------
    found : HelixMeasurement
    membership : (2, h, w) array
        Coverage of both strands.
    axis : Axis
        The axis along which `found` was measured.
    """
    t, known = found.phase.attrs["knot_s"], found.phase["resolved"].to_numpy()
    if found.tine is None:
        return found
    tine = float(np.interp(found.tine, found.phase["s"], t))
    pitch, r = found.pitch / found.length_per_pixel, found.r / found.length_per_pixel
    ahead = np.flatnonzero(known & (t > tine))
    if not len(ahead) or known[: ahead[0]].all():
        return found
    g = np.arange(0.0, min(t[ahead[0]] + pitch, axis.s[-1]), 0.5 * r)
    seen, r = _look(membership, axis, g, r)
    level, depth, lost = _held(seen, found, g, r)
    if _longest(lost) * g[1] > HIDDEN * pitch:
        return found
    scale, rng = _scale(level.value, level.weight > 0, g, r, pitch, tine), np.random.default_rng(0)
    h, v = (_draws(part, g[1], scale, rng) for part in (level, depth))
    rows = np.flatnonzero(~known[: ahead[0]] & (np.interp(t[: ahead[0]], g, lost) < 0.5))
    # How far strands part towards the viewer before a tine is not seen: up to a radian and more.
    near = np.where(g < tine, PARTED[0] * np.exp(-(((tine - g) / (PARTED[1] * pitch)) ** 2)), 0.0)
    phi = _phase(h, v, r)
    off = rng.standard_normal((DRAWS, 1))
    phi[1:] += near * (off - off.mean())
    return _filled(found, g, phi, np.hypot(h, v), rows, (tine, pitch, t[ahead[0]]))


def _look(membership: np.ndarray, axis: Axis, g: Array, r: float) -> tuple[Look, float]:
    """See sides and visible widths at arclengths ``g``, and the strand radius [px]."""
    rows = np.minimum(np.rint(g).astype(int), len(axis.s) - 1)
    some = Axis(*(part[rows] for part in (axis.s, axis.points, axis.tangents, axis.normals)))
    u = np.arange(-REACH * r, REACH * r + 0.5, 0.5)
    profiles = sample(membership, some, u)
    r = strand_radius(profiles, u)
    return look(some.s, u, profiles, r), r


def _held(seen: Look, found: HelixMeasurement, g: Array, r: float) -> tuple[Held, Held, Mask]:
    """Find what is known of h and of v at ``g``, and where nothing is."""
    h, front = 0.5 * seen.separation, seen.excess / (2 * r)
    alone = np.isnan(h) | ((h == 0) & (np.abs(front) > 0.5))
    hidden = _hidden(alone, h, 1.2 * r) | (np.isnan(h) & (front == 0))
    h = np.where(hidden, 0.0, np.nan_to_num(h))
    level = Held(h, np.where(hidden, 0.0, 1 / (SEEN * r + 0.3 * r * alone) ** 2))
    close = ~hidden & (np.abs(h) < OVERLAP * r) & (np.abs(front) > CLEAR)
    size = np.sqrt(np.maximum((CLOSE[0] * r) ** 2 - h**2, 0.0))
    # Neighbours, half a radius apart, tell the same.
    value, weight = np.sign(front) * size, np.where(close, 0.5 / (CLOSE[1] * r) ** 2, 0.0)
    for first, end in _runs(hidden & (np.abs(front) > 0.5)):
        value[first:end] = BESIDE[0] * r * np.sign(front[first:end])
        weight[first:end] = 1 / ((BESIDE[1] * r) ** 2 * (end - first))
    t, inside = found.phase.attrs["knot_s"], found.phase["resolved"].to_numpy()
    fitted = np.interp(g, t, inside.astype(float)) > 0.99
    phi, R = (np.interp(g, t[inside], found.phase[name][inside]) for name in ("phi", "R"))
    R, sure = R / found.length_per_pixel, 1 / (SEEN * r) ** 2
    return (
        Held(np.where(fitted, R * np.cos(phi), h), np.where(fitted, sure, level.weight)),
        Held(np.where(fitted, R * np.sin(phi), value), np.where(fitted, sure, weight)),
        (level.weight == 0) & (weight == 0) & ~fitted,
    )


def _hidden(alone: Mask, h: Array, least: float) -> Mask:
    """Find where something hides a strand: sides do not swap there, and lie apart beside it."""
    found = np.zeros_like(alone)
    for first, end in _runs(alone):
        beside = np.array([h[k] for k in (first - 1, end) if 0 <= k < len(h)])
        crossing = len(beside) == 2 and beside.prod() < 0
        found[first:end] = not crossing and not (np.abs(beside) < least).all()
    return found


def _runs(mask: Mask) -> np.ndarray:
    return np.flatnonzero(np.diff(np.r_[0, mask.astype(int), 0])).reshape(-1, 2)


def _longest(mask: Mask) -> int:
    return int(np.diff(_runs(mask), axis=1).max(initial=0))


def _scale(h: Array, seen: Mask, g: Array, r: float, pitch: float, tine: float) -> Array:
    """Intensity (n - 2,) [1/px] of the white noise that h'' is.

    Behind the tine from second differences over half a pitch, ahead of it that of a helix in
    contact, wound half as tightly again.
    """
    step, behind = g[1], g < tine
    lag = max(int(pitch / 2 / step), 1)
    known = seen & behind
    both = known[2 * lag :] & known[lag:-lag] & known[: -2 * lag]
    bend = h[2 * lag :] - 2 * h[lag:-lag] + h[: -2 * lag]
    square = np.mean(bend[both] ** 2) if both.any() else 8 * r**2
    wound = 8 * r**2 * WOUND**4
    return 1.5 * np.where(behind, square, wound)[1:-1] / (lag * step) ** 3


def _draws(held: Held, step: float, scale: Array, rng: np.random.Generator) -> Array:
    """Most likely curve and DRAWS draws (1 + DRAWS, n) of a smoothing spline."""
    n = len(held.value)
    bend = np.diff(np.eye(n), 2, axis=0)
    precision = bend.T @ (bend / (scale * step**3)[:, None]) + np.diag(held.weight + 1e-9)
    root = np.linalg.cholesky(precision)
    mean = np.linalg.solve(precision, held.weight * held.value)
    noise = np.linalg.solve(root.T, rng.standard_normal((n, DRAWS)))
    return np.vstack([mean, mean + noise.T])


def _phase(h: Array, v: Array, r: float) -> Array:
    """Phase of strands that do not run into each other."""
    least = np.sqrt(np.maximum(r**2 - h**2, 0.0))
    return np.unwrap(np.arctan2(np.where(v < 0, -1, 1) * np.maximum(np.abs(v), least), h), axis=1)


def _filled(
    found: HelixMeasurement,
    g: Array,
    phi: Array,
    R: Array,
    rows: np.ndarray,
    where: tuple[float, float, float],
) -> HelixMeasurement:
    """Put phase, radius and link into rows; where: tine, pitch, first that is known [px]."""
    (tine, pitch, end), per_pixel = where, found.length_per_pixel
    t, s = found.phase.attrs["knot_s"], found.phase["s"].to_numpy()
    anchor = np.interp(end, t, found.phase["phi"]) - _at(phi, g, np.array([end]))
    phi = phi + 2 * np.pi * np.rint(anchor / (2 * np.pi))
    low, high = t[rows] - pitch / 2, t[rows] + pitch / 2
    low = np.maximum(low, np.where(t[rows] < tine, 0.0, tine))
    high = np.minimum(high, np.where(t[rows] < tine, tine, end))
    length = np.interp(high, t, s) - np.interp(low, t, s)
    turns = (_at(phi, g, high) - _at(phi, g, low)) / (2 * np.pi)
    sd = np.hypot(turns[1:].std(axis=0), np.sqrt(2) * DRAWN_SD / (2 * np.pi))
    phase, density = found.phase.copy(), found.link_density.copy()
    angle, radius = _at(phi, g, t[rows]), per_pixel * _at(R, g, t[rows])
    columns = {
        "phi": angle.mean(axis=0), "sd": np.hypot(angle.std(axis=0), DRAWN_SD),
        "R": radius.mean(axis=0), "R_sd": radius.std(axis=0), "resolved": True, "by": BY_SIDES,
    }  # fmt: skip
    for name, value in columns.items():
        phase.loc[rows, name] = value
    link = turns.mean(axis=0) / length
    density.loc[rows, "link"] = link
    density.loc[rows, "sd"] = np.hypot(sd / length, link * found.length_sd)
    return replace(found, phase=phase, link_density=density, draws=(g, phi[1:]))


def _at(curves: Array, g: Array, t: Array) -> Array:
    """Curves (m, len(g)) at other arclengths."""
    return np.array([np.interp(t, g, curve) for curve in curves])
