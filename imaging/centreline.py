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
NONE = np.int16(2**14)  # stands for no sample: more than there are across a strand
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
    along = np.empty((2, len(line)))
    along[:, 0], along[:, -1] = line[1] - line[0], line[-1] - line[-2]
    along[:, 1:-1] = (line[2:] - line[:-2]).T
    along /= np.maximum(np.sqrt((along**2).sum(axis=0)), 1e-9)
    return np.stack([-along[1], along[0]], axis=1)


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
    across = step * np.arange(-reach, reach + 1)[:, None]
    x, y = line.T
    along_x, along_y = normals(line).T
    profile = _looked_up(own, x + across * along_x, y + across * along_y)
    middle = _nearest_inside(profile, reach, SEARCH * width / step)
    beyond = int(np.ceil(BEYOND / step))
    found = []
    for way in (-1, 1):
        first = _first_outside(profile, middle, way)
        behind = (np.maximum(first, 0) + way * beyond).clip(0, 2 * reach)
        far = across[behind, 0]
        shown = _looked_up(strand, (x + far * along_x)[None], (y + far * along_y)[None])[0]
        hidden = shown - profile[behind, np.arange(len(line))] > 0.3
        place = (_half_way(profile, first, way) - reach) * step
        found.append(np.where((first >= 0) & ~hidden, place, np.nan))
    return found[0], found[1]


def sample(field: np.ndarray, at: np.ndarray) -> np.ndarray:
    """Return bilinear values (n, m) or (n, m, 3) of a picture at points (n, m, 2), 0 outside."""
    # cv2.remap takes pictures of at most 32767 rows
    blocks = [
        _looked_up(field, block[..., 0], block[..., 1])
        for block in np.array_split(at, len(at) // 30000 + 1)
    ]
    return np.concatenate(blocks)


def _looked_up(field: np.ndarray, x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Bilinear values of a picture at points (n, m), 0 outside."""
    parts = len(x[0]) // 30000 + 1
    blocks = [
        cv2.remap(field, u.astype(np.float32), v.astype(np.float32), cv2.INTER_LINEAR)
        for u, v in zip(np.array_split(x, parts, 1), np.array_split(y, parts, 1), strict=True)
    ]
    return blocks[0] if parts == 1 else np.concatenate(blocks, axis=1)


def _nearest_inside(profile: np.ndarray, reach: int, far: float) -> np.ndarray:
    """Index (n,) of the sample above 0.5 nearest to the middle; -1 when none within `far`."""
    off = np.arange(-reach, reach + 1, dtype=np.int16)[:, None]
    rank = 2 * np.abs(off) + (off > 0)  # from the middle outwards
    nearest = np.where(profile >= 0.5, rank, NONE).min(axis=0)
    distance = nearest // 2
    index = reach + np.where(nearest % 2, distance, -distance)
    return np.where(distance <= far, index, -1)


def _first_outside(profile: np.ndarray, middle: np.ndarray, way: int) -> np.ndarray:
    """Index (n,) of the first sample below 0.5 from the middle on, up or down; -1 when none."""
    index = np.arange(len(profile), dtype=np.int16)[:, None]
    middle = middle.astype(np.int16)
    if way > 0:
        first = np.where((profile < 0.5) & (index > middle), index, NONE).min(axis=0)
    else:
        first = np.where((profile < 0.5) & (index < middle), index, np.int16(-1)).max(axis=0)
    return np.where((middle >= 0) & (first < NONE), first, -1).astype(int)


def _half_way(profile: np.ndarray, first: np.ndarray, way: int) -> np.ndarray:
    """Index (fractional) where the profile falls through 0.5 before the sample `first`."""
    first = first.clip(1, len(profile) - 2)
    column = np.arange(len(first))
    inner, outer = profile[first - way, column], profile[first, column]
    fraction = np.divide(inner - 0.5, inner - outer, out=np.zeros_like(inner), where=inner > outer)
    return first - way + way * fraction


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
