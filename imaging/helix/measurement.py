"""What a photograph tells of a double helix, from the fitted model to tables in the user's unit."""

from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd

from imaging.errors import Unmeasurable
from imaging.helix.axis import Axis
from imaging.helix.count import HalfTurns
from imaging.helix.edges import Edges
from imaging.helix.fit import TUKEY, Fit, miss, worse
from imaging.helix.lean import LEANING, is_told, length_sd, mean_lean, said_of_lean, upright
from imaging.helix.model import Model
from imaging.helix.space import heading, in_space, link_beyond_phase, sine_of_lean
from imaging.helix.splines import basis

Array = np.ndarray
Mask = np.ndarray
NEAR_END_ON = np.radians(45.0)  # a lean that foreshortens too much to be measured
# What lights unlike those the model knows do to edges and the radius (helix_unlike.py):
TURNING = 0.2  # px; edges at either end of a stretch whose turns are counted
WIDENING = 0.02, 0.2  # R, of itself and px
MISFIT = 0.15  # strand radii; where outer edges miss the outline by more, the phase is another
LOST = 0.05  # strand radii beyond noise; edges that miss the outline by more are not explained
THROUGH = 0.75  # strand radii; strands closer to the axis would go through each other
BY_SIDES = "sides"
DRAWN_SD = 0.25  # rad; of a phase by sides, beside what its draws differ by
HIDDEN = 0.5  # pitch; a longer gap may hide a whole turn


@dataclass(frozen=True)
class HelixMeasurement:
    """What a photograph tells of a double helix.

    Lengths are metres when a scale was given, else pixels (``unit``); picture points are always
    pixels, centres at integers, x right, y down. NaN: not resolved there (see ``warnings``).

    Attributes
    ----------
    link_density : DataFrame
        ``s``, ``link``, ``sd``: arclength from the root, link per length, its standard deviation.
    phase : DataFrame
        ``s``, ``phi``, ``sd``, ``R``, ``R_sd``, ``x``, ``y``, ``resolved``, ``by``: phase [rad],
        helix radius, axis in the picture [px], and what tells them: edges, half-turns
        counted, or behind a tine the sides on which the strands hang (``sides``).
    crossings : DataFrame
        ``s``, ``phi``, ``front``, ``sense``, ``confidence``: half-turns, the colour in front, +1
        where right-handed, and by how much of its width the front strand shows more than the other
        (0: hidden, sense taken from the others).
    total_link, total_link_sd : float
        Turns between the first and the last resolved point, gaps included. Right-handed > 0.
    handedness : str
        "right" or "left".
    R, R_sd, r, pitch, pitch_sd : float
        Typical helix radius, strand radius, and pitch (1 / mean link density).
    lean, lean_sd : float
        Mean angle [rad] by which the axis leaves the picture, tip away from the viewer. Lengths are
        corrected for the angle at each place; where the mean is not told (within two sd of none,
        or a strand radius below 6 px) it is left out of that and counted in their sd.
    resolution : float
        Length over which the link density is in effect averaged.
    tine : float or None
        Arclength of the tine.
    unit : str
        "m" or "px".
    warnings : tuple of str
    strands : two (n, 2) arrays
        Fitted centrelines [px], NaN where not resolved.
    fit : Fit or None
        The model fitted to edges, in pixels; None where half-turns were counted only.
    draws : ((n,) array, (m, n) array) or None
        Draws of the phase by sides (`imaging.helix.sides`) along the axis [px].
    """

    link_density: pd.DataFrame
    phase: pd.DataFrame
    crossings: pd.DataFrame
    total_link: float
    total_link_sd: float
    handedness: str
    R: float
    R_sd: float
    r: float
    pitch: float
    pitch_sd: float
    lean: float
    lean_sd: float
    resolution: float
    tine: float | None
    unit: str
    warnings: tuple[str, ...]
    strands: tuple[Array, Array]
    fit: Fit | None
    length_per_pixel: float
    draws: tuple[Array, Array] | None = None

    @property
    def axis(self) -> Array:
        """Axis (n, 2) in the picture [px], root to tip."""
        return self.phase[["x", "y"]].to_numpy()

    @property
    def length_sd(self) -> float:
        """Relative sd that all lengths have in common: of the scale, the lean and the shading."""
        turns = self.total_link_sd / self.total_link
        return float(np.sqrt(max((self.pitch_sd / self.pitch) ** 2 - turns**2, 0.0)))

    def mean_link(self, start: float, end: float) -> tuple[float, float]:
        """Mean link density and its sd between two arclengths, from the phases at both.

        Returns NaN where either end is not resolved.
        """
        rows = [int(np.abs(self.phase["s"] - s).argmin()) for s in (start, end)]
        if not self.phase["resolved"].iloc[rows].all() or rows[0] == rows[1]:
            return float("nan"), float("nan")
        length = float(np.diff(self.phase["s"].iloc[rows])[0])
        turns, sd = self._turns(rows)
        return turns / length, float(np.hypot(sd, turns * self.length_sd)) / length

    def _turns(self, rows: list[int]) -> tuple[float, float]:
        """Count turns between two rows, and their sd but for that of lengths."""
        ends, by = self.phase.iloc[rows], self.phase["by"].iloc[rows]
        if self.fit is not None and (by == "edges").all():
            return _turns(self.fit, *(self.phase.attrs["knot_s"][i] for i in rows))
        sd = float(np.linalg.norm(ends["sd"]))
        turns = np.diff(ends["phi"])
        if self.draws is not None and (by == BY_SIDES).any():
            first, last = (self._drawn(row) for row in rows)
            turns, sd = last - first, np.hypot(np.std(last - first), np.sqrt(2) * DRAWN_SD)
        return float(np.mean(turns)) / (2 * np.pi), float(sd) / (2 * np.pi)

    def _drawn(self, row: int) -> Array:
        """Phase at a row as its draws have it; all the same where it is known otherwise."""
        if self.draws is None or self.phase["by"].iloc[row] != BY_SIDES:
            return np.array([self.phase["phi"].iloc[row]])
        where, phases = self.draws
        t = self.phase.attrs["knot_s"][row]
        return np.array([np.interp(t, where, phi) for phi in phases])


@dataclass(frozen=True)
class Start:
    """What is known of a pair before the fit, lengths in pixels."""

    axis: Axis
    r: float
    R: float
    pitch: float
    middle: Array
    spread: Mask
    turns: HalfTurns


def measurement_of(
    start: Start,
    fitted: Fit,
    edges: Edges,
    valid: Mask,
    tine: float | None,
    scale: tuple[float, float, str],
) -> HelixMeasurement:
    """Turn a fit into tables and numbers.

    Parameters
    ----------
    start : Start
    fitted : Fit
    edges : Edges
        The edge points that were fitted.
    valid : (n,) bool array
        Sections of the starting axis that were fitted.
    tine : float or None
        Its arclength along the starting axis [px].
    scale : (float, float, str)
        Length of a pixel, its relative sd, unit.

    Raises
    ------
    Unmeasurable
        When nothing is resolved.
    """
    model, (per_pixel, scale_sd, unit) = fitted.model, scale
    t = np.arange(0.0, model.axis.s[-1], max(start.r, 2.0))
    resolved = _resolved(t, fitted, edges, valid, start)
    if np.count_nonzero(resolved) < 2:
        raise Unmeasurable(
            "nowhere do the edges that can be seen follow two strands wound round each other"
        )
    lean, lean_sd = mean_lean(fitted, t[resolved])
    told, strands = is_told(lean, lean_sd, start.r), _centrelines(model, t, resolved)
    fitted = fitted if told else upright(fitted, lean)
    untold, model = None if told else lean, fitted.model
    said = said_of_lean(np.arcsin(sine_of_lean(model, t[resolved])), lean, lean_sd, told=told)
    arc = per_pixel * in_space(model)[0]
    s = np.interp(t, model.table.s, arc)
    # Where the model misses the edges its errors do not average along them, as noise does.
    wider = worse(model, fitted.residual, edges, t)
    phase = _phase_table(fitted, t, s, resolved, per_pixel, wider)
    link = _link_table(fitted, t, s, resolved, per_pixel, scale_sd, wider, untold)
    phase.attrs |= {"unit": unit, "knot_s": t}
    link.attrs |= {"unit": unit, "resolution": _resolution(fitted, s, resolved)}
    return HelixMeasurement(
        link_density=link,
        phase=phase,
        crossings=crossing_table(start.turns, np.interp(start.turns.s, model.table.s, arc)),
        tine=None if tine is None else float(np.interp(tine, model.table.s, arc)),
        lean=lean,
        lean_sd=lean_sd,
        resolution=link.attrs["resolution"],
        unit=unit,
        warnings=(*said, *_warnings(start, fitted, s, resolved, unit)),
        strands=strands,
        fit=fitted,
        length_per_pixel=per_pixel,
        r=float(model.part("radii").mean() * per_pixel),
        **_typical(phase, fitted, float(np.hypot(scale_sd, length_sd(lean, lean_sd, untold)))),
    )


def _typical(phase: pd.DataFrame, fitted: Fit, length_sd: float) -> dict[str, Any]:
    """Total link, hand, radius and pitch of what is resolved."""
    inside = phase["resolved"].to_numpy()
    t, s = phase.attrs["knot_s"][inside], phase["s"].to_numpy()[inside]
    total, total_sd = _turns(fitted, t[0], t[-1])
    pitch = float(s[-1] - s[0]) / abs(total)
    return {
        "total_link": total,
        "total_link_sd": total_sd,
        "handedness": "right" if total > 0 else "left",
        "R": float(np.nanmedian(phase["R"])),
        "R_sd": float(np.nanmedian(phase["R_sd"])),
        "pitch": pitch,
        "pitch_sd": pitch * float(np.hypot(total_sd / total, length_sd)),
    }


def _centrelines(model: Model, t: Array, resolved: Mask) -> tuple[Array, Array]:
    """Both strands in the picture at arclengths ``t``, NaN where not resolved."""
    cut = np.where(resolved[:, None], 1.0, np.nan)
    a, b = (
        cut * np.column_stack([np.interp(t, model.table.s, c[:, i]) for i in (0, 1)])
        for c in model.table.strands
    )
    return a, b


def _resolved(t: Array, fitted: Fit, edges: Edges, valid: Mask, start: Start) -> Mask:
    """Where sections are valid, edges within an eighth of a pitch are there, and the model fits.

    Not within a quarter of a pitch of where it explains less than half of the edges, or of an axis
    that leans by more than NEAR_END_ON. What is left between such places is too short to tell.
    """
    model, reach = fitted.model, start.pitch / 8
    place, residual = edges.s, np.abs(fitted.residual)
    explained = residual < TUKEY * fitted.noise + LOST * start.r
    here = valid[np.minimum(np.rint(t).astype(int), len(valid) - 1)]
    here &= _count(t, place[explained], reach) > reach
    here &= miss(fitted.residual, edges, t, 2 * reach) < MISFIT * start.r
    here &= THROUGH * start.r < model.at(t).R
    found = _count(t, place, reach / 2)
    lost = (found > 0) & (_count(t, place[explained], reach / 2) < found / 2)
    steep = here & (np.abs(sine_of_lean(model, t)) > np.sin(NEAR_END_ON))
    here &= ~_beside(t, lost | steep, 2 * reach)
    return _without_short(here, t, HIDDEN * start.pitch)


def _count(t: Array, place: Array, reach: float) -> np.ndarray:
    """Return how many of the places, which ascend, lie within ``reach`` of each t."""
    first, last = (np.searchsorted(place, t + side * reach) for side in (-1, 1))
    return last - first


def _without_short(here: Mask, t: Array, length: float) -> Mask:
    """Drop runs that are no longer than ``length``."""
    runs = np.flatnonzero(np.diff(np.r_[0, here.astype(int), 0])).reshape(-1, 2)
    kept = np.zeros_like(here)
    for first, end in runs:
        kept[first:end] = t[end - 1] - t[first] > length
    return kept


def _beside(t: Array, those: Mask, reach: float) -> Mask:
    """Whether one of those places lies within ``reach``."""
    return np.asarray(np.any(np.abs(t[:, None] - t[those]) < reach, axis=1))


def _phase_table(
    fitted: Fit, t: Array, s: Array, resolved: Mask, per_pixel: float, wider: Array
) -> pd.DataFrame:
    """Phase and radius; ``wider`` multiplies their sd."""
    model, v = fitted.model, fitted.model.at(t)
    points = np.column_stack([np.interp(t, model.table.s, model.table.axis[:, i]) for i in (0, 1)])
    frame = pd.DataFrame({
        "s": s,
        "phi": v.phi,
        "sd": wider * _sd(fitted, "phi", t),
        "R": per_pixel * v.R,
        "R_sd": per_pixel * np.hypot(wider * _sd(fitted, "R", t), _widening(v.R)),
    })  # fmt: skip
    frame[~resolved] = np.nan
    by = np.where(resolved, "edges", "")
    return frame.assign(s=s, x=points[:, 0], y=points[:, 1], resolved=resolved, by=by)


def _widening(R: Array) -> Array:
    """Error [px] of the helix radius that unlike lights may make."""
    return np.hypot(WIDENING[0] * R, WIDENING[1])


def _link_table(
    fitted: Fit,
    t: Array,
    s: Array,
    resolved: Mask,
    per_pixel: float,
    scale_sd: float,
    wider: Array,
    untold: float | None,
) -> pd.DataFrame:
    """Link density per length of the axis in space."""
    model, table = fitted.model, fitted.model.table
    pace, beyond, bend = (
        np.interp(t, table.s, np.gradient(along, table.s))
        for along in (in_space(model)[0], link_beyond_phase(model), heading(model))
    )
    per_length = 1 / (2 * np.pi * per_pixel * pace)
    sine = sine_of_lean(model, t)
    lean_sd = np.hypot(wider * _sd(fitted, "lean", t), LEANING) / np.sqrt(1 - sine**2)
    link = np.where(resolved, (model.at(t).dphi + beyond) * per_length, np.nan)
    sd = per_length * np.hypot(wider * _sd(fitted, "phi", t, 1), np.sin(lean_sd) * bend)
    common = np.hypot(scale_sd, length_sd(np.arcsin(sine), lean_sd, untold))
    sd = np.where(resolved, np.hypot(sd, common * link), np.nan)
    return pd.DataFrame({"s": s, "link": link, "sd": sd})


def _sd(fitted: Fit, name: str, t: Array, derivative: int = 0) -> Array:
    where = fitted.model.layout.blocks[name]
    design = basis(getattr(fitted.model.layout, name), t, derivative).toarray()
    return np.sqrt(
        np.einsum("ij,jk,ik->i", design, fitted.covariance[where, where], design, optimize=True)
    )


def _turns(fitted: Fit, start: float, end: float) -> tuple[float, float]:
    """Link between two places of the starting axis [px], and its sd."""
    model, where = fitted.model, fitted.model.layout.blocks["phi"]
    design = basis(model.layout.phi, np.array([start, end])).toarray()
    difference = (design[1] - design[0]) / (2 * np.pi)
    variance = max(float(difference @ fitted.covariance[where, where] @ difference), 0.0)
    bend, beyond = (
        np.diff(np.interp([start, end], model.table.s, along))[0] / (2 * np.pi)
        for along in (heading(model), link_beyond_phase(model))
    )
    turns = float(difference @ model.part("phi") + beyond)
    ends = np.sqrt(2) * TURNING / float(np.median(model.part("R"))) / (2 * np.pi)
    return turns, float(np.hypot(np.hypot(np.sqrt(variance), ends), LEANING * bend))


def _resolution(fitted: Fit, s: Array, resolved: Mask) -> float:
    """Return the resolved length per free parameter of the phase."""
    length = float(np.sum(np.diff(s)[resolved[1:] & resolved[:-1]]))
    return length / max(fitted.freedom["phi"] - 1, 1.0)


def crossing_table(turns: HalfTurns, s: Array) -> pd.DataFrame:
    """Tabulate half-turns at these arclengths."""
    front = np.where(np.sin(turns.phase) > 0, "a", "b")
    return pd.DataFrame(
        {"s": s, "phi": turns.phase, "front": front, "sense": turns.sense, "confidence": turns.sure}
    )


def _warnings(start: Start, fitted: Fit, s: Array, resolved: Mask, unit: str) -> list[str]:
    """Say what the numbers do not: gaps, hidden crossings, poor fit."""
    said = []
    if (start.turns.sure == 0).any():
        said.append(
            f"{int((start.turns.sure == 0).sum())} of {len(start.turns.s)} crossings do not show "
            "who is in front; their sense is taken from the others"
        )
    if len(set(np.sign(np.diff(start.turns.phase)))) > 1:
        said.append("not all half-turns have the same sense; total link is their sum")
    said += gaps(s, resolved, unit, start.pitch * s[-1] / start.axis.s[-1])
    if fitted.noise > 0.1 * start.r:
        said.append(f"edges scatter by {fitted.noise:.2f} px about the helix; is it one?")
    return said


def gaps(s: Array, resolved: Mask, unit: str, pitch: float) -> list[str]:
    """Say where nothing is resolved."""
    open_ = np.flatnonzero(np.diff(np.r_[1, resolved.astype(int), 1])).reshape(-1, 2)
    said = [
        f"not resolved from s = {s[a]:.4g} to {s[min(b, len(s) - 1)]:.4g} {unit}" for a, b in open_
    ]
    longest = max((s[b - 1] - s[a] for a, b in open_ if a > 0 and b < len(s)), default=0.0)
    if longest > HIDDEN * pitch:
        said.append(
            "more than half a pitch lies in a gap: the winding across it is not determined, and "
            "whole turns hidden there are missing from the total link"
        )
    return said
