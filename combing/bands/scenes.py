"""The scenes behind a band: the same one on a coarser mesh, and members of an ensemble."""

from collections.abc import Mapping

import sim
from combing.ensemble import perturbed
from sim.scene import Helix, Points, Rod

RATIO = 1.5  # elements of a scene over those of its coarser one
FEWEST = 3.0  # elements a pitch of a helix, below which it is none; of any rod, 4


def scenes_of_bands(scene: sim.Scene, members: int, size: float) -> Mapping[int, sim.Scene]:
    """Return the scene as 0, its members as 1, 2, ..., its coarser one, if it has one, as -1."""
    found = {0: scene}
    found |= {k: perturbed(scene, scene.seed + k, size) for k in range(1, members + 1)}
    coarse = coarser(scene)
    return found if coarse is None else found | {-1: coarse}


def coarser(scene: sim.Scene, ratio: float = RATIO) -> sim.Scene | None:
    """Return the scene with fewer elements; None where a rod cannot have fewer."""
    rods = [_coarser(rod, ratio) for rod in scene.rods]
    if any(rod is None for rod in rods):
        return None
    return scene.model_copy(update={"rods": rods, "title": scene.title})


def _coarser(rod: Rod, ratio: float) -> Rod | None:
    elements = round(rod.elements / ratio)
    if isinstance(rod.shape, Points) or isinstance(rod.stretch, list) or elements < 4:
        return None
    if isinstance(rod.shape, Helix) and elements < FEWEST * rod.shape.height / rod.shape.pitch:
        return None
    return rod.model_copy(update={"elements": elements})
