"""Where strands cross in the picture, and which one lies on top."""

from collections.abc import Sequence

import numpy as np
import pandas as pd
from scipy.spatial import cKDTree

from imaging.centreline import arclength
from imaging.segment import Segmentation
from imaging.trace import Strand

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
APART = 0.25  # of their joint sd; two lines that part by less between crossings are one contact
DOUBT = 0.7  # a smaller share of the votes is "unknown"
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
    Two crossings of one pair between which the lines part by less than a quarter of their joint
    uncertainty are one contact: both are dropped, which keeps the parity. (Dropping at one sd lost
    31 true crossings of 505 on rendered curls for 15 false ones.)
    """
    lines = [_line(strand) for strand in strands]
    table = _intersections(lines)
    table = _resolved(table, lines, [_spread(strand) for strand in strands])
    over, confidence = _over(table, strands, lines, segmentation)
    table["over"] = pd.array(over, dtype="Int64")
    table["confidence"] = confidence
    return table.sort_values(["strand_a", "strand_b", "s_a"], ignore_index=True)[COLUMNS]


def _line(strand: Strand | np.ndarray) -> np.ndarray:
    return np.asarray(strand.line if isinstance(strand, Strand) else strand, float)


def _spread(strand: Strand | np.ndarray) -> np.ndarray:
    return strand.sd if isinstance(strand, Strand) else np.zeros(len(strand))


def _intersections(lines: list[np.ndarray]) -> pd.DataFrame:
    """Exact intersections of all segments, found through the segments' midpoints."""
    counts = [max(len(line) - 1, 0) for line in lines]
    owner = np.repeat(np.arange(len(lines)), counts)
    start = np.concatenate([line[:-1] for line in lines] or [np.empty((0, 2))])
    step = np.concatenate([np.diff(line, axis=0) for line in lines] or [np.empty((0, 2))])
    s = np.concatenate([arclength(line)[:-1] for line in lines] or [np.empty(0)])
    i, j, u, v = _segment_pairs(start, step, owner)
    length = np.hypot(*step.T)
    place = start[i] + u[:, None] * step[i]
    cosine = np.abs((step[i] * step[j]).sum(axis=1)) / np.maximum(length[i] * length[j], 1e-300)
    return pd.DataFrame(
        {
            "strand_a": owner[i] + 1,
            "strand_b": owner[j] + 1,
            "kind": np.where(owner[i] == owner[j], "self", "inter"),
            "x": place[:, 0],
            "y": place[:, 1],
            "s_a": s[i] + u * length[i],
            "s_b": s[j] + v * length[j],
            "angle": np.arccos(np.clip(cosine, 0, 1)),
        }
    )


def _segment_pairs(
    start: np.ndarray, step: np.ndarray, owner: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Find indices i < j of segments that intersect, and how far along each (0 <= u, v < 1)."""
    if len(start) < 2:
        return np.empty(0, int), np.empty(0, int), np.empty(0), np.empty(0)
    # Segments of one length class at a time would be quicker for wildly uneven polylines.
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


def _cross(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    return a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]


def _resolved(
    table: pd.DataFrame, lines: list[np.ndarray], spreads: list[np.ndarray]
) -> pd.DataFrame:
    """Drop pairs of crossings between which the two lines are not told apart."""
    dropped: list[int] = []
    for (a, b), pair in table[table["kind"] == "inter"].groupby(["strand_a", "strand_b"]):
        pair = pair.sort_values("s_a")
        left = pair.index.tolist()
        while len(left) > 1:
            parting = [
                _parting(pair.loc[p], pair.loc[q], lines, spreads, a - 1, b - 1)
                for p, q in zip(left, left[1:], strict=False)
            ]
            closest = int(np.argmin(parting))
            if parting[closest] >= APART:
                break
            dropped += left[closest : closest + 2]
            del left[closest : closest + 2]
    return table.drop(index=dropped)


def _parting(
    first: pd.Series,
    second: pd.Series,
    lines: list[np.ndarray],
    spreads: list[np.ndarray],
    a: int,
    b: int,
) -> float:
    """Largest distance between two lines from one crossing to the next, over its uncertainty."""
    between_a = _between(lines[a], first["s_a"], second["s_a"])
    between_b = _between(lines[b], first["s_b"], second["s_b"])
    if not between_a.any() or not between_b.any():
        return 0.0 if max(spreads[a].max(), spreads[b].max()) > 0 else np.inf
    apart, _ = cKDTree(lines[b][between_b]).query(lines[a][between_a])
    spread = np.hypot(spreads[a][between_a].max(), spreads[b][between_b].max())
    return float(apart.max() / spread) if spread > 0 else np.inf


def _between(line: np.ndarray, low: float, high: float) -> np.ndarray:
    s = arclength(line)
    return (s > min(low, high)) & (s < max(low, high))


def _over(
    table: pd.DataFrame,
    strands: Sequence[Strand | np.ndarray],
    lines: list[np.ndarray],
    segmentation: Segmentation | None,
) -> tuple[list[int | None], list[float]]:
    """Who is on top at each crossing, and the probability that this is right."""
    if segmentation is None:
        return [None] * len(table), [np.nan] * len(table)
    trees = [cKDTree(line) for line in lines]
    over, confidence = [], []
    for row in table.itertuples():
        a, b = strands[row.strand_a - 1], strands[row.strand_b - 1]
        if not isinstance(a, Strand) or not isinstance(b, Strand) or a.colour == b.colour:
            over.append(None)
            confidence.append(np.nan)
            continue
        trees_ab = (trees[row.strand_a - 1], trees[row.strand_b - 1])
        shown = _labels_in_overlap((row.x, row.y), row.angle, trees_ab, segmentation)
        for_a, for_b = (shown == a.colour + 1).sum(), (shown == b.colour + 1).sum()
        share, sure = _verdict(for_a, for_b)
        known = share >= DOUBT
        over.append((row.strand_a if for_a > for_b else row.strand_b) if known else None)
        confidence.append(sure)
    return over, confidence


def _verdict(for_a: int, for_b: int) -> tuple[float, float]:
    """Share of the majority, and Laplace's estimate of its being right from few witnesses."""
    total = for_a + for_b
    if total == 0:
        return 0.0, 0.5
    most = max(for_a, for_b)
    witnesses = total / PIXELS_PER_VOTE
    return most / total, (most / PIXELS_PER_VOTE + 1) / (witnesses + 2)


def _labels_in_overlap(
    place: tuple[float, float],
    angle: float,
    trees: tuple[cKDTree, cKDTree],
    segmentation: Segmentation,
) -> np.ndarray:
    """Labels of the pixels near both centrelines around a crossing."""
    width, labels = segmentation.width, segmentation.labels
    reach = int(np.ceil(min(width / np.sin(max(angle, 0.1)), 6 * width)))
    x, y = round(place[0]), round(place[1])
    x0, y0 = max(x - reach, 0), max(y - reach, 0)
    box = labels[y0 : y + reach + 1, x0 : x + reach + 1]
    if box.size == 0:
        return np.empty(0, int)
    ys, xs = np.mgrid[y0 : y0 + box.shape[0], x0 : x0 + box.shape[1]]
    points = np.stack([xs.ravel(), ys.ravel()], axis=1)
    far = CORE * width
    close = [np.isfinite(tree.query(points, distance_upper_bound=far)[0]) for tree in trees]
    return box.ravel()[close[0] & close[1]]
