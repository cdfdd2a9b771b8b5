"""Exact topology of strands in space: link, its density along a pair, twist and writhe.

A right-handed double helix of strands that run the same way has positive link.
"""

from __future__ import annotations

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike, NDArray
from scipy.ndimage import uniform_filter1d

from sim.kernels import topology as kernels

Array = NDArray[np.float64]

EXTENSION = 10.0  # by how many times the pair's own length open strands are prolonged


def curve_of(points: ArrayLike) -> Array:
    """Return the nodes of a strand as an (n, 3) array, or raise ValueError."""
    curve = np.ascontiguousarray(points, float)
    if curve.ndim != 2 or curve.shape[1] != 3 or len(curve) < 2:
        raise ValueError(f"a strand is an (n, 3) array with n >= 2; got shape {curve.shape}")
    return curve


def _links(first: Array, second: Array) -> Array:
    """Return the link of every segment of `second` with all of `first`, (len(second) - 1,)."""
    sums = np.zeros(len(second) - 1)
    kernels.add_links(first, second, sums)
    return sums


def gauss_link(a: ArrayLike, b: ArrayLike) -> float:
    """Return the Gauss linking integral of two polylines, open or closed.

    Parameters
    ----------
    a, b : (n, 3) and (m, 3)
        Nodes; a closed curve repeats its first node at the end.

    Returns
    -------
    float
        An integer for closed curves that do not touch; for open ones the link averaged over all
        directions of view.
    """
    return float(_links(curve_of(a), curve_of(b)).sum())


def average_crossing_number(a: ArrayLike, b: ArrayLike) -> float:
    """Return the number of crossings of two polylines, averaged over all directions of view."""
    return float(2 * kernels.crossing_number(curve_of(a), curve_of(b)))


def writhe(points: ArrayLike) -> float:
    """Return the writhe of a polyline, (n, 3); a closed curve repeats its first node at the end."""
    curve = curve_of(points)
    return float(_links(curve, curve).sum())


def twist(centreline: ArrayLike, normals: ArrayLike) -> float:
    """Return the total twist of a ribbon in turns.

    Parameters
    ----------
    centreline : (n, 3)
        Nodes.
    normals : (n, 3)
        Vectors at the nodes from the centreline to the ribbon's edge; only their part normal to the
        centreline counts.

    Notes
    -----
    A polyline's twist sits on its chords, between the normals at both ends, and at its corners: a
    normal that leans along one chord is not the next chord's after parallel transport (Langer &
    Singer, SIAM Rev. 38, 605 (1996)). Exact: with the writhe it adds up to the link of the curve
    and a ribbon's edge close to it. A closed curve repeats its first node and normal.
    """
    curve, ribbon = curve_of(centreline), np.asarray(normals, float)
    tangents = np.diff(curve, axis=0)
    tangents /= np.linalg.norm(tangents, axis=1, keepdims=True)
    total = _turn(tangents, _across(ribbon[:-1], tangents), _across(ribbon[1:], tangents)).sum()
    if np.array_equal(curve[0], curve[-1]):
        tangents, ribbon = np.vstack([tangents, tangents[:1]]), np.vstack([ribbon, ribbon[1:2]])
    return float((total + corner_angles(tangents, ribbon[1:-1]).sum()) / (2 * np.pi))


def corner_angles(tangents: Array, normals: Array) -> Array:
    """Return the twist of a ribbon at its corners [rad], from n chords, n - 1 normals between."""
    before, after = tangents[:-1], tangents[1:]
    axis = np.cross(before, after)
    cosine = np.einsum("ij,ij->i", before, after)[:, None]
    start = _across(normals, before)
    lift = np.einsum("ij,ij->i", axis, start)[:, None] / np.maximum(1 + cosine, 1e-12)
    carried = cosine * start + np.cross(axis, start) + lift * axis
    return _turn(after, carried, _across(normals, after))


def _turn(axes: Array, start: Array, end: Array) -> Array:
    """Return the angle from `start` to `end` about unit axes normal to both [rad], (n,)."""
    sine = np.einsum("ij,ij->i", axes, np.cross(start, end))
    return np.arctan2(sine, np.einsum("ij,ij->i", start, end))


def _across(vectors: Array, units: Array) -> Array:
    return vectors - np.einsum("ij,ij->i", vectors, units)[:, None] * units


def net_axis(a: Array, b: Array) -> Array:
    """Return the unit vector from the roots to the tips of a pair, (3,)."""
    axis = (a[-1] - a[0]) + (b[-1] - b[0])
    return axis / np.linalg.norm(axis)


def extended(strand: Array, axis: Array, length: float) -> Array:
    """Prolong a strand at both ends by a straight segment parallel to `axis`, (n + 2, 3)."""
    return np.vstack([strand[0] - length * axis, strand, strand[-1] + length * axis])


def link_density(a: ArrayLike, b: ArrayLike, *, resolution: float | None = None) -> pd.DataFrame:
    """Return the local link density of a pair of strands along their common centreline.

    A segment's share is its row sum of the Gauss link matrix (Klenin & Langowski, Biopolymers 54,
    307 (2000)), taken over both strands and halved, with both strands prolonged in parallel along
    the net axis so that open ends count in full. The strands are paired by planes normal to the
    local axis, not by arclength, so sliding one along the other does not bias the density.

    Parameters
    ----------
    a, b : (n, 3) and (m, 3)
        Nodes of the strands [m], root to tip.
    resolution : float, optional
        Width of the box over which the density is averaged [m]; default, one segment.

    Returns
    -------
    pandas.DataFrame
        `s` [m] along the centreline of the pair, `link` [1/m] and `sd` [1/m], zero as the curves
        are exact. ``attrs``: `total_link`, `end_link` (share of the prolongations), `length`.
    """
    first, second = curve_of(a), curve_of(b)
    axis = net_axis(first, second)
    longer = EXTENSION * float(max(_arclength(first)[-1], _arclength(second)[-1]))
    long_first, long_second = extended(first, axis, longer), extended(second, axis, longer)
    rows, columns = _links(long_second, long_first), _links(long_first, long_second)
    on_a, on_b = common_arclength(first, second, abs(rows.sum()))
    edges = np.linspace(0.0, max(on_a[-1], on_b[-1]), len(first))
    link = np.diff(0.5 * (_cumulative(edges, on_a, rows) + _cumulative(edges, on_b, columns)))
    link /= np.diff(edges)
    s = 0.5 * (edges[1:] + edges[:-1])
    if resolution is not None:
        link = box_average(s, link, resolution)
    table = pd.DataFrame({"s": s, "link": link, "sd": np.zeros_like(s)})
    table.attrs |= {
        "total_link": float(rows.sum()),
        "end_link": float(rows[0] + rows[-1] + columns[0] + columns[-1]) / 2,
        "length": float(edges[-1]),
        "method": "3-D topology, symmetrised row sum",
    }
    return table


def _cumulative(edges: Array, nodes: Array, rows: Array) -> Array:
    """Return a strand's link from its root up to every edge; rows include the prolongations."""
    return np.interp(edges, nodes, np.concatenate([[0.0], np.cumsum(rows[1:-1])]))


def box_average(s: Array, values: Array, width: float) -> Array:
    """Return the mean of piecewise constant, evenly spaced values over a box around every s."""
    step = s[1] - s[0]
    total = np.concatenate([[0.0], np.cumsum(values * step)])
    edges = np.concatenate([[s[0] - step / 2], s + step / 2])
    low = np.maximum(s - width / 2, edges[0])
    high = np.minimum(s + width / 2, edges[-1])
    return (np.interp(high, edges, total) - np.interp(low, edges, total)) / (high - low)


def _arclength(curve: Array) -> Array:
    steps = np.linalg.norm(np.diff(curve, axis=0), axis=1)
    return np.concatenate([[0.0], np.cumsum(steps)])


def common_arclength(a: Array, b: Array, turns: float) -> tuple[Array, Array]:
    """Return the arclength on the pair's centreline of every node of a and of b [m].

    Parameters
    ----------
    a, b : (n, 3) and (m, 3)
        Nodes, root to tip.
    turns : float
        How often they wind around each other: the local axis is the midline averaged over a turn.

    Returns
    -------
    (n,) and (m,)
        Never decreasing.
    """
    partner = partners(a, b, turns)
    index = np.arange(len(b))
    opposite = np.column_stack([np.interp(partner, index, b[:, k]) for k in range(3)])
    on_a = _arclength(0.5 * (a + opposite))
    rising = np.maximum.accumulate(partner) + 1e-9 * np.arange(len(a))
    return on_a, np.interp(index, rising, on_a)


def partners(a: Array, b: Array, turns: float) -> Array:
    """Return for every node of a the (fractional) index on b in the plane normal to the axis, (n,).

    Among the places where b crosses the plane the one nearest by arclength is taken; where b ends
    before it reaches the plane, its end.
    """
    guess = np.linspace(0, len(b) - 1, len(a))
    index = np.arange(len(b))
    midline = 0.5 * (a + np.column_stack([np.interp(guess, index, b[:, k]) for k in range(3)]))
    width = int(np.clip(round(len(a) / max(turns, 1.0)), 3, max(3, len(a) // 4)))
    tangents = np.gradient(uniform_filter1d(midline, width, axis=0, mode="nearest"), axis=0)
    found = np.empty(len(a))
    kernels.pass_planes(a, np.ascontiguousarray(tangents), b, guess, found)
    return found
