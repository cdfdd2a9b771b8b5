"""An emulator of the simulation: summaries over friction and factor, from its runs.

Strategy: forces go as the rigidity wherever inertia and gravity do nothing, so log factor is taken
off those summaries, and only what is left is emulated. The scatter of members within their points
is pooled, with a log-linear course over friction; summaries are turned to axes in which it is
independent and of unit size; the mean of each over the unit square is a Gaussian process.
"""

import warnings
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from combing.errors import UserError

MISSING = 'combing fit needs scikit-learn: pip install "combing[fit]"'
FLOORS = {"log spacing of jams": 0.1}  # sd of a count that never differed among members
FLOOR = 0.003  # of all others: what a mesh is off by
LENGTHS = (0.1, 20.0)  # of the processes, in ranges; the upper says "does not depend"


def needs_sklearn() -> None:
    """Raise UserError, before anything is simulated, where scikit-learn is not installed."""
    try:
        import sklearn.gaussian_process  # noqa: F401
    except ImportError:
        raise UserError(MISSING) from None


@dataclass(frozen=True)
class Emulator:
    """Mean and scatter of summaries over the unit square of (friction, log factor).

    Attributes
    ----------
    names : tuple of str
        Of the p summaries.
    growth : (p,) array
        1 where the logarithm of a summary grows with that of the factor, else 0.
    span : (float, float)
        log factor at the ends of the square.
    processes : sequence
        A Gaussian process for each axis.
    axes : (p, p) array
        Columns: directions of independent scatter, each a sd long, in units of `sizes`.
    sizes, slopes : (p,) arrays
        log sd of a summary over members = sizes + slopes (u - 1/2), u the first coordinate.
    freedom : int
        Degrees of freedom that the scatter is known with.
    """

    names: tuple[str, ...]
    growth: np.ndarray
    span: tuple[float, float]
    processes: Sequence[Any]
    axes: np.ndarray
    sizes: np.ndarray
    slopes: np.ndarray
    freedom: int

    def grown(self, unit: np.ndarray) -> np.ndarray:
        """Return what log factor alone adds to every summary, (n, p)."""
        low, high = self.span
        return (low + unit[:, 1:] * (high - low)) * self.growth

    def sd(self, unit: np.ndarray) -> np.ndarray:
        """Return the sd of one more member, (n, p)."""
        return np.exp(self.sizes + self.slopes * (unit[:, :1] - 0.5))

    def mean(self, unit: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the mean over members and the covariance of its own error, (n, p), (n, p, p)."""
        found = [one.predict(unit, return_std=True) for one in self.processes]
        z, doubt = (np.array(part).T for part in zip(*found, strict=True))
        turn = np.exp(self.sizes)[:, None] * self.axes
        return z @ turn.T + self.grown(unit), (turn * doubt[:, None] ** 2) @ turn.T

    def scatter(self, unit: np.ndarray) -> np.ndarray:
        """Return the covariance of one more member, (n, p, p)."""
        sd = self.sd(unit)
        return sd[:, :, None] * (self.axes @ self.axes.T) * sd[:, None, :]


def train(
    unit: np.ndarray,
    values: Sequence[np.ndarray],
    names: Sequence[str],
    growing: Sequence[str],
    span: tuple[float, float],
) -> Emulator:
    """Make an emulator from the members of every point.

    Parameters
    ----------
    unit : (n, 2) array
        Points in the unit square.
    values : sequence of (m, p) arrays
        Summaries of the members of each point.
    names, growing : sequence of str
        Of all summaries, and of those that grow with the factor.
    span : (float, float)
        log factor at the ends of the square.

    Raises
    ------
    UserError
        If scikit-learn is not installed.
    """
    needs_sklearn()
    growth = np.array([float(one in growing) for one in names])
    off = (span[0] + unit[:, 1:] * (span[1] - span[0])) * growth
    means = np.array([some.mean(axis=0) for some in values]) - off
    counts = np.array([len(some) for some in values])
    sizes, slopes = _sizes(unit, values, names)
    local = np.exp(sizes + slopes * (unit[:, :1] - 0.5))
    apart = np.concatenate(
        [(some - some.mean(axis=0)) / sd for some, sd in zip(values, local, strict=True)]
    )
    freedom = int(np.sum(counts - 1))
    axes = _independent(apart.T @ apart / freedom, np.exp(sizes), names)
    z = np.linalg.solve(np.exp(sizes)[:, None] * axes, means.T).T
    spread = np.mean((local / np.exp(sizes)) ** 2, axis=1)  # a noisier point counts for less
    processes = [process(unit, column, spread / counts) for column in z.T]
    return Emulator(tuple(names), growth, span, processes, axes, sizes, slopes, freedom)


def _sizes(
    unit: np.ndarray, values: Sequence[np.ndarray], names: Sequence[str]
) -> tuple[np.ndarray, np.ndarray]:
    """Fit log variance = a + b (u - 1/2) to the squares of the members' differences.

    The most likely exponential course for normal draws: Newton's method on a concave likelihood,
    held back by a normal prior of sd 1 on b, so that few members tell no wild course.
    """
    count = np.concatenate([[len(some) - 1.0] for some in values])
    squares = np.array([((some - some.mean(axis=0)) ** 2).sum(axis=0) for some in values])
    floors = np.array([FLOORS.get(name, FLOOR) for name in names]) ** 2
    squares = squares + count[:, None] * floors
    design = np.column_stack([np.ones(len(unit)), unit[:, 0] - 0.5])
    found = np.array([_course(design, count, column) for column in squares.T])
    return found[:, 0] / 2, found[:, 1] / 2


def _course(design: np.ndarray, count: np.ndarray, squares: np.ndarray) -> np.ndarray:
    at = np.array([np.log(squares.sum() / count.sum()), 0.0])
    prior = np.diag([0.0, 1.0])
    for _ in range(50):
        ratio = squares / np.exp(design @ at)
        slope = design.T @ (ratio - count) / 2 - prior @ at
        curve = design.T @ (design * ratio[:, None]) / 2 + prior
        step = np.linalg.solve(curve, slope)
        at = at + np.clip(step, -1, 1)
        if np.abs(step).max() < 1e-8:
            break
    return at


def _independent(correlation: np.ndarray, sd: np.ndarray, names: Sequence[str]) -> np.ndarray:
    """Return the columns that make up a correlation matrix, with the floors on its diagonal."""
    floors = np.array([FLOORS.get(name, FLOOR) for name in names]) / sd
    values, vectors = np.linalg.eigh(correlation + np.diag(floors**2))
    return vectors * np.sqrt(np.clip(values, 1e-6, None))


def process(unit: np.ndarray, values: np.ndarray, variance: np.ndarray) -> Any:
    """Return a Gaussian process through values with a known variance at every point.

    Parameters
    ----------
    unit : (n, 2) array
    values : (n,) or (n, m) array
        Several columns have one kernel in common.
    variance : (n,) array
    """
    from sklearn.exceptions import ConvergenceWarning
    from sklearn.gaussian_process import GaussianProcessRegressor
    from sklearn.gaussian_process.kernels import RBF, ConstantKernel

    size = ConstantKernel(max(float(np.var(values)), 1.0), (1e-2, 1e8))
    kernel = ConstantKernel(1e4 + float(np.mean(values)) ** 2, "fixed") + size * RBF(
        [1.0, 1.0], LENGTHS
    )
    process = GaussianProcessRegressor(
        kernel, alpha=variance, n_restarts_optimizer=2, random_state=0
    )
    with warnings.catch_warnings():
        # A length at its bound is an answer here: the summary does not depend on that parameter.
        warnings.simplefilter("ignore", ConvergenceWarning)
        return process.fit(unit, values)
