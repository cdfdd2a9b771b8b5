"""Photographs of a tine on its way -> change of the link density, jump across the tine."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd

from imaging.errors import Unmeasurable
from imaging.helix.measurement import HelixMeasurement
from imaging.helix.photograph import helix
from imaging.photo import Photo
from imaging.segment import Segmentation

Array = np.ndarray


@dataclass(frozen=True)
class HelixSequence:
    """Link density while a tine combs a double helix.

    Attributes
    ----------
    profiles : DataFrame
        ``frame, x, s, link, sd, change, change_sd``: ``change`` is (lambda(s) - lambda_0)/lambda_0,
        NaN where not resolved.
    jumps : DataFrame
        One row per frame: ``frame, x, tine, lambda_0, behind, ahead, jump`` and their ``_sd``.
    measurements : tuple of HelixMeasurement
    """

    profiles: pd.DataFrame
    jumps: pd.DataFrame
    measurements: tuple[HelixMeasurement, ...]


def helix_sequence(
    frames: Sequence[Photo | Segmentation],
    positions: Sequence[float],
    *,
    before: Photo | Segmentation | None = None,
    tines: Sequence[tuple[float, ...] | None] | None = None,
    **options: Any,
) -> HelixSequence:
    """Measure a series of photographs with the tine at known places.

    Parameters
    ----------
    frames : sequence of Photo or Segmentation
    positions : sequence of float
        Tine displacement x = d/D of every frame.
    before : Photo or Segmentation, optional
        The helix before combing, for lambda_0; the first frame when left out.
    tines : sequence, optional
        Where the tine is in each picture, as in `helix`.
    **options
        Passed on to `helix`: pair, scale, root.

    Raises
    ------
    Unmeasurable
        When there are not as many positions as frames, or a frame cannot be measured.
    """
    if len(positions) != len(frames):
        raise Unmeasurable(
            f"{len(positions)} tine positions for {len(frames)} photographs; give one for each"
        )
    places = tines if tines is not None else [None] * len(frames)
    measured = [
        helix(frame, tine=tine, **options) for frame, tine in zip(frames, places, strict=True)
    ]
    first = measured[0] if before is None else helix(before, **options)
    return sequence_of(measured, positions, (1 / first.pitch, first.pitch_sd / first.pitch**2))


def sequence_of(
    measured: Sequence[HelixMeasurement],
    positions: Sequence[float],
    lambda_0: tuple[float, float],
) -> HelixSequence:
    """Put measured frames beside each other, relative to an initial link density and its sd."""
    profiles, jumps = [], []
    for number, (one, x) in enumerate(zip(measured, positions, strict=True)):
        sign = 1.0 if one.handedness == "right" else -1.0
        table = one.link_density.assign(frame=number, x=float(x))
        ratio = sign * table["link"] / lambda_0[0]
        table["change"] = ratio - 1
        table["change_sd"] = np.hypot(table["sd"], ratio * lambda_0[1]) / lambda_0[0]
        profiles.append(table[["frame", "x", "s", "link", "sd", "change", "change_sd"]])
        jumps.append({"frame": number, "x": float(x), **link_jump(one, lambda_0)})
    return HelixSequence(
        pd.concat(profiles, ignore_index=True), pd.DataFrame(jumps), tuple(measured)
    )


def link_jump(
    measurement: HelixMeasurement, lambda_0: tuple[float, float] | None = None
) -> dict[str, float]:
    """Mean link density behind and ahead of the tine, and the jump across it.

    Behind is the root's side. Each mean is that of the resolved stretch next to the tine, from the
    phases at its ends; where nothing is resolved, half the signed crossings per length with the
    sd of a count that may be off by half a turn at either end (1/sqrt(24) turn).

    Parameters
    ----------
    measurement : HelixMeasurement
    lambda_0 : (float, float), optional
        Link density before combing (its size) and sd; the mean of this picture when left out.

    Returns
    -------
    dict
        ``tine, lambda_0, behind, ahead, jump`` and ``*_sd``; ``jump`` = (ahead - behind)/lambda_0.
        NaN when no tine is in the picture.
    """
    m = measurement
    value, value_sd = lambda_0 or (1 / m.pitch, m.pitch_sd / m.pitch**2)
    sign = 1.0 if m.handedness == "right" else -1.0
    tine = float("nan") if m.tine is None else m.tine
    end = float(m.phase["s"].iloc[-1])
    behind, behind_sd = _mean(m, 0.0, tine, from_end=True)
    ahead, ahead_sd = _mean(m, tine, end, from_end=False)
    jump = sign * (ahead - behind) / value
    sd = float(np.hypot(np.hypot(behind_sd, ahead_sd), jump * value_sd)) / value
    return {
        "tine": tine,
        "lambda_0": value,
        "lambda_0_sd": value_sd,
        "behind": sign * behind,
        "behind_sd": behind_sd,
        "ahead": sign * ahead,
        "ahead_sd": ahead_sd,
        "jump": jump,
        "jump_sd": sd,
    }


def kymograph(sequence: HelixSequence, points: int = 200) -> tuple[Array, Array, Array]:
    """Change of link density as a picture.

    Returns
    -------
    x : (n,) array
        Tine positions, ascending.
    s : (points,) array
        Arclength from the root.
    change : (n, points) array
        (lambda - lambda_0)/lambda_0, NaN where not resolved.
    """
    table = sequence.profiles
    s = np.linspace(0.0, float(table["s"].max()), points)
    frames = [group for _, group in table.groupby(["x", "frame"])]
    rows = [np.interp(s, g["s"], g["change"], left=np.nan, right=np.nan) for g in frames]
    return np.array([float(g["x"].iloc[0]) for g in frames]), s, np.array(rows)


def _mean(m: HelixMeasurement, start: float, end: float, *, from_end: bool) -> tuple[float, float]:
    """Mean link density between two arclengths, from the resolved stretch nearest to one end."""
    if not end > start:
        return float("nan"), float("nan")
    table = m.phase
    inside = ((table["s"] > start) & (table["s"] < end) & table["resolved"]).to_numpy()
    runs = np.flatnonzero(np.diff(np.r_[0, inside.astype(int), 0])).reshape(-1, 2)
    if len(runs):
        a, b = runs[-1 if from_end else 0]
        if b - a > 1:
            s = table["s"].to_numpy()
            return m.mean_link(float(s[a]), float(s[b - 1]))
    crossings = m.crossings[(m.crossings["s"] > start) & (m.crossings["s"] < end)]
    turns = float(crossings["sense"].sum()) / 2
    return turns / (end - start), 1 / np.sqrt(24) / (end - start)
