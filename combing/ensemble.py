"""Ensembles: the same scene with small imperfections, drawn from a seed, as repeats have them.

After the first release of a jam a combing depends chaotically on details (docs/accuracy.md), so one
run says little there. What a simulated band shows is an ensemble, as an experiment's is of repeats.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

import sim
from sim.march.state import centreline
from sim.scene import Helix, RandomCurvature, Rod
from sim.scene.presets import DoubleHelix, preset_scene

IMPERFECTION = 0.02  # where the parameters name none; the virtual lab's specimens scatter as much
STREAM = 7  # sets these draws apart from those that the scene's own seed makes


@dataclass(frozen=True)
class Member:
    """A scene of a preset and how it came about.

    Attributes
    ----------
    preset : str
        Name of the preset.
    parameters : mapping
        Parameters as they were asked for, without imperfections.
    seed : int or None
        What the imperfections are drawn from; None: the scene as drawn.
    scene : Scene
    setting : mapping, optional
        Mesh, step, speed and stiffness, where they were chosen for a tolerance.
    """

    preset: str
    parameters: Mapping[str, Any]
    seed: int | None
    scene: sim.Scene
    setting: Mapping[str, float] | None = None


def members(
    preset: str, parameters: Mapping[str, Any], seeds: Sequence[int] | None
) -> list[Member]:
    """Return the members of an ensemble, one a seed; without seeds the scene itself.

    The size of the imperfections is the parameter `imperfection`, 2 % where it is left out. A
    double helix gets a pitch off by a normal draw of that share, a second strand turned about the
    axis by that share of half a turn, and each strand a random intrinsic curvature of that share of
    the helix's own (`sim.scene.presets.DoubleHelix`). A curl is drawn anew.

    Raises
    ------
    sim.SceneError
        If a parameter is unknown or out of range.
    """
    if seeds is None:
        return [Member(preset, parameters, None, preset_scene(preset, dict(parameters)))]
    return [Member(preset, parameters, seed, _drawn(preset, parameters, seed)) for seed in seeds]


def _drawn(preset: str, parameters: Mapping[str, Any], seed: int) -> sim.Scene:
    if preset != "double_helix":
        return preset_scene(preset, {**parameters, "seed": seed})
    size = parameters.get("imperfection", IMPERFECTION)
    pitch, phase = np.random.default_rng([seed, STREAM]).standard_normal(2)
    asked = {**parameters, "imperfection": size, "seed": seed}
    nominal = asked.get("pi1", DoubleHelix.model_fields["pi1"].default)
    scene = preset_scene(preset, asked | {"pi1": nominal * (1 + size * pitch)})
    first, second = scene.rods
    shape = second.shape
    assert isinstance(shape, Helix)  # noqa: S101 (a double helix has two)
    turned = shape.model_copy(update={"phase": shape.phase + np.pi * size * phase})
    return scene.model_copy(update={"rods": [first, second.model_copy(update={"shape": turned})]})


def perturbed(scene: sim.Scene, seed: int, size: float = IMPERFECTION) -> sim.Scene:
    """Return a scene with a random intrinsic curvature in every strand, drawn from a seed.

    Its sd is `size` times the strand's own curvature (of a straight one, pi over its length), its
    correlation length the pitch of a helix, else a tenth of the length: what is bent by hand is off
    by as much. Strands whose curvature is random already are drawn anew instead.
    """
    rods = [rod if rod.curvature else _bent(rod, size) for rod in scene.rods]
    return scene.model_copy(update={"rods": rods, "seed": seed})


def _bent(rod: Rod, size: float) -> Rod:
    if isinstance(rod.shape, Helix):
        radius, rise = rod.shape.radius, rod.shape.pitch / (2 * np.pi)
        own, correlation = radius / (radius**2 + rise**2), rod.shape.pitch
    else:
        chords = np.diff(centreline(rod), axis=0)
        lengths = np.linalg.norm(chords, axis=1)
        along = chords / lengths[:, None]
        turns = np.linalg.norm(np.diff(along, axis=0), axis=1)
        whole = float(lengths.sum())
        bend = float(np.sqrt(np.sum(turns**2 / lengths[1:]) / whole))
        own, correlation = max(bend, np.pi / whole), whole / 10
    return rod.model_copy(
        update={"curvature": RandomCurvature(sd=size * own, correlation=correlation)}
    )
