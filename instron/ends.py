"""Where combing ends: one rule for a machine's log and a simulated one."""

from dataclasses import dataclass

import numpy as np

from instron.average import FINE
from instron.errors import Unscalable
from instron.rig import Rig

SHARE = 0.01  # of the work: what comes after combing carries less
BRIEF = 0.05  # the same of touches that last less than the averaging length
AROUND = 1.5  # averaging lengths to either side of the fall that are fitted
BINS = 200  # rows that are fitted at most
ROUNDS = 5  # of centring that stretch on the place found
CHI2 = 3.84  # 95 % of chi-squared with one degree of freedom ...
JUMP = 7.35  # ... and of the same for the place of a jump (Hansen, Econometrica 68, 575, 2000)
WIDTH = 1.96


@dataclass(frozen=True)
class End:
    """Where combing ends [m].

    Attributes
    ----------
    D, low, high
        Estimate and 95 % interval; of a log that stops before, D is its last place, the others NaN.
    ended
        Whether the force falls for good within the record.
    threshold
        Averaged force above which the tine combs [N].
    rule, warnings
        In words.
    """

    D: float
    low: float
    high: float
    ended: bool
    threshold: float
    rule: str
    warnings: list[str]


def find_end(
    d: np.ndarray,
    F: np.ndarray,
    smooth: np.ndarray,
    length: float,
    noise: tuple[float, float],
    rig: Rig,
    name: str,
) -> End:
    """Return where the averaged force falls for good.

    The tine combs where the averaged force is above ``end_fraction`` of its peak and
    ``end_sigma`` times its noise. Of the stretches in which it is, those at the end which together
    carry less than SHARE of the work are touches of a free tine, and so is one that lasts less
    than the averaging length and carries less than BRIEF. The last one left ends combing. Where in
    its fall the force passes ``end_fraction`` of the peak is read off a line with a step down to
    zero, fitted to the readings around it: averaging would smear a sudden release by half a length.

    Parameters
    ----------
    d, F, smooth
        Place [m], force and averaged force [N] by row.
    length
        That F is averaged over [m].
    noise
        Standard deviation of a reading and of the averaged force [N].

    Raises
    ------
    Unscalable
        When no force stands out of the noise.
    """
    peak = float(smooth.max())
    if peak <= 0 or peak < rig.end_sigma * noise[1]:
        raise Unscalable(f"{name}: the peak force {peak:.3g} N does not stand out of the noise")
    by_noise = rig.end_sigma * noise[1] > rig.end_fraction * peak
    rule = f"{rig.end_sigma:g} x noise" if by_noise else f"{rig.end_fraction:.0%} of the peak"
    threshold = max(rig.end_sigma * noise[1], rig.end_fraction * peak)
    last, touches = _last_row(d, smooth, threshold, length)
    if last == len(d) - 1:
        note = "the log stops before combing ends: D is the last displacement"
        return End(float(d[-1]), np.nan, np.nan, False, threshold, rule, [note])
    level = rig.end_fraction * peak
    D, low, high = float(d[last]), 0.0, 0.0
    for _ in range(ROUNDS):
        before = D
        D, low, high = _fall(d, F, before, length, level, noise)
        if abs(D - before) < length / FINE:
            break
    if D <= 0:
        raise Unscalable(f"{name}: the force is above {threshold:.3g} N only at the start")
    notes = [_said(touches, D)] if touches else []
    notes += _loose(d, smooth, threshold, length, D)
    return End(D, low, high, True, threshold, rule, notes)


def _last_row(
    d: np.ndarray, smooth: np.ndarray, threshold: float, length: float
) -> tuple[int, list[tuple[float, float]]]:
    """Return the last row of combing, and place [m] and share of the work of later touches."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], smooth > threshold, [0]]).astype(int)))
    spans = edges.reshape(-1, 2)
    area = np.concatenate([[0], np.cumsum(np.diff(d) * (smooth[1:] + smooth[:-1]) / 2)])
    work = np.array([area[b - 1] - area[a] for a, b in spans])
    touches, carried = [], 0.0
    for (a, b), one in zip(spans[:0:-1], work[:0:-1], strict=True):
        carried += one
        brief = d[b - 1] - d[a] < 2 * length  # averaging adds a length to what lasts
        if carried > (BRIEF if brief else SHARE) * work.sum():
            break
        touches.append((float(d[a] + d[b - 1]) / 2, float(one / work.sum())))
    return int(spans[len(spans) - 1 - len(touches), 1]) - 1, touches


def _said(touches: list[tuple[float, float]], D: float) -> str:
    place, share = max(touches, key=lambda touch: touch[1])
    return (
        f"after combing ends at d = {D:.4g} m the tine touches again ({len(touches)} times, the"
        f" largest at {place:.4g} m with {share:.1%} of the work): left out"
    )


def _loose(
    d: np.ndarray, smooth: np.ndarray, threshold: float, length: float, D: float
) -> list[str]:
    """Say so where D hangs on the threshold: force that fades instead of falling."""
    places = [float(d[_last_row(d, smooth, k * threshold, length)[0]]) for k in (2.0, 0.5)]
    if places[1] - places[0] > 0.05 * D + length:
        return [f"D depends on the threshold: {places[0]:.4g} to {places[1]:.4g} m for twice and"
                " half of it"]  # fmt: skip
    return []


def _fall(
    d: np.ndarray,
    F: np.ndarray,
    last: float,
    length: float,
    level: float,
    noise: tuple[float, float],
) -> tuple[float, float, float]:
    """Return where the force falls through ``level`` near ``last``, with a 95 % interval [m].

    Least squares of F = h + s (e - d) before a place e and 0 after it, e tried everywhere, with
    h = 0 unless a step down is needed. The interval holds what all places within chi-squared of the
    best one give; coloured noise counts by how much more of it averaging leaves than of white.
    """
    d, F = _around(d, F, last, length)
    if len(d) < 5:
        return last, last - length / 2, last + length / 2
    ramps, steps = _ramps_and_steps(d, F, level)
    step = float(np.median(np.diff(d)))
    least = max(0.0, float(min(ramps[0].min(), steps[0].min())))
    variance = max(least / max(1, len(d) - 3), noise[0] ** 2)
    colour = 1.0
    if noise[0] > 0:
        colour = max(1.0, (noise[1] / noise[0]) ** 2 * max(1.0, length / step))
    allowed = colour * variance * np.repeat([CHI2, JUMP], steps.shape[1])
    steps[0] += CHI2 * colour * variance  # a step must be needed: noise makes small ones
    rest, places, doubts = np.concatenate([ramps, steps], axis=1)
    best = int(np.argmin(rest))
    near = rest <= rest[best] + allowed
    reach = np.hypot(WIDTH * doubts[near] * np.sqrt(colour * variance), step / 2)
    low, high = (places[near] - reach).min(), (places[near] + reach).max()
    return float(places[best]), float(low), float(high)


def _around(
    d: np.ndarray, F: np.ndarray, last: float, length: float
) -> tuple[np.ndarray, np.ndarray]:
    """Return the rows around the fall; if they are over BINS, means of neighbours."""
    reach = max(length, 4 * float(np.median(np.diff(d))))
    inside = np.abs(d - last) <= AROUND * reach
    d, F = d[inside], F[inside]
    size = -(-len(d) // BINS)
    whole = len(d) - len(d) % size
    return d[:whole].reshape(-1, size).mean(axis=1), F[:whole].reshape(-1, size).mean(axis=1)


def _ramps_and_steps(d: np.ndarray, F: np.ndarray, level: float) -> tuple[np.ndarray, np.ndarray]:
    """Fit both models with their edge between any two rows.

    Returns
    -------
    ramps, steps
        (3, edges) each: squares left, place where the fit passes ``level``, and its sd per unit of
        noise. A step that is higher than ``level`` passes it at its edge.
    """
    edge = (d[2:-2] + d[3:-1]) / 2
    away = np.clip(edge[:, None] - d, 0, None)
    count = (away > 0).sum(axis=1)
    a, aa, aF = away.sum(axis=1), (away**2).sum(axis=1), away @ F
    sum_F, squares = (away > 0) @ F, float(F @ F)
    slope = aF / aa
    before = np.where(slope > 0, np.minimum(level / np.where(slope > 0, slope, 1), edge - d[0]), 0)
    doubt = before / np.sqrt(aa) / np.where(slope > 0, slope, np.inf)
    ramps = np.array([squares - slope * aF, edge - before, doubt])
    spread = aa - a**2 / count
    slope = (aF - a * sum_F / count) / spread
    height = (sum_F - slope * a) / count
    inside = (height < level) & (slope > 0)
    before = np.where(inside, (level - height) / np.where(inside, slope, 1), 0)
    doubt = np.sqrt(1 / count + (before - a / count) ** 2 / spread) / np.where(
        inside, slope, np.inf
    )
    rest = squares - sum_F**2 / count - slope**2 * spread
    return ramps, np.array([rest, edge - before, doubt])
