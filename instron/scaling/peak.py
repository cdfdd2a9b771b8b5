"""The highest averaged force, freed of what noise adds to a maximum, with its interval."""

from dataclasses import dataclass

import numpy as np
from scipy.special import stdtrit

from instron.scaling.average import FINE

DRAWS, PART = 200, 50
LEVEL = 0.95


@dataclass(frozen=True)
class Peak:
    """Highest averaged force [N]: estimate and 95 % interval, as noise has it."""

    F: float
    low: float
    high: float


def highest(
    F: np.ndarray, noise: float, freedom: float = np.inf, zero: float = 0.0, *, seed: int = 0
) -> Peak:
    """Return the maximum of a noisy averaged force, corrected for being a maximum.

    Noise lifts a maximum: of many places one has it upwards. Two estimates hold the true maximum
    between them. Drawing noise e anew and looking where F + e is highest, but reading F - e there,
    whose noise is independent of F + e's, gives the true force at a place that noise has chosen:
    never too high in the mean (data fission; Leiner et al., J. Am. Stat. Assoc. 120, 135, 2025).
    By how much e lifts the maximum of F (the bootstrap) is too little, since F has its own noise,
    and taken off leaves the maximum too high. Their mean is taken; half of their distance counts
    as an uncertainty beside the noise.

    Parameters
    ----------
    F
        Averaged force [N] at even places, ``FINE`` to the length that it is averaged over.
    noise
        Its standard deviation [N].
    freedom
        Degrees of freedom that this is known with.
    zero
        Standard uncertainty of the zero [N].
    """
    top = float(F.max())
    if noise <= 0:
        return Peak(top, top, top)
    rng = np.random.default_rng(seed)
    found = np.concatenate([_twice(F, noise, rng) for _ in range(DRAWS // PART)])
    lower, lifted = found.mean(axis=0)
    upper = 2 * top - lifted
    middle, half = float(lower + upper) / 2, abs(upper - lower) / 2
    reach = float(stdtrit(freedom, (1 + LEVEL) / 2) * np.sqrt(noise**2 + half**2 + zero**2))
    return Peak(middle, middle - reach, middle + reach)


def _twice(F: np.ndarray, noise: float, rng: np.random.Generator) -> np.ndarray:
    """Return, for PART draws of e, F - e and F + e where F + e is highest."""
    drawn = _box_noise(noise, (PART, len(F)), rng)
    place = np.argmax(F + drawn, axis=1)
    e = drawn[np.arange(PART), place]
    return np.column_stack([F[place] - e, F[place] + e])


def _box_noise(sd: float, shape: tuple[int, int], rng: np.random.Generator) -> np.ndarray:
    """Return draws of white noise averaged over FINE places, whose sd is ``sd``."""
    white = rng.standard_normal((shape[0], shape[1] + FINE - 1))
    total = np.cumsum(np.pad(white, ((0, 0), (1, 0))), axis=1)
    return sd * (total[:, FINE:] - total[:, :-FINE]) / np.sqrt(FINE)
