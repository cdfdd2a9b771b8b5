"""What data say of friction and factor together: the posterior on a grid, its region, its ridge.

Two parameters need no sampler: the density is computed everywhere.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from combing.fit.emulator import Emulator
from combing.fit.plan import from_unit

LEVEL = 0.95
CELLS = 64  # of the grid along either parameter
ZOOMS = 4  # times that the grid is drawn in around what is likely
NEGLIGIBLE = 14.0  # log likelihood below the highest, beyond which nothing is left: exp(-14) a cell
ROOM = 2  # cells kept around it
WHOLE = ((0.0, 1.0), (0.0, 1.0))
HIGH = 0.13  # density at an edge over the highest, from which the data give no bound there: exp(-2)


Window = tuple[tuple[float, float], tuple[float, float]]


class Measured(NamedTuple):
    """Summaries of a lab.

    Attributes
    ----------
    values, error : (p,) arrays
        Means over specimens, and the sd by which the measurement itself is off.
    specimens : (p,) array
        How many each is a mean of; fewer are some of the more.
    """

    values: np.ndarray
    error: np.ndarray
    specimens: np.ndarray


class Interval(NamedTuple):
    """Median and 95 % interval of a parameter; whether the data bound it on either side."""

    value: float
    low: float
    high: float
    bounded_below: bool
    bounded_above: bool


@dataclass(frozen=True)
class Posterior:
    """Probability of every cell of the unit square of (friction, log factor).

    Attributes
    ----------
    mass : (CELLS, CELLS) array
        First index friction, second log factor; adds up to 1.
    friction, factor : (float, float)
        Ranges of the parameters beforehand: what the unit square stands for.
    window : ((float, float), (float, float))
        Part of the unit square that the cells cover; nothing is left beyond it.
    """

    mass: np.ndarray
    friction: tuple[float, float]
    factor: tuple[float, float]
    window: Window = WHOLE

    @property
    def axes(self) -> tuple[np.ndarray, np.ndarray]:
        """Friction and factor in the middle of the cells."""
        found = from_unit(np.column_stack(_middles(self.window)), self.friction, self.factor)
        return found[:, 0], found[:, 1]

    @property
    def content(self) -> np.ndarray:
        """Mass of all cells that are at least as likely as each: the 95 % region is <= 0.95."""
        order = np.argsort(-self.mass, axis=None, kind="stable")
        content = np.empty(self.mass.size)
        content[order] = np.cumsum(self.mass.ravel()[order])
        return content.reshape(self.mass.shape)

    @property
    def share(self) -> float:
        """Area of the 95 % region over that of all that was possible beforehand."""
        area = float(np.prod([high - low for low, high in self.window]))
        return float(np.mean(self.content <= LEVEL)) * area

    @property
    def best(self) -> tuple[float, float]:
        """Most likely friction and factor."""
        i, j = np.unravel_index(np.argmax(self.mass), self.mass.shape)
        friction, factor = self.axes
        return float(friction[i]), float(factor[j])

    def holds(self, friction: float, factor: float) -> bool:
        """Tell whether the 95 % region holds a point: it ends where 95 % are reached."""
        at = self._cells(friction, factor)
        if not all(0 <= u < CELLS for u in at):
            return False
        i, j = (int(u) for u in at)
        return bool(self.content[i, j] - self.mass[i, j] < LEVEL)

    def rank(self, friction: float, factor: float) -> tuple[float, float]:
        """Return the share of the posterior below each coordinate of a point."""
        shares = (np.append(0, np.cumsum(self.mass.sum(axis=axis))) for axis in (1, 0))
        at = self._cells(friction, factor)
        one, other = (
            np.interp(u, np.arange(CELLS + 1), s) for u, s in zip(at, shares, strict=True)
        )
        return float(one), float(other)

    def intervals(self) -> tuple[Interval, Interval]:
        """Return median and equal-tailed interval of friction and of factor."""
        return self._interval(0), self._interval(1)

    def ridge(self) -> np.ndarray:
        """Return (friction, factor) along the ridge: the mean log factor at every friction that
        carries any weight, (n, 2).
        """
        weight = self.mass.sum(axis=1)
        friction, factor = self.axes
        kept = weight > weight.max() * 1e-3
        mean = (self.mass @ np.log(factor))[kept] / weight[kept]
        return np.column_stack([friction[kept], np.exp(mean)])

    def correlation(self) -> float:
        """Return the correlation of friction and log factor."""
        friction, factor = self.axes
        a, b = friction[:, None] - self.mass.sum(axis=1) @ friction, np.log(factor)
        b = b - self.mass.sum(axis=0) @ b
        products = [float(np.sum(self.mass * one)) for one in (a * b, a * a, b * b)]
        return products[0] / np.sqrt(products[1] * products[2])

    def draws(self, count: int, rng: np.random.Generator) -> np.ndarray:
        """Return points of the unit square drawn from it, (count, 2)."""
        cells = rng.choice(self.mass.size, count, p=self.mass.ravel())
        at = np.column_stack(np.unravel_index(cells, self.mass.shape))
        low, high = np.array(self.window).T
        return low + (at + rng.random((count, 2))) / CELLS * (high - low)

    def unit_of(self, friction: float, factor: float) -> np.ndarray:
        """Return a point of the unit square."""
        low, high = np.log(self.factor)
        one = (friction - self.friction[0]) / (self.friction[1] - self.friction[0])
        return np.array([one, (np.log(factor) - low) / (high - low)])

    def _cells(self, friction: float, factor: float) -> np.ndarray:
        """Return where a point is, in cells from the first corner of the window."""
        low, high = np.array(self.window).T
        return (self.unit_of(friction, factor) - low) / (high - low) * CELLS

    def _interval(self, axis: int) -> Interval:
        weight, middle = self.mass.sum(axis=1 - axis), self.axes[axis]
        share = np.append(0, np.cumsum(weight))
        cells = np.interp([0.5, (1 - LEVEL) / 2, (1 + LEVEL) / 2], share, np.arange(CELLS + 1))
        scale = np.log(middle) if axis else middle
        found = np.polyval(np.polyfit(np.arange(CELLS) + 0.5, scale, 1), cells)
        found = np.exp(found) if axis else found
        most = HIGH * weight.max()
        low, high = self.window[axis]
        sure = low > 0 or weight[0] < most, high < 1 or weight[-1] < most
        value, below, above = map(float, found)
        return Interval(value, below, above, bool(sure[0]), bool(sure[1]))


def posterior(
    emulator: Emulator,
    measured: Measured,
    friction: tuple[float, float],
    factor: tuple[float, float],
    *,
    only: Sequence[int] | None = None,
) -> Posterior:
    """Return the posterior, from a prior that is even in friction and in log factor.

    Parameters
    ----------
    emulator : Emulator
    measured : Measured
        A value for every summary of the emulator.
    friction, factor : (float, float)
        Ranges that the emulator's unit square stands for.
    only : sequence of int, optional
        Summaries to use; all when left out.
    """
    used = np.arange(len(measured.values)) if only is None else np.asarray(only)
    window = WHOLE
    for _ in range(1 + ZOOMS):
        log = _on_grid(emulator, measured, window, used)
        mass = np.exp(log - log.max())
        found = Posterior(mass / mass.sum(), friction, factor, window)
        closer = _around(log, window)
        if all(b - a > (d - c) / 2 for (a, b), (c, d) in zip(closer, window, strict=True)):
            break
        window = closer
    return found


def _on_grid(
    emulator: Emulator, measured: Measured, window: Window, used: np.ndarray
) -> np.ndarray:
    """Return the log likelihood in the middle of every cell, (CELLS, CELLS)."""
    unit = np.stack(np.meshgrid(*_middles(window), indexing="ij"), axis=-1).reshape(-1, 2)
    apart, spread = distances(emulator, measured, unit)
    apart, spread = apart[:, used], spread[:, used[:, None], used]
    return log_likelihood(apart, spread, emulator.freedom).reshape(CELLS, CELLS)


def _middles(window: Window) -> list[np.ndarray]:
    return [low + (np.arange(CELLS) + 0.5) / CELLS * (high - low) for low, high in window]


def _around(log: np.ndarray, window: Window) -> Window:
    """Return the part of a window that holds whatever is not negligible, with some room."""
    likely = log > log.max() - NEGLIGIBLE

    def ends(axis: int) -> tuple[float, float]:
        low, high = window[axis]
        cells = np.flatnonzero(likely.any(axis=1 - axis))
        first, last = max(cells[0] - ROOM, 0), min(cells[-1] + 1 + ROOM, CELLS)
        size = (high - low) / CELLS
        return float(low + first * size), float(low + last * size)

    return ends(0), ends(1)


def distances(
    emulator: Emulator, measured: Measured, unit: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return by how much a lab is off the emulator at points, and the covariance of that.

    The scatter of specimens over their number, the error of the measurement and the emulator's own.
    """
    mean, doubt = emulator.mean(unit)
    # Of a mean of n and that of m < n of the same specimens the covariance is that of one over n.
    scatter = emulator.scatter(unit) / np.maximum.outer(measured.specimens, measured.specimens)
    return measured.values - mean, scatter + doubt + np.diag(measured.error**2)


def log_likelihood(apart: np.ndarray, spread: np.ndarray, freedom: int) -> np.ndarray:
    """Return the log likelihood of distances with a covariance that is an estimate itself.

    Student's t instead of the normal distribution (Sellentin & Heavens, MNRAS Lett. 456, L132,
    2016), for a covariance known with `freedom` degrees of freedom.
    """
    squares = chi_squared(apart, spread)
    return -np.linalg.slogdet(spread)[1] / 2 - (freedom + 1) / 2 * np.log1p(squares / freedom)


def chi_squared(apart: np.ndarray, spread: np.ndarray) -> np.ndarray:
    """Return squared distances in units of their covariance, (n,)."""
    return np.einsum("ni,ni->n", apart, np.linalg.solve(spread, apart[:, :, None])[:, :, 0])
