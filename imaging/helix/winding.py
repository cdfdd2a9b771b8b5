"""Pairs of strands that wind round each other, and their link density."""

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
import pandas as pd

from imaging.errors import Unmeasurable
from imaging.helix.colours import split_colours
from imaging.helix.measurement import HelixMeasurement
from imaging.helix.photograph import helix
from imaging.photo import Photo
from imaging.segment import Segmentation
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
    photo: Photo, segmentation: Segmentation, strands: Sequence[Strand], pairs: Sequence[Pair]
) -> tuple[dict[Pair, HelixMeasurement], list[str]]:
    """Measure the link density of pairs of strands, in pixels.

    Returns
    -------
    found : dict
        A `HelixMeasurement` for each pair that could be measured.
    notes : list of str
        Why the others could not.
    """
    found, notes = {}, []
    for a, b in pairs:
        try:
            colours = [segmentation.colours[strands[i - 1].colour] for i in (a, b)]
            found[a, b] = helix(photo, colours=_indices(photo, segmentation, colours))
        except Unmeasurable as error:
            notes.append(f"strands {a} and {b} wind, but their link density is not known: {error}")
    return found, notes


def _indices(photo: Photo, segmentation: Segmentation, colours: list[np.ndarray]) -> Pair | None:
    """Find two colours among those that `helix` tells apart; None where it sees no others."""
    known = split_colours(photo, segmentation).colours
    if len(known) <= 2:
        return None
    first, second = (int(np.linalg.norm(known - c, axis=1).argmin()) for c in colours)
    return None if first == second else (first, second)
