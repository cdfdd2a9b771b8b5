"""What must not be marched from: bodies that lie in each other as drawn."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from sim.errors import SceneError
from sim.guards.passing import deep_pairs, nearness, tight_bends
from sim.march.marching import Marching
from sim.march.state import centreline
from sim.scene import End, Rod, Scene

OVERLAP = 0.05  # of the contact distance
MESH = 0.3  # of the contact distance: most that is laid to the chords of curved strands


def refuse_start(march: Marching) -> None:
    """Refuse a scene whose strands or tines lie in each other as drawn.

    Pushed apart where the contact asks for it: what is in each other then is known to the guards.

    Raises
    ------
    SceneError
        Two strands overlap by more than 5 % of the contact distance, the sagitta of their chords
        left out, a tine covers a clamped or pinned end, or a strand lies in a plane or behind it.
    """
    _refuse_covered_ends(march)
    _refuse_buried(march)
    contact = march.scene.contact
    if contact is not None and contact.overlap == "refuse":
        _refuse_overlap(march)
    march.deep, march.tight = deep_pairs(march), tight_bends(march)


def _refuse_overlap(march: Marching) -> None:
    pairs = deep_pairs(march, 1 - OVERLAP)
    if len(pairs) == 0:
        return
    a, b = pairs.T
    reach = march.state.row("RADIUS")[a] + march.state.row("RADIUS")[b]
    bulge = _sagitta(march)
    near = np.array([nearness(march, *pair) for pair in pairs.tolist()])
    gap = near + np.minimum((bulge[a] + bulge[b]) / reach, MESH)
    worst = int(np.argmin(gap))
    if gap[worst] >= 1 - OVERLAP:
        return
    (rod, element), (other, there) = (march.state.place(int(i)) for i in pairs[worst])
    raise SceneError(
        f"rods.{rod} and rods.{other} lie in each other as drawn: elements {element} and {there} "
        f"are {near[worst]:.2f} of the contact distance apart; draw them farther apart or thinner, "
        'or have them pushed apart: contact.overlap = "push apart"'
    )


def _sagitta(march: Marching) -> NDArray[np.float64]:
    """Return how far the curve through the nodes bulges out of each element [m], (n,)."""
    x = march.state.rows("X0 X1 X2")
    bent = np.linalg.norm(np.roll(x, -1, axis=1) - 2 * x + np.roll(x, 1, axis=1), axis=0)
    bent *= march.state.row("PREVIOUS") * march.state.row("NEXT")
    return np.maximum(bent, np.roll(bent, -1)) / 8


def _refuse_covered_ends(march: Marching) -> None:
    """Refuse tines that, fully grown, cover an end that is held: it could not give way."""
    scene, x = march.scene, march.state.rows("X0 X1 X2").T
    for number, rod in enumerate(scene.rods):
        at = march.state.nodes(number)
        for end, node in ((rod.root, at.start), (rod.tip, at.stop - 1)):
            for m, tine in enumerate(scene.tines):
                gap = _distance_to_axis(x[node], tine.position, tine.axis, tine.length)
                if end.hold != "free" and gap < (1 - OVERLAP) * (tine.radius + rod.radius):
                    raise SceneError(
                        f"tines.{m}: {gap:.3g} m from the {end.hold} end of rod {number}, which "
                        f"it covers with its radius of {tine.radius:.3g} m; make it thinner or put "
                        "it elsewhere"
                    )


def _refuse_buried(march: Marching) -> None:
    """Refuse strands that lie in a plane or behind it."""
    for m, plane in enumerate(march.scene.planes):
        normal = np.array(plane.normal) / np.linalg.norm(plane.normal)
        for number, nodes in enumerate(march.state.strands()):
            height = (nodes - plane.point) @ normal
            node, radius = int(np.argmin(height)), march.scene.rods[number].radius
            if height[node] < (1 - OVERLAP) * radius:
                raise SceneError(
                    f"planes.{m}: node {node} of rod {number}, of radius {radius:.3g} m, is drawn "
                    f"{height[node]:.3g} m above it; draw the rod on the side where normal = "
                    f"{plane.normal} leads, clear of the plane"
                )


def _distance_to_axis(
    x: NDArray[np.float64],
    middle: tuple[float, float, float],
    axis: tuple[float, float, float],
    length: float,
) -> float:
    unit = np.array(axis) / np.linalg.norm(axis)
    along = np.clip((x - middle) @ unit, -length / 2, length / 2)
    return float(np.linalg.norm(x - middle - along * unit))


def notes(scene: Scene) -> list[str]:
    """Return what a user should know of a scene before it is simulated."""
    if scene.tines or scene.contact is not None and len(scene.rods) > 1:
        return []
    return [
        f"rods.{number} is perfectly straight and nothing pushes it aside: it cannot buckle, "
        "however hard it is pressed or twisted; give it a little curvature, say "
        f"{{sd = {0.01 / _length(rod):.2g}, correlation = {_length(rod):.2g}}}"
        for number, rod in enumerate(scene.rods)
        if _cannot_buckle(rod, scene.gravity)
    ]


def _length(rod: Rod) -> float:
    return float(np.linalg.norm(np.diff(centreline(rod), axis=0), axis=1).sum())


def _cannot_buckle(rod: Rod, gravity: tuple[float, float, float] | None) -> bool:
    """Tell whether a rod is pressed or twisted along its axis alone, without any imperfection."""
    nodes = centreline(rod)
    axis = (nodes[-1] - nodes[0]) / np.linalg.norm(nodes[-1] - nodes[0])
    curved = rod.curvature is not None and rod.curvature.sd > 0
    drives = [drive for end in (rod.root, rod.tip) for drive in _drives(end)]
    if curved or not any(np.any(drive) for drive in drives) or _off(nodes - nodes[0], axis) > 1e-9:
        return False
    return all(_off(np.array(v, float), axis) == 0 for v in (*drives, gravity or (0, 0, 0)))


def _off(vectors: NDArray[np.float64], axis: NDArray[np.float64]) -> float:
    """Return how far vectors lead away from an axis, as a part of the longest of them."""
    size = float(np.linalg.norm(vectors, axis=-1).max())
    across = float(np.linalg.norm(np.cross(vectors, axis), axis=-1).max())
    return 0.0 if across <= 1e-12 * size else across / size


def _drives(end: End) -> list[tuple[float, float, float]]:
    """Return velocity, spin, force and couple of an end."""
    motion = [] if end.motion is None else [end.motion.velocity, end.motion.spin]
    load = [] if end.load is None else [end.load.force, end.load.couple]
    return [*motion, *load]
