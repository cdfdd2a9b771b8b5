"""Where strands cross in the picture, and which one lies on top."""

from collections.abc import Sequence
from itertools import groupby, pairwise
from typing import NamedTuple

import numpy as np
import pandas as pd
from scipy.spatial import cKDTree

from imaging.segment import Segmentation
from imaging.trace import Strand
from imaging.trace.centreline import arclength, normals


class Hit(NamedTuple):
    """One intersection: strands from 1, place, arclengths, angle [rad]."""

    strand_a: int
    strand_b: int
    x: float
    y: float
    s_a: float
    s_b: float
    angle: float


COLUMNS = [
    "strand_a",
    "strand_b",
    "kind",
    "x",
    "y",
    "s_a",
    "s_b",
    "angle",
    "over",
    "confidence",
]
CORE = 0.35  # strand widths from both centrelines within which a pixel votes on who is on top
APART = 0.6  # of their joint sd; two lines that part by less between crossings are one contact
DOUBT = 0.7  # a smaller share of the votes is "unknown"
MISTAKE = 0.25  # share of witnesses that are wrong, where labels are mixed up at all
PIXELS_PER_VOTE = 4.0  # neighbouring pixels share blur and are not independent witnesses


def crossings(
    strands: Sequence[Strand | np.ndarray], segmentation: Segmentation | None = None
) -> pd.DataFrame:
    """Find every transversal intersection of the strands' centrelines.

    Parameters
    ----------
    strands : sequence of Strand or (n, 2) array
        In pixels or metres.
    segmentation : Segmentation, optional
        Needed to say which strand is on top; then `strands` are in its pixels.

    Returns
    -------
    DataFrame
        One row a crossing, ordered along the first strand: ``strand_a`` <= ``strand_b`` (numbered
        from 1), ``kind`` inter or self, position ``x``, ``y`` and arclengths ``s_a``, ``s_b`` in
        the strands' unit, ``angle`` between 0 and pi/2 [rad], ``over`` = the number of the strand
        on top or <NA> when unknown (always for ``self``: one colour does not tell), and its
        ``confidence``, the probability that ``over`` is right.

    Notes
    -----
    Two crossings of one pair between which the lines part by less than 0.6 of their joint
    uncertainty are one contact: both are dropped, which keeps the parity. (On 48 rendered curls
    about as many false pairs are left then as true ones lost: 0.991 crossings for each true one.)
    """
    lines = [_line(strand) for strand in strands]
    hits = _resolved(_intersections(lines), lines, [_spread(strand) for strand in strands])
    verdicts = [_over(hit, strands, lines, segmentation) for hit in hits]
    kinds = Hit.__annotations__  # a table without rows has them too
    table = pd.DataFrame(hits, columns=Hit._fields).astype(kinds)
    table["kind"] = np.where(table["strand_a"] == table["strand_b"], "self", "inter")
    table["over"] = pd.array([over for over, _ in verdicts], dtype="Int64")
    table["confidence"] = np.array([sure for _, sure in verdicts], float)
    return table[COLUMNS]


def _line(strand: Strand | np.ndarray) -> np.ndarray:
    return np.asarray(strand.line if isinstance(strand, Strand) else strand, float)


def _spread(strand: Strand | np.ndarray) -> np.ndarray:
    return strand.sd if isinstance(strand, Strand) else np.zeros(len(strand))


def _intersections(lines: list[np.ndarray]) -> list[Hit]:
    """All intersections of the lines' segments, ordered by strands and along the first."""
    owner = np.repeat(np.arange(len(lines)), [max(len(line) - 1, 0) for line in lines])
    start = np.concatenate([line[:-1] for line in lines] or [np.empty((0, 2))])
    step = np.concatenate([np.diff(line, axis=0) for line in lines] or [np.empty((0, 2))])
    s = np.concatenate([arclength(line)[:-1] for line in lines] or [np.empty(0)])
    i, j, u, v = _segment_pairs(start, step, owner)
    length = np.hypot(*step.T)
    place = start[i] + u[:, None] * step[i]
    cosine = np.abs((step[i] * step[j]).sum(axis=1)) / np.maximum(length[i] * length[j], 1e-300)
    angle = np.arccos(np.clip(cosine, 0, 1))
    columns = [owner[i] + 1, owner[j] + 1, *place.T, s[i] + u * length[i], s[j] + v * length[j]]
    hits = zip(*[column.tolist() for column in (*columns, angle)], strict=True)
    return sorted(
        (Hit(*hit) for hit in hits), key=lambda hit: (hit.strand_a, hit.strand_b, hit.s_a)
    )


def _segment_pairs(
    start: np.ndarray, step: np.ndarray, owner: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Find indices i < j of segments that intersect, and how far along each (0 <= u, v < 1)."""
    if len(start) < 2:
        return np.empty(0, int), np.empty(0, int), np.empty(0), np.empty(0)
    reach = np.hypot(*step.T).max()
    pairs = cKDTree(start + step / 2).query_pairs(reach * (1 + 1e-9), output_type="ndarray")
    i, j = pairs.T
    apart = (owner[i] != owner[j]) | (np.abs(i - j) > 1)
    i, j = i[apart], j[apart]
    denominator = _cross(step[i], step[j])
    usable = np.abs(denominator) > 1e-12 * reach**2
    i, j, denominator = i[usable], j[usable], denominator[usable]
    between = start[j] - start[i]
    u = _cross(between, step[j]) / denominator
    v = _cross(between, step[i]) / denominator
    hit = (u >= 0) & (u < 1) & (v >= 0) & (v < 1)
    return i[hit], j[hit], u[hit], v[hit]


def crossing_matrix(table: pd.DataFrame, strands: int) -> np.ndarray:
    """Count the crossings of every two strands in a picture.

    Parameters
    ----------
    table : DataFrame
        Of `crossings`.
    strands : int
        Their number n.

    Returns
    -------
    (n, n) array of int
        Symmetric; on the diagonal how often each crosses itself. Averaged over all directions of
        view it is the average crossing number of the strands in space.
    """
    found = np.zeros((strands, strands), int)
    a, b = (table[name].to_numpy(dtype=int) - 1 for name in ("strand_a", "strand_b"))
    np.add.at(found, (a, b), 1)
    return found + np.triu(found, 1).T


def _cross(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    return a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]


def _resolved(hits: list[Hit], lines: list[np.ndarray], spreads: list[np.ndarray]) -> list[Hit]:
    """Drop pairs of crossings between which the two lines are not told apart."""
    kept: list[Hit] = []
    for (a, b), group in groupby(hits, key=lambda hit: (hit.strand_a, hit.strand_b)):
        left = list(group)
        while a != b and len(left) > 1:
            parting = [_parting(p, q, lines, spreads) for p, q in pairwise(left)]
            closest = int(np.argmin(parting))
            if parting[closest] >= APART:
                break
            del left[closest : closest + 2]
        kept += left
    return kept


def _parting(p: Hit, q: Hit, lines: list[np.ndarray], spreads: list[np.ndarray]) -> float:
    """Largest distance between two lines from one crossing to the next, over its uncertainty.

    Where that is at least APART, some distance that is.
    """
    a, b = p.strand_a - 1, p.strand_b - 1
    on_a, on_b = _between(lines[a], p.s_a, q.s_a), _between(lines[b], p.s_b, q.s_b)
    if max(spreads[a].max(), spreads[b].max()) == 0:
        return np.inf
    if not on_a.any() or not on_b.any():
        return 0.0
    sd = np.hypot(spreads[a][on_a].max(), spreads[b][on_b].max())
    first, second, normal = lines[a][on_a], lines[b][on_b], normals(lines[b])[on_b]
    half_way = first[len(first) // 2]
    nearest = np.hypot(*(second - half_way).T).argmin()
    apart = abs((half_way - second[nearest]) @ normal[nearest])
    if apart < APART * sd:
        nearest = cKDTree(second).query(first)[1]
        apart = np.abs(((first - second[nearest]) * normal[nearest]).sum(axis=1)).max()
    return float(apart / sd)


def _between(line: np.ndarray, low: float, high: float) -> np.ndarray:
    s = arclength(line)
    return (s > min(low, high)) & (s < max(low, high))


def _over(
    hit: Hit,
    strands: Sequence[Strand | np.ndarray],
    lines: list[np.ndarray],
    segmentation: Segmentation | None,
) -> tuple[int | None, float]:
    """Who is on top at a crossing, and the probability that this is right."""
    a, b = strands[hit.strand_a - 1], strands[hit.strand_b - 1]
    if segmentation is None or not isinstance(a, Strand) or not isinstance(b, Strand):
        return None, np.nan
    colour_a, colour_b = _colour_at(a, hit.s_a), _colour_at(b, hit.s_b)
    if colour_a == colour_b:
        return None, np.nan
    shown = _labels_in_overlap(hit, lines, segmentation)
    for_a, for_b = int((shown == colour_a + 1).sum()), int((shown == colour_b + 1).sum())
    share, sure = _verdict(for_a, for_b)
    if share < DOUBT:
        return None, sure
    return (hit.strand_a if for_a > for_b else hit.strand_b), sure


def _colour_at(strand: Strand, s: float) -> int:
    return int(strand.tones[np.searchsorted(arclength(strand.line), s, side="right") - 1])


def _verdict(for_a: int, for_b: int) -> tuple[float, float]:
    """Share of the majority, and the odds for it of witnesses each wrong MISTAKE of the time."""
    total = for_a + for_b
    if total == 0:
        return 0.0, 0.5
    lead = abs(for_a - for_b) / PIXELS_PER_VOTE
    return max(for_a, for_b) / total, 1 / (1 + (MISTAKE / (1 - MISTAKE)) ** lead)


def _labels_in_overlap(hit: Hit, lines: list[np.ndarray], segmentation: Segmentation) -> np.ndarray:
    """Labels of the strand pixels near both centrelines around a crossing."""
    width, labels = segmentation.width, segmentation.labels
    reach = int(np.ceil(min(width / np.sin(max(hit.angle, 0.1)), 6 * width)))
    x0, y0 = max(round(hit.x) - reach, 0), max(round(hit.y) - reach, 0)
    ys, xs = np.nonzero(labels[y0 : y0 + 2 * reach + 1, x0 : x0 + 2 * reach + 1])
    points = np.stack([xs + x0, ys + y0], axis=1)
    for strand in (hit.strand_a, hit.strand_b):
        line = lines[strand - 1]
        near = np.abs(line - [hit.x, hit.y]).max(axis=1) <= 2 * reach
        distance, _ = cKDTree(line[near]).query(points, distance_upper_bound=CORE * width)
        points = points[np.isfinite(distance)]
    return labels[points[:, 1], points[:, 0]]
