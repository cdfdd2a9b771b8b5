"""Sub-pixel centrelines: midpoints of the two half-contrast edges, smoothed along the strand."""

from collections.abc import Callable, Sequence
from typing import NamedTuple

import cv2
import numpy as np
from scipy import ndimage
from scipy.interpolate import CubicSpline
from scipy.linalg import solveh_banded

from imaging.trace.bundle import Bundle, bundled, normals_of, resampled

ROWS = 10  # cross-sections in each strand width of length, at most one a pixel
AROUND = 20.0  # strand widths over which a strand's width is averaged
SAMPLES = 16  # across a strand's width
FINEST = 0.35  # px between samples; a picture holds no more
BEYOND = 0.75  # px beyond an edge where the background must show, or else the edge is hidden
AGAIN = 3.0  # strand widths around a hidden edge in which placing the strand moves its line
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
    along = np.empty((2, len(line)))
    along[:, 0], along[:, -1] = line[1] - line[0], line[-1] - line[-2]
    along[:, 1:-1] = (line[2:] - line[:-2]).T
    along /= np.maximum(np.sqrt((along**2).sum(axis=0)), 1e-9)
    return np.stack([-along[1], along[0]], axis=1)


def edges(
    line: np.ndarray,
    own: np.ndarray,
    strand: np.ndarray,
    width: float,
    normal: np.ndarray | None = None,
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
    normal : (n, 2) array, optional
        Unit normals; by default those of the line.

    Returns
    -------
    low, high : (n,) arrays
        NaN where the edge is hidden or not found within 1.5 widths.
    """
    step = max(width / SAMPLES, FINEST)
    reach = int(np.ceil(1.5 * width / step))
    across = step * np.arange(-reach, reach + 1)
    normal = normals(line) if normal is None else normal
    profile = _aside(own, line, normal, across[:, None])
    outside = np.ascontiguousarray((profile < 0.5).T)
    middle = _nearest_inside(outside, SEARCH * width / step)
    ways = np.array([[-1], [1]])
    first = np.stack([_first_outside(outside, middle, way) for way in (-1, 1)])
    behind = (np.maximum(first, 0) + ways * int(np.ceil(BEYOND / step))).clip(0, 2 * reach)
    shown = _aside(strand, line, normal, across[behind])
    hidden = shown - profile[behind, np.arange(len(line))] > 0.3
    place = (_half_way(profile, first, ways) - reach) * step
    low, high = np.where((first >= 0) & ~hidden, place, np.nan)
    return low, high


def _aside(
    field: np.ndarray, line: np.ndarray, normal: np.ndarray, distance: np.ndarray
) -> np.ndarray:
    """Values (m, n) of a picture at these distances, (m, 1) or (m, n), beside a line's points."""
    x, y = line.T.astype(np.float32)
    along_x, along_y = normal.T.astype(np.float32)
    distance = distance.astype(np.float32)
    return _looked_up(field, x + distance * along_x, y + distance * along_y)


def sample(field: np.ndarray, at: np.ndarray) -> np.ndarray:
    """Return bilinear values (n, m) or (n, m, 3) of a picture at points (n, m, 2), 0 outside."""
    # cv2.remap takes pictures of at most 32767 rows
    blocks = np.array_split(at.astype(np.float32), len(at) // 30000 + 1)
    return np.concatenate([_looked_up(field, *np.moveaxis(block, -1, 0)) for block in blocks])


def _looked_up(field: np.ndarray, x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Bilinear values of a picture at points (n, m), 0 outside."""
    parts = len(x[0]) // 30000 + 1
    if parts == 1:
        return cv2.remap(field, x, y, cv2.INTER_LINEAR)
    blocks = zip(np.array_split(x, parts, 1), np.array_split(y, parts, 1), strict=True)
    return np.concatenate([_looked_up(field, u, v) for u, v in blocks], axis=1)


def _nearest_inside(outside: np.ndarray, far: float) -> np.ndarray:
    """Index (n,) of the sample inside nearest to the middle; -1 when none within `far`."""
    reach = outside.shape[1] // 2
    middle = np.full(len(outside), reach)
    astray = np.flatnonzero(outside[:, reach])
    from_middle = np.argsort(np.abs(np.arange(-reach, reach + 1)), kind="stable")
    nearest = from_middle[outside[astray][:, from_middle].argmin(axis=1)]
    found = ~outside[astray, nearest] & (np.abs(nearest - reach) <= far)
    middle[astray] = np.where(found, nearest, -1)
    return middle


def _first_outside(outside: np.ndarray, middle: np.ndarray, way: int) -> np.ndarray:
    """Index (n,) of the first sample outside from the middle on, up or down; -1 when none."""
    index = np.arange(outside.shape[1], dtype=np.int16)[::way]
    beyond = outside[:, ::way] & (way * index > way * middle[:, None].astype(np.int16))
    first = beyond.argmax(axis=1)
    found = beyond[np.arange(len(beyond)), first] & (middle >= 0)
    return np.where(found, index[first], -1)


def _half_way(profile: np.ndarray, first: np.ndarray, way: np.ndarray) -> np.ndarray:
    """Index (fractional) where the profile falls through 0.5 before the sample `first`."""
    first = first.clip(1, len(profile) - 2)
    column = np.arange(first.shape[1])
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


class Sections(NamedTuple):
    """Evenly spaced cross-sections of a strand, about a tenth of its width apart.

    Attributes
    ----------
    line : (n, 2) array
        The smoothed centreline [px].
    middle : (n, 2) array
        Middle between the edges, as it was seen [px].
    sd : (n,) array
        Relative sd of that: 1 where both edges show, more where it rests on less, NaN = not seen.
    width : (n,) array
        Local width [px].
    edges : (n,) int array
        How many of the two edges are seen.
    """

    line: np.ndarray
    middle: np.ndarray
    sd: np.ndarray
    width: np.ndarray
    edges: np.ndarray


Place = Callable[[np.ndarray, np.ndarray], tuple[np.ndarray, np.ndarray]]


def refine(
    line: np.ndarray,
    own: np.ndarray,
    strand: np.ndarray,
    width: float,
    rough: float | None = None,
) -> Sections:
    """Move a rough centreline (n, 2) to the middle between the strand's edges.

    Where one edge is hidden the other is used with the strand's local width; where both are
    hidden the smoothing spline bridges with least bending, or keeps to the rough line, if that
    has a relative sd (`rough`).
    """
    smooth = _even(bundled([line]), width)
    for _ in range(2):  # again on the moved line, whose normals are better
        even = resampled(smooth, _step(width))
        found = _seen(even, own, strand, width)
        sd = found.sd if rough is None else np.where(np.isfinite(found.sd), found.sd, rough)
        smooth = even._replace(points=_weighed(found.middle, sd, width))
    return found._replace(line=smooth.points)


def sections_of(line: np.ndarray, own: np.ndarray, strand: np.ndarray, width: float) -> Sections:
    """Cross-sections of a centreline (n, 2) that stays where it is."""
    return _seen(resampled(bundled([line]), _step(width)), own, strand, width)


def settle(
    found: Sections, own: np.ndarray, strand: np.ndarray, width: float, place: Place
) -> Sections:
    """Ask `place` for the offset and its relative sd wherever an edge is hidden.

    Edges are sought again only within `AGAIN` strand widths of there: elsewhere the line has not
    moved since they were found.
    """
    reach = int(AGAIN * width / _step(width))
    near = ndimage.binary_dilation(found.sd != 1, iterations=reach)
    line, normal = found.line, normals(found.line)
    low, high = edges(line[near], own, strand, width, normal[near])
    offset, sd = np.zeros(len(line)), found.sd.copy()
    offset[near], sd[near] = _offsets(low, high, found.width[near])
    unsure = sd != 1
    there, spread = place(line, unsure)
    offset, sd = np.where(unsure, there, offset), np.where(unsure, spread, sd)
    seen = found.edges.copy()
    seen[near] = _edges_seen(low, high, sd[near])
    middle = np.where(near[:, None], line + offset[:, None] * normal, found.middle)
    return Sections(_weighed(middle, sd, width), middle, sd, found.width, seen)


def centred(
    lines: Sequence[np.ndarray], own: np.ndarray, strand: np.ndarray, width: float
) -> list[np.ndarray]:
    """Points (m, 2) of `refine`'s first round, of several lines of one colour."""
    if not lines:
        return []
    even = resampled(_even(bundled(lines), width), _step(width))
    found = _seen(even, own, strand, width)
    smooth = even._replace(points=_weighed(found.middle, found.sd, width, even.sizes))
    parts = smooth.parted(smooth.points)
    return parts if _step(width) == 1 else [_between(part)[0] for part in parts]


def _step(width: float) -> float:
    """Distance between cross-sections [px]."""
    return max(1.0, width / ROWS)


def _even(lines: Bundle, width: float) -> Bundle:
    """Smooth points at equal distances along rough lines."""
    points, count = resampled(lines, _step(width))
    return Bundle(smoothed(points, np.ones(len(points)), width / _step(width), count), count)


def _seen(lines: Bundle, own: np.ndarray, strand: np.ndarray, width: float) -> Sections:
    """Find what is seen of strands of one colour in the cross-sections of lines."""
    normal = normals_of(lines)
    low, high = edges(lines.points, own, strand, width, normal)
    around = int(AROUND * width / _step(width))
    spans = lines.parted(high - low)
    local = np.concatenate([_local_width(span, width, around) for span in spans])
    offset, sd = _offsets(low, high, local)
    middle = lines.points + offset[:, None] * normal
    return Sections(lines.points, middle, sd, local, _edges_seen(low, high, sd))


def _edges_seen(low: np.ndarray, high: np.ndarray, sd: np.ndarray) -> np.ndarray:
    return np.where(np.isfinite(sd), np.isfinite(low).astype(int) + np.isfinite(high), 0)


def _weighed(
    points: np.ndarray, sd: np.ndarray, width: float, count: np.ndarray | None = None
) -> np.ndarray:
    """Smooth points of these relative sds; NaN counts for nothing."""
    weight = np.where(np.isfinite(sd), 1 / np.square(sd), 0)
    return smoothed(points, weight, width / _step(width), count)


def dense(found: Sections, width: float) -> Centreline:
    """Points about 1 px apart, on the cubic through the middles of cross-sections."""
    spread = _spread(found, width)
    if _step(width) == 1:
        return Centreline(found.line, found.width, spread, found.edges)
    line, at = _between(found.line)
    even = np.arange(len(found.line))
    wide, sd = np.interp(at, even, found.width), np.interp(at, even, spread)
    return Centreline(line, wide, sd, found.edges[np.rint(at).astype(int)])


def _between(line: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Points about 1 px apart on the cubic through a line, and where between its points."""
    s = arclength(line)
    fine = np.linspace(0, s[-1], int(round(s[-1])) + 1)
    return CubicSpline(s, line)(fine), np.interp(fine, s, np.arange(len(s)))


def _local_width(span: np.ndarray, width: float, around: int) -> np.ndarray:
    """Return the running mean of the width where both edges show, filled in elsewhere."""
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


def smoothed(
    points: np.ndarray, weight: np.ndarray, width: float, count: np.ndarray | None = None
) -> np.ndarray:
    """Smooth evenly spaced points; half power at a wave of SHORTEST_WAVE widths [points].

    Minimises sum w |p - z|^2 + lam sum |second difference of z|^2 (Whittaker 1923), the discrete
    smoothing spline: where nothing is seen (w = 0) it bridges with least bending. `count` points
    each are lines of their own, and those of which too little is known stay as they are.
    """
    count = np.array([len(points)]) if count is None else count
    last = np.cumsum(count) - 1
    known = np.add.reduceat(weight > 0, last + 1 - count, dtype=int)
    # The penalty halves waves of angular frequency lam**-0.25 per sample.
    lam = (SHORTEST_WAVE * width / (2 * np.pi)) ** 4
    stiff = np.repeat(np.where((count >= 8) & (known >= 5), lam, 0), count)
    stiff[last] = stiff[last - 1] = 0  # no second difference starts there
    stiff = stiff[:-2]
    w = np.maximum(weight, 1e-9)
    band = np.zeros((3, len(points)))
    band[2] = w
    for shift, coefficient in enumerate([1.0, -2.0, 1.0]):
        band[2, shift : len(stiff) + shift] += stiff * coefficient**2
    band[1, 1:-1] += -2 * stiff
    band[1, 2:] += -2 * stiff
    band[0, 2:] += stiff
    return solveh_banded(band, w[:, None] * points)


def _spread(found: Sections, width: float) -> np.ndarray:
    """Estimate the standard deviation of the smoothed centreline [px]."""
    smooth, sd = found.line, found.sd
    seen = np.isfinite(sd)
    if not seen.any():
        return np.full(len(smooth), width)
    step = arclength(smooth)[-1] / max(len(smooth) - 1, 1)
    rest = ((found.middle - smooth) * normals(smooth)).sum(axis=1)[seen] / sd[seen]
    noise = 1.4826 * float(np.median(np.abs(rest)))
    at = np.flatnonzero(seen)
    index = np.arange(len(smooth))
    right = at[np.searchsorted(at, index).clip(0, len(at) - 1)]
    left = at[(np.searchsorted(at, index, side="right") - 1).clip(0, len(at) - 1)]
    away = np.minimum(np.abs(index - left), np.abs(right - index)) * step
    bias = width * np.where(found.edges == 2, SHADING_SD, np.hypot(SHADING_SD, ONE_EDGE_SD))
    growth = HIDDEN_GROWTH * away**1.5 / np.sqrt(width)
    return np.sqrt(noise**2 + bias**2 + growth**2 + (VALLEY * width * np.where(seen, sd, 0)) ** 2)
