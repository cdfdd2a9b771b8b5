"""Where strands touch, or nearly: contacts one by one, and the network that they make."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike, NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from sim.topology.pair import curve_of

Array = NDArray[np.float64]
Index = NDArray[np.int64]


@dataclass(frozen=True, repr=False)
class ContactNetwork:
    """Contacts of n strands.

    Attributes
    ----------
    contacts : DataFrame
        Every place where two strands, or two parts of one, are nearer than the distance asked for:
        `strand_a, s_a, strand_b, s_b` (s [m] along either), `gap` between the centrelines where it
        is least [m], the place `x, y, z` half-way [m], and the `length` of a that is near [m].
    per_strand : (n,) array
        Number of contacts of every strand.
    cluster : (n,) array
        Number of the cluster that a strand belongs to: strands joined by contacts, over others too.
    """

    contacts: pd.DataFrame
    per_strand: Index
    cluster: Index

    def __repr__(self) -> str:
        """Say how many contacts there are and how far they connect."""
        return (
            f"<ContactNetwork of {len(self.cluster)} strands: {len(self.contacts)} contacts, "
            f"{self.cluster.max() + 1} clusters, the largest of {self.largest} strands>"
        )

    @property
    def largest(self) -> int:
        """Number of strands in the largest cluster."""
        return int(np.bincount(self.cluster).max())


def contact_network(strands: Sequence[ArrayLike], distance: float) -> ContactNetwork:
    """Find where strands come nearer to each other than a distance.

    Parameters
    ----------
    strands : sequence of (n, 3) arrays
        Nodes [m].
    distance : float
        Between centrelines [m]: the diameter of the strands, and a little for what counts as near.

    Raises
    ------
    ValueError
        There is no strand, one is not a curve in space, or the distance is not positive.

    Notes
    -----
    Segments that are near and follow one another on both strands are one contact: two strands that
    lie along each other touch once. Parts of one strand count when they are more than twice the
    distance apart along it.
    """
    if not strands or not distance > 0:
        raise ValueError(f"a contact network needs strands and a distance > 0, not {distance!r}")
    parts = _segments([curve_of(strand) for strand in strands])
    near = _near(parts, distance)
    near["group"] = _together(near["i"].to_numpy(), near["j"].to_numpy(), parts.strand)
    closest = near.sort_values(["group", "gap"]).groupby("group").head(1)
    once = near.drop_duplicates(["group", "i"])
    lengths = pd.Series(parts.length[once["i"]]).groupby(once["group"].to_numpy()).sum()
    contacts = closest.drop(columns=["i", "j", "group"]).assign(length=lengths.to_numpy())
    return _network(contacts.reset_index(drop=True), len(strands))


@dataclass(frozen=True)
class _Segments:
    """Segments of all strands: start and vector (m, 3), length, strand and arclength before it."""

    start: Array
    edge: Array
    length: Array
    strand: Index
    s: Array


def _segments(curves: Sequence[Array]) -> _Segments:
    start = np.concatenate([curve[:-1] for curve in curves])
    edges = [np.diff(curve, axis=0) for curve in curves]
    lengths = [np.linalg.norm(edge, axis=1) for edge in edges]
    strand = np.repeat(np.arange(len(curves)), [len(edge) for edge in edges])
    s = np.concatenate([np.cumsum(one) - one for one in lengths])
    return _Segments(start, np.concatenate(edges), np.concatenate(lengths), strand, s)


def _near(parts: _Segments, distance: float) -> pd.DataFrame:
    """Return the pairs of segments i, j nearer than a distance, the earlier one first."""
    middles = parts.start + parts.edge / 2
    reach = distance + parts.length.max()
    pairs = cKDTree(middles).query_pairs(reach, output_type="ndarray")
    i, j = np.sort(pairs, axis=1).T
    on_i, on_j, gap = nearest_places(parts.start[i], parts.edge[i], parts.start[j], parts.edge[j])
    s_a, s_b = parts.s[i] + on_i * parts.length[i], parts.s[j] + on_j * parts.length[j]
    near = (gap < distance) & ((parts.strand[i] != parts.strand[j]) | (s_b - s_a > 2 * distance))
    first = parts.start[i] + on_i[:, None] * parts.edge[i]
    second = parts.start[j] + on_j[:, None] * parts.edge[j]
    table = pd.DataFrame({"strand_a": parts.strand[i] + 1, "s_a": s_a})
    table = table.assign(strand_b=parts.strand[j] + 1, s_b=s_b, gap=gap)
    table[["x", "y", "z"]] = (first + second) / 2
    return table.assign(i=i, j=j)[near]


def _network(contacts: pd.DataFrame, n: int) -> ContactNetwork:
    a, b = contacts["strand_a"].to_numpy() - 1, contacts["strand_b"].to_numpy() - 1
    per_strand = np.bincount(a, minlength=n) + np.bincount(b[a != b], minlength=n)
    graph = coo_array((np.ones(len(a)), (a, b)), shape=(n, n))
    return ContactNetwork(contacts, per_strand, connected_components(graph, directed=False)[1])


def _together(i: Index, j: Index, strand: Index) -> Index:
    """Give one number to pairs of segments that follow one another on both strands."""
    if not len(i):
        return np.empty(0, np.int64)
    pairs = np.column_stack([i, j])
    one, other = cKDTree(pairs).query_pairs(1.5, output_type="ndarray").T
    same = (strand[i[one]] == strand[i[other]]) & (strand[j[one]] == strand[j[other]])
    graph = coo_array((np.ones(same.sum()), (one[same], other[same])), shape=(len(i), len(i)))
    return connected_components(graph, directed=False)[1]


def nearest_places(p: Array, u: Array, q: Array, v: Array) -> tuple[Array, Array, Array]:
    """Return where segments p + a u and q + b v are nearest, a and b in 0..1, and how near.

    Parameters
    ----------
    p, u, q, v : (n, 3)
        Starts and vectors of n pairs of segments.

    Returns
    -------
    a, b, distance : (n,)
        The least distance is from an end to the other segment, or along the common normal.
    """
    w, uv = p - q, _dot(u, v)
    uu, vv = (np.maximum(_dot(one, one), 1e-300) for one in (u, v))  # a node may be there twice
    uw, vw, zero, one = _dot(u, w), _dot(v, w), np.zeros(len(p)), np.ones(len(p))
    inverse = 1 / np.maximum(uu * vv - uv**2, 1e-300)
    a = [zero, one, -uw / uu, (uv - uw) / uu, (uv * vw - vv * uw) * inverse]
    b = [vw / vv, (vw + uv) / vv, zero, one, (uu * vw - uv * uw) * inverse]
    at, to = np.clip(a, 0, 1), np.clip(b, 0, 1)
    away = np.linalg.norm(w + at[..., None] * u - to[..., None] * v, axis=-1)
    best = away.argmin(axis=0), np.arange(len(p))
    return at[best], to[best], away[best]


def _dot(a: Array, b: Array) -> Array:
    return np.einsum("ij,ij->i", a, b)


def nearest_strand(strands: Sequence[ArrayLike]) -> list[Array]:
    """Return for every strand the distance from its nodes to the nearest other strand [m].

    Parameters
    ----------
    strands : sequence of (n, 3) arrays
        Nodes [m], of at least two strands.

    Returns
    -------
    list of (n,) arrays
        To the nearest segment of another strand.

    Raises
    ------
    ValueError
        There are fewer than two strands, or one is not a curve in space.
    """
    curves = [curve_of(strand) for strand in strands]
    if len(curves) < 2:
        raise ValueError(f"the nearest other strand needs two strands or more, not {len(curves)}")
    return [
        _to_segments(curve, [other for k, other in enumerate(curves) if k != number])
        for number, curve in enumerate(curves)
    ]


def _to_segments(points: Array, curves: list[Array]) -> Array:
    """Return the distances of points to the nearest segment of several curves, (n,)."""
    parts = _segments(curves)
    middles, half = parts.start + parts.edge / 2, parts.length.max() / 2
    tree = cKDTree(middles)
    bound = tree.query(points)[0] + half  # the nearest segment's middle is no farther than this
    near = tree.query_ball_point(points, bound + half)
    point = np.repeat(np.arange(len(points)), [len(one) for one in near])
    segment = np.concatenate(near).astype(int)
    w, edge = points[point] - parts.start[segment], parts.edge[segment]
    along = np.clip(_dot(w, edge) / np.maximum(_dot(edge, edge), 1e-300), 0, 1)
    away = np.linalg.norm(w - along[:, None] * edge, axis=1)
    first = np.searchsorted(point, np.arange(len(points)))
    return np.minimum.reduceat(away, first)
