"""Photographs of a combing: before the tine, and with the tine on its way down."""

from dataclasses import dataclass

import numpy as np
import pandas as pd
from numpy.typing import NDArray

import sim
from combing.camera import Array, Camera
from combing.render import Tine
from combing.runs import tine_at
from combing.virtual_lab.photographs import NYLON, broadside, frame, photograph, smooth

PLACES = (0.004, 0.008, 0.014, 0.04, 0.065, 0.09)
WINDOW = 0.004  # m; how far from its place the tine may be when the picture is taken
PIXELS_PER_RADIUS = 8
TINE_SHOWN = 0.02


@dataclass(frozen=True)
class Shot:
    """A moment of a combing as it is photographed.

    Attributes
    ----------
    name : str
        File name without its ending.
    snapshot : int
        Number of the run's snapshot.
    d : float
        Tine displacement [m]; NaN before the tine is inserted.
    """

    name: str
    snapshot: int
    d: float


def shots(run: sim.Run) -> list[Shot]:
    """Choose the moments: before the tine, and near every place the most planar one.

    Ahead of the tine the pair kinks and whirls about the axis; a photographer waits until the
    kink shows its broad side.
    """
    chosen = [Shot("synthetic_helix_before", 0, float("nan"))]
    for number, place in enumerate(PLACES, start=1):
        near = np.flatnonzero(np.abs(run.displacements - place) <= WINDOW / 2)
        best = min(map(int, near), key=lambda snapshot: thickness(run.strands(snapshot)))
        name = f"synthetic_helix_{number}"
        chosen.append(Shot(name, best, float(run.displacements[best])))
    return chosen


def thickness(strands: list[Array]) -> float:
    """Spread of hanging strands along the direction in which they spread least [m]."""
    return float(np.std(np.concatenate(strands) @ broadside(strands)))


def strands_of(run: sim.Run, shot: Shot) -> list[Array]:
    """Centrelines as they are drawn (n, 3) [m]: a spline through the nodes."""
    return [smooth(strand) for strand in run.strands(shot.snapshot)]


def view(run: sim.Run, shot: Shot) -> Camera:
    """Camera of a shot: before the broad side of the kink, or along the tine to come."""
    strands = strands_of(run, shot)
    towards = np.array(run.scene.tines[0].axis) if np.isnan(shot.d) else broadside(strands)
    pixel = run.scene.rods[0].radius / PIXELS_PER_RADIUS
    return frame(strands, towards / np.linalg.norm(towards), pixel)


def take(run: sim.Run, shot: Shot, *, rng: np.random.Generator | int | None) -> NDArray[np.uint8]:
    """Take the picture (h, w, 3)."""
    tine = None if np.isnan(shot.d) else _tine(run, shot.d)
    strands = strands_of(run, shot)
    radius = run.scene.rods[0].radius
    return photograph(strands, radius, NYLON, view(run, shot), tine=tine, rng=rng)


def true_link(run: sim.Run, shot: Shot) -> pd.DataFrame:
    """Link density of the photographed strands by their topology: photo, s [m], link [1/m]."""
    table = sim.link_density(*strands_of(run, shot)[:2])
    return pd.DataFrame({"photo": shot.name, "s": table["s"], "link": table["link"]})


def _tine(run: sim.Run, d: float) -> Tine:
    (centre, axis), tine = tine_at(run, d), run.scene.tines[0]
    return Tine(centre, axis, tine.radius, min(tine.length, TINE_SHOWN))
