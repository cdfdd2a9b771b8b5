"""What is combed and photographed in the virtual lab: scenes with the scatter of real specimens."""

from dataclasses import dataclass

import numpy as np

import sim

SEED = 20210309
PI1 = 18.0
RADIUS = 4.25e-4
HEIGHT = 0.15
PITCH_SCATTER = 0.02
FRICTION = (0.1, 0.3)
IMPERFECTION = 0.02
REPEATS = 5

HAIR_RADIUS = 7.5e-5
HAIRS = 12
CURLS = 4


@dataclass(frozen=True)
class Specimen:
    """A specimen: its name in file names, what varies, and the scene that it is."""

    name: str
    parameters: dict[str, float]
    scene: sim.Scene


def helices() -> list[Specimen]:
    """Five double helices as one would wind them: pitch, friction and straightness differ."""
    return [_helix(number) for number in range(1, REPEATS + 1)]


def curls() -> list[Specimen]:
    """Curls of twelve wavy hairs, each with its own curvatures and roots."""
    return [_curl(f"curl_{number}", seed=SEED + number) for number in range(1, CURLS + 1)]


def study_scenes() -> dict[str, str]:
    """TOML of the scenes that the demo's study compares with the specimens, by file name."""
    helix = (
        '# The paper\'s main case, frictionless.\npreset = "double_helix"\n'
        f"pi1 = {PI1}\npi2 = 1.0\npi3 = 2.0\nheight = {HEIGHT}\n"
    )
    curl = '# Twelve wavy hairs that hang and relax.\npreset = "curl"\nn = {n}\nseed = {seed}\n'
    scenes = {
        f"curl_{number}.toml": curl.format(n=HAIRS, seed=number) for number in range(1, CURLS + 1)
    }
    return {"double_helix.toml": helix, **scenes}


def _helix(number: int) -> Specimen:
    rng = np.random.default_rng([SEED, number])
    parameters = {
        "pi1": float(PI1 * (1 + PITCH_SCATTER * rng.standard_normal())),
        "friction": float(rng.uniform(*FRICTION)),
        "imperfection": IMPERFECTION,
        "seed": SEED + number,
    }
    scene = sim.double_helix(height=HEIGHT, **parameters)
    return Specimen(f"combing_{number}", parameters, scene)


def _curl(name: str, seed: int) -> Specimen:
    parameters: dict[str, float] = {"n": HAIRS, "seed": seed}
    return Specimen(name, parameters, sim.curl(**parameters))
