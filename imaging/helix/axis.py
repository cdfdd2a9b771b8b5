"""Where the pair of strands runs in the picture: its midline, and sections normal to it."""

from dataclasses import dataclass
from itertools import chain

import cv2
import numba
import numpy as np
from scipy.interpolate import CubicSpline
from scipy.ndimage import gaussian_filter1d
from skimage.graph import MCP_Geometric

from imaging.errors import Unmeasurable

Array = np.ndarray
BRIDGES = (4.0, 8.0, 20.0)  # strand radii of the disc that closes gaps
WHOLE = 0.9  # of the pair in one piece
TOWARDS_ROOT = {"top": (0, -1), "bottom": (0, 1), "left": (-1, 0), "right": (1, 0)}


@dataclass(frozen=True)
class Axis:
    """A smooth plane curve from root to tip, one point per pixel of arclength.

    Attributes
    ----------
    s : (n,) array
        Arclength [px].
    points, tangents, normals : (n, 2) arrays
        ``normal = (t_y, -t_x)``: to the right of the picture where the axis runs down.
    """

    s: Array
    points: Array
    tangents: Array
    normals: Array

    def to_picture(self, u: Array) -> Array:
        """Picture points (n, m, 2) at signed offsets ``u`` (m,) or (n, m) from every axis point."""
        u = np.broadcast_to(u, (len(self.s), np.shape(u)[-1]))
        return self.points[:, None] + u[..., None] * self.normals[:, None]


def axis_through(points: Array) -> Axis:
    """Resample a curve to one point per pixel of arclength."""
    steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    points = points[np.r_[True, steps > 1e-9]]
    chord = np.r_[0.0, np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))]
    curve = CubicSpline(chord, points)
    s = np.linspace(0.0, chord[-1], max(int(round(chord[-1])), 2) + 1)
    tangents = curve(s, 1)
    tangents /= np.linalg.norm(tangents, axis=1, keepdims=True)
    return Axis(s, curve(s), tangents, np.column_stack([tangents[:, 1], -tangents[:, 0]]))


def find_axis(pair: np.ndarray, r: float, *, root: str = "top") -> Axis:
    """Midline of a pair of strands, through gaps as long as a tine is wide.

    Strategy: close the union of both strands until a tine and the hole it spreads are filled, with
    a wider disc where that leaves much of the pair apart,
    take the most central path between its two ends, then move that path to the middle of the
    pair's outer edges. The outer edges lie at +-(R|cos(phi)| + r), so their middle is the axis
    whatever the phase, even where one strand is hidden.

    Parameters
    ----------
    pair : (h, w) array
        Summed membership of both strands, 0 to 1.
    r : float
        Strand radius [px].
    root : {"top", "bottom", "left", "right"}
        The side of the picture nearest to which the clamped end lies.

    Returns
    -------
    Axis

    Raises
    ------
    Unmeasurable
        When the pair is too short to have an axis.
    """
    if root not in TOWARDS_ROOT:
        raise Unmeasurable(f"root is {root!r}; it must be one of {', '.join(TOWARDS_ROOT)}")
    step = max(1, int(r / 3))
    size = (pair.shape[1] // step, pair.shape[0] // step)
    small = cv2.resize(pair, size, interpolation=cv2.INTER_AREA) > 0.5
    body = _body(small, r / step)
    path = step * _central_path(body) + (step - 1) / 2
    if len(path) * step < 8 * r:
        raise Unmeasurable(f"the pair is only {len(path) * step} px long; no axis can be found")
    if (path[0] - path[-1]) @ TOWARDS_ROOT[root] < 0:
        path = path[::-1]
    smooth = _smoothed(path, 2.0 * r / step)
    axis = axis_through(_straight_ends(smooth, int(4.0 * r / step)))
    width = step * float(np.percentile(_depth(body)[body], 99)) + 3.0 * r
    for smoothing in (3.0 * r, 1.5 * r):
        axis = _centred(axis, pair, width, smoothing)
    return axis


def smoothed(axis: Axis, sigma: float) -> Axis:
    """Smooth an axis over ``sigma`` [px], so that it keeps no ripple of the strands it ran along.

    The middle of two strands that lean out of the picture sways twice a pitch; smoothed over a
    quarter of a pitch, less than a hundredth of that is left.
    """
    return axis_through(_smoothed(axis.points, sigma))


def sample(maps: np.ndarray, axis: Axis, u: Array) -> Array:
    """Sample maps (k, h, w) at offsets ``u`` from the axis -> (k, n, m); 0 outside the picture."""
    return bilinear(maps, axis.to_picture(u))


def bilinear(maps: np.ndarray, xy: Array, *, nearest: bool = False) -> Array:
    """Values (k, n, m) of maps (k, h, w) at picture points (n, m, 2), straight between pixels.

    Outside the picture they are 0, or those of the ``nearest`` pixel.
    """
    found = np.zeros((len(maps), *xy.shape[:2]), maps.dtype)
    if nearest:
        xy = np.clip(xy, 0, np.subtract(maps.shape[:0:-1], 1))
    for values, out in zip(maps, found, strict=True):
        _looked_up(values, xy, out)
    return found


def _body(pair: np.ndarray, r: float) -> np.ndarray:
    """Close the smallest gaps that leave the pair in one piece, else those of a usual tine."""
    bodies = (_largest(closed(pair, reach * r)) for reach in BRIDGES)
    first = next(bodies)
    for body in chain([first], bodies):
        if (body & pair).sum() > WHOLE * pair.sum():
            return body
    return first


def closed(mask: np.ndarray, radius: float) -> np.ndarray:
    """Close a mask with a disc of ``radius`` [px], by two distance transforms."""
    pad = int(radius) + 2
    wide = np.pad(mask, pad)
    grown = cv2.distanceTransform((~wide).astype(np.uint8), cv2.DIST_L2, 5) < radius
    return (_depth(grown) >= radius)[pad:-pad, pad:-pad] | mask


def _depth(mask: np.ndarray) -> np.ndarray:
    """Distance to the outside, the picture's border counting as outside."""
    padded = np.pad(mask, 1).astype(np.uint8)
    return cv2.distanceTransform(padded, cv2.DIST_L2, 5)[1:-1, 1:-1]


def _largest(mask: np.ndarray) -> np.ndarray:
    count, blobs, stats, _ = cv2.connectedComponentsWithStats(mask.astype(np.uint8))
    if count < 2:
        raise Unmeasurable("no pair of strands in the picture")
    return blobs == 1 + int(np.argmax(stats[1:, cv2.CC_STAT_AREA]))


def _central_path(body: np.ndarray) -> Array:
    """Path (n, 2) between the two ends of a body that keeps to its middle."""
    corner, body = _cropped(body)
    depth = _depth(body)
    cost = np.where(body, 1.0 + (depth.max() / np.maximum(depth, 0.5)) ** 2, -1.0)
    plain = np.where(body, 1.0, -1.0)
    start = np.argwhere(body)[0]
    for _ in range(2):
        far, _ = MCP_Geometric(plain).find_costs([start])
        end, start = start, np.argwhere(far == far[np.isfinite(far)].max())[0]
    finder = MCP_Geometric(cost)
    finder.find_costs([start])
    return np.array(finder.traceback(end), dtype=float)[:, ::-1] + corner


def _cropped(mask: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Corner (x, y) of the window that holds a mask, and the mask in it."""
    (x, last_x), (y, last_y) = (np.flatnonzero(mask.any(axis=k))[[0, -1]] for k in (0, 1))
    return np.array([x, y]), mask[y : last_y + 1, x : last_x + 1]


def _smoothed(points: Array, sigma: float) -> Array:
    """Gaussian smoothing along a curve whose ends are extended straight."""
    pad = min(int(4 * sigma), len(points) - 1)
    head = 2 * points[0] - points[pad:0:-1]
    tail = 2 * points[-1] - points[-2 : -pad - 2 : -1]
    smooth = gaussian_filter1d(np.vstack([head, points, tail]), sigma, axis=0)
    return smooth[pad : len(smooth) - pad] if pad else points


def _straight_ends(points: Array, reach: int) -> Array:
    """Replace both ends, which lead into one strand's tip, by straight lines of equal length."""
    reach = min(reach, len(points) // 4)
    if reach == 0:
        return points
    inner = points[reach:-reach]
    steps = np.arange(1, reach + 1)[:, None]
    back = min(2 * reach, len(inner) - 1)
    head = inner[0] + steps[::-1] * (inner[0] - inner[back]) / back
    tail = inner[-1] + steps * (inner[-1] - inner[-1 - back]) / back
    return np.vstack([head, inner, tail])


def _centred(axis: Axis, pair: np.ndarray, width: float, smoothing: float) -> Axis:
    """Move an axis to the middle of the outer edges, then smooth it."""
    u = np.arange(-width, width + 0.5, 0.5)
    inside = sample(pair[None], axis, u)[0] > 0.5
    seen = inside.any(axis=1)
    left = u[np.argmax(inside, axis=1)]
    right = u[len(u) - 1 - np.argmax(inside[:, ::-1], axis=1)]
    if not seen.any():
        return axis
    middle = np.interp(axis.s, axis.s[seen], (0.5 * (left + right))[seen])
    first, last = np.flatnonzero(seen)[[0, -1]]
    moved = axis.points + middle[:, None] * axis.normals
    return axis_through(_smoothed(moved[first : last + 1], smoothing))


@numba.njit(cache=True)
def _looked_up(values, xy, out):
    """Fill in values between four pixels where a point lies in the picture."""
    height, width = values.shape
    for i in range(xy.shape[0]):
        for j in range(xy.shape[1]):
            x, y = xy[i, j, 0], xy[i, j, 1]
            if not (0 <= x <= width - 1 and 0 <= y <= height - 1):
                continue
            left, top = min(int(x), max(width - 2, 0)), min(int(y), max(height - 2, 0))
            right, below = min(left + 1, width - 1), min(top + 1, height - 1)
            u, v = x - left, y - top
            upper = (1 - u) * values[top, left] + u * values[top, right]
            lower = (1 - u) * values[below, left] + u * values[below, right]
            out[i, j] = (1 - v) * upper + v * lower
