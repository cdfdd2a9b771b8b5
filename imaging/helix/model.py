"""The model of two twisted strands in a picture: splines along an axis, and the edges they give.

Strand a and b have the centrelines (e = +1, -1)

    C(s) = A(s) + e [R(s) cos(phi(s)) n(s) + T(s) sin(phi(s)) t(s)],   A = A0 + m(s) n0(s),

with n, t the unit normal and tangent of the axis A in the picture. T/R is the sine of the angle
by which the axis leaves the picture plane, and the slope of the line of sight in a near
photograph: T/R = lean(s) + tau y, with y the distance along the axis from the picture's centre.
A tube's outline in the picture is the curve at distance r from its projected centreline, exactly.
"""

from dataclasses import dataclass, replace
from functools import cached_property

import numba
import numpy as np

from imaging.helix.axis import Axis
from imaging.helix.splines import curve

Array = np.ndarray
FEET = 6  # steps to the nearest point
GRID = 0.5  # px; the centrelines are tabulated this densely


@dataclass(frozen=True)
class Values:
    """The model's fields at some arclengths, each (n,) or (n, 2); primes are d/ds."""

    phi: Array
    dphi: Array
    mid: Array
    R: Array
    lean: Array


@dataclass(frozen=True)
class Layout:
    """Where the unknowns sit in their vector: four splines, then the line of sight and radii."""

    phi: Array
    mid: Array
    R: Array
    lean: Array

    @cached_property
    def blocks(self) -> dict[str, slice]:
        """Slices of the unknowns: ``phi, mid, R, lean``, then ``sight`` (1) and ``radii`` (8)."""
        sizes = {name: len(getattr(self, name)) - 4 for name in ("phi", "mid", "R", "lean")}
        sizes |= {"sight": 1, "radii": 8}
        ends = np.cumsum(list(sizes.values()))
        return {
            name: slice(int(end) - size, int(end))
            for (name, size), end in zip(sizes.items(), ends, strict=True)
        }

    @cached_property
    def order(self) -> np.ndarray:
        """Unknowns sorted by their place along the axis; those of the whole axis stand last."""
        place = np.concatenate([knot[2:-2] for knot in self._splines])
        return np.r_[np.argsort(place, kind="stable"), len(place) : self.size]

    @cached_property
    def rank(self) -> np.ndarray:
        """Where each unknown stands among the sorted ones."""
        return np.argsort(self.order)

    @cached_property
    def width(self) -> int:
        """How far apart two sorted unknowns stand at most whose splines overlap."""
        low, high = (np.concatenate([k[side] for k in self._splines])[self.order[: -self.shared]]
                     for side in (slice(None, -4), slice(4, None)))  # fmt: skip
        i, j = np.nonzero((low[:, None] < high) & (low < high[:, None]))
        return int(np.abs(i - j).max())

    @property
    def _splines(self) -> tuple[Array, ...]:
        return self.phi, self.mid, self.R, self.lean

    @property
    def shared(self) -> int:
        """Number of unknowns that belong to the whole axis."""
        return self.size - self.blocks["sight"].start

    @property
    def size(self) -> int:
        """Number of unknowns."""
        return self.blocks["radii"].stop


@dataclass(frozen=True)
class Model:
    """An axis to start from, the unknowns, and the picture's centre (x, y) [px]."""

    axis: Axis
    layout: Layout
    beta: Array
    centre: Array

    def moved(self, beta: Array) -> "Model":
        """Return the same model with other unknowns."""
        return replace(self, beta=beta)

    def part(self, name: str) -> Array:
        """Return one block of the unknowns."""
        return self.beta[self.layout.blocks[name]]

    def at(self, s: Array) -> Values:
        """Evaluate the splines at arclengths ``s``."""
        layout = self.layout
        return Values(
            curve(layout.phi, self.part("phi"), s),
            curve(layout.phi, self.part("phi"), s, 1),
            curve(layout.mid, self.part("mid"), s),
            curve(layout.R, self.part("R"), s),
            curve(layout.lean, self.part("lean"), s) + self.sight(s) @ self.part("sight"),
        )

    def sight(self, s: Array) -> Array:
        """Distance (n, 1) along the axis from the picture's centre, over the axis' length."""
        along = ((self.axis.points - self.centre) * self.axis.tangents).sum(axis=1)
        return np.interp(s, self.axis.s, along)[:, None] / self.axis.s[-1]

    @cached_property
    def pitch(self) -> float:
        """Typical pitch [px], at most the axis' length."""
        length = float(self.axis.s[-1])
        typical = float(np.median(np.abs(self.at(self.axis.s).dphi)))
        return 2 * np.pi / max(typical, 2 * np.pi / length)

    @cached_property
    def table(self) -> "Table":
        """The curves, tabulated."""
        return _tabulate(self)


@dataclass(frozen=True)
class Table:
    """Axis, its frame and both centrelines at dense arclengths of the starting axis."""

    s: Array
    axis: Array
    tangents: Array
    normals: Array
    speed: Array
    strands: Array


def outlines(model: Model) -> Array:
    """Offsets (2, 2, n) at which the tubes' lower and upper edges cross each section [px].

    The tube radius is the mean of the eight effective radii.
    """
    table, axis, r = model.table, model.axis, float(model.part("radii").mean())
    across = np.empty((2, 2, len(axis.s)))
    for k, strand in enumerate(table.strands):
        along = np.gradient(strand, axis=0)
        along /= np.linalg.norm(along, axis=1, keepdims=True)
        normal = np.column_stack([along[:, 1], -along[:, 0]])
        for j, q in enumerate((-1.0, 1.0)):
            across[k, j] = offsets(axis, table.s, strand + q * r * normal)
    return across


def feet(model: Model, strand: np.ndarray, s: Array, points: Array) -> Array:
    """Arclengths of the centreline points nearest to picture points, starting from ``s``."""
    table, found = model.table, s.astype(float)
    _slide(table.strands, table.s[0], table.s[1] - table.s[0], strand, points, found)
    return found


def positions(model: Model, strand: np.ndarray, s: Array) -> Array:
    """Centreline points (n, 2) of the strands named, at arclengths ``s``."""
    return _on_curve(model.table, strand, s, model.table.s[1] - model.table.s[0])[0]


def _tabulate(model: Model) -> Table:
    axis = model.axis
    s = np.linspace(axis.s[0], axis.s[-1], int(axis.s[-1] / GRID) + 2)
    values = model.at(s)
    base = np.column_stack([np.interp(s, axis.s, axis.points[:, i]) for i in (0, 1)])
    n0 = np.column_stack([np.interp(s, axis.s, axis.normals[:, i]) for i in (0, 1)])
    points = base + values.mid[:, None] * n0
    along = np.gradient(points, s, axis=0)
    speed = np.linalg.norm(along, axis=1)
    tangents = along / speed[:, None]
    normals = np.column_stack([tangents[:, 1], -tangents[:, 0]])
    offset = (values.R * np.cos(values.phi))[:, None] * normals
    offset += (values.R * values.lean * np.sin(values.phi))[:, None] * tangents
    return Table(s, points, tangents, normals, speed, np.stack([points + offset, points - offset]))


def offsets(axis: Axis, s: Array, points: Array) -> Array:
    """Where a curve known at (s, points) crosses the sections of an axis."""
    for _ in range(3):
        base = np.column_stack([np.interp(s, axis.s, axis.points[:, i]) for i in (0, 1)])
        tangent = np.column_stack([np.interp(s, axis.s, axis.tangents[:, i]) for i in (0, 1)])
        s = s + ((points - base) * tangent).sum(axis=1)
    normal = np.column_stack([tangent[:, 1], -tangent[:, 0]])
    u = ((points - base) * normal).sum(axis=1)
    return np.interp(axis.s, np.maximum.accumulate(s), u)


@numba.njit(cache=True, error_model="numpy")
def _slide(strands, start, step, strand, points, s):
    """Move each s by Newton's steps to the foot of its point on a tabulated strand."""
    last = strands.shape[1] - 1
    for k in range(len(s)):
        line, x, y = strands[strand[k]], points[k, 0], points[k, 1]
        place = (s[k] - start) / step
        for _ in range(FEET):
            at = min(place, last - 1e-6) if place > 0 else 0.0
            i = int(at)
            dx, dy = line[i + 1, 0] - line[i, 0], line[i + 1, 1] - line[i, 1]
            off = (x - line[i, 0]) * dx + (y - line[i, 1]) * dy
            place = min(max(i + off / (dx * dx + dy * dy) + place - at, 0.0), last)
        s[k] = start + step * place


def _on_curve(table: Table, strand: np.ndarray, s: Array, ds: float) -> tuple[Array, Array]:
    """Points and derivatives d/ds on the tabulated strands, linear between entries."""
    place = np.clip((s - table.s[0]) / ds, 0, len(table.s) - 1.000001)
    i = place.astype(int)
    here, there = table.strands[strand, i], table.strands[strand, i + 1]
    return here + (place - i)[:, None] * (there - here), (there - here) / ds
