"""Contact that the picture does not resolve: where two strands may cross twice, or only touch.

Strategy: along each pair of strands, find the stretches on which their centrelines are closer than
their joint uncertainty allows to tell apart. A stretch with one crossing in it is a crossing, as
the strands have changed sides, unless it is too long to say where. Any other number of crossings,
none included, is one guess among several.
"""

from collections.abc import Sequence
from itertools import combinations_with_replacement
from typing import NamedTuple

import numpy as np
import pandas as pd
from scipy.spatial import cKDTree

from imaging.trace import Strand
from imaging.trace.centreline import arclength, normals

TOGETHER = 2.0  # joint sds; two centrelines closer than this are not told apart
CLOSEST = 1.0  # joint sds; only those that come closer than this may have crossed unseen
FARTHEST = 2.0  # strand widths; farther apart nothing is in contact, whatever the sd
BREAK = 1.0  # strand widths by which a stretch may be interrupted
LONG = 10.0  # strand widths; in a longer stretch one crossing is not placed, and may be three
FOLD = 4.0  # strand widths along a strand within which it is always near itself
COLUMNS = {
    "strand_a": int, "strand_b": int, "kind": object, "crossings": int, "s_a_from": float,
    "s_a_to": float, "s_b_from": float, "s_b_to": float, "x_from": float, "y_from": float,
    "x_to": float, "y_to": float,
}  # fmt: skip


class Near(NamedTuple):
    """Points of one strand near another: indices on both, distance over its joint sd."""

    on_a: np.ndarray
    on_b: np.ndarray
    apart: np.ndarray


def unresolved(strands: Sequence[Strand], table: pd.DataFrame) -> pd.DataFrame:
    """Find the stretches of contact in which the number or the place of crossings is a guess.

    Parameters
    ----------
    strands : sequence of Strand
    table : DataFrame
        Result of ``crossings(strands, ...)``.

    Returns
    -------
    DataFrame
        One row a stretch: ``strand_a`` <= ``strand_b``, ``kind`` inter or self, ``crossings`` of
        the table that lie in it, its extent along both strands (``s_a_from`` < ``s_a_to``,
        ``s_b_from`` < ``s_b_to``) and, on the first, from ``x_from``, ``y_from`` to ``x_to``,
        ``y_to`` [px].

    Notes
    -----
    Set on 24 rendered curls of 12 strands: stretches with one crossing held one in 98 of 100 up to
    10 widths and in 14 of 21 beyond; those with two or more held as many in half the cases; those
    with none held two in 19 of 44 where the lines came within one sd, and in none of 120 otherwise.
    """
    if not strands:
        return _typed([])
    width = float(np.median(np.concatenate([strand.width for strand in strands])))
    trees = [cKDTree(strand.line) for strand in strands]
    across = [normals(strand.line) for strand in strands]
    along = [arclength(strand.line) for strand in strands]
    who, where = (table[[f"{what}_a", f"{what}_b"]].to_numpy() for what in ("strand", "s"))
    rows = []
    for a, b in combinations_with_replacement(range(len(strands)), 2):
        near = _near(strands[a], strands[b], trees[a], trees[b], across[b], width)
        own = where[(who == (a + 1, b + 1)).all(axis=1)]
        for stretch in _stretches(near, along[a], width):
            row = _row(stretch, strands[a].line, along[a], along[b], own)
            if _is_unresolved(row, stretch, width):
                rows.append({"strand_a": a + 1, "strand_b": b + 1, **row})
    kinds = {True: "self", False: "inter"}
    return _typed([{**row, "kind": kinds[row["strand_a"] == row["strand_b"]]} for row in rows])


def _typed(rows: list[dict]) -> pd.DataFrame:
    """Table of rows; one without any has the same types in its columns."""
    return pd.DataFrame(rows, columns=list(COLUMNS)).astype(COLUMNS)


def _near(
    a: Strand, b: Strand, tree_a: cKDTree, tree_b: cKDTree, normal: np.ndarray, width: float
) -> Near:
    """Points of `a` that are not told apart from the nearest point of `b`."""
    reach = min(TOGETHER * float(np.hypot(a.sd.max(), b.sd.max())) + 1, FARTHEST * width)
    if a is b:
        on_a, on_b = _nearest_of_itself(tree_a, reach, FOLD * width)
    else:
        far, nearest = tree_b.query(a.line, distance_upper_bound=reach)
        on_a = np.flatnonzero(np.isfinite(far))
        on_b = nearest[on_a]
    across = ((a.line[on_a] - b.line[on_b]) * normal[on_b]).sum(axis=1)
    apart = np.abs(across) / np.hypot(a.sd[on_a], b.sd[on_b])
    together = apart < TOGETHER
    return Near(on_a[together], on_b[together], apart[together])


def _nearest_of_itself(tree: cKDTree, reach: float, fold: float) -> tuple[np.ndarray, np.ndarray]:
    """Pairs of points i < j of one line, far along it yet close, the closest for each i."""
    pairs = tree.query_pairs(reach, output_type="ndarray")
    pairs = pairs[np.abs(pairs[:, 1] - pairs[:, 0]) > fold]
    far = np.hypot(*(tree.data[pairs[:, 0]] - tree.data[pairs[:, 1]]).T)
    pairs = pairs[np.lexsort((far, pairs[:, 0]))]
    _, first = np.unique(pairs[:, 0], return_index=True)
    return pairs[first, 0], pairs[first, 1]


def _stretches(near: Near, s: np.ndarray, width: float) -> list[Near]:
    """Cut where a strand is away from the other for longer than BREAK."""
    if len(near.on_a) == 0:
        return []
    cuts = np.flatnonzero(np.diff(s[near.on_a]) > BREAK * width) + 1
    parts = zip(*(np.split(column, cuts) for column in near), strict=True)
    return [Near(*part) for part in parts]


def _row(
    stretch: Near, line: np.ndarray, along_a: np.ndarray, along_b: np.ndarray, own: np.ndarray
) -> dict[str, float]:
    """Extent of a stretch, and how many of a pair's crossings (n, 2: arclengths) lie in it."""
    s_a, s_b = along_a[stretch.on_a], along_b[stretch.on_b]
    low, high = np.array([[s_a[0], s_b.min()], [s_a[-1], s_b.max()]])
    inside = ((own >= low - 1) & (own <= high + 1)).all(axis=1)  # points are about a pixel apart
    (x_from, y_from), (x_to, y_to) = line[stretch.on_a[[0, -1]]]
    return {
        "crossings": int(inside.sum()),
        "s_a_from": s_a[0], "s_a_to": s_a[-1], "s_b_from": s_b.min(), "s_b_to": s_b.max(),
        "x_from": x_from, "y_from": y_from, "x_to": x_to, "y_to": y_to,
    }  # fmt: skip


def _is_unresolved(row: dict[str, float], stretch: Near, width: float) -> bool:
    if row["crossings"] == 1:
        return bool(row["s_a_to"] - row["s_a_from"] > LONG * width)
    return row["crossings"] > 1 or bool(stretch.apart.min() < CLOSEST)


def contact_of(table: pd.DataFrame, stretches: pd.DataFrame) -> pd.Series:
    """Return the number (from 1) of the unresolved stretch each crossing lies in, <NA> for none."""
    number = pd.Series(pd.NA, index=table.index, dtype="Int64")
    for i, row in enumerate(stretches.to_dict("records"), start=1):
        inside = (table["strand_a"] == row["strand_a"]) & (table["strand_b"] == row["strand_b"])
        for which in "ab":
            low, high = row[f"s_{which}_from"] - 1, row[f"s_{which}_to"] + 1
            inside &= table[f"s_{which}"].between(low, high)
        number[inside] = i
    return number


def contact_notes(contacts: pd.DataFrame, found: pd.DataFrame | None) -> list[str]:
    """Say between which strands contact is unresolved, and how many interactions rest on it."""
    if len(contacts) == 0:
        return []
    pairs = dict.fromkeys(
        f"{row['strand_a']} and {row['strand_b'] if row['kind'] == 'inter' else 'itself'}"
        for row in contacts.to_dict("records")
    )
    note = (
        f"unresolved contact in {len(contacts)} place{'s' * (len(contacts) > 1)}, how often or "
        f"where these strands cross is a guess: {', '.join(pairs)}"
    )
    if found is not None:
        doubtful, count = int(found["unresolved"].sum()), int(found["count"].sum())
        note += f"; {doubtful} of {count} interactions rest on it"
    return [note]


def hidden_ends(strands: Sequence[Strand]) -> list[str]:
    """Say which strands disappear under others for good: half go on (drawn curls)."""
    places = [
        f"{number} at x = {point[0]:.0f}, y = {point[1]:.0f}"
        for number, strand in enumerate(strands, start=1)
        for end, point in zip(strand.ends, strand.line[[0, -1]], strict=True)
        if end == "hidden"
    ]
    if not places:
        return []
    return [f"strands disappear under others and may go on unseen: {', '.join(places)}"]
