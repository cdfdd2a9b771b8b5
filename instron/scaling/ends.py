"""Where combing ends: one rule for a machine's log and a simulated one."""

from dataclasses import dataclass, replace

import numpy as np
from scipy.special import stdtrit

from instron.errors import Unscalable
from instron.scaling.average import FINE
from instron.scaling.noise import SLOW, Noise
from instron.scaling.rig import Rig

SHARE = 0.01  # of the work: what comes after combing carries less
BRIEF = 0.05  # the same of touches that last less than the averaging length
AROUND = 1.5  # averaging lengths to either side of the fall that are fitted
BINS = 200  # rows that are fitted at most
ROUNDS = 5  # of centring that stretch on the place found
CHI2 = 3.84  # 95 % of chi-squared with one degree of freedom ...
JUMP = 7.35  # ... and of the same for the place of a jump (Hansen, Econometrica 68, 575, 2000)
WIDTH = 1.96
SURE = 4.0  # sd
MOST = 4.0  # times that noise may be larger than what a few swings of it tell


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


@dataclass(frozen=True)
class _Doubt:
    """What is not known of the force where it falls.

    Attributes
    ----------
    noise
        Of the record.
    zero
        Standard uncertainty of the force that means nothing [N].
    length, step
        Averaging length, and distance of two rows [m].
    """

    noise: Noise
    zero: float
    length: float
    step: float

    @property
    def unsure(self) -> float:
        """How many times larger noise as slow as the length may be than what is known of it.

        The quantile of Student's t over that of the normal distribution: a few swings tell little.
        """
        if self.noise.averaged <= SLOW * self.noise.sd:
            return 1.0
        return float(min(MOST, stdtrit(self.noise.freedom, 0.975) / WIDTH))

    @property
    def colour(self) -> float:
        """How much more noise averaging leaves than it would of white noise."""
        return self.noise.colour(self.length / self.step)


def find_end(
    d: np.ndarray,
    F: np.ndarray,
    smooth: np.ndarray,
    length: float,
    noise: Noise,
    rig: Rig,
    name: str,
    zero: float = 0.0,
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
        Of a reading and of the averaged force.
    zero
        Standard uncertainty of the zero where combing ends [N].

    Raises
    ------
    Unscalable
        When no force stands out of the noise.
    """
    peak = float(smooth.max())
    limit, level = rig.end_sigma * noise.averaged, rig.end_fraction * peak
    if peak <= 0 or peak < limit:
        raise Unscalable(f"{name}: the peak force {peak:.3g} N does not stand out of the noise")
    threshold = max(limit, level)
    by_noise = f"{rig.end_sigma:g} x noise"
    rule = by_noise if limit > level else f"{rig.end_fraction:.0%} of the peak"
    last, touches = _last_row(d, smooth, threshold, length)
    if last == len(d) - 1:
        note = "the log stops before combing ends: D is the last displacement"
        return End(float(d[-1]), np.nan, np.nan, False, threshold, rule, [note])
    doubt = _Doubt(noise, zero, length, float(np.median(np.diff(d))))
    D, low, high = _last_fall(d, F, last, level, doubt)
    if D <= 0:
        raise Unscalable(f"{name}: the force is above {threshold:.3g} N only at the start")
    if doubt.unsure > 1:
        early, late = _swung(d, smooth, level, threshold, peak, doubt)
        low, high = min(low, early), max(high, late)
    notes = [_said(touches, D)] if touches else []
    notes += _loose(d, smooth, threshold, length, D)
    return End(D, float(low), float(high), True, threshold, rule, notes)


def _last_fall(
    d: np.ndarray, F: np.ndarray, last: int, level: float, doubt: _Doubt
) -> tuple[float, float, float]:
    """Return where the force falls through ``level`` at row ``last``, with a 95 % interval [m].

    The fit is centred on what it finds, and looks only at the later of two releases close together.
    """
    length, noise = doubt.length, doubt.noise
    D, low, high, first = float(d[last]), 0.0, 0.0, 0
    until = D - length / 2
    for _ in range(ROUNDS):
        before = D
        D, low, high = _fall(d[first:], F[first:], before, level, doubt)
        beyond = (d > D) & (d <= until)
        if _goes_on(F[beyond], level, noise.sd * doubt.colour):
            first, D = int(np.argmax(beyond)), until
        elif abs(D - before) < length / FINE:
            break
    return D, low, high


def _swung(
    d: np.ndarray, smooth: np.ndarray, level: float, threshold: float, peak: float, doubt: _Doubt
) -> tuple[float, float]:
    """Return the ends if a swing of the noise was taken for force, and force for a swing [m]."""
    limits = max(level, threshold / doubt.unsure), min(threshold * doubt.unsure, peak / 2)
    late, early = (float(d[_last_row(d, smooth, limit, doubt.length)[0]]) for limit in limits)
    return early - doubt.length / 2, late + doubt.length / 2


def _goes_on(F: np.ndarray, level: float, sd: float) -> bool:
    """Tell whether readings are above ``level`` in the mean, by SURE of its standard deviation."""
    return len(F) > 2 and float(F.mean()) > level + SURE * sd / np.sqrt(len(F))


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
    d: np.ndarray, F: np.ndarray, last: float, level: float, doubt: _Doubt
) -> tuple[float, float, float]:
    """Return where the force falls through ``level`` near ``last``, with a 95 % interval [m].

    Least squares of s (e - d) before a place e and 0 after it, e tried everywhere, and where the
    data ask for it with a bend, s (e - d) + q (e - d)^2, or a step, h + s (e - d). The interval
    holds what all places within chi-squared of the best one give; coloured noise counts by how
    much more of it averaging leaves than of white. What the zero is off moves the place by the
    inverse of the slope there.
    """
    d, F = _around(d, F, last, AROUND * doubt.length)
    if len(d) < 5:
        return last, last - doubt.length / 2, last + doubt.length / 2
    ramps, curves, steps = _fits(d, F, level)
    step = float(np.median(np.diff(d)))
    least = max(0.0, float(min(one[0].min() for one in (ramps, curves, steps))))
    variance = max(least / max(1, len(d) - 3), doubt.noise.sd**2)
    colour = replace(doubt, step=step).colour ** 2
    doubtful = colour * variance * doubt.unsure**2
    allowed = doubtful * np.repeat([CHI2, CHI2, JUMP], steps.shape[1])
    for one in (curves, steps):  # must be needed: noise makes small bends and steps
        one[0] += CHI2 * colour * variance
    rest, places, doubts, flat = np.concatenate([ramps, curves, steps], axis=1)
    best = int(np.argmin(rest))
    near = rest <= rest[best] + allowed
    sd = np.hypot(doubts[near] * np.sqrt(doubtful), flat[near] * doubt.zero)
    reach = np.hypot(WIDTH * sd, step / 2)
    low, high = (places[near] - reach).min(), (places[near] + reach).max()
    return float(places[best]), float(low), float(high)


def _around(
    d: np.ndarray, F: np.ndarray, last: float, reach: float
) -> tuple[np.ndarray, np.ndarray]:
    """Return the rows around the fall; if they are over BINS, means of neighbours."""
    reach = max(reach, 6 * float(np.median(np.diff(d))))
    inside = np.abs(d - last) <= reach
    d, F = d[inside], F[inside]
    size = -(-len(d) // BINS)
    whole = len(d) - len(d) % size
    return d[:whole].reshape(-1, size).mean(axis=1), F[:whole].reshape(-1, size).mean(axis=1)


def _fits(d: np.ndarray, F: np.ndarray, level: float) -> tuple[np.ndarray, ...]:
    """Fit all three models with their edge between any two rows.

    Returns
    -------
    ramps, curves, steps
        (4, edges) each: squares left, place where the fit passes ``level``, its sd per unit of
        noise, and by how much it moves per unit of force. A step that is higher than ``level``
        passes it at its edge.
    """
    edge = (d[2:-2] + d[3:-1]) / 2
    away = np.clip(edge[:, None] - d, 0, None)
    before = away > 0
    powers = [before.astype(float), away, away**2]
    sums = [power @ F for power in powers]
    squares = float(F @ F)

    def fitted(m: int, n: int) -> np.ndarray:
        """Fit a sum of the powers m and n of the distance from the edge; m alone if equal."""
        mm, mn, nn = ((powers[i] * powers[j]).sum(axis=1) for i, j in ((m, m), (m, n), (n, n)))
        if m == n:
            one, two = sums[m] / mm, np.zeros(len(edge))
            spread = np.array([[1 / mm, 0 * mm], [0 * mm, 0 * mm]])
        else:
            whole = mm * nn - mn**2
            spread = np.array([[nn, -mn], [-mn, mm]]) / whole
            one, two = np.einsum("ijk,jk->ik", spread, np.array([sums[m], sums[n]]))
        rest = squares - one * sums[m] - two * sums[n]
        if n == 2:  # a bend that falls all the way to its edge
            falls = (one >= 0) & (one + 2 * two * (edge - d[0]) >= 0)
            rest = np.where(falls, rest, np.inf)
        far = _passes(m, one, n, two, level, edge - d[0])
        slope = np.abs(m * one * far ** max(m - 1, 0) + n * two * far ** max(n - 1, 0))
        row = np.array([far**m, far**n])
        sd = np.sqrt(np.clip(np.einsum("ik,ijk,jk->k", row, spread, row), 0, None))
        flat = np.where((far > 0) & (slope > 0), 1 / np.where(slope > 0, slope, 1), 0.0)
        return np.array([rest, edge - far, sd * flat, flat])

    return fitted(1, 1), fitted(1, 2), fitted(0, 1)


def _passes(
    m: int, one: np.ndarray, n: int, two: np.ndarray, level: float, most: np.ndarray
) -> np.ndarray:
    """Return how far before its edge a fit first passes ``level``, at most ``most`` [m]."""
    constant = (one if m == 0 else 0.0) - level
    linear = (one if m == 1 else 0.0) + (two if n == 1 and m != 1 else 0.0)
    square = two if n == 2 else np.zeros_like(two)
    under = np.clip(linear**2 - 4 * square * constant, 0, None)
    below = linear + np.sqrt(under)
    far = np.where(below > 0, -2 * constant / np.where(below > 0, below, 1), most)
    return np.clip(np.where(constant >= 0, 0.0, far), 0.0, most)
