"""The testing machine: what its load cell and its clock make of a true force."""

from dataclasses import dataclass

import numpy as np
import pandas as pd

NOISE = 0.004  # N


@dataclass(frozen=True)
class LoadCell:
    """A load cell and its amplifier.

    Parameters
    ----------
    offset : float
        Reading without load [N].
    drift : float
        Change of the offset over the whole log [N].
    noise : float
        Standard deviation of a reading [N].
    resolution : float
        Last digit of a reading [N].
    """

    offset: float
    drift: float
    noise: float
    resolution: float = 1e-4


def record(
    truth: pd.DataFrame,
    cell: LoadCell,
    *,
    samples: int,
    rng: np.random.Generator | int | None,
) -> pd.DataFrame:
    """Return the log that the machine writes of a true force log.

    Parameters
    ----------
    truth : DataFrame
        Force log: time [s], displacement [m], force [N].
    cell : LoadCell
        What is added to the force.
    samples : int
        Readings at equal times; each averages the true force since the one before, as an
        anti-alias filter does.
    rng : Generator or seed
        Source of the noise.
    """
    rng = np.random.default_rng(rng)
    edges = np.linspace(0, len(truth), samples + 1).round().astype(int)
    bins = np.repeat(np.arange(samples), np.diff(edges))
    log = truth[["time", "displacement", "force"]].groupby(bins).mean().reset_index(drop=True)
    log["time"] -= log["time"].iloc[0]
    drift = cell.drift * log["time"] / log["time"].iloc[-1]
    reading = log["force"] + cell.offset + drift + rng.normal(0, cell.noise, len(log))
    log["force"] = cell.resolution * np.round(reading / cell.resolution)
    return log


def draw_cell(rng: np.random.Generator) -> LoadCell:
    """Draw a load cell as it stands on the day: a 10 N cell that was zeroed, but not just now."""
    return LoadCell(
        offset=float(rng.normal(0, 0.02)), drift=float(rng.normal(0, 0.01)), noise=NOISE
    )
