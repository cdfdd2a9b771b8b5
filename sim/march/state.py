"""A scene's rods laid out in the buffer that the kernels work on."""

from __future__ import annotations

import math
import mmap
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sim.errors import SceneError
from sim.kernels import layout
from sim.scene import End, Helix, Material, Rod, Scene, Straight, shapes

Array = NDArray[np.float64]

FOLDED = 1e-9  # 1 + cosine of a turn within 5e-5 of 180 degrees: it has no plane


@dataclass
class State:
    """The buffer of all rods and where each lies in it.

    Attributes
    ----------
    buf : (ROWS * PITCH,) float64
        See `sim.kernels.layout`.
    n : int
        Number of indices in use, ghosts included.
    first : list of int
        Index of every rod's root node.
    elements : list of int
        Number of elements of every rod.
    """

    buf: Array
    n: int
    first: list[int]
    elements: list[int]

    def row(self, name: str) -> Array:
        """Return the used part of one row as a view, (n,)."""
        start = layout.ROW[name] * layout.PITCH
        return self.buf[start : start + self.n]

    def used(self) -> Array:
        """Return the used part of all rows and the index behind it as a view, (ROWS, n + 1)."""
        return self.buf.reshape(layout.ROWS, layout.PITCH)[:, : self.n + 1]

    def rows(self, names: str) -> Array:
        """Return several rows by name, separated by blanks, as one (rows, n) copy."""
        return np.stack([self.row(name) for name in names.split()])

    def nodes(self, rod: int) -> slice:
        """Return the indices of a rod's nodes."""
        return slice(self.first[rod], self.first[rod] + self.elements[rod] + 1)

    def place(self, index: int) -> tuple[int, int]:
        """Return the rod that an index is on, and its number there."""
        rod = int(np.searchsorted(self.first, index, side="right") - 1)
        return rod, index - self.first[rod]

    def strands(self) -> list[Array]:
        """Return the centreline of every rod, (n, 3) [m], root to tip."""
        positions = self.rows("X0 X1 X2").T
        return [positions[self.nodes(rod)].copy() for rod in range(len(self.first))]

    def frames(self) -> list[Array]:
        """Return the directors of every rod's elements, (n - 1, 3, 3), rows d1, d2, d3."""
        directors = self.rows("Q00 Q01 Q02 Q10 Q11 Q12 Q20 Q21 Q22").T.reshape(-1, 3, 3)
        return [directors[self.nodes(rod)][:-1] for rod in range(len(self.first))]

    def rod_of_element(self) -> NDArray[np.int32]:
        """Return the rod that every element belongs to, -1 for ghosts."""
        rod = np.full(self.n, -1, np.int32)
        for number, (first, count) in enumerate(zip(self.first, self.elements, strict=True)):
            rod[first : first + count] = number
        return rod


def empty_buffer() -> Array:
    """Return a zeroed buffer whose memory the system hands out only where it is touched."""
    return np.frombuffer(mmap.mmap(-1, 8 * layout.ROWS * layout.PITCH), dtype=np.float64)


def build(scene: Scene) -> State:
    """Lay out the rods of a scene, at rest.

    Raises
    ------
    SceneError
        There are more elements than the buffer holds, a rod has an element without length, or it
        turns by half a turn or more from one element to the next.
    """
    elements = [_element_count(rod) for rod in scene.rods]
    # A ghost element before every root and after every tip: the frames of their clamps.
    first = list(1 + np.concatenate([[0], np.cumsum(np.array(elements[:-1], int) + 2)]).astype(int))
    n = int(first[-1] + elements[-1] + 1)
    if n >= layout.CAPACITY:
        raise SceneError(f"rods: {sum(elements)} elements; at most {layout.CAPACITY} fit")
    state = State(empty_buffer(), n, first, elements)
    for name in ("Q00", "Q11", "Q22"):
        state.row(name)[:] = 1.0
    for number, rod in enumerate(scene.rods):
        _fill_rod(state, number, rod, scene)
    return state


def _element_count(rod: Rod) -> int:
    return rod.elements if isinstance(rod.shape, Helix | Straight) else len(rod.shape.nodes) - 1


def centreline(rod: Rod) -> Array:
    """Return the nodes of a rod as drawn, (elements + 1, 3) [m]."""
    shape = rod.shape
    if isinstance(shape, Helix):
        return shapes.helix(
            shape.radius, shape.pitch, shape.height, rod.elements, shape.phase,
            left=shape.handedness == "left",
        )  # fmt: skip
    if isinstance(shape, Straight):
        return shapes.straight(
            np.array(shape.root), np.array(shape.direction), shape.length, rod.elements
        )
    return np.array(shape.nodes, float)


def _fill_rod(state: State, number: int, rod: Rod, scene: Scene) -> None:
    nodes = centreline(rod)
    drawn = np.linalg.norm(np.diff(nodes, axis=0), axis=1)
    _refuse_shape(number, rod, nodes, drawn)
    lengths = drawn / _stretch(number, rod, len(drawn))
    at = state.nodes(number)
    within = slice(at.start, at.stop - 1)
    directors = shapes.frames(nodes)
    for axis in range(3):
        state.row(f"X{axis}")[at] = nodes[:, axis]
        for k in range(3):
            state.row(f"Q{axis}{k}")[within] = directors[:, axis, k]
    _fill_elements(state, within, rod, lengths, scene.rotary_inertia)
    _fill_nodes(state, at, rod, lengths)
    _fill_vertices(
        state, at, rod, lengths, directors, np.random.default_rng([scene.seed, 2, number])
    )
    _refuse_rest(state, number, at)
    _hold(state, rod, rod.root, at.start, at.start - 1, lengths[0], directors[0])
    _hold(state, rod, rod.tip, at.stop - 1, at.stop - 1, lengths[-1], directors[-1])


def _refuse_shape(number: int, rod: Rod, nodes: Array, lengths: Array) -> None:
    """Refuse nodes that coincide and turns that no frames can follow."""
    if not lengths.min() > 0:
        raise SceneError(
            f"rods.{number}.shape: element {int(np.argmin(lengths))} has no length; "
            "two neighbouring nodes coincide"
        )
    if isinstance(rod.shape, Helix):
        turns = rod.shape.height / rod.shape.pitch
        if 2 * turns >= rod.elements:
            raise SceneError(
                f"rods.{number}.elements = {rod.elements}: {turns / rod.elements:.3g} of a turn of "
                f"the helix per element cannot be told from less than half a turn; ask for more "
                f"than {math.ceil(2 * turns)}, better {math.ceil(12 * turns)}"
            )
    tangents = np.diff(nodes, axis=0) / lengths[:, None]
    straightness = 1 + np.einsum("ij,ij->i", tangents[1:], tangents[:-1])
    if straightness.min() < FOLDED:
        raise SceneError(
            f"rods.{number}.shape: the strand folds back onto itself by 180 degrees at node "
            f"{int(np.argmin(straightness)) + 1}; round the fold off over several nodes"
        )


def _stretch(number: int, rod: Rod, elements: int) -> Array | float:
    """Return by how much elements are longer as drawn than without tension, (elements,) or one."""
    if isinstance(rod.stretch, list) and len(rod.stretch) != elements:
        raise SceneError(
            f"rods.{number}.stretch: {len(rod.stretch)} values for {elements} elements; give one "
            "for each, or one for all"
        )
    return np.array(rod.stretch)


def _refuse_rest(state: State, number: int, at: slice) -> None:
    """Refuse a rest shape that turns by half a turn or more from one element to the next."""
    inner = slice(at.start + 1, at.stop - 1)
    turns = (
        np.linalg.norm(state.rows("K0 K1 K2")[:, inner], axis=0) / state.row("INV_VORONOI")[inner]
    )
    if turns.max() >= np.pi:
        raise SceneError(
            f"rods.{number}: its rest shape turns by {turns.max():.3g} rad, half a turn or more, "
            f"at node {int(np.argmax(turns)) + 1}; make elements shorter or the curvature smaller"
        )


def _fill_elements(state: State, at: slice, rod: Rod, lengths: Array, rotary_inertia: str) -> None:
    material, radius = rod.material, rod.radius
    area, second_moment = np.pi * radius**2, np.pi * radius**4 / 4
    inertia = material.density * second_moment * lengths
    polar = 2 * inertia
    if rotary_inertia == "element":
        # An element's own extent: vanishes as its length squared, and lengthens the time step.
        inertia = inertia + material.density * area * lengths**3 / 12
    state.row("LENGTH")[at], state.row("INV_LENGTH")[at] = lengths, 1 / lengths
    state.row("RADIUS")[at] = radius
    state.row("SHEAR")[at] = material.shear_coefficient * material.shear_modulus * area
    state.row("STRETCH")[at] = material.E * area
    state.row("INV_J1")[at], state.row("INV_J3")[at] = 1 / inertia, 1 / polar
    state.row("J_RATIO")[at] = polar / inertia - 1


def _fill_nodes(state: State, at: slice, rod: Rod, lengths: Array) -> None:
    line_density = rod.material.density * np.pi * rod.radius**2
    padded = np.concatenate([[0], lengths, [0]])
    mass = line_density * 0.5 * (padded[:-1] + padded[1:])
    state.row("MASS")[at], state.row("INV_MASS")[at] = mass, 1 / mass
    state.row("PREVIOUS")[at.start + 1 : at.stop] = 1.0
    state.row("NEXT")[at.start : at.stop - 1] = 1.0


def _fill_vertices(
    state: State, at: slice, rod: Rod, lengths: Array, directors: Array, rng: np.random.Generator
) -> None:
    inner = slice(at.start + 1, at.stop - 1)
    voronoi = 0.5 * (lengths[:-1] + lengths[1:])
    bend, twist = rigidities(rod.material, rod.radius)
    state.row("INV_VORONOI")[inner] = 1 / voronoi
    state.row("BEND")[inner], state.row("TWIST")[inner] = bend, twist
    rest = (
        shapes.curvature(directors, voronoi) if rod.rest == "drawn" else np.zeros((len(voronoi), 3))
    )
    for axis in range(3):
        state.row(f"K{axis}")[inner] = rest[:, axis]
    if rod.curvature is not None:
        drawn = shapes.random_curvature(
            lengths, rod.curvature.sd, rod.curvature.correlation, rng=rng
        )
        for axis in range(2):
            state.row(f"K{axis}")[at] += drawn[:, axis]


def _hold(
    state: State, rod: Rod, end: End, node: int, ghost: int, length: float, directors: Array
) -> None:
    """Hold an end's node, and bend its half element against a ghost, the clamp's frame.

    Holding the element itself would leave its half of the bending out, an error of first order: 6 %
    of a cantilever's deflection at 32 elements.
    """
    if end.hold == "free":
        return
    if end.slides is None:
        state.row("INV_MASS")[node] = 0.0
    if end.hold == "pinned":
        return
    for axis in range(3):
        for k in range(3):
            state.row(f"Q{axis}{k}")[ghost] = directors[axis, k]
    bend, twist = rigidities(rod.material, rod.radius)
    state.row("INV_VORONOI")[node] = 2 / length
    state.row("BEND")[node], state.row("TWIST")[node] = bend, twist


def rigidities(material: Material, radius: float) -> tuple[float, float]:
    """Return the bending rigidity B = E I and the twisting rigidity C = G J [N m^2]."""
    second_moment = np.pi * radius**4 / 4
    return material.E * second_moment, 2 * material.shear_modulus * second_moment
