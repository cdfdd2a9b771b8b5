"""Join the pieces of a colour into strands: one global matching of their ends."""

from collections.abc import Iterable, Iterator, Sequence
from itertools import product

import networkx as nx  # type: ignore[import-untyped]
import numpy as np
from scipy.optimize import Bounds, LinearConstraint, milp

from imaging.trace.branches import End

GIVE_UP = 20.0  # cost of each end of a strand
LONG = 5.0  # strand widths; a shorter piece is left out more cheaply, in proportion
TURN = 0.30  # rad; typical turn between an end's direction and the chord to its partner
TURN_PER_WIDTH = 0.02  # rad more for each strand width of gap
PLACE = 0.2  # strand widths; how well the place of an end is known
EXPOSED = 6.0  # cost of each strand width of a join that should be seen but is not
OWN = 2.0  # cost of each strand width of a join under what is seen of its own colour
BULGES = np.linspace(-1, 1, 5)  # strand widths; sideways bends of a join that are tried
DISTANCE = 0.1  # cost of each strand width of gap
FARTHEST = 60.0  # strand widths
PARTNERS = 24  # of each end that bend least, weighed further; in a weave hundreds lie in reach
MANY = 100  # possible joins; more are chosen from by an integer program
MARGIN = 2.0  # cost; joins that are better than others by less are guesses
ROWS = 10  # points of a join in each strand width, at most one a pixel
STEP_UP = 32  # points; so that joins of about the same length have the same number
AT_ONCE = 2**14  # points of joins worked on together: they stay in the processor's cache


Gain = tuple[int, int, float]  # a possible join: two ends, and how much less it costs than none


def join(ends: list[End], refunds: Iterable[float], gains: Iterable[Gain]) -> list[tuple[int, int]]:
    """Choose the joins of least total cost.

    Each end is joined at most once. A strand that ends costs the same everywhere; a piece that may
    be left out of every strand has an edge between its own two ends. The best set is a
    maximum-weight matching (Edmonds' blossom algorithm).

    Parameters
    ----------
    ends : list of End
        Those of piece i are 2 i and 2 i + 1.
    refunds : iterable of float
        From `refund`, one a piece.
    gains : iterable of (int, int, float)
        Joins to choose from.

    Returns
    -------
    list of (int, int)
        Indices into `ends`.
    """
    graph = nx.Graph()
    for i, j, gain in gains:
        graph.add_edge(i, j, weight=gain)
    for i, weight in enumerate(refunds):
        if weight > 0:
            graph.add_edge(2 * i, 2 * i + 1, weight=weight)
    joins = [
        (min(a, b), max(a, b))
        for part in nx.connected_components(graph)
        for a, b in _heaviest(graph.subgraph(part))
    ]
    return _without_rings(sorted(j for j in joins if j[0] // 2 != j[1] // 2), graph, ends)


def doubtful(joins: Sequence[tuple[int, int]], gains: Iterable[Gain]) -> set[tuple[int, int]]:
    """Find the joins that are hardly better than another, partners exchanged with one more join.

    Parameters
    ----------
    joins : sequence of (int, int)
        Ends joined, the lower first; those of piece i are 2 i and 2 i + 1.
    gains : iterable of (int, int, float)
        All joins there were to choose from.

    Returns
    -------
    set of (int, int)
        Of `joins`.
    """
    worth: dict[int, dict[int, float]] = {}
    for i, j, gain in gains:
        worth.setdefault(i, {})[j] = gain
        worth.setdefault(j, {})[i] = gain
    partner = dict(joins) | {b: a for a, b in joins}
    return {
        (a, b)
        for a, b in joins
        if min(_loss(a, b, worth, partner), _loss(b, a, worth, partner)) < MARGIN
    }


def _loss(
    end: int, joined: int, worth: dict[int, dict[int, float]], partner: dict[int, int]
) -> float:
    """Return what is lost, at least, when an end is joined to another than it is."""
    least = float("inf")
    for other, gain in worth[end].items():
        freed = partner.get(other)
        loss = worth[end][joined] - gain
        if other == joined or (freed is not None and freed // 2 == joined // 2):
            continue
        if freed is not None:
            loss += worth[other][freed] - worth[joined].get(freed, 0)
        least = min(least, loss)
    return least


def _heaviest(graph: nx.Graph) -> Iterable[tuple[int, int]]:
    """Maximum-weight matching: by blossoms (Edmonds), or by an integer program where many compete.

    Both are exact. In Python the blossoms of 580 edges take 0.2 s, the program 8 ms; but it takes
    5 ms of a handful, too.
    """
    if graph.number_of_edges() < MANY:
        return nx.max_weight_matching(graph)
    pairs = list(graph.edges)
    at_ends = nx.incidence_matrix(graph)
    chosen = milp(
        [-graph.edges[pair]["weight"] for pair in pairs],
        integrality=1,
        bounds=Bounds(0, 1),
        constraints=LinearConstraint(at_ends, ub=1),
        options={"mip_rel_gap": 0},
    )
    return [pair for pair, taken in zip(pairs, chosen.x, strict=True) if taken > 0.5]


def refund(length: float, broad: bool, width: float) -> float:
    """How much less it costs to leave a piece out than to let it be a strand.

    A short piece may be a speck; a broad one holds two strands of one colour side by side, which
    may both be joined past it.
    """
    return 2 * GIVE_UP * (1 if broad else max(1 - length / (LONG * width), 0))


def within_colour(
    ends: Sequence[End], covered: np.ndarray, own: np.ndarray, width: float
) -> list[Gain]:
    """Pairs of ends of one colour whose join costs less than leaving both, and how much less.

    A join costs its bending (turn at both ends over what is usual for its length), the length
    that runs over open background or under its own colour, where it would have to cross itself,
    and a little for its length.

    Parameters
    ----------
    ends : sequence of End
    covered : (h, w) bool array
        Where a strand may hide: under any strand.
    own : (h, w) bool array
        Where the colour of these ends is seen.
    width : float
        Strand width [px].

    Returns
    -------
    list of (int, int, float)
        Indices into `ends`, and the gain.
    """
    if len(ends) < 4:
        return []
    points, directions, branch = as_arrays(ends)
    i, j = np.nonzero(np.triu(branch[:, None] != branch[None, :], 1))
    bend, gap = bending(points[i], directions[i], points[j], directions[j], width)
    gain = 2 * GIVE_UP - bend - DISTANCE * gap / width
    good = np.flatnonzero((gain > 0) & (gap < FARTHEST * width))
    good = good[_among_best(i[good], j[good], gain[good])]
    i, j, gain = i[good], j[good], gain[good]
    for some, count in _of_a_length(gap[good] / max(1, width / ROWS)):
        ends_of_some = points[i[some]], directions[i[some]], points[j[some]], directions[j[some]]
        paths = _hermite(*ends_of_some, np.linspace(0, 1, count))
        gain[some] -= _toll(paths, covered, own, width)
    left = gain > 0
    return list(zip(i[left].tolist(), j[left].tolist(), gain[left].tolist(), strict=True))


def _among_best(i: np.ndarray, j: np.ndarray, gain: np.ndarray) -> np.ndarray:
    """Tell which joins (n,) are among the PARTNERS best of either of their ends."""
    ends, pair = np.concatenate([i, j]), np.tile(np.arange(len(i)), 2)
    order = np.lexsort((-gain[pair], ends))
    first = np.searchsorted(ends[order], ends[order])
    best = np.zeros(len(i), bool)
    best[pair[order[np.arange(len(order)) - first < PARTNERS]]] = True
    return best


def _of_a_length(count: np.ndarray) -> Iterator[tuple[np.ndarray, int]]:
    """Yield joins of about as many points, to be worked on together: which, and how many points."""
    points = (np.ceil(count / STEP_UP) * STEP_UP).astype(int)
    for many in np.unique(points).tolist():
        same = np.flatnonzero(points == many)
        for start in range(0, len(same), AT_ONCE // many + 1):
            yield same[start : start + AT_ONCE // many + 1], many


def _toll(paths: np.ndarray, covered: np.ndarray, own: np.ndarray, width: float) -> np.ndarray:
    """Cost (n,) of what joins (n, m, 2) run over, of several that bulge to one side or the other.

    Where a strand disappears its last direction is not well known: a bulge of h over a gap g turns
    both ends by 4 h/g, which costs what any turn does.
    """
    chord = paths[:, -1] - paths[:, 0]
    gap = np.maximum(np.hypot(*chord.T), 1e-6)[:, None]
    bulge = width * BULGES
    v = np.linspace(0, 1, paths.shape[1])
    aside = 4 * bulge[:, None] * v * (1 - v)
    normal = np.stack([-chord[:, 1], chord[:, 0]]) / gap.T
    middle = np.ascontiguousarray(np.moveaxis(paths, -1, 0))
    x, y = np.rint(middle[:, :, None] + normal[:, :, None, None] * aside).astype(np.int32)
    height, across = covered.shape
    inside = (x >= 0) & (y >= 0) & (x < across) & (y < height)
    at = np.where(inside, y * across + x, 0)
    exposed = (inside & ~covered.ravel()[at]).sum(axis=2)
    beneath = (inside & own.ravel()[at]).sum(axis=2)
    over = (EXPOSED * exposed + OWN * beneath) * (gap / (width * len(v)))
    return (over + 2 * (4 * bulge / (gap * TURN)) ** 2).min(axis=1)


def as_arrays(ends: Sequence[End]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Points (n, 2), directions (n, 2) and branches (n,) of ends."""
    points = np.array([e.point for e in ends])
    directions = np.array([e.direction for e in ends])
    return points, directions, np.array([e.branch for e in ends])


def bending(
    p: np.ndarray, t: np.ndarray, q: np.ndarray, u: np.ndarray, width: float
) -> tuple[np.ndarray, np.ndarray]:
    """Cost of turning from t at p to the chord, and from the chord to -u at q; and the gap."""
    chord = q - p
    gap = np.maximum(np.hypot(*chord.T), 1e-6)
    first = _angle(t, chord)
    second = _angle(-u, chord)
    usual = TURN**2 + (TURN_PER_WIDTH * gap / width) ** 2
    spread = usual + (PLACE * width / gap) ** 2
    # Close to each other the chord says nothing, but the two directions still do.
    whole = _angle(t, -u)
    bend = np.maximum((first**2 + second**2) / spread, whole**2 / (2 * usual))
    return bend, gap


def _angle(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    cross = a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]
    return np.abs(np.arctan2(cross, (a * b).sum(axis=1)))


def bridge(a: End, b: End) -> np.ndarray:
    """Cubic Hermite curve from one end to another, a point a pixel, both ends included."""
    gap = float(np.hypot(*(b.point - a.point)))
    v = np.linspace(0, 1, max(2, int(np.ceil(gap)) + 1))
    return _hermite(a.point, a.direction, b.point, b.direction, v)


def _hermite(
    p: np.ndarray, t: np.ndarray, q: np.ndarray, u: np.ndarray, v: np.ndarray
) -> np.ndarray:
    """Cubic (..., m, 2) from p, where it points to t, to q, where it comes from u (..., 2)."""
    gap = np.hypot(*np.moveaxis(q - p, -1, 0))[..., None]
    start, go = 2 * v**3 - 3 * v**2 + 1, v**3 - 2 * v**2 + v
    stop, come = 3 * v**2 - 2 * v**3, v**2 - v**3
    weights = np.stack([start, go, stop, come], axis=1)
    return weights @ np.stack([p, gap * t, q, gap * u], axis=-2)


def _without_rings(
    joins: list[tuple[int, int]], graph: nx.Graph, ends: list[End]
) -> list[tuple[int, int]]:
    """Thread closed loops of branches into another chain, or open them: a strand has two ends."""
    joins = list(joins)
    while ring := _ring(joins, ends):
        swap = _best_swap(ring, [pair for pair in joins if pair not in ring], graph)
        if swap is None:
            joins.remove(min(ring, key=lambda pair: graph.edges[pair]["weight"]))
        else:
            removed, added = swap
            joins = [pair for pair in joins if pair not in removed] + added
    return joins


def _ring(joins: list[tuple[int, int]], ends: list[End]) -> list[tuple[int, int]]:
    """Return the joins of one closed loop of branches, if there is any."""
    chain = nx.MultiGraph()
    for a, b in joins:
        chain.add_edge(ends[a].branch, ends[b].branch, pair=(a, b))
    for part in nx.connected_components(chain):
        edges = list(chain.subgraph(part).edges(data="pair"))
        if len(edges) == len(part):
            return [pair for _, _, pair in edges]
    return []


def _best_swap(
    ring: list[tuple[int, int]], others: list[tuple[int, int]], graph: nx.Graph
) -> tuple[list[tuple[int, int]], list[tuple[int, int]]] | None:
    """Exchange partners between a ring's join and another's, at the least loss."""
    best, least = None, np.inf
    for (a, b), (c, d) in product(ring, others):
        old = graph.edges[a, b]["weight"] + graph.edges[c, d]["weight"]
        for first, second in (((a, c), (b, d)), ((a, d), (b, c))):
            if graph.has_edge(*first) and graph.has_edge(*second):
                loss = old - graph.edges[first]["weight"] - graph.edges[second]["weight"]
                if loss < least:
                    best, least = ([(a, b), (c, d)], [first, second]), loss
    return best


def chains(count: int, joins: list[tuple[int, int]]) -> list[list[tuple[int, bool]]]:
    """Follow the joins: each strand as a list of (branch, walked from last to first).

    Ends are numbered 2 i (first) and 2 i + 1 (last) for branch i.
    """
    partner = dict(joins) | {b: a for a, b in joins}
    done: set[int] = set()
    found = []
    starts = [e for e in range(2 * count) if e not in partner]
    for start in starts:
        if start // 2 in done:
            continue
        walk, entry = [], start
        while True:
            done.add(entry // 2)
            walk.append((entry // 2, bool(entry % 2)))
            leave = partner.get(entry ^ 1)
            if leave is None:
                break
            entry = leave
        found.append(walk)
    return found
