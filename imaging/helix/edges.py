"""Which edges of two twisted strands can be seen, and where they lie to a fraction of a pixel.

The strand in front shows both edges, the strand behind its outer edge only. Centroids of what is
visible are biased by the hidden part (at R = r by a quarter of the radius); these edges are not.
"""

from dataclasses import dataclass, fields, replace
from itertools import product

import numpy as np

from imaging.errors import Unmeasurable
from imaging.helix.axis import Axis, bilinear
from imaging.helix.model import Model, outlines
from imaging.helix.profile import OUTSIDE, Profiles, edge_places, likely_blur, sampled_places

Array = np.ndarray
SLIVER = 2.5  # px; a narrower strip of one strand is blurred into its neighbours
RIM = 1.0  # px; how far the rear strand must stick out for its outer edge to be the pair's
HIDDEN, OUTER, CONTACT = range(3)
LEFT = {OUTER: 0.05, CONTACT: 0.25}  # px; what a step on a slope still errs by, with the phase
NO_EDGE = "no edge of the two strands stands out clearly enough to be followed"
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
    doubt : (n,) array
        Least error [px] that shading leaves.
    """

    s: Array
    points: Array
    strand: np.ndarray
    side: np.ndarray
    border: np.ndarray
    doubt: Array

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


def edges_in_light(
    light: np.ndarray, model: Model, valid: np.ndarray, gate: float, blur: float | None = None
) -> tuple[Edges, float]:
    """Locate the visible edges in the light itself, where a step on a slope fits best.

    Parameters
    ----------
    light : (c, h, w) array
        The picture's light in each channel.
    model, valid, gate
        As for `find_edges`.
    blur : float, optional
        The picture's blur [px]; estimated when left out.

    Returns
    -------
    Edges
    blur : float

    Raises
    ------
    Unmeasurable
        When no edge against the ground can be seen.
    """
    inside = float(np.clip(0.5 * model.part("radii").mean(), 2.5, 5.0))
    strips = _strips(light, model, valid, inside, sampled_places(inside, gate))
    outer = [strip.profiles for strip in strips if strip.which[2] == OUTER]
    if not outer:
        raise Unmeasurable(NO_EDGE)
    blur = blur or likely_blur(outer, inside)
    found = [strip.edges(model.axis, inside, blur) for strip in strips]
    every = Edges(*(np.concatenate(parts) for parts in zip(*found, strict=True)))
    return every.sorted(), blur


def doubted(edges: Edges, least: tuple[float, float]) -> Edges:
    """Return edges with the ``least`` error [px] of those against the ground, those in contact."""
    return replace(edges, doubt=np.where(edges.border == OUTER, *least))


def visible(
    across: Array, a_in_front: np.ndarray, rim: float = RIM, sliver: float = SLIVER
) -> np.ndarray:
    """Tell what lies beyond each edge: background (OUTER), a strand (CONTACT), or HIDDEN.

    Parameters
    ----------
    across : (2, 2, n) array
        Offsets [px] of both strands' lower and upper edges in each section.
    a_in_front : (n,) bool array
    rim, sliver : float
        Least width [px] of the strand behind where it sticks out, and where it is seen beyond an
        edge of the strand in front.

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
            border[k, j, front & (beyond > sliver) & (gap < 0.0)] = CONTACT
            border[k, j, front & (beyond < -RIM)] = OUTER
            border[1 - k, j, front & (beyond > rim)] = OUTER
    return border


@dataclass(frozen=True)
class _Strip:
    """Light across one edge of one strand (strand, side, border) where it can be seen."""

    which: tuple[int, int, int]
    points: Array
    outward: Array
    profiles: Profiles

    def edges(self, axis: Axis, inside: float, blur: float) -> tuple[Array, ...]:
        """Fields of `Edges` for the sections where the edge is clear."""
        where, _ = edge_places(self.profiles, inside, blur)
        ok = np.isfinite(where)
        points = self.points[ok] + where[ok, None] * self.outward[ok]
        named = (np.full(int(ok.sum()), value) for value in self.which)
        doubt = np.full(int(ok.sum()), LEFT[self.which[2]])
        return axis.s[self.profiles.rows[ok]], points, *named, doubt


def _strips(
    light: np.ndarray, model: Model, valid: np.ndarray, inside: float, places: Array
) -> list[_Strip]:
    """Sample the light across every edge that can be seen, along its own normal.

    Left out are strips too narrow to show a slope beside the step: a strand behind that sticks
    out by less than ``inside``, or is seen beyond the one in front for less than OUTSIDE.
    """
    across = outlines(model)
    border = visible(across, np.sin(model.at(model.axis.s).phi) > 0, inside, OUTSIDE + 0.5)
    border[:, :, ~valid] = HIDDEN
    strips = []
    for k, j, kind in product((0, 1), (0, 1), (OUTER, CONTACT)):
        rows = np.flatnonzero(border[k, j] == kind)
        if not len(rows):
            continue
        outline = model.axis.points + across[k, j, :, None] * model.axis.normals
        along = np.gradient(outline, axis=0)
        along /= np.maximum(np.linalg.norm(along, axis=1, keepdims=True), 1e-9)
        outward = ((2 * j - 1) * np.column_stack([along[:, 1], -along[:, 0]]))[rows]
        xy = outline[rows, None] + places[:, None] * outward[:, None]
        seen = np.moveaxis(bilinear(light, xy, nearest=True), 0, -1)
        profiles = Profiles(places, seen, rows, kind == CONTACT)
        strips.append(_Strip((k, 2 * j - 1, kind), outline[rows], outward, profiles))
    return strips


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
    inside = bilinear(coverage[None], xy)[0]
    where = _half_crossing(inside, outward)
    ok = np.isfinite(where)
    rows, where = rows[ok], where[ok]
    offset = expected[rows] + q * where
    points = axis.points[rows] + offset[:, None] * axis.normals[rows]
    n = len(rows)
    return axis.s[rows], points, np.full(n, strand), np.full(n, q), np.full(n, kind), np.zeros(n)


def _half_crossing(inside: Array, outward: Array) -> Array:
    """Where each row falls through one half, nearest to zero; NaN if nowhere."""
    falls = (inside[:, :-1] > 0.5) & (inside[:, 1:] <= 0.5)
    drop = np.where(falls, inside[:, :-1] - inside[:, 1:], np.inf)
    where = outward[:-1] + STEP * (inside[:, :-1] - 0.5) / drop
    where[~falls] = np.inf
    nearest = where[np.arange(len(inside)), np.argmin(np.abs(where), axis=1)]
    return np.where(np.isfinite(nearest), nearest, np.nan)
