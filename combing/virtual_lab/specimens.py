"""What is combed and photographed in the virtual lab: scenes with the scatter of real specimens."""

from dataclasses import dataclass
from typing import Any

import numpy as np

import sim

SEED = 20210309
PI1 = 18.0
RADIUS = 4.25e-4
HEIGHT = 0.15
YOUNG = 0.078 * 2.8e9
PITCH_SCATTER = 0.02
FRICTION = (0.1, 0.3)
IMPERFECTION = 0.02
REPEATS = 5
SNAPSHOTS = 201

HAIR_RADIUS = 7.5e-5
HAIRS = 12
CURLS = 3


@dataclass(frozen=True)
class Specimen:
    """A specimen: its name in file names, what sets it apart, and the scene that it is."""

    name: str
    parameters: dict[str, Any]
    scene: sim.Scene


def helices() -> list[Specimen]:
    """Five double helices as one would wind them: pitch, friction and straightness differ."""
    return [_helix(number) for number in range(1, REPEATS + 1)]


def curls() -> list[Specimen]:
    """Curls of twelve wavy hairs, each with its own curvatures and roots."""
    return [_curl(number) for number in range(1, CURLS + 1)]


def study_scenes() -> dict[str, str]:
    """TOML of the scenes that the demo's study compares with the specimens, by file name."""
    helix = (
        "# The paper's main case: no friction, no imperfection.\n"
        f'preset = "double_helix"\npi1 = {PI1}\npi2 = 1.0\npi3 = 2.0\nheight = {HEIGHT}\n'
    )
    scenes = {"double_helix.toml": helix}
    for number in range(1, CURLS + 1):
        scenes[f"curl_{number}.toml"] = (
            "# Twelve wavy hairs that hang and relax.\n"
            f'preset = "curl"\nn = {HAIRS}\nseed = {number}\nsnapshots = 2\n'
        )
    return scenes


def _helix(number: int) -> Specimen:
    rng = np.random.default_rng([SEED, number])
    parameters = {
        "pi1": round(float(PI1 * (1 + PITCH_SCATTER * rng.standard_normal())), 3),
        "friction": round(float(rng.uniform(*FRICTION)), 3),
        "imperfection": IMPERFECTION,
        "seed": SEED + number,
    }
    scene = sim.double_helix(height=HEIGHT, snapshots=SNAPSHOTS, **parameters)
    return Specimen(f"synthetic_combing_{number}", parameters, scene)


def _curl(number: int) -> Specimen:
    parameters = {"n": HAIRS, "seed": SEED + number}
    return Specimen(f"synthetic_curl_{number}", parameters, sim.curl(snapshots=2, **parameters))
