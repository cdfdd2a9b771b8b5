"""Count half-turns of two strands from who is on which side, and who passes in front."""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from scipy.ndimage import median_filter

from imaging.errors import Unmeasurable

Array = np.ndarray
UNSURE = 0.1  # of a strand's width; less tells nothing of who is in front


@dataclass(frozen=True)
class Look:
    """What each section normal to the axis shows before any model is fitted.

    Attributes
    ----------
    s : (n,) array
        Arclength of the sections [px].
    separation : (n,) array
        Offset of strand a minus that of strand b [px] from the pair's outer edges; 0 where one
        strand hides the other, NaN where neither or only one is there.
    excess : (n,) array
        Visible width of a minus that of b [px]: positive where a is in front.
    """

    s: Array
    separation: Array
    excess: Array


@dataclass(frozen=True)
class HalfTurns:
    """Places where the strands swap sides, root to tip.

    Attributes
    ----------
    s : (n,) array
        Arclength [px].
    phase : (n,) array
        Phase there, an odd multiple of pi/2, lifted from one crossing to the next.
    sense : (n,) array
        +1 right-handed, -1 left-handed.
    sure : (n,) array
        Width by which the front strand shows more than the rear one, over a strand's width; 0
        where the crossing itself is hidden and its sense is taken from the others.
    """

    s: Array
    phase: Array
    sense: Array
    sure: Array


def look(s: Array, u: Array, profiles: Array, r: float) -> Look:
    """Read sides and visible widths off sections.

    Parameters
    ----------
    s : (n,) array
        Arclength of the sections [px].
    u : (m,) array
        Offsets [px], equally spaced.
    profiles : (2, n, m) array
        Membership of both strands.
    r : float
        Strand radius [px].
    """
    inside = np.asarray(profiles > 0.5)
    widths = inside.sum(axis=2) * (u[1] - u[0])
    anyone = np.any(inside, axis=0)
    first = u[np.argmax(anyone, axis=1)]
    last = u[len(u) - 1 - np.argmax(anyone[:, ::-1], axis=1)]
    with np.errstate(invalid="ignore"):
        centres = (inside * u).sum(axis=2) / inside.sum(axis=2)
    size = np.maximum(last - first + (u[1] - u[0]) - 2 * r, 0.0)
    both = widths.min(axis=0) > 0
    separation = np.where(both, np.sign(centres[0] - centres[1]) * size, 0.0)
    # One strand alone is a crossing only when it fills the whole pair and both are near.
    lonely = ~both & ((widths.max(axis=0) == 0) | ~_near(both, int(3 * r)))
    return Look(s, np.where(lonely, np.nan, separation), widths[0] - widths[1])


def strand_radius(profiles: Array, u: Array) -> float:
    """Half the width of the strand in front, the wider one, in a typical section [px]."""
    widths = (profiles > 0.5).sum(axis=2).max(axis=0) * (u[1] - u[0])
    return float(0.5 * np.median(widths[widths > 0])) if (widths > 0).any() else 0.0


def helix_radius(seen: Look, turns: HalfTurns) -> float:
    """Typical half separation between swaps [px], from the widest place of each half-turn."""
    pieces = np.searchsorted(turns.s, seen.s)
    size = np.abs(seen.separation)
    widest = [np.nanmax(size[pieces == k], initial=0.0) for k in range(1, len(turns.s))]
    return float(0.5 * np.median(widest)) if widest else 0.0


def half_turns(seen: Look, r: float) -> HalfTurns:
    """Find the crossings of the pair and lift their phase.

    Each swap of sides from right to left (a seen from the axis, root on top) with a in front
    advances the phase by half a turn, as in a right-handed helix; with b in front it takes it back.

    Raises
    ------
    Unmeasurable
        When the strands swap sides fewer than twice.
    """
    size = np.abs(np.nan_to_num(seen.separation))
    typical = float(np.median(size[size > 0])) if size.any() else 0.0
    side, runs = _sides(seen.separation, max(0.35 * r, 0.4 * typical, 1.5))
    if len(side) < 3:
        raise Unmeasurable(
            f"the two strands swap sides {max(len(side) - 1, 0)} times; "
            "a link density needs at least 2 crossings"
        )
    gaps = [(a[1], b[0]) for a, b in pairwise(runs)]
    s = np.array([_zero(seen, a, b) for a, b in gaps])
    excess = np.array([np.sum(seen.excess[a : b + 1]) / (2 * r * max(b - a, 1)) for a, b in gaps])
    unsure = np.abs(excess) < UNSURE
    # a going right -> left in front, or left -> right behind, turns right-handed.
    sense = np.sign(excess) * side[:-1]
    sense[unsure] = np.sign(np.sum(sense[~unsure])) or 1.0
    first = 0.0 if side[0] > 0 else np.pi
    phase = first + np.pi * (np.cumsum(sense) - 0.5 * sense)
    return HalfTurns(s, phase, sense, np.where(unsure, 0.0, np.minimum(np.abs(excess), 1)))


def first_phase(turns: HalfTurns, s: Array) -> Array:
    """Phase at arclengths ``s``, straight between the crossings and beyond them."""
    phase = np.interp(s, turns.s, turns.phase)
    for outside, (i, j) in ((s < turns.s[0], (0, 1)), (s > turns.s[-1], (-2, -1))):
        slope = (turns.phase[j] - turns.phase[i]) / (turns.s[j] - turns.s[i])
        anchor = 0 if i == 0 else -1
        phase[outside] = turns.phase[anchor] + slope * (s[outside] - turns.s[anchor])
    return phase


def spread_apart(seen: Look, radius: float, reach: float, covered: np.ndarray) -> np.ndarray:
    """Sections where the strands lie further apart than a helix of ``radius`` allows, or are lost.

    Three fifths more than the typical radius are allowed, for a helix that widens and for sections
    that a kink leaves aslant. What lies within ``reach`` [px] of such a place widens too steeply.
    """
    size = np.abs(seen.separation) / 2
    apart = median_filter(np.nan_to_num(size, nan=np.inf), 5) > 1.6 * radius + 1.0
    apart &= ~_near(covered, int(radius) + 3)
    return _near(apart, max(int(reach), 1))


def _sides(separation: Array, least: float) -> tuple[Array, list[tuple[int, int]]]:
    """Return runs of strand a on one side: the side (+1, -1), first and last section."""
    side: list[float] = []
    runs: list[tuple[int, int]] = []
    for i in np.flatnonzero(np.abs(np.nan_to_num(separation)) > least):
        now = float(np.sign(separation[i]))
        if side and side[-1] == now:
            runs[-1] = (runs[-1][0], int(i))
        else:
            side.append(now)
            runs.append((int(i), int(i)))
    return np.array(side), runs


def _zero(seen: Look, a: int, b: int) -> float:
    """Arclength at which the separation passes zero between sections a and b."""
    d = np.abs(seen.separation[[a, b]])
    return float(seen.s[a] + (seen.s[b] - seen.s[a]) * d[0] / d.sum())


def _near(mask: np.ndarray, reach: int) -> np.ndarray:
    """Grow a one-dimensional mask by ``reach`` on both sides."""
    padded = np.concatenate([np.zeros(reach, bool), mask, np.zeros(reach, bool)])
    total = np.cumsum(np.concatenate([[0], padded]))
    return total[2 * reach + 1 :] - total[: -2 * reach - 1] > 0
