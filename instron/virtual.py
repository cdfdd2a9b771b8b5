"""Made combings whose truth is known: what accuracy is measured on."""

from collections.abc import Callable

import numpy as np
import pandas as pd

STROKE = 0.06  # m
GONE = 0.05  # m; where the strands are free

Shape = Callable[[np.ndarray], np.ndarray]
Noise = Callable[[int, np.random.Generator], np.ndarray]


def hump(d: np.ndarray) -> np.ndarray:
    """Return a parabola up to GONE, its top 1."""
    x = d / GONE
    return np.where(x < 1, 4 * x * (1 - x), 0.0)


def jams(d: np.ndarray) -> np.ndarray:
    """Return three narrow jams on a low hump, the highest 1 within 3 %."""
    tops = ((0.010, 0.5, 8e-4), (0.022, 0.7, 1e-3), (0.034, 0.62, 7e-4))
    return 0.3 * hump(d) + sum(h * np.exp(-(((d - p) / w) ** 2)) for p, h, w in tops)


def teeth(d: np.ndarray) -> np.ndarray:
    """Return a rise that lets go suddenly every 8 mm, and for good at GONE."""
    phase = np.mod(d, 8e-3) / 8e-3
    return np.where(d < GONE, (0.3 + 0.7 * phase) * np.minimum(1, d / 0.02), 0.0)


def plateau(d: np.ndarray) -> np.ndarray:
    """Return a force that rises within 8 mm, stays, and falls within 3 mm."""
    return np.clip(d / 8e-3, 0, 1) * np.clip((GONE - d) / 3e-3, 0, 1)


def release(d: np.ndarray) -> np.ndarray:
    """Return a force that rises to the end and is gone at once."""
    return np.where(d < GONE, 0.5 + 0.5 * d / GONE, 0.0) * np.minimum(1, d / 3e-3)


SHAPES: dict[str, Shape] = {
    "hump": hump, "jams": jams, "teeth": teeth, "plateau": plateau, "release": release
}  # fmt: skip


def white(n: int, rng: np.random.Generator) -> np.ndarray:
    """Return n readings of white noise, sd 1."""
    return rng.standard_normal(n)


def lagging(n: int, rng: np.random.Generator, memory: float = 0.9) -> np.ndarray:
    """Return noise of one pole (AR(1)), sd 1."""
    from scipy.signal import lfilter

    run_in = 500
    made = lfilter([np.sqrt(1 - memory**2)], [1, -memory], rng.standard_normal(n + run_in))
    return np.asarray(made[run_in:])


def filtered(n: int, rng: np.random.Generator, cutoff: float = 0.05) -> np.ndarray:
    """Return noise behind a Butterworth low-pass of order 4, sd 1; cutoff per Nyquist."""
    from scipy.signal import butter, sosfilt

    sections = butter(4, cutoff, output="sos")
    run_in = int(100 / cutoff)
    response = sosfilt(sections, np.eye(1, run_in)[0])
    made = sosfilt(sections, rng.standard_normal(n + run_in))[run_in:]
    return np.asarray(made) / np.sqrt((response**2).sum())


def hum(n: int, rng: np.random.Generator, turns: float = 0.137) -> np.ndarray:
    """Return a sine of so many turns a reading, as the mains leave it, sd 1."""
    return np.sqrt(2) * np.sin(2 * np.pi * (turns * np.arange(n) + rng.random()))


NOISES: dict[str, Noise] = {"white": white, "lagging": lagging, "filtered": filtered, "hum": hum}


def combing(
    shape: Shape,
    rows: int,
    *,
    height: float = 0.5,
    sd: float = 0.0,
    noise: Noise = white,
    digit: float = 0.0,
    rng: np.random.Generator | int | None = None,
) -> pd.DataFrame:
    """Return a force log of a made combing.

    Parameters
    ----------
    shape
        Force over place, about 1 at its highest.
    rows
        Readings over the STROKE.
    height
        Of the shape [N].
    sd, noise
        Standard deviation [N] and kind of the noise.
    digit
        Last digit of the readings [N]; 0: all digits.
    rng
        Seed or generator of the noise.
    """
    d = np.linspace(0, STROKE, rows)
    F = height * shape(d)
    if sd > 0:
        F = F + sd * noise(rows, np.random.default_rng(rng))
    if digit > 0:
        F = digit * np.round(F / digit)
    return pd.DataFrame({"time": d / 1e-3, "displacement": d, "force": F})
