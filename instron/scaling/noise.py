"""Noise of a force log, of any colour: of one reading and of the force averaged over a length."""

from dataclasses import dataclass

import numpy as np

STRETCH = 0.05  # of the rows: what is looked at at a time where no quiet end is known
FEWEST = 24  # rows that a noise can be told from
ALIKE = 1.3  # stretches up to this multiple of the quietest one's sd are noise alone
SLOW, SLOWER = 0.85, 3.0  # share of the sd that averaging leaves of noise as slow as the length
LENGTHS = 4.0  # averaging lengths in which swings are seen
EVEN = 1.5  # times that they go further one way than the other
SMALL = 0.25  # of the peak
FAR = 5.0  # sd at which a touch of the free tine is cut off


@dataclass(frozen=True)
class Noise:
    """Standard deviations [N].

    Attributes
    ----------
    sd
        Of one reading.
    averaged
        Of the force averaged over the stated length.
    where
        Which rows tell it.
    freedom
        Degrees of freedom of ``averaged``.
    """

    sd: float
    averaged: float
    where: str
    freedom: float = 1.0

    def colour(self, rows: float) -> float:
        """Return how much more noise averaging over so many rows leaves than of white noise."""
        if self.sd == 0:
            return 1.0
        return max(1.0, self.averaged / self.sd * max(1.0, rows) ** 0.5)


def noise_of(F: np.ndarray) -> float:
    """Return the standard deviation of the noise on one reading [unit of F].

    Told from the quietest stretches of the signal, each a twentieth of its rows.
    """
    return quietest(F, 1.0).sd


def quietest(F: np.ndarray, rows: float) -> Noise:
    """Return the noise of readings, and of means over ``rows`` rows, where F is quietest.

    A parabola is taken off every twentieth of the record. The quietest of them, and all whose sd is
    within 1.3 times its own, are taken for noise. What is slower than a stretch is not seen.
    """
    if len(F) < 5:
        return Noise(0.0, 0.0, "too few rows")
    size = min(len(F), max(FEWEST, int(STRETCH * len(F))))
    rest = _without(np.lib.stride_tricks.sliding_window_view(F, size)[:: max(1, size // 4)], 3)
    power = (rest**2).sum(axis=1)
    quiet = rest[power <= ALIKE**2 * power.min()]
    return _noise(quiet, 3, rows, last_digit(F), f"quietest stretches of {size} rows")


def of_free_end(F: np.ndarray, rows: float) -> Noise | None:
    """Return the noise of readings of a free tine, None where they are too few to tell.

    A line (the load cell's drift) is taken off, and what is beyond 4 sd (a touch) left out.
    """
    if len(F) < FEWEST:
        return None
    digit = last_digit(F)
    rest = F - np.median(F)
    for _ in range(2):
        limit = FAR * max(1.4826 * float(np.median(np.abs(rest))), digit)
        rest = _without(np.clip(rest, -limit, limit)[None, :], 2)[0]
    inside = np.abs(rest) < 0.8 * limit  # a touch moves the line a little
    rest = np.where(inside, rest, 0.0) / np.sqrt(max(inside.mean(), 0.5))
    return _noise(rest[None, :], 2, rows, digit, f"{len(F)} rows after combing")


def swings(F: np.ndarray, smooth: np.ndarray, rows: float) -> tuple[int, Noise] | None:
    """Return from which row on the rest of a record swings about a level, and that as noise.

    Noise as slow as the averaging length may be taken for combing to the end of the log: what is
    left after that is too short to show it. Combing pushes one way, noise goes both ways: the rest
    after the highest force is noise if it leaves its median as far upwards as downwards, crosses
    it, is as lively in its last third, and small beside the peak.

    Parameters
    ----------
    F, smooth
        Readings, and their average over ``rows`` rows, positive where they resist [N].
    """
    top = int(np.argmax(smooth))
    least = int(LENGTHS * rows)
    for first in range(top + int(rows), len(F) - least, max(1, int(rows / 4))):
        tail = smooth[first:]
        away = tail - np.median(tail)
        up, down = float(away.max()), float(-away.min())
        if max(up, down) > min(EVEN * min(up, down), SMALL * float(smooth[top] - np.median(tail))):
            continue
        crossings = np.count_nonzero(np.diff(np.sign(away)) != 0)
        if crossings < 3 or np.ptp(away[-len(away) // 3 :]) < (up + down) / 2:
            continue
        noise = of_free_end(F[first:], rows)
        if noise is not None and noise.averaged > SLOW * noise.sd:
            return first, noise
    return None


def last_digit(F: np.ndarray) -> float:
    """Return the step of which all readings are multiples, 0 if there is none [unit of F]."""
    values = np.unique(F)
    steps = np.diff(values)
    steps = steps[steps > 1e-9 * np.abs(values).max()]
    if not len(steps):
        return 0.0
    step = float(steps.min())
    whole = (values - values[0]) / step
    return step if np.abs(whole - np.round(whole)).max() < 0.05 else 0.0


def _without(stretches: np.ndarray, terms: int) -> np.ndarray:
    """Take the best polynomial of so many terms off every stretch (k, n)."""
    basis, _ = np.linalg.qr(np.vander(np.linspace(-1, 1, stretches.shape[1]), terms))
    return stretches - (stretches @ basis) @ basis.T


def _noise(rest: np.ndarray, fitted: int, rows: float, digit: float, where: str) -> Noise:
    """Return the noise that stretches (k, n), ``fitted`` freedoms short, hold.

    What averaging leaves of it is the variance of means over as many rows, or over a quarter of a
    stretch if that is less; from there on it falls as 1/rows. Readings have an sd of q/sqrt(12) at
    least, q their last digit; noise below q/2 does not let averages see between the digits.
    """
    size = rest.shape[1]
    sd = float(np.sqrt((rest**2).sum() / (rest.size - fitted * len(rest))))
    batch = int(np.clip(round(rows), 1, max(1, size // (2 * fitted))))
    total = np.concatenate([np.zeros((len(rest), 1)), np.cumsum(rest, axis=1)], axis=1)
    means = (total[:, batch:] - total[:, :-batch]) / batch
    left = float(np.sqrt((means**2).mean() / (1 - fitted * batch / size)))
    left *= min(1.0, batch / max(rows, 1.0)) ** 0.5
    least = digit / np.sqrt(12)
    slow = SLOWER if left > SLOW * sd else 1.0  # then a mean tells less than a mean's rows should
    freedom = max(1.0, len(rest) * (size / batch - fitted) / slow)
    if sd < digit / 2:
        return Noise(max(sd, least), max(left, least), where, freedom)
    return Noise(sd, min(left, sd), where, freedom)
