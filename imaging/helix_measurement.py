"""What a photograph tells of a double helix, from the fitted model to tables in the user's unit."""

from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd

from imaging.helix_axis import Axis
from imaging.helix_count import HalfTurns
from imaging.helix_edges import Edges
from imaging.helix_fit import Fit, misfit
from imaging.helix_model import Model, basis

Array = np.ndarray
Mask = np.ndarray
STEEP = np.radians(5.0)  # a lean out of the picture that the user should hear of
SHADING = 0.1  # px; by which shading moves edges alike at every crossing (measured on drawings)
MISFIT = 3.0  # times the typical distance of edges from the outline; further off, no helix is
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
        ``s``, ``phi``, ``sd``, ``R``, ``R_sd``, ``x``, ``y``, ``resolved``: phase [rad], helix
        radius, axis in the picture [px].
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
        Angle [rad] by which the axis leaves the picture, tip away from the viewer; corrected for.
    resolution : float
        Length over which the link density is in effect averaged.
    tine : float or None
        Arclength of the tine.
    unit : str
        "m" or "px".
    warnings : tuple of str
    strands : two (n, 2) arrays
        Fitted centrelines [px], NaN where not resolved.
    fit : Fit
        The fitted model, in pixels.
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
    fit: Fit
    length_per_pixel: float

    @property
    def axis(self) -> Array:
        """Axis (n, 2) in the picture [px], root to tip."""
        return self.phase[["x", "y"]].to_numpy()

    def mean_link(self, start: float, end: float) -> tuple[float, float]:
        """Mean link density and its sd between two arclengths, from the phases at both.

        Returns NaN where either end is not resolved.
        """
        rows = [int(np.abs(self.phase["s"] - s).argmin()) for s in (start, end)]
        if not self.phase["resolved"].iloc[rows].all() or rows[0] == rows[1]:
            return float("nan"), float("nan")
        first, last = (self.phase.iloc[i] for i in rows)
        length = last["s"] - first["s"]
        turns, sd = _turns(self.fit, *(self.phase.attrs["knot_s"][i] for i in rows))
        return turns / length, sd / length


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
    """
    model, (per_pixel, scale_sd, unit) = fitted.model, scale
    lean, lean_sd = _lean(fitted)
    stretch = per_pixel / np.cos(lean)
    cosine_sd = np.hypot(np.tan(lean) * lean_sd, lean_sd**2 / np.sqrt(2))
    length_sd = float(np.hypot(scale_sd, cosine_sd))
    t = np.arange(0.0, model.axis.s[-1], max(start.r, 2.0))
    arc = stretch * _arclength(model)
    s = np.interp(t, model.table.s, arc)
    wider = misfit(fitted, edges, t, start.pitch / 4)
    resolved = _resolved(t, edges, valid, wider, start.pitch)
    phase = _phase_table(fitted, t, s, resolved, per_pixel, wider)
    link = _link_table(fitted, t, s, resolved, stretch, length_sd, wider)
    phase.attrs |= {"unit": unit, "knot_s": t}
    link.attrs |= {"unit": unit, "resolution": _resolution(fitted, s, resolved)}
    return HelixMeasurement(
        link_density=link,
        phase=phase,
        crossings=_crossing_table(start, np.interp(start.turns.s, model.table.s, arc)),
        tine=None if tine is None else float(np.interp(tine, model.table.s, arc)),
        lean=lean,
        lean_sd=lean_sd,
        resolution=link.attrs["resolution"],
        unit=unit,
        warnings=tuple(_warnings(start, fitted, s, resolved, lean, unit)),
        strands=_centrelines(model, t, resolved),
        fit=fitted,
        length_per_pixel=per_pixel,
        r=float(model.part("radii").mean() * per_pixel),
        **_typical(phase, fitted, length_sd),
    )


def _arclength(model: Model) -> Array:
    """Arclength of the fitted axis in the picture, at the model's table [px]."""
    speed = model.table.speed
    steps = 0.5 * (speed[1:] + speed[:-1]) * np.diff(model.table.s)
    return np.concatenate([[0.0], np.cumsum(steps)])


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


def _lean(fitted: Fit) -> tuple[float, float]:
    """Angle out of the picture and its sd, which holds what shading may do to the edges."""
    where = fitted.model.layout.blocks["lean"].start
    sine = float(np.clip(fitted.model.beta[where], -0.9, 0.9))
    radius = float(np.median(fitted.model.part("R")))
    sd = np.hypot(np.sqrt(fitted.covariance[where, where]), SHADING / radius)
    return float(np.arcsin(sine)), float(sd / np.sqrt(1 - sine**2))


def _resolved(t: Array, edges: Edges, valid: Mask, wider: Array, pitch: float) -> Mask:
    """Where sections are valid, and edges within an eighth of a pitch are there and fit."""
    place = np.sort(edges.s)
    first, last = (np.searchsorted(place, t + side * pitch / 8) for side in (-1, 1))
    here = valid[np.minimum(np.rint(t).astype(int), len(valid) - 1)]
    return here & (last - first > pitch / 8) & (wider < MISFIT)


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
        "R_sd": per_pixel * wider * _sd(fitted, "R", t),
    })  # fmt: skip
    frame[~resolved] = np.nan
    return frame.assign(s=s, x=points[:, 0], y=points[:, 1], resolved=resolved)


def _link_table(
    fitted: Fit, t: Array, s: Array, resolved: Mask, stretch: float, common: float, wider: Array
) -> pd.DataFrame:
    """Link density per length of the axis; ``common`` is that length's relative sd."""
    table = fitted.model.table
    per_length = 1 / (2 * np.pi * stretch * np.interp(t, table.s, table.speed))
    turning, frame = (
        np.interp(t, table.s, np.gradient(along, table.s))
        for along in (_heading(fitted.model), _frame_turn(fitted.model))
    )
    link = np.where(resolved, (fitted.model.at(t).dphi + frame) * per_length, np.nan)
    sd = np.hypot(wider * _sd(fitted, "phi", t, 1), np.sin(_lean(fitted)[1]) * turning)
    sd = np.where(resolved, sd * per_length, np.nan)
    return pd.DataFrame({"s": s, "link": link, "sd": np.hypot(sd, common * link)})


def _heading(model: Model) -> Array:
    """Direction of the axis in the picture [rad], at the model's table."""
    x, y = model.table.tangents.T
    return np.unwrap(np.arctan2(y, x))


def _frame_turn(model: Model) -> Array:
    """Angle [rad] by which the picture's normal has turned about an axis that leans and bends.

    The phase is counted from that normal, which turns about the tangent by the sine of the lean
    times the change of heading, as the meridian does along a circle of latitude; link is counted
    in the frame that does not turn.
    """
    heading, sine = _heading(model), model.at(model.table.s).lean
    steps = 0.5 * (sine[1:] + sine[:-1]) * np.diff(heading)
    return np.concatenate([[0.0], np.cumsum(steps)])


def _sd(fitted: Fit, name: str, t: Array, derivative: int = 0) -> Array:
    where = fitted.model.layout.blocks[name]
    design = basis(getattr(fitted.model.layout, name), t, derivative).toarray()
    return np.sqrt(
        np.einsum("ij,jk,ik->i", design, fitted.covariance[where, where], design, optimize=True)
    )


def _turns(fitted: Fit, start: float, end: float) -> tuple[float, float]:
    """Link between two places of the starting axis [px], and its sd."""
    where = fitted.model.layout.blocks["phi"]
    design = basis(fitted.model.layout.phi, np.array([start, end])).toarray()
    difference = (design[1] - design[0]) / (2 * np.pi)
    variance = max(float(difference @ fitted.covariance[where, where] @ difference), 0.0)
    heading, frame = (
        np.diff(np.interp([start, end], fitted.model.table.s, along))[0] / (2 * np.pi)
        for along in (_heading(fitted.model), _frame_turn(fitted.model))
    )
    turns = float(difference @ fitted.model.part("phi") + frame)
    return turns, float(np.hypot(np.sqrt(variance), np.sin(_lean(fitted)[1]) * heading))


def _resolution(fitted: Fit, s: Array, resolved: Mask) -> float:
    """Return the resolved length per free parameter of the phase."""
    length = float(np.sum(np.diff(s)[resolved[1:] & resolved[:-1]]))
    return length / max(fitted.freedom["phi"] - 1, 1.0)


def _crossing_table(start: Start, s: Array) -> pd.DataFrame:
    front = np.where(np.sin(start.turns.phase) > 0, "a", "b")
    return pd.DataFrame(
        {
            "s": s,
            "phi": start.turns.phase,
            "front": front,
            "sense": start.turns.sense,
            "confidence": start.turns.sure,
        }
    )


def _warnings(
    start: Start, fitted: Fit, s: Array, resolved: Mask, lean: float, unit: str
) -> list[str]:
    """Say what the numbers do not: gaps, hidden crossings, a leaning axis, poor fit."""
    said = []
    if abs(lean) > STEEP:
        said.append(
            f"the axis leans {np.degrees(lean):+.1f} degrees out of the picture (tip away from the "
            f"viewer > 0); lengths are corrected by {100 * (1 / np.cos(lean) - 1):.2f} %"
        )
    if (start.turns.sure == 0).any():
        said.append(
            f"{int((start.turns.sure == 0).sum())} of {len(start.turns.s)} crossings do not show "
            "who is in front; their sense is taken from the others"
        )
    if len(set(np.sign(np.diff(start.turns.phase)))) > 1:
        said.append("not all half-turns have the same sense; total link is their sum")
    gaps = np.flatnonzero(np.diff(np.r_[1, resolved.astype(int), 1])).reshape(-1, 2)
    said += [
        f"not resolved from s = {s[a]:.4g} to {s[min(b, len(s) - 1)]:.4g} {unit}" for a, b in gaps
    ]
    longest = max((s[b - 1] - s[a] for a, b in gaps if a > 0 and b < len(s)), default=0.0)
    if longest > HIDDEN * start.pitch * s[-1] / start.axis.s[-1]:
        said.append(
            "more than half a pitch lies in a gap: whole turns hidden there are missing from the "
            "total link"
        )
    if fitted.noise > 0.1 * start.r:
        said.append(f"edges scatter by {fitted.noise:.2f} px about the helix; is it one?")
    return said
