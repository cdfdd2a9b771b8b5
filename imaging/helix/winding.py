"""Pairs of strands that wind round each other, and their link density."""

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
import pandas as pd
from scipy.spatial import cKDTree

from imaging.errors import Unmeasurable
from imaging.helix.measurement import HelixMeasurement
from imaging.helix.photograph import helices
from imaging.photo import Photo
from imaging.trace import Strand

TURNS = 4  # crossings in a row with the strands taking turns on top: two turns, not chance

Pair = tuple[int, int]


def winding_pairs(crossings: pd.DataFrame) -> list[Pair]:
    """Pairs of strands that take turns on top at TURNS crossings in a row, numbered from 1."""
    inter = crossings[crossings["kind"] == "inter"]
    return [
        (int(rows["strand_a"].iloc[0]), int(rows["strand_b"].iloc[0]))
        for _, rows in inter.groupby(["strand_a", "strand_b"])
        if _longest_turn(rows.sort_values("s_a")["over"].tolist()) >= TURNS
    ]


def _longest_turn(over: list) -> int:
    """Length of the longest run in which every known entry differs from the one before."""
    longest = run = 1
    for before, after in pairwise(over):
        known = not (pd.isna(before) or pd.isna(after))
        run = run + 1 if known and before != after else 1
        longest = max(longest, run)
    return longest


def wound(
    photo: Photo, strands: Sequence[Strand], pairs: Sequence[Pair]
) -> tuple[dict[Pair, HelixMeasurement], list[str]]:
    """Measure the link density of pairs of strands, in pixels.

    Returns
    -------
    found : dict
        A `HelixMeasurement` for each pair that could be measured.
    notes : list of str
        Why the others could not.
    """
    if not pairs:
        return {}, []
    every: list[HelixMeasurement | Unmeasurable]
    try:
        every = helices(photo)
    except Unmeasurable as error:
        every = [error]
    measured = [one for one in every if isinstance(one, HelixMeasurement)]
    reason = next((one for one in every if isinstance(one, Unmeasurable)), None)
    found, notes = {}, []
    for a, b in pairs:
        if measured:
            found[a, b] = min(measured, key=lambda one: _apart(one, strands[a - 1]))
        else:
            notes.append(f"strands {a} and {b} wind, but their link density is not known: {reason}")
    return found, notes


def _apart(one: HelixMeasurement, strand: Strand) -> float:
    """Typical distance [px] of a strand from a pair's axis."""
    return float(np.median(cKDTree(one.axis).query(strand.line)[0]))
