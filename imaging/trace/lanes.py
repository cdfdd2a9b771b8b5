"""Strands of one colour that run together: a graph of stretches, and how many strands run in each.

The skeleton of what is seen of a colour is cut at its forks into stretches. Where strands lie on or
beside each other a stretch is broader than one of them. How many run in each is that choice of
least cost with which as many come to each fork as leave it: what is broader than so many strands,
strands that end at a fork, and two that end together cost. Side by side, the strands in a stretch
are its lanes, in order from its left to its right. Which goes on as which is left open here.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np
from scipy.optimize import Bounds, LinearConstraint, milp
from scipy.sparse.csgraph import connected_components

from imaging.segment.skeleton import degrees, in_order, linked, thinned
from imaging.trace.branches import without_spurs
from imaging.trace.centreline import arclength, edges, normals, resample, smoothed

ROWS = 5  # cross-sections in each strand width of length, at most one a pixel
AHEAD = 2.5  # strand widths from a fork to where the direction of a stretch is taken
SHORT = 0.6  # strand widths; two forks nearer than that are one
MOST = 10  # strands in a stretch, for which edges are sought that far apart
BROAD = 0.15  # strand widths; by which so many strands may look broader than they are
UNCOVERED = 2.0  # cost of each square width that is seen and not covered by so many strands
SPARE = 0.1  # cost of each width of length of a strand more than what is seen needs
ENDS = 12.0  # cost of a strand that ends at a fork, or together with another
SPREAD = 0.6  # strand widths beyond the lanes; what is broader is a fork, not a stretch

Half = tuple[int, bool, int]  # stretch, whether at its last point, lane


@dataclass
class Stretch:
    """A stretch between forks.

    Attributes
    ----------
    line : (n, 2) array
        Middle of what is seen, evenly spaced [px].
    normal : (n, 2) array
    low, high : (n,) arrays
        Distance of the two edges along the normal [px]; NaN where not found.
    forks : (int, int)
        Numbers of the forks at its first and last point, -1 = none.
    count : int
        Strands that run in it.
    """

    line: np.ndarray
    normal: np.ndarray
    low: np.ndarray
    high: np.ndarray
    forks: tuple[int, int]
    count: int = 1

    def length(self) -> float:
        """Length [px]."""
        return float(arclength(self.line)[-1])

    def told(self, width: float) -> np.ndarray:
        """Tell where (n,) the edges are those of so many strands: not at forks."""
        broad = self.high - self.low
        least, most = 0.65 * width, (self.count + SPREAD) * width
        near = _near_forks(self, 0.7 * width)
        return np.isfinite(broad) & (broad > least) & (broad < most) & ~near


@dataclass(frozen=True)
class Graph:
    """Stretches and forks of one colour.

    Attributes
    ----------
    stretches : list of Stretch
    forks : (k, 2) array
        Where they are [px].
    links : list of list of (half, half)
        Of each fork, which half of a lane comes to it and which goes on; strands may end there.
    width : float
        Width of a single strand, most frequent of what is seen [px].
    step : float
        Distance between the points of a stretch [px].
    """

    stretches: list[Stretch]
    forks: np.ndarray
    links: list[list[tuple[Half, Half]]]
    width: float
    step: float


def graph_of(mask: np.ndarray, own: np.ndarray, coverage: np.ndarray, width: float) -> Graph:
    """Cut what is seen of a colour into stretches, and count the strands in each.

    Parameters
    ----------
    mask : (h, w) bool array
        Where the colour is seen.
    own, coverage : (h, w) float32 arrays
        Membership of the colour, and coverage by any strand.
    width : float
        Strand width [px], roughly.
    """
    step = max(1.0, width / ROWS)
    paths, forks = _merged(*_cut(mask, width), width)
    stretches = [_stretch(path, at, own, coverage, width, step) for path, at in paths]
    width = _most_frequent(np.concatenate([s.high - s.low for s in stretches] or [[]]), width)
    meetings = [_meeting(stretches, fork, at, width) for fork, at in enumerate(forks)]
    _count(stretches, [ports for ports, _ in meetings], width)
    links = [
        _linked(stretches, ports, at, axis, width)
        for at, (ports, axis) in zip(forks, meetings, strict=True)
    ]
    return Graph(stretches, forks, links, width, step)


Path = tuple[np.ndarray, tuple[int, int]]  # points (n, 2), forks at its ends


def _cut(mask: np.ndarray, width: float) -> tuple[list[Path], np.ndarray]:
    """Cut a skeleton at its forks: paths with the forks at their ends, and the forks (k, 2)."""
    points, touching = linked(without_spurs(thinned(np.pad(mask, 1)), width))
    forked = degrees(touching) > 2
    at_fork, between = np.flatnonzero(forked), np.flatnonzero(~forked)
    count, number = connected_components(touching[at_fork][:, at_fork], directed=False)
    fork_of = np.full(len(points), -1)
    fork_of[at_fork] = number
    points = points - 1.0
    paths = []
    for walk in in_order(touching[between][:, between]):
        path = between[walk]
        beside = [sorted(set(fork_of[touching[[end], :].indices]) - {-1}) for end in path[[0, -1]]]
        if len(path) == 1:
            beside = [beside[0][:1], beside[0][1:2]]
        first, last = ([*forks, -1][0] for forks in beside)
        paths.append((points[path], (int(first), int(last))))
    return paths, np.array([points[at_fork[number == k]].mean(axis=0) for k in range(count)])


def _merged(paths: list[Path], forks: np.ndarray, width: float) -> tuple[list[Path], np.ndarray]:
    """Make one of forks that a short path joins."""
    short = [
        arclength(path)[-1] < SHORT * width and min(ends) >= 0 if len(path) > 1 else min(ends) >= 0
        for path, ends in paths
    ]
    same = np.eye(len(forks), dtype=bool)
    for (_, (a, b)), is_short in zip(paths, short, strict=True):
        if is_short:
            same[a, b] = True
    count, number = connected_components(same, directed=False)
    middle = np.array([forks[number == k].mean(axis=0) for k in range(count)])
    number = np.append(number, -1)  # no fork stays none
    kept = [
        (path, (int(number[a]), int(number[b])))
        for (path, (a, b)), is_short in zip(paths, short, strict=True)
        if not is_short
    ]
    return kept, middle


def _stretch(
    path: np.ndarray,
    forks: tuple[int, int],
    own: np.ndarray,
    coverage: np.ndarray,
    width: float,
    step: float,
) -> Stretch:
    if len(path) < 4:
        unknown = np.full(len(path), np.nan)
        return Stretch(path, np.zeros(path.shape), unknown, unknown, forks)
    line = resample(path, step)
    line = smoothed(line, np.ones(len(line)), width / step)
    low, high = edges(line, own, coverage, 0.4 * MOST * width)
    return Stretch(line, normals(line), low, high, forks)


def _most_frequent(widths: np.ndarray, otherwise: float) -> float:
    """Half-sample mode of widths (Bickel & Frühwirth 2006), from where 40 are left their median."""
    x = np.sort(widths[np.isfinite(widths)])
    while len(x) > 40:
        half = (len(x) + 1) // 2
        first = int(np.argmin(x[half - 1 :] - x[: len(x) - half + 1]))
        x = x[first : first + half]
    return float(np.median(x)) if len(x) else otherwise


def _near_forks(stretch: Stretch, far: float) -> np.ndarray:
    s = arclength(stretch.line)
    first, last = stretch.forks
    return ((s < far) & (first >= 0)) | ((s > s[-1] - far) & (last >= 0))


Port = tuple[int, bool, bool]  # stretch, whether its last point is here, whether it leads on


def _meeting(
    stretches: Sequence[Stretch], fork: int, at: np.ndarray, width: float
) -> tuple[list[Port], np.ndarray]:
    """Tell which stretches come to a fork and which lead on, and along which direction (2,).

    It is the direction that most of them have; where all lie on one side of it, none lead on.
    """
    here = [(n, last) for n, s in enumerate(stretches) for last in (False, True)
            if s.forks[last] == fork]  # fmt: skip
    ways = np.array([_way(stretches[n], last, at, width) for n, last in here]).reshape(-1, 2)
    pairs = [a + sign * b for a, b in combinations(ways, 2) for sign in (1, -1)]
    best, axis = 0.0, np.zeros(2)
    for way in [*ways, *pairs]:
        way = way / max(np.hypot(*way), 1e-9)
        along = ways @ way
        if along.min() < 0 < along.max() and np.abs(along).sum() > best + 1e-9:
            best, axis = np.abs(along).sum(), way
    if best == 0:
        return [], axis
    on = (ways @ axis > 0).tolist()
    return [(n, last, leads) for (n, last), leads in zip(here, on, strict=True)], axis


def _way(stretch: Stretch, last: bool, at: np.ndarray, width: float) -> np.ndarray:
    """Direction from a fork along a stretch."""
    line = stretch.line[::-1] if last else stretch.line
    far = min(int(np.searchsorted(arclength(line), AHEAD * width)), len(line) - 1)
    way = line[far] - at
    return way / max(np.hypot(*way), 1e-9)


def _count(stretches: Sequence[Stretch], meetings: Sequence[list[Port]], width: float) -> None:
    """Set how many strands run in each stretch, by an integer program.

    A count is a sum of MOST steps of 0 or 1, whose costs rise: the lower are taken first.
    """
    size = len(stretches) * MOST
    cost = np.concatenate(
        [*(_steps(s, width) for s in stretches), np.full(2 * len(meetings), ENDS)]
    )
    balance = np.zeros((len(meetings), len(cost)))
    for fork, ports in enumerate(meetings):
        for n, _, leads in ports:
            balance[fork, n * MOST : (n + 1) * MOST] += 1 if leads else -1
        balance[fork, size + fork] = -1
        balance[fork, size + len(meetings) + fork] = 1
    most = np.concatenate([np.ones(size), np.full(2 * len(meetings), float(MOST))])
    conserved = [LinearConstraint(balance, 0, 0)] if len(meetings) else []
    found = milp(cost, integrality=np.ones(len(cost)), bounds=Bounds(0, most),
                 constraints=conserved, options={"time_limit": 10})  # fmt: skip
    if found.x is not None:
        for s, steps in zip(stretches, found.x[:size].reshape(-1, MOST), strict=True):
            s.count = round(steps.sum())


def _steps(stretch: Stretch, width: float) -> np.ndarray:
    """Cost (MOST,) of each strand more in a stretch."""
    s = arclength(stretch.line)
    known = np.isfinite(stretch.low + stretch.high) & ~_near_forks(stretch, width)
    broad = (stretch.high - stretch.low)[known, None] / width
    count = np.arange(MOST + 1)
    bare = UNCOVERED * np.maximum(broad - count - BROAD, 0)
    spare = SPARE * np.maximum(count - np.maximum(broad, 1) - 0.5, 0)
    cost = (bare + spare).sum(axis=0) * s[-1] / (max(len(s) - 1, 1) * width) + 0.02 * count
    cost[0] = max(cost[0], cost[1] + 2 * s[-1] / width)
    steps = np.diff(cost) + 1e-4 * count[:-1]
    if min(stretch.forks) < 0:
        steps[1:] += ENDS
    return steps


def _linked(
    stretches: Sequence[Stretch], ports: list[Port], at: np.ndarray, axis: np.ndarray, width: float
) -> list[tuple[Half, Half]]:
    """Join the lanes that come to a fork to those that lead on, in order from left to right."""
    if not ports:
        return []
    come, go = (_side(stretches, ports, at, axis, width, leads) for leads in (False, True))
    few, many = sorted((come, go), key=len)
    turns = [[abs(a - b) for b, _ in many] for a, _ in few]
    chosen: Iterable[int] = range(len(few))
    if 0 < len(many) - len(few) <= 3 and len(many) <= MOST:  # some end here
        chosen = min(
            combinations(range(len(many)), len(few)),
            key=lambda some: sum(turns[i][k] for i, k in enumerate(some)),
        )
    pairs = [(few[i][1], many[k][1]) for i, k in enumerate(chosen)]
    return pairs if few is come else [(b, a) for a, b in pairs]


def _side(
    stretches: Sequence[Stretch],
    ports: list[Port],
    at: np.ndarray,
    axis: np.ndarray,
    width: float,
    leads: bool,
) -> list[tuple[float, Half]]:
    """Lanes on one side of a fork, in order across the axis, each with its angle to it [rad]."""
    aside = np.array([-axis[1], axis[0]])
    found: list[tuple[float, int, list[Half]]] = []
    for n, last, on in ports:
        if on == leads:
            way = _way(stretches[n], last, at, width)
            lanes = [(n, last, lane) for lane in range(stretches[n].count)]
            forwards = last != leads  # its points run along the axis
            angle = float(np.arctan2(way @ aside, abs(way @ axis)))
            found.append((angle, n, lanes if forwards else lanes[::-1]))
    return [(angle, half) for angle, _, lanes in sorted(found) for half in lanes]
