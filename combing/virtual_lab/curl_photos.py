"""Photographs of settled curls whose hairs are dyed in twelve colours, and what is true of them."""

import numpy as np
import pandas as pd
from numpy.typing import NDArray

import imaging
import sim
from combing.camera import Array, Camera, project
from combing.virtual_lab.palette import palette
from combing.virtual_lab.photographs import frame, photograph, smooth
from combing.virtual_lab.specimens import HAIR_RADIUS

PIXEL = 2 * HAIR_RADIUS / 5
TOWARDS = np.array([0.0, 1, 0])


def hairs_of(run: sim.Run) -> list[Array]:
    """Centrelines of the settled curl as they are drawn (n, 3) [m]."""
    return [smooth(strand) for strand in run.strands(-1)]


def view(run: sim.Run) -> Camera:
    """Camera before a curl."""
    return frame(hairs_of(run), TOWARDS, PIXEL)


def take(run: sim.Run, *, rng: np.random.Generator | int | None) -> NDArray[np.uint8]:
    """Take the picture (h, w, 3)."""
    hairs = hairs_of(run)
    return photograph(hairs, HAIR_RADIUS, palette(len(hairs)), view(run), rng=rng)


def true_interactions(run: sim.Run, name: str, n_sec: int) -> pd.DataFrame:
    """N-body interactions of the true centrelines in the picture: photo, section, N, count."""
    lines = [project(hair, view(run)) for hair in hairs_of(run)]
    found = imaging.interactions(lines, n_sec)
    found.insert(0, "photo", name)
    return found[["photo", "section", "N", "count"]]
