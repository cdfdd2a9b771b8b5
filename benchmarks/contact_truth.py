"""What becomes of near-parallel contact in drawn curls: resolved, rightly or wrongly, or not."""

from itertools import combinations
from typing import NamedTuple

import numpy as np
import pandas as pd
from scipy.spatial import cKDTree

from imaging import Strand, crossings
from imaging.trace.centreline import arclength

LONG = 5.0  # strand widths on which centrelines are less than a width apart: 23 degrees at most
NEAR = 8.0  # px between a crossing found and its place
MISTAKEN = 3.0  # px; a strand whose median error is larger is no strand of the truth


class Contacts(NamedTuple):
    """Counts of one curl.

    Attributes
    ----------
    right, open, wrong, lost : int
        True stretches of near-parallel contact whose crossings are counted rightly, that are called
        unresolved, the others, and those along which one of the strands was not followed at all.
    sure_found, sure_right : int
        Crossings found outside unresolved contact, and those of them that are there.
    sure_true, sure_seen : int
        True crossings outside unresolved contact of their pair, and those of them that are found.
    stretches : int
        Of unresolved contact.
    """

    right: int
    open: int
    wrong: int
    lost: int
    sure_found: int
    sure_right: int
    sure_true: int
    sure_seen: int
    stretches: int


def score_contacts(
    lines: list[np.ndarray],
    width: float,
    strands: list[Strand],
    table: pd.DataFrame,
    contacts: pd.DataFrame,
) -> Contacts:
    """Compare crossings `table` and unresolved `contacts` of the strands found with true lines."""
    owner = owners(lines, strands)
    truth, found = _places(crossings(lines)), _places(table, owner)
    open_to = _extents(strands, contacts, owner)
    verdicts = [
        _verdict(stretch, pair, truth, found, open_to)
        if all(_followed(stretch, k, owner, strands, width) for k in pair)
        else "lost"
        for pair in combinations(range(len(lines)), 2)
        for stretch in _near_parallel(lines[pair[0]], lines[pair[1]], width)
    ]
    sure = np.zeros(4, int)
    for pair in sorted(set(truth) | set(found)):
        known, seen = truth.get(pair, _NONE), found.get(pair, _NONE)
        known_sure = known[~_within(known, open_to.get(pair, []))]
        seen_sure = seen[~_within(seen, open_to.get(pair, []))]
        sure += len(seen_sure), _met(seen_sure, known), len(known_sure), _met(known_sure, seen)
    tally = [verdicts.count(verdict) for verdict in ("right", "open", "wrong", "lost")]
    return Contacts(*tally, *sure.tolist(), len(contacts))


def owners(lines: list[np.ndarray], strands: list[Strand]) -> list[int]:
    """Find the true strand nearest to each strand found, -1 for none."""
    trees = [cKDTree(line) for line in lines]
    far = [[np.median(tree.query(s.line)[0]) for tree in trees] for s in strands]
    return [int(np.argmin(f)) if min(f) < MISTAKEN else -1 for f in far]


_NONE = np.empty((0, 2))


def _places(table: pd.DataFrame, owner: list[int] | None = None) -> dict[tuple, np.ndarray]:
    """Places of crossings by pair of true strands; strands that are none are all number -1."""
    places: dict[tuple, list] = {}
    for row in table[table["kind"] == "inter"].itertuples():
        a, b = row.strand_a - 1, row.strand_b - 1
        pair = (a, b) if owner is None else tuple(sorted((owner[a], owner[b])))
        places.setdefault(pair, []).append((row.x, row.y))
    return {pair: np.array(points) for pair, points in places.items()}


def _extents(strands: list[Strand], contacts: pd.DataFrame, owner: list[int]) -> dict[tuple, list]:
    """Stretches of unresolved contact by pair of true strands, as points on the first."""
    found: dict[tuple, list] = {}
    for row in contacts[contacts["kind"] == "inter"].itertuples():
        line = strands[row.strand_a - 1].line
        s = arclength(line)
        pair = tuple(sorted((owner[row.strand_a - 1], owner[row.strand_b - 1])))
        found.setdefault(pair, []).append(line[(s >= row.s_a_from) & (s <= row.s_a_to)])
    return found


def _near_parallel(a: np.ndarray, b: np.ndarray, width: float) -> list[np.ndarray]:
    """Stretches of one line that are less than a width from another, for longer than LONG."""
    near = np.flatnonzero(cKDTree(b).query(a)[0] < width)
    s = arclength(a)
    parts = np.split(near, np.flatnonzero(np.diff(s[near]) > width) + 1) if len(near) else []
    return [a[part] for part in parts if s[part[-1]] - s[part[0]] > LONG * width]


def _followed(
    stretch: np.ndarray, number: int, owner: list[int], strands: list[Strand], width: float
) -> bool:
    """Tell whether a strand was found within two widths of where it runs beside another."""
    own = [s.line for s, k in zip(strands, owner, strict=True) if k == number]
    far = [cKDTree(line).query(stretch)[0] for line in own]
    return bool(far) and np.min(far, axis=0).max() < 2 * width


def _verdict(
    stretch: np.ndarray,
    pair: tuple[int, int],
    truth: dict[tuple, np.ndarray],
    found: dict[tuple, np.ndarray],
    open_to: dict[tuple, list],
) -> str:
    if any(cKDTree(one).query(stretch)[0].min() < NEAR for one in open_to.get(pair, [])):
        return "open"
    known = _within(truth.get(pair, _NONE), [stretch]).sum()
    seen = _within(found.get(pair, _NONE), [stretch]).sum()
    return "right" if known == seen else "wrong"


def _within(places: np.ndarray, stretches: list[np.ndarray]) -> np.ndarray:
    """Tell which places are near one of the stretches."""
    inside = np.zeros(len(places), bool)
    for stretch in stretches if len(places) else []:
        inside |= cKDTree(stretch).query(places)[0] < NEAR
    return inside


def _met(places: np.ndarray, others: np.ndarray) -> int:
    """Count places that have one of the others near."""
    if len(places) == 0 or len(others) == 0:
        return 0
    return int((cKDTree(others).query(places)[0] < NEAR).sum())
