"""Tips that show again beyond what hides them: specks of a strand's colour ahead of its end.

A speck, shorter than a strand is wide, has no direction and takes no part in the matching of
pieces. That a strand disappears just before it, pointing to it, with nothing but other strands in
between, tells whose it is.
"""

from collections.abc import Iterable, Mapping, Sequence
from typing import NamedTuple

import cv2
import numpy as np

from imaging.trace.branches import REACH, end_fit
from imaging.trace.matching import DISTANCE, EXPOSED, PLACE, TURN, TURN_PER_WIDTH

OWNED = 1.3  # strand widths across a centreline; what is seen there of its colour is its own
SMALLEST = 0.15  # strand widths squared; less may be noise
FARTHEST = 15.0  # strand widths ahead of an end
PRICE = 3.0  # most that the turn, the distance and bare ground on the way may cost

Tip = tuple[int, bool]  # number of a strand, and whether it is its last end or its first


class Way(NamedTuple):
    """A way from a tip to a speck: what it costs, and its points (n, 2) outwards."""

    cost: float
    tip: Tip
    speck: int
    points: np.ndarray


def led_on(
    lines: Mapping[int, np.ndarray],
    hidden: Sequence[Tip],
    seen: np.ndarray,
    covered: np.ndarray,
    width: float,
) -> dict[int, np.ndarray]:
    """Lead strands of one colour on to the specks in which they show again, the cheapest first.

    Parameters
    ----------
    lines : mapping of int to (n, 2) array
        All strands of the colour.
    hidden : sequence of (int, bool)
        Those of their ends that disappear under other strands.
    seen : (h, w) bool array
        Where the colour is seen.
    covered : (h, w) bool array
        Where a strand may hide.
    width : float
        Strand width [px].

    Returns
    -------
    dict of int to (m, 2) array
        The strands that go on, longer.
    """
    longer: dict[int, np.ndarray] = {}
    ends = [lines[number][-last] for number, last in hidden]
    specks = _specks(seen, lines.values(), np.array(ends), width)
    while len(specks):
        now = {**lines, **longer}
        ways = [way for tip in hidden for way in _ways(tip, now[tip[0]], specks, covered, width)]
        if not ways:
            break
        best = min(ways, key=lambda way: way.cost)
        number, last = best.tip
        parts = [now[number], best.points] if last else [best.points[::-1], now[number]]
        longer[number] = np.concatenate(parts)
        specks = np.delete(specks, best.speck, axis=0)
    return longer


def _specks(
    seen: np.ndarray, lines: Iterable[np.ndarray], ends: np.ndarray, width: float
) -> np.ndarray:
    """Middles (k, 2) of what is seen of a colour around these ends, away from its strands."""
    reach = 2 * FARTHEST * width  # from speck to speck it goes on
    low = np.maximum(ends.min(axis=0) - reach, 0).astype(int)
    high = (ends.max(axis=0) + reach).astype(int) + 1
    rest = seen[low[1] : high[1], low[0] : high[0]].astype(np.uint8)
    drawn = [np.rint(line - low).astype(np.int32) for line in lines]
    cv2.polylines(rest, drawn, False, 0, max(1, round(OWNED * width)))
    _, _, stats, middles = cv2.connectedComponentsWithStats(rest)
    large = stats[1:, cv2.CC_STAT_AREA] > SMALLEST * width**2
    return middles[1:][large] + low


def _ways(
    tip: Tip, line: np.ndarray, specks: np.ndarray, covered: np.ndarray, width: float
) -> list[Way]:
    """Find the specks that a tip points to with little but other strands on the way."""
    outwards = line if tip[1] else line[::-1]
    end, direction = end_fit(outwards[-max(3, int(REACH * width)) :])
    chord = specks - end
    gap = np.maximum(np.hypot(*chord.T), 1e-6)
    turn = np.arccos(np.clip(chord @ direction / gap, -1, 1))
    usual = TURN**2 + (TURN_PER_WIDTH * gap / width) ** 2 + (PLACE * width / gap) ** 2
    cost = turn**2 / usual + DISTANCE * gap / width
    found = []
    for speck in np.flatnonzero((cost < PRICE) & (gap < FARTHEST * width)).tolist():
        points = _arc(end, direction, specks[speck])
        x, y = np.rint(points).astype(int).T
        last_y, last_x = np.subtract(covered.shape, 1)
        bare = ~covered[y.clip(0, last_y), x.clip(0, last_x)]
        whole = float(cost[speck] + EXPOSED * bare.sum() / width)
        if whole < PRICE:
            found.append(Way(whole, tip, speck, points))
    return found


def _arc(start: np.ndarray, direction: np.ndarray, stop: np.ndarray) -> np.ndarray:
    """Parabola that leaves `start` in a direction, points about 1 px apart, `start` left out."""
    chord = stop - start
    gap = np.hypot(*chord)
    v = np.linspace(0, 1, max(2, int(gap) + 1))[1:, None]
    aside = gap * direction - (gap * direction @ chord) / gap**2 * chord
    return start + v * chord + v * (1 - v) * aside
