"""Which strand goes on as which where strands of one colour run together: the smoothest courses.

At every knot, a stretch of several lanes or a fork of several on both sides, each way in which
those that come in may go on is tried. A strand is a smoothing spline whose change of curvature is
small, through what is seen of it: alone, the middle between its edges; among others, one edge
wherever it lies outermost. So a strand is carried on by its curvature across several widths, and
what is seen along the stretch tells crossing from touching: where two cross, it is as broad as one.
Knots are settled one after another, each with the others as they are, until none changes.
"""

import math
from collections.abc import Iterator, Sequence
from itertools import combinations, combinations_with_replacement, permutations
from typing import NamedTuple

import numpy as np
from scipy.linalg import solveh_banded

from imaging.segment import Segmentation
from imaging.trace.chain import Chain
from imaging.trace.lanes import Graph, Half, Stretch, graph_of

BUNDLE = 3.0  # strand widths; where three or more run together for longer, their courses tell
REACH = 14.0  # strand widths on either side of a knot in which its strands are followed
SEEN_SD = 0.06  # strand widths; of the middle between two edges
OUTSIDE = 4.0  # times that, of a strand that must lie between the outermost two
WAVE = 16.0  # strand widths; shorter wiggles of a strand are taken for noise
ROUNDS = 6  # of settling all knots
PLACINGS = 2  # of the strands along a stretch, each of them where the others leave it room
ALL = 4  # lanes of which all orders are tried at once; of more, exchanges of two
GUESS = 100.0  # cost; another way that costs less than so much more is possible


def bundled_chains(segmentation: Segmentation, coverage: np.ndarray) -> list[Chain] | None:
    """Chains of strands of the first colour; None where nowhere three of them run together.

    Parameters
    ----------
    segmentation : Segmentation
    coverage : (h, w) float32 array
        Coverage by any strand.
    """
    mask, own = segmentation.labels == 1, segmentation.membership[0]
    graph = graph_of(mask, own, coverage, segmentation.width)
    if not any(s.count > 2 and s.length() > BUNDLE * graph.width for s in graph.stretches):
        return None
    exchange = Exchange(graph)
    exchange.settle()
    return exchange.chains(0)


class Course(NamedTuple):
    """What is seen of a strand, in order: points (n, 2) and their sd (n,) [px]."""

    points: np.ndarray
    sd: np.ndarray

    def back(self) -> "Course":
        """Return the same the other way."""
        return Course(self.points[::-1], self.sd[::-1])


class Placed(NamedTuple):
    """A course, and the places (n,) of its points on a line of equal steps, from 0."""

    points: np.ndarray
    sd: np.ndarray
    at: np.ndarray


class Knot(NamedTuple):
    """Where strands may go on in several ways: the halves of lanes on both sides.

    Of a stretch, those of its own lanes; of a fork, those of the lanes that end at it.
    """

    first: tuple[Half, ...]
    last: tuple[Half, ...]
    stretch: int | None


class Exchange:
    """Lanes of a graph joined to strands."""

    def __init__(self, graph: Graph) -> None:
        self.graph = graph
        self.sd = SEEN_SD * graph.width
        wave = WAVE * graph.width / (2 * np.pi * graph.step)
        self.spline = Spline(wave**6 / self.sd**2, graph.step)
        self.goes_on = {
            (n, last, lane): (n, not last, lane)
            for n, stretch in enumerate(graph.stretches)
            for last in (False, True)
            for lane in range(stretch.count)
        }
        pairs = [pair for fork in graph.links for pair in fork]
        self.links = dict(pairs) | {b: a for a, b in pairs}
        self.seen = {
            (n, lane): course
            for n, stretch in enumerate(graph.stretches)
            for lane, course in enumerate(self._side_by_side(stretch))
        }
        self.doubts: dict[Half, np.ndarray] = {}
        self._known: dict[Knot, bytes] = {}

    def _side_by_side(self, stretch: Stretch) -> Iterator[Course]:
        """Tell what is seen of the lanes of a stretch, if none change places."""
        told = stretch.told(self.graph.width)
        middle = (stretch.low + stretch.high)[told, None] / 2
        room = np.maximum(stretch.high - stretch.low - self.graph.width, 0)[told, None]
        for lane in range(stretch.count):
            aside = lane / max(stretch.count - 1, 1) - 0.5 if stretch.count > 1 else 0.0
            points = stretch.line[told] + (middle + aside * room) * stretch.normal[told]
            inner = 0 < lane < stretch.count - 1
            sd = self.sd + inner * (0.25 * room[:, 0] + 0.1 * self.graph.width)
            yield Course(points, sd)

    def settle(self) -> None:
        """Settle all knots until none changes."""
        knots = list(self._knots())
        for _ in range(ROUNDS):
            if not any([self._settle(knot) for knot in knots]):
                break

    def _knots(self) -> Iterator[Knot]:
        for n, stretch in enumerate(self.graph.stretches):
            if stretch.count > 1:
                lanes = range(stretch.count)
                yield Knot(
                    tuple((n, False, k) for k in lanes), tuple((n, True, k) for k in lanes), n
                )
        for pairs in self.graph.links:
            first, last = (tuple(side) for side in zip(*pairs, strict=True)) if pairs else ((), ())
            if all(len({half[0] for half in side}) > 1 for side in (first, last)):
                yield Knot(first, last, None)

    def _settle(self, knot: Knot) -> bool:
        """Choose the best way through a knot; tell whether it is another than before."""
        onwards = self.goes_on if knot.stretch is not None else self.links
        before = [self._from(half, knot).back() for half in knot.first]
        after = [self._from(half, knot) for half in knot.last]
        now = tuple(knot.last.index(onwards[half]) for half in knot.first)
        state = b"".join(c.points.tobytes() for c in [*before, *after]) + bytes(now)
        if self._known.get(knot) == state:
            return False
        ways = self._weighed(knot, before, after, now)
        best = min(ways, key=lambda way: ways[way][0])
        for half, other in zip(knot.first, best, strict=True):
            onwards[half], onwards[knot.last[other]] = knot.last[other], half
        if knot.stretch is not None:
            self.seen |= {(knot.stretch, k): c for k, c in enumerate(ways[best][1])}
        self._doubt(knot, {way: cost - ways[best][0] for way, (cost, _) in ways.items()}, best)
        self._known[knot] = state if best == now else b""
        return best != now

    def _doubt(self, knot: Knot, more: dict[tuple[int, ...], float], best: tuple[int, ...]) -> None:
        """Note which strands could as well go on otherwise."""
        place = self._place(knot)
        for k, half in enumerate(knot.first):
            self.doubts.pop(half, None)
            if any(way[k] != best[k] and cost < GUESS for way, cost in more.items()):
                self.doubts[half] = place

    def _place(self, knot: Knot) -> np.ndarray:
        stretch = self._stretch(knot)
        if knot.stretch is not None:
            return stretch.line[len(stretch.line) // 2]
        return stretch.line[-1 if knot.first[0][1] else 0]

    def _from(self, half: Half, knot: Knot) -> Course:
        """Follow the strand beyond a half of a knot: what is seen of it there."""
        start = half if knot.stretch is None else self.links.get(half)
        reach = int(REACH * self.graph.width / self.graph.step)
        courses, many = [Course(np.empty((0, 2)), np.empty(0))], 0
        for enters in self._walk(start):
            courses.append(self._course(enters))
            many += len(self.graph.stretches[enters[0]].line)
            if many > reach:
                break
        points, sd = (np.concatenate(parts)[:reach] for parts in zip(*courses, strict=True))
        return Course(points, sd)

    def _walk(self, start: Half | None) -> Iterator[Half]:
        """Halves at which a strand enters one stretch after another; a ring ends where it began."""
        half = start
        while half is not None:
            yield half
            half = self.links.get(self.goes_on[half])
            if half == start:
                return

    def _course(self, enters: Half) -> Course:
        stretch, last, lane = enters
        if not last:
            return self.seen[stretch, lane]
        return self.seen[stretch, self.goes_on[enters][2]].back()

    def _weighed(
        self, knot: Knot, before: Sequence[Course], after: Sequence[Course], now: tuple[int, ...]
    ) -> dict[tuple[int, ...], tuple[float, list[Course]]]:
        """Cost of the ways through a knot, and what is seen of each strand in its stretch.

        What is seen there makes all ways dearer: those that cost too much without are left out.
        """
        unseen = np.empty((0, 2)) if knot.stretch is None else self._stretch(knot).line
        nowhere = Course(unseen, np.full(len(unseen), np.nan))
        starts, ends = ([self.spline.placed(one) for one in side] for side in (before, after))
        fits = [[self.spline.through(a, nowhere, b) for b in ends] for a in starts]
        least = {way: sum(fits[k][o][0] for k, o in enumerate(way)) for way in _ways(now)}
        ways: dict[tuple[int, ...], tuple[float, list[Course]]] = {}
        best = np.inf
        for way in sorted(least, key=lambda way: least[way]):
            if least[way] > best + GUESS:
                break
            ways[way] = least[way], []
            if knot.stretch is not None:
                pairs = [(starts[k], ends[o]) for k, o in enumerate(way)]
                lines = np.array([fits[k][o][1] for k, o in enumerate(way)])
                ways[way] = self._along(self._stretch(knot), pairs, lines)
            best = min(best, ways[way][0])
        return ways

    def _stretch(self, knot: Knot) -> Stretch:
        return self.graph.stretches[knot.first[0][0]]

    def _along(
        self, stretch: Stretch, pairs: Sequence[tuple[Placed, Placed]], lines: np.ndarray
    ) -> tuple[float, list[Course]]:
        """Cost of strands that run so through a stretch, first along lines (k, n, 2)."""
        told = stretch.told(self.graph.width)
        for _ in range(PLACINGS):
            seen = self._outermost(stretch, told, lines)
            fits = [self.spline.through(a, one, b) for (a, b), one in zip(pairs, seen, strict=True)]
            lines = np.array([line for _, line in fits])
        known = [np.isfinite(one.sd) for one in seen]
        courses = [Course(c.points[k], c.sd[k]) for c, k in zip(seen, known, strict=True)]
        return sum(cost for cost, _ in fits), courses

    def _outermost(self, stretch: Stretch, told: np.ndarray, lines: np.ndarray) -> list[Course]:
        """Places along a stretch and their sds: the outermost strand on a side is at its edge."""
        half = self.graph.width / 2
        low, high = stretch.low + half, stretch.high - half
        middle = (low + high) / 2
        low, high = np.minimum(low, middle), np.maximum(high, middle)
        offset = ((lines - stretch.line) * stretch.normal).sum(axis=-1)
        rank = np.arange(len(lines))[:, None]
        first, last = rank == offset.argmin(axis=0), rank == offset.argmax(axis=0)
        place = np.where(first, low, np.where(last, high, np.clip(offset, low, high)))
        beyond = (offset < low) | (offset > high)
        sd = np.where(first | last, self.sd, np.where(beyond, OUTSIDE * self.sd, np.nan))
        sd = np.where(told, sd, np.nan)
        place = np.where(np.isfinite(sd), place, 0)
        points = stretch.line + place[..., None] * stretch.normal
        return [Course(*one) for one in zip(points, sd, strict=True)]

    def chains(self, colour: int) -> list[Chain]:
        """Strands from end to end, as smooth as they were taken to be."""
        found, done = [], set()
        halves = sorted(self.goes_on, key=lambda half: half in self.links)  # ends first
        for start in halves:
            if start not in done:
                walk = list(self._walk(start))
                done |= {half for enters in walk for half in (enters, self.goes_on[enters])}
                found.append(self._chain(walk, colour))
        return [chain for chain in found if len(chain.line) > 3]

    def _chain(self, walk: list[Half], colour: int) -> Chain:
        points, sd = (
            np.concatenate(parts) for parts in zip(*(self._course(h) for h in walk), strict=True)
        )
        line = self.spline.along(Course(points, sd))
        doubts = {
            tuple(self.doubts[half].tolist())
            for enters in walk
            for half in (enters, self.goes_on[enters])
            if half in self.doubts
        }
        return Chain(line, np.full(len(line), colour), np.reshape(sorted(doubts), (-1, 2)))


def _ways(now: tuple[int, ...]) -> Iterator[tuple[int, ...]]:
    """Ways through a knot to be tried, the present one among them."""
    if len(now) <= ALL:
        yield from permutations(range(len(now)))
        return
    yield now
    for i, k in combinations(range(len(now)), 2):
        other = list(now)
        other[i], other[k] = other[k], other[i]
        yield tuple(other)


class Spline:
    """Smoothing splines with little change of curvature, on points at equal distances.

    Minimises sum |p - z|^2 / sd^2 + stiffness sum |third difference of z|^2; where nothing is
    seen it goes on as it bends. The minimum is -2 log of the posterior's density, but for a
    constant, if changes of curvature are white noise.
    """

    def __init__(self, stiffness: float, step: float) -> None:
        self.stiffness, self.step = stiffness, step
        self._bands: dict[int, np.ndarray] = {}

    def placed(self, course: Course) -> Placed:
        """Put what is seen on a line of equal steps."""
        return Placed(*course, self._steps(course.points))

    def through(self, before: Placed, here: Course, after: Placed) -> tuple[float, np.ndarray]:
        """Cost, and points (n, 2), along a line (n, 2) between what is seen before and after."""
        known = np.flatnonzero(np.isfinite(here.sd))
        parts = [(before.points, before.at), (here.points, np.arange(len(here.points))),
                 (after.points, after.at)]  # fmt: skip
        at, start, end = [], 0, None
        for points, own in parts:
            if len(points) and end is not None:
                start += max(round(math.dist(end, points[0]) / self.step), 1) - 1
            at.append(start + own)
            if len(points):
                start, end = start + int(own[-1]) + 1, points[-1]
        middle = at[1]
        at[1] = middle[known]
        cost, curve = self._solved(
            np.concatenate(at),
            np.concatenate([before.points, here.points[known], after.points]),
            np.concatenate([before.sd, here.sd[known], after.sd]),
            start,
        )
        return cost, curve[middle]

    def along(self, course: Course) -> np.ndarray:
        """Points (m, 2) at equal distances along what is seen."""
        if len(course.points) < 4:
            return course.points
        at = self._steps(course.points)
        return self._solved(at, course.points, course.sd, int(at[-1]) + 1)[1]

    def _steps(self, points: np.ndarray) -> np.ndarray:
        """Places (n,) of points, each at least a step from the one before."""
        if len(points) == 0:
            return np.empty(0, int)
        apart = np.hypot(*np.diff(points, axis=0).T) / self.step
        return np.concatenate([[0], np.cumsum(np.maximum(np.rint(apart).astype(int), 1))])

    def _solved(
        self, at: np.ndarray, points: np.ndarray, sd: np.ndarray, count: int
    ) -> tuple[float, np.ndarray]:
        if len(points) < 3 or count < 5:
            return 0.0, np.resize(points, (count, 2)) if len(points) else np.zeros((count, 2))
        weight = 1 / sd**2
        band = self._band(count).copy()
        band[3, at] += weight
        right = np.zeros((count, 2))
        right[at] = points * weight[:, None]
        curve = solveh_banded(band, right, overwrite_ab=True, check_finite=False)
        misfit = (((points - curve[at]) ** 2).sum(axis=1) * weight).sum()
        return float(
            misfit
            + self.stiffness
            * ((curve[3:] - curve[:-3] - 3 * (curve[2:-1] - curve[1:-2])) ** 2).sum()
        ), curve

    def _band(self, count: int) -> np.ndarray:
        """Upper bands (4, count) of the penalty's matrix."""
        if count not in self._bands:
            third = np.array([-1.0, 3.0, -3.0, 1.0])
            band = np.zeros((4, count))
            for i, k in combinations_with_replacement(range(4), 2):
                band[3 - (k - i), k : count - 3 + k] += self.stiffness * third[i] * third[k]
            band[3] += 1e-7  # where too little is seen for a parabola
            self._bands[count] = band
        return self._bands[count]
