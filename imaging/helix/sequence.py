"""Photographs of a tine on its way -> change of the link density, jump across the tine."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
import pandas as pd

from imaging.errors import Unmeasurable
from imaging.helix.measurement import HelixMeasurement
from imaging.helix.photograph import helix
from imaging.photo import Photo
from imaging.segment import Segmentation

Array = np.ndarray
MeanLink = Callable[[float, float], tuple[float, float]]
HALF_TURN_SD = 1 / np.sqrt(24)  # turns; of a count that may be off by half a turn at either end


@dataclass(frozen=True)
class HelixSequence:
    """Link density while a tine combs a double helix.

    Attributes
    ----------
    profiles : DataFrame
        ``frame, x, s, link, sd, change, change_sd``: ``change`` is (lambda(s) - lambda_0)/lambda_0,
        NaN where not resolved.
    jumps : DataFrame
        One row per frame: ``frame, x``, ``turns`` from root to tip, what leaves by the free end
        as the tine goes on, its sd, and what `jump_across` gives.
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
    return sequence_of(measured, positions, first_link(first))


def sequence_of(
    measured: Sequence[HelixMeasurement],
    positions: Sequence[float],
    lambda_0: tuple[float, float],
) -> HelixSequence:
    """Put measured frames beside each other, relative to an initial link density and its sd.

    `lambda_0` as `first_link` gives it.
    """
    profiles, jumps = [], []
    for number, (one, x) in enumerate(zip(measured, positions, strict=True)):
        table = one.link_density.assign(frame=number, x=float(x))
        ratio = table["link"] / lambda_0[0]
        table["change"] = ratio - 1
        table["change_sd"] = np.hypot(table["sd"], ratio * lambda_0[1]) / abs(lambda_0[0])
        profiles.append(table[["frame", "x", "s", "link", "sd", "change", "change_sd"]])
        length = float(one.phase["s"].iloc[-1])
        turns, sd = (length * value for value in mean_link(one, 0.0, length))
        row = {"frame": number, "x": float(x), "turns": turns, "turns_sd": sd}
        jumps.append(row | link_jump(one, lambda_0))
    return HelixSequence(
        pd.concat(profiles, ignore_index=True), pd.DataFrame(jumps), tuple(measured)
    )


def link_before(mean: MeanLink, length: float) -> tuple[float, float]:
    """Link density before combing, lambda_0, and its sd: the mean but for a pitch at either end.

    Parameters
    ----------
    mean : callable
        Mean link density and its sd between two arclengths, of the helix that nothing combs yet.
    length : float
        Of the helix; of one shorter than four pitches a quarter is left out at either end.
    """
    middle = abs(mean(0.25 * length, 0.75 * length)[0])
    end = length / max(4.0, length * middle)
    return mean(end, length - end)


def jump_across(
    mean: MeanLink,
    tine: float,
    length: float,
    lambda_0: tuple[float, float],
    *,
    reach: float | None = None,
) -> dict[str, float]:
    """Jump of the link density across a tine, of a photograph and of a simulation alike.

    Each side's density is the mean over a pitch, 1/lambda_0, that begins at the tine's own reach:
    what lies nearer is the tine's doing and not the helix's.

    Parameters
    ----------
    mean : callable
        Mean link density and its sd between two arclengths from the root.
    tine, length : float
        Arclengths of the tine and of the tip.
    lambda_0 : (float, float)
        Link density before combing, as `link_before` gives it, and its sd.
    reach : float, optional
        A quarter of a pitch when left out: about tine radius, helix radius and strand radius of
        the paper's main case (0.22 of a pitch).

    Returns
    -------
    dict
        ``tine, reach, lambda_0, behind, ahead, jump`` and ``*_sd``: behind is the root's side, and
        ``jump`` = (ahead - behind)/lambda_0; densities count positive in lambda_0's sense. NaN on a
        side where less than half a pitch is left.
    """
    value, value_sd = abs(lambda_0[0]), lambda_0[1]
    pitch, sense = 1 / value, np.sign(lambda_0[0])
    reach = pitch / 4 if reach is None else reach
    spans = {
        "behind": (max(tine - reach - pitch, 0.0), tine - reach),
        "ahead": (tine + reach, min(tine + reach + pitch, length)),
    }
    found = {"tine": tine, "reach": reach, "lambda_0": value, "lambda_0_sd": value_sd}
    for side, (start, end) in spans.items():
        nothing = (float("nan"), float("nan"))
        one, sd = mean(start, end) if end - start >= pitch / 2 else nothing
        found |= {side: float(sense * one), f"{side}_sd": sd}
    jump = (found["ahead"] - found["behind"]) / value
    sd = np.hypot(np.hypot(found["behind_sd"], found["ahead_sd"]), jump * value_sd) / value
    return found | {"jump": jump, "jump_sd": float(sd)}


def link_jump(
    measurement: HelixMeasurement, lambda_0: tuple[float, float] | None = None
) -> dict[str, float]:
    """Jump of the link density across the tine in a photograph, as `jump_across` gives it.

    Parameters
    ----------
    measurement : HelixMeasurement
    lambda_0 : (float, float), optional
        Link density before combing and its sd, as `first_link` gives them; the mean of this
        picture when left out.

    Returns
    -------
    dict
        As of `jump_across`; NaN when no tine is in the picture.
    """
    m = measurement
    value = lambda_0 or (np.sign(m.total_link) / m.pitch, m.pitch_sd / m.pitch**2)
    tine = float("nan") if m.tine is None else m.tine
    return jump_across(partial(mean_link, m), tine, float(m.phase["s"].iloc[-1]), value)


def first_link(measurement: HelixMeasurement) -> tuple[float, float]:
    """Link density of a photograph of the helix before combing, and its sd (`link_before`)."""
    return link_before(partial(mean_link, measurement), float(measurement.phase["s"].iloc[-1]))


def mean_link(m: HelixMeasurement, start: float, end: float) -> tuple[float, float]:
    """Mean link density and its sd between two arclengths, whatever is resolved between them.

    Turns between the first and the last resolved place are those of the phase. Towards an end that
    is not resolved it goes on at the same pace, which may be anything from none to the double (an
    sd of 1/sqrt(3) of it), or from crossing to crossing, known to half a turn at either end of the
    stretch (an sd of 1/sqrt(24) turn): whichever is known better.
    """
    table, length = m.phase, end - start
    s = table.loc[table["s"].between(start, end) & table["resolved"], "s"].to_numpy()
    if len(s) < 2:
        return _by_crossings(m, start, end) / length, HALF_TURN_SD / length
    pace, pace_sd = m.mean_link(float(s[0]), float(s[-1]))
    seen, step = float(s[-1] - s[0]), 1.5 * float(table["s"].diff().max())
    turns, parts = pace * seen, [pace_sd * seen]
    for a, b in ((start, s[0]), (s[-1], end)):
        sd = abs(pace) * (b - a) / np.sqrt(3)
        if b - a <= step or sd < HALF_TURN_SD:
            turns += pace * (b - a)
            parts.append(sd if b - a > step else 0.0)
        else:
            turns += _by_crossings(m, a, b)
            parts.append(HALF_TURN_SD)
    return turns / length, float(np.linalg.norm(parts)) / length


def _by_crossings(m: HelixMeasurement, start: float, end: float) -> float:
    """Return the turns between two arclengths, the phase straight from crossing to crossing."""
    if m.crossings.empty:
        return 0.0
    table = m.crossings.sort_values("s")
    first, last = np.interp([start, end], table["s"], table["phi"])
    return float(last - first) / (2 * np.pi)


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
