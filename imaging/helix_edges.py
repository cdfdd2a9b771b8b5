"""Which edges of two twisted strands can be seen, and where they lie to a fraction of a pixel.

The strand in front shows both edges, the strand behind its outer edge only. Centroids of what is
visible are biased by the hidden part (at R = r by a quarter of the radius); these edges are not.
"""

from dataclasses import dataclass, fields

import numpy as np
from scipy.ndimage import map_coordinates

from imaging.helix_axis import Axis
from imaging.helix_model import Model, outlines

Array = np.ndarray
SLIVER = 2.5  # px; a narrower strip of one strand is blurred into its neighbours
RIM = 1.0  # px; how far the rear strand must stick out for its outer edge to be the pair's
HIDDEN, OUTER, CONTACT = range(3)
STEP = 0.5  # px between samples across an edge


@dataclass(frozen=True)
class Edges:
    """Edge points and what each is an edge of.

    Attributes
    ----------
    s : (n,) array
        Arclength of the section [px].
    points : (n, 2) array
        Picture points at half membership.
    strand : (n,) int array
        0 = a, 1 = b.
    side : (n,) int array
        +1 towards the axis normal, -1 away from it.
    border : (n,) int array
        OUTER or CONTACT.
    """

    s: Array
    points: Array
    strand: np.ndarray
    side: np.ndarray
    border: np.ndarray

    @property
    def kind(self) -> np.ndarray:
        """Which of the eight effective radii applies: the track, + 4 if in contact."""
        return self.track + 4 * (self.border == CONTACT)

    @property
    def track(self) -> np.ndarray:
        """Which of the four edge curves the point belongs to."""
        return 2 * self.strand + (self.side > 0)

    def sorted(self) -> "Edges":
        """Return the edges from root to tip."""
        order = np.argsort(self.s, kind="stable")
        return Edges(*(getattr(self, field.name)[order] for field in fields(self)))


def find_edges(membership: np.ndarray, model: Model, valid: np.ndarray, gate: float) -> Edges:
    """Locate the edges that a model says are visible, each within ``gate`` [px] of it.

    Parameters
    ----------
    membership : (2, h, w) array
        Coverage of strand a and strand b.
    model : Model
        Current axis, phase and radii.
    valid : (n,) bool array
        Axis points whose sections may be used.
    gate : float
        Half length of the search across the edge [px].
    """
    across = outlines(model)
    border = visible(across, np.sin(model.at(model.axis.s).phi) > 0)
    border[:, :, ~valid] = HIDDEN
    # The pair's outer edge is sharp even where the strip of the strand that owns it is narrow.
    pair = membership.sum(axis=0)
    found = [
        _search(pair if kind == OUTER else membership[k], model.axis, across[k, j],
                border[k, j] == kind, (k, 2 * j - 1, kind), gate)
        for k in (0, 1)
        for j in (0, 1)
        for kind in (OUTER, CONTACT)
    ]  # fmt: skip
    every = Edges(*(np.concatenate(parts) for parts in zip(*found, strict=True)))
    return every.sorted()


def visible(across: Array, a_in_front: np.ndarray) -> np.ndarray:
    """Tell what lies beyond each edge: background (OUTER), a strand (CONTACT), or HIDDEN.

    Parameters
    ----------
    across : (2, 2, n) array
        Offsets [px] of both strands' lower and upper edges in each section.
    a_in_front : (n,) bool array

    Returns
    -------
    (2, 2, n) int array
        OUTER: nothing but background beyond. CONTACT: the other strand. HIDDEN also where blur
        mixes the two, and where a gap lies between the strands: too little background shows in it
        to tell how much of a pixel it covers (edges there erred by 0.35 px, always the same way).
    """
    border = np.full(across.shape, HIDDEN)
    for k, front in ((0, a_in_front), (1, ~a_in_front)):
        for j, q in ((0, -1.0), (1, 1.0)):
            beyond = q * (across[1 - k, j] - across[k, j])
            gap = q * (across[1 - k, 1 - j] - across[k, j])
            border[k, j, front & (beyond > SLIVER) & (gap < 0.0)] = CONTACT
            border[k, j, front & (beyond < -RIM)] = OUTER
            border[1 - k, j, front & (beyond > RIM)] = OUTER
    return border


def _search(
    coverage: np.ndarray,
    axis: Axis,
    expected: Array,
    wanted: np.ndarray,
    which: tuple[int, int, int],
    gate: float,
) -> tuple[Array, ...]:
    """Follow one edge of one strand: fields of `Edges` for the sections where it was found."""
    strand, q, kind = which
    rows = np.flatnonzero(wanted)
    outward = np.arange(-gate, gate + STEP, STEP)
    u = expected[rows, None] + q * outward
    xy = axis.points[rows, None] + u[..., None] * axis.normals[rows, None]
    inside = map_coordinates(coverage, [xy[..., 1], xy[..., 0]], order=1, mode="constant")
    where = _half_crossing(inside, outward)
    ok = np.isfinite(where)
    rows, where = rows[ok], where[ok]
    offset = expected[rows] + q * where
    points = axis.points[rows] + offset[:, None] * axis.normals[rows]
    n = len(rows)
    return axis.s[rows], points, np.full(n, strand), np.full(n, q), np.full(n, kind)


def _half_crossing(inside: Array, outward: Array) -> Array:
    """Where each row falls through one half, nearest to zero; NaN if nowhere."""
    falls = (inside[:, :-1] > 0.5) & (inside[:, 1:] <= 0.5)
    drop = np.where(falls, inside[:, :-1] - inside[:, 1:], np.inf)
    where = outward[:-1] + STEP * (inside[:, :-1] - 0.5) / drop
    where[~falls] = np.inf
    nearest = where[np.arange(len(inside)), np.argmin(np.abs(where), axis=1)]
    return np.where(np.isfinite(nearest), nearest, np.nan)
