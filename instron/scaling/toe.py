"""Where slack ends: the foot of the first rise of a force."""

from dataclasses import dataclass

import numpy as np
from scipy.special import stdtrit

from instron.errors import Unscalable
from instron.scaling.noise import Noise

RISE = 0.1  # of the highest force: so much of the first rise is looked at
SURE = 10  # sd of the averaged noise that it has at least
GONE = 0.5  # of that force: under it a first rise is over
AGAIN = 0.1  # of the work that comes later: the first rise was a jam's
GENTLEST = 3.0  # power of a rise; the steepest is straight
COARSE = 0.25  # step of the powers tried first
FINE = (0.125, 0.02)  # beside the best so far, twice
PLACES = 101
FEWEST, MOST = 6, 200  # rows of the rise; of more the means of some are taken


@dataclass(frozen=True)
class Toe:
    """The place [m] at which a first rise leaves zero, with its 95 % interval."""

    foot: float
    low: float
    high: float


def find_toe(
    d: np.ndarray,
    F: np.ndarray,
    smooth: np.ndarray,
    length: float,
    noise: Noise,
    zero: float,
    name: str,
) -> Toe:
    """Return where the tangent at the foot of the first rise meets zero.

    Up to a tenth of the highest force the rise is ``a (d - foot)^p`` with 1 <= p <= 3: straight
    rises and those that begin gently leave zero at their foot, whatever jam comes later.

    Parameters
    ----------
    d, F, smooth
        Displacement [m], force from its zero and averaged force [N], by row.
    length
        Averaging length [m].
    noise, zero
        Of the force, and the standard uncertainty of its zero [N].
    name
        Of the log, for messages.

    Raises
    ------
    Unscalable
        Where the log begins on the rise, has too few rows on it, or the rise is that of a jam
        after which the force is gone again.
    """
    level = max(RISE * float(smooth.max()), SURE * noise.averaged)
    top = int(np.argmax(smooth >= level))
    rows = d <= d[top] + length / 2
    count = np.count_nonzero(rows)
    if count < FEWEST:
        raise Unscalable(f"{name}: toe = 'tangent': {count} rows up to a force of {level:.3g} N"
                         " show no slack; use toe = 'none'")  # fmt: skip
    _refuse_jam(d, smooth, level, top, name)
    each = count // MOST + 1
    x, y = (v[rows][count % each :].reshape(-1, each).mean(axis=1) for v in (d, F))
    colour = noise.colour(length / float(np.median(np.diff(d))))
    known = (colour * noise.sd / zero) ** 2 / each if zero else np.inf
    foot, likely = _least(x, y, known, stdtrit(len(x) - 3, 0.975) * colour)
    if top == 0 or foot <= x[0] - length:
        raise Unscalable(
            f"{name}: toe = 'tangent': the first rise, at {d[top]:.4g} m, runs on from before the"
            " first row: where slack ends is not in the log; use toe = 'none'"
        )
    return Toe(foot, float(likely[0]), float(likely[-1]))


def _refuse_jam(d: np.ndarray, smooth: np.ndarray, level: float, top: int, name: str) -> None:
    """Refuse a rise after which the force is gone before it rises again."""
    over = top + np.flatnonzero(smooth[top:] < GONE * level)
    if len(over) and smooth[over[0] :].clip(0).sum() > AGAIN * smooth[top:].clip(0).sum():
        raise Unscalable(
            f"{name}: toe = 'tangent': the first rise, at {d[top]:.4g} m, is that of a jam: the"
            f" force is gone again at {d[over[0]]:.4g} m; use toe = 'none'"
        )


def _least(x: np.ndarray, y: np.ndarray, known: float, wide: float) -> tuple[float, np.ndarray]:
    """Return the place that leaves the least, and those that leave not much more."""
    places = np.linspace(2 * x[0] - x[-1], x[-1], 2 * PLACES)
    for _ in range(3):  # twice more, finely, where it may be
        rest = _misfits(x, y, places, known)
        likely = places[rest <= rest.min() * (1 + wide**2 / (len(x) - 3))]
        step = places[1] - places[0]
        places = np.linspace(likely[0] - step, min(likely[-1] + step, x[-1]), PLACES)
    return float(places[np.argmin(_misfits(x, y, places, known))]), likely


def _misfits(x: np.ndarray, y: np.ndarray, places: np.ndarray, known: float) -> np.ndarray:
    """Return the sum of squares that the best rise from each place leaves, whatever its power.

    The zero is fitted, known beforehand as well as so many readings tell it.
    """
    shape, weight = np.maximum(x - places[:, None], 0) / (x[-1] - x[0]), len(x) + known
    spread = y @ y - y.sum() ** 2 / weight

    def misfit(risen: np.ndarray) -> np.ndarray:
        total = risen.sum(axis=1)
        along = np.maximum(risen @ y - total * y.sum() / weight, 0)
        size = np.maximum((risen**2).sum(axis=1) - total**2 / weight, 1e-300)
        return np.asarray(spread - along**2 / size)

    powers = np.arange(1, GENTLEST + COARSE / 2, COARSE)
    tried = np.array([misfit(shape**power) for power in powers])
    best, rest = powers[np.argmin(tried, axis=0)], tried.min(axis=0)
    for step in FINE:  # the lowest of the parabola through three, where that is lower
        below, above = (misfit(shape ** (best + sign * step)[:, None]) for sign in (-1, 1))
        bend = np.maximum(below + above - 2 * rest, 1e-300)
        off = np.clip((below - above) / 2 / bend, -1, 1) * step
        new = np.clip(best + off, 1, GENTLEST)
        there = misfit(shape ** new[:, None])
        best, rest = np.where(there < rest, new, best), np.minimum(there, rest)
    return rest
