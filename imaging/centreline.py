"""Sub-pixel centrelines: midpoints of the two half-contrast edges, smoothed along the strand."""

from collections.abc import Callable
from typing import NamedTuple

import cv2
import numpy as np
from scipy import ndimage
from scipy.interpolate import CubicSpline
from scipy.linalg import solveh_banded

ROWS = 10  # cross-sections in each strand width of length, at most one a pixel
AROUND = 20.0  # strand widths over which a strand's width is averaged
SAMPLES = 16  # across a strand's width
FINEST = 0.35  # px between samples; a picture holds no more
BEYOND = 0.75  # px beyond an edge where the background must show, or else the edge is hidden
SEARCH = 0.8  # strand widths; how far a rough centreline may be from what is seen of its strand
SHORTEST_WAVE = 4.0  # strand widths; shorter wiggles are taken for noise
# Calibrated on rendered curls (shading, highlight, blur, uneven light):
SHADING_SD = 0.018  # strand widths; both edges seen, moved by shading and highlight
ONE_EDGE_SD = 0.07  # strand widths more, where an edge is hidden
VALLEY = 0.015  # strand widths for each unit of sd in which a strand could be as well
HIDDEN_GROWTH = 0.15  # px of sd per px^1.5 of distance to the nearest visible point, over w^0.5


def arclength(line: np.ndarray) -> np.ndarray:
    """Cumulated length along a polyline, shape (n,)."""
    return np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(line, axis=0).T))])


def resample(line: np.ndarray, step: float = 1.0) -> np.ndarray:
    """Place points at equal distances (about `step`) along a polyline."""
    s = arclength(line)
    keep = np.concatenate([[True], np.diff(s) > 1e-9])
    s, line = s[keep], line[keep]
    even = np.linspace(0, s[-1], max(2, int(round(s[-1] / step)) + 1))
    return np.stack([np.interp(even, s, line[:, i]) for i in (0, 1)], axis=1)


def normals(line: np.ndarray) -> np.ndarray:
    """Return unit normals (n, 2): the tangent turned from x towards y."""
    tangent = np.gradient(line, axis=0)
    tangent /= np.maximum(np.hypot(*tangent.T), 1e-9)[:, None]
    return np.stack([-tangent[:, 1], tangent[:, 0]], axis=1)


def edges(
    line: np.ndarray, own: np.ndarray, strand: np.ndarray, width: float
) -> tuple[np.ndarray, np.ndarray]:
    """Signed distances along the normal to a strand's two edges.

    Parameters
    ----------
    line : (n, 2) array
    own : (h, w) float32 array
        Membership of the strand's colour; its edge is at 0.5.
    strand : (h, w) float32 array
        Coverage by any strand: where it stays high beyond the edge, another strand hides this one.
    width : float

    Returns
    -------
    low, high : (n,) arrays
        NaN where the edge is hidden or not found within 1.5 widths.
    """
    step = max(width / SAMPLES, FINEST)
    reach = int(np.ceil(1.5 * width / step))
    across = step * np.arange(-reach, reach + 1)
    at = line[:, None] + across[None, :, None] * normals(line)[:, None]
    profile = sample(own, at)
    other = sample(strand, at) - profile
    middle = _nearest_inside(profile, reach, SEARCH * width / step)
    beyond = int(np.ceil(BEYOND / step))
    high = _edge(profile, other, middle, beyond)
    low = _edge(profile, other, middle, -beyond)
    return (low - reach) * step, (high - reach) * step


def sample(field: np.ndarray, at: np.ndarray) -> np.ndarray:
    """Return bilinear values (n, m) or (n, m, 3) of a picture at points (n, m, 2), 0 outside."""
    points = at.astype(np.float32)
    # cv2.remap takes pictures of at most 32767 rows
    blocks = [
        cv2.remap(field, block[..., 0], block[..., 1], cv2.INTER_LINEAR)
        for block in np.array_split(points, len(points) // 30000 + 1)
    ]
    return np.concatenate(blocks)


def _nearest_inside(profile: np.ndarray, reach: int, far: float) -> np.ndarray:
    """Index of the sample above 0.5 nearest to the middle; -1 when none within `far`."""
    distance = np.abs(np.arange(profile.shape[1]) - reach)
    cost = np.where(profile >= 0.5, distance, 10**6)
    nearest = cost.argmin(axis=1)
    found = cost[np.arange(len(profile)), nearest] <= far
    return np.where(found, nearest, -1)


def _edge(profile: np.ndarray, other: np.ndarray, middle: np.ndarray, ahead: int) -> np.ndarray:
    """Index (fractional) where the profile falls through 0.5 going the way of `ahead`.

    NaN where another strand is seen `ahead` samples beyond.
    """
    way = int(np.sign(ahead))
    rows = np.arange(len(profile))
    index = np.arange(profile.shape[1])
    beyond = (index - middle[:, None]) * way > 0
    outside = beyond & (profile < 0.5)
    first = np.where(outside.any(axis=1), (outside[:, ::way].argmax(axis=1)), -1)
    first = np.where((way < 0) & (first >= 0), profile.shape[1] - 1 - first, first)
    good = (first >= 0) & (middle >= 0)
    first = np.where(good, first, 1).clip(1, profile.shape[1] - 2)
    inner, outer = profile[rows, first - way], profile[rows, first]
    fraction = np.divide(inner - 0.5, inner - outer, out=np.zeros_like(inner), where=inner > outer)
    hidden = other[rows, (first + ahead).clip(0, profile.shape[1] - 1)] > 0.3
    return np.where(good & ~hidden, first - way + way * fraction, np.nan)


class Centreline(NamedTuple):
    """A refined centreline.

    Attributes
    ----------
    line : (m, 2) array
        Points about 1 px apart.
    width, sd : (m,) arrays
        Local width, and standard deviation across the strand [px].
    edges : (m,) int array
        How many of the two edges are seen: 0 = hidden, 1, 2.
    """

    line: np.ndarray
    width: np.ndarray
    sd: np.ndarray
    edges: np.ndarray


def refine(
    line: np.ndarray,
    own: np.ndarray,
    strand: np.ndarray,
    width: float,
    *,
    rounds: int = 2,
    place: Callable[[np.ndarray, np.ndarray], tuple[np.ndarray, np.ndarray]] | None = None,
) -> Centreline:
    """Move a rough centreline (n, 2) to the middle between the strand's edges.

    Where one edge is hidden the other is used with the strand's local width; where both are
    hidden the smoothing spline bridges with least bending. `place`, if given, is asked instead for
    the offset and its relative sd wherever an edge is hidden.
    """
    step = max(1.0, width / ROWS)
    even = resample(line, step)
    smooth = _smoothed(even, np.ones(len(even)), width / step)
    for _ in range(rounds):  # again on the moved line, whose normals are better
        smooth = resample(smooth, step)
        low, high = edges(smooth, own, strand, width)
        local = _local_width(low, high, width, int(AROUND * width / step))
        offset, sd = _offsets(low, high, local)
        if place is not None:
            unsure = sd != 1
            there, spread = place(smooth, unsure)
            offset, sd = np.where(unsure, there, offset), np.where(unsure, spread, sd)
        moved = smooth + offset[:, None] * normals(smooth)
        smooth = _smoothed(moved, np.where(np.isfinite(sd), 1 / np.square(sd), 0), width / step)
    seen = np.where(np.isfinite(sd), np.isfinite(low).astype(int) + np.isfinite(high), 0)
    spread = _spread(moved, smooth, sd, seen == 2, width)
    return _dense(Centreline(smooth, local, spread, seen), step)


def _dense(found: Centreline, step: float) -> Centreline:
    """Points about 1 px apart, on the cubic through points about `step` apart."""
    if step == 1 or len(found.line) < 4:
        return found
    s = arclength(found.line)
    fine = np.linspace(0, s[-1], int(round(s[-1])) + 1)
    nearest = np.rint(np.interp(fine, s, np.arange(len(s)))).astype(int)
    width, sd = np.interp(fine, s, found.width), np.interp(fine, s, found.sd)
    return Centreline(CubicSpline(s, found.line)(fine), width, sd, found.edges[nearest])


def _local_width(low: np.ndarray, high: np.ndarray, width: float, around: int) -> np.ndarray:
    """Return the running mean of the width where both edges show, filled in elsewhere."""
    span = high - low
    known = np.isfinite(span) & (span < 1.6 * width)
    if known.sum() < 5:
        return np.full(len(span), width)
    at = np.flatnonzero(known)
    typical = np.median(span[at])
    filled = np.interp(np.arange(len(span)), at, np.clip(span[at], 0.7 * typical, 1.3 * typical))
    return ndimage.uniform_filter1d(filled, around | 1, mode="nearest")


def _offsets(low: np.ndarray, high: np.ndarray, local: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Distance to the middle and its relative sd: both edges, one edge, or none (NaN)."""
    both = np.isfinite(low) & np.isfinite(high)
    wide = both & (high - low > 1.35 * local)  # grown together with another of its colour
    narrow = both & (high - low < 0.6 * local)  # cut by another strand
    middle = np.where(np.isfinite(low), low + local / 2, high - local / 2)
    middle = np.where(both, (low + high) / 2, middle)
    sd = np.where(both, 1.0, 1.6)
    sd = np.where(wide | narrow | ~np.isfinite(middle) | (np.abs(middle) > local), np.nan, sd)
    return np.where(np.isfinite(sd), middle, 0), sd


def _smoothed(points: np.ndarray, weight: np.ndarray, width: float) -> np.ndarray:
    """Smooth evenly spaced points; half power at a wave of SHORTEST_WAVE widths [points].

    Minimises sum w |p - z|^2 + lam sum |second difference of z|^2 (Whittaker 1923), the discrete
    smoothing spline: where nothing is seen (w = 0) it bridges with least bending.
    """
    n = len(points)
    if n < 8 or (weight > 0).sum() < 5:
        return points
    # The penalty halves waves of angular frequency lam**-0.25 per sample.
    lam = (SHORTEST_WAVE * width / (2 * np.pi)) ** 4
    w = np.maximum(weight, 1e-9)
    band = np.zeros((3, n))
    band[2] = w
    for shift, coefficient in enumerate([1.0, -2.0, 1.0]):
        band[2, shift : n - 2 + shift] += lam * coefficient**2
    band[1, 1:-1] += -2 * lam
    band[1, 2:] += -2 * lam
    band[0, 2:] += lam
    return solveh_banded(band, w[:, None] * points)


def _spread(
    moved: np.ndarray, smooth: np.ndarray, sd: np.ndarray, both: np.ndarray, width: float
) -> np.ndarray:
    """Estimate the standard deviation of the smoothed centreline [px]."""
    seen = np.isfinite(sd)
    if not seen.any():
        return np.full(len(smooth), width)
    step = arclength(smooth)[-1] / max(len(smooth) - 1, 1)
    rest = ((moved - smooth) * normals(smooth)).sum(axis=1)[seen] / sd[seen]
    noise = 1.4826 * float(np.median(np.abs(rest)))
    at = np.flatnonzero(seen)
    index = np.arange(len(smooth))
    right = at[np.searchsorted(at, index).clip(0, len(at) - 1)]
    left = at[(np.searchsorted(at, index, side="right") - 1).clip(0, len(at) - 1)]
    away = np.minimum(np.abs(index - left), np.abs(right - index)) * step
    bias = width * np.where(both, SHADING_SD, np.hypot(SHADING_SD, ONE_EDGE_SD))
    growth = HIDDEN_GROWTH * away**1.5 / np.sqrt(width)
    return np.sqrt(noise**2 + bias**2 + growth**2 + (VALLEY * width * np.where(seen, sd, 0)) ** 2)
