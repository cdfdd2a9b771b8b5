"""Two twisted strands in a photograph -> axis, radius, phase, link density, each with its sd."""

from dataclasses import dataclass, replace

import cv2
import numpy as np
import pandas as pd
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from imaging.errors import Unmeasurable
from imaging.helix_axis import Axis, find_axis, sample, smoothed
from imaging.helix_count import (
    HalfTurns,
    Look,
    first_phase,
    half_turns,
    helix_radius,
    look,
    spread_apart,
    strand_radius,
)
from imaging.helix_edges import Edges, find_edges
from imaging.helix_fit import PENALISED, Fit, fit
from imaging.helix_model import Layout, Model, basis, knots, offsets
from imaging.helix_pair import pair_membership, rough_radius, twisted_pair
from imaging.photo import Photo
from imaging.scale import Scale, stated
from imaging.segment import Segmentation, segment

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
STEEP = np.radians(5.0)  # a lean out of the picture that the user should hear of
MISFIT = 4.0  # times the noise; where half of the edges lie further off, no helix is
THIN = 2.5  # px; strands thinner than this have no middle to measure


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


def helix(
    picture: Photo | Segmentation,
    *,
    colours: tuple[int, int] | None = None,
    scale: float | Scale | None = None,
    root: str = "top",
    tine: tuple[float, ...] | None = None,
) -> HelixMeasurement:
    """Measure the link density of two strands of different colours wound round each other.

    Strategy: the axis is the midline of the pair; who is on which side and who passes in front
    give the phase to a quarter turn; then axis, radius and phase are fitted as penalised splines
    to the edges that can be seen (both of the strand in front, the outer one of the strand
    behind), each at a strand radius from its centreline.

    Parameters
    ----------
    picture : Photo or Segmentation
        With a photograph, the border between the strands is read from its colours.
    colours : (i, j), optional
        The two strands; by default the two colours that touch along the greatest length.
    scale : float or Scale, optional
        Pixels per metre, or a measured scale, whose sd is carried on. Without it lengths are in
        pixels.
    root : {"top", "bottom", "left", "right"}
        The side of the picture towards which the clamped end lies.
    tine : (x, y) or (x, y, radius), optional
        Where the tine crosses the pair [px]; by default any other colour that covers it.

    Returns
    -------
    HelixMeasurement

    Raises
    ------
    Unmeasurable
        When there are not two strands, they do not twist, or they are too thin.
    """
    segmentation = segment(picture) if isinstance(picture, Photo) else picture
    pair = twisted_pair(segmentation, colours)
    photo = picture if isinstance(picture, Photo) else None
    membership = pair_membership(segmentation, pair, photo)
    others = (segmentation.labels > 0) & ~np.isin(segmentation.labels, np.add(pair, 1))
    start = _first_look(membership, root)
    hidden, tine_s = _tine(start, others, tine)
    fitted, edges, valid = _fit_all(membership, start, hidden)
    return _measured(start, fitted, edges, valid, tine_s, _per_pixel(scale))


@dataclass(frozen=True)
class _Start:
    """What is known before the fit."""

    axis: Axis
    r: float
    R: float
    pitch: float
    middle: Array
    spread: Mask
    turns: HalfTurns


def _first_look(membership: NDArray[np.float32], root: str) -> _Start:
    """Axis, radii and half-turns read off without a model."""
    r = rough_radius(membership > 0.5)
    if r < THIN:
        raise Unmeasurable(
            f"the strands are {2 * r:.1f} px wide; a link density needs at least {2 * THIN:.0f} px"
        )
    axis = find_axis(membership.sum(axis=0), r, root=root)
    r, seen, turns = _sides(membership, axis, r)
    R = max(helix_radius(seen, turns), 0.5 * r)
    pitch = 2 * float(np.median(np.diff(turns.s)))
    # Smoothing cuts the corner of a kink, where sections would then be aslant and look too wide.
    spread = spread_apart(seen, R, 0.5 * pitch)
    smooth = smoothed(axis, pitch / 4)
    place = _places(smooth, axis)
    turns = replace(turns, s=np.interp(turns.s, place, smooth.s))
    middle = offsets(smooth, np.interp(axis.s, place, smooth.s), axis.points)
    return _Start(smooth, r, R, pitch, middle, np.interp(place, axis.s, spread) > 0.5, turns)


def _places(axis: Axis, other: Axis) -> Array:
    """Arclengths on another axis of the points nearest to this one's, never falling."""
    _, nearest = cKDTree(other.points).query(axis.points)
    return np.maximum.accumulate(other.s[nearest])


def _sides(
    membership: NDArray[np.float32], axis: Axis, r: float
) -> tuple[float, Look, HalfTurns]:
    u = np.arange(-6 * r, 6 * r + 0.5, 0.5)
    profiles = sample(membership, axis, u)
    r = strand_radius(profiles, u)
    seen = look(axis.s, u, profiles, r)
    return r, seen, half_turns(seen, r)


def _tine(
    start: _Start, others: Mask, given: tuple[float, ...] | None
) -> tuple[Mask, float | None]:
    """Sections a tine hides, and its arclength [px]."""
    s = start.axis.s
    if given is not None:
        centre = float(s[np.argmin(np.linalg.norm(start.axis.points - given[:2], axis=1))])
        reach = given[2] if len(given) > 2 else 2 * start.r
        return np.abs(s - centre) <= reach + 2, centre
    u = np.arange(-2 * start.r, 2 * start.r + 1, 1.0)
    bar = _thicker(others, 1.2 * start.r).astype(np.float32)
    covered = (sample(bar[None], start.axis, u)[0] > 0.5).sum(axis=1) > start.r
    if not covered.any():
        return np.zeros(len(s), dtype=bool), None
    return np.convolve(covered, np.ones(5), mode="same") > 0, float(np.median(s[covered]))


def _thicker(mask: Mask, least: float) -> Mask:
    """Keep the blobs into which a disc of radius ``least`` [px] fits: a tine, not a highlight."""
    _, blobs = cv2.connectedComponents(mask.astype(np.uint8))
    depth = cv2.distanceTransform(mask.astype(np.uint8), cv2.DIST_L2, 5)
    thick = np.zeros(blobs.max() + 1, dtype=bool)
    thick[np.unique(blobs[depth > least])] = True
    thick[0] = False
    return thick[blobs]


def _fit_all(
    membership: NDArray[np.float32], start: _Start, hidden: Mask
) -> tuple[Fit, Edges, Mask]:
    """Fit, look for the edges again where the fit says they are, fit again."""
    model = _first_model(start, membership.shape[1:])
    s = start.axis.s
    valid = ~start.spread & ~hidden
    valid &= (s > 2 * start.r) & (s < s[-1] - 2 * start.r)
    valid &= _long_enough(valid, start)
    if not valid.any():
        raise Unmeasurable(
            "no stretch of half a pitch shows the strands twisted at a steady radius; "
            "nothing can be measured"
        )
    held = _held(model, valid)
    edges = find_edges(membership, model, valid, max(2.0, 0.7 * start.r))
    fitted = fit(model, edges, held)
    for _ in range(2):
        edges = find_edges(membership, fitted.model, valid, max(2.0, 0.35 * start.r))
        fitted = fit(fitted.model, edges, held, fitted.prior, rounds=5)
    return fitted, edges, valid


def _first_model(start: _Start, shape: tuple[int, ...]) -> Model:
    """Splines through the first phase; 16 knots a pitch for it, 8 for the axis, one for R."""
    axis, end = start.axis, start.axis.s[-1]
    layout = Layout(
        *(knots(0.0, end, start.pitch / n) for n in (16, 8, 4)),
    )
    beta = np.zeros(layout.size)
    phase = first_phase(start.turns, axis.s)
    # A B-spline's coefficients are close to the curve at the middles of its basis functions.
    beta[layout.blocks["phi"]] = np.interp(layout.phi[2:-2], axis.s, phase)
    beta[layout.blocks["mid"]] = np.interp(layout.mid[2:-2], axis.s, start.middle)
    beta[layout.blocks["R"]] = start.R
    beta[layout.blocks["radii"]] = start.r
    centre = np.array([(shape[1] - 1) / 2, (shape[0] - 1) / 2])
    return Model(axis, layout, beta, centre)


def _long_enough(valid: Mask, start: _Start) -> Mask:
    """Keep stretches of at least half a pitch that hold a crossing."""
    edges = np.flatnonzero(np.diff(np.r_[0, valid.astype(int), 0]))
    keep = np.zeros_like(valid)
    for a, b in edges.reshape(-1, 2):
        inside = (start.turns.s >= start.axis.s[a]) & (start.turns.s <= start.axis.s[b - 1])
        if b - a > 0.5 * start.pitch and inside.any():
            keep[a:b] = True
    return keep


def _held(model: Model, valid: Mask) -> dict[str, Mask]:
    """Differences of the coefficients to penalise: all but those that reach across a gap's middle.

    What lies before and behind a tine is so fitted apart; the axis is one curve throughout.
    """
    runs = np.flatnonzero(np.diff(np.r_[0, valid.astype(int), 0])).reshape(-1, 2)
    cuts = model.axis.s[(runs[1:, 0] + runs[:-1, 1]) // 2]
    held = {}
    for name, order in PENALISED.items():
        middles = getattr(model.layout, name)[2:-2]
        first, last = middles[:-order], middles[order:]
        across = (first[:, None] <= cuts) & (last[:, None] > cuts)
        held[name] = np.ones(len(first), bool) if name == "mid" else ~across.any(axis=1)
    return held


def _per_pixel(scale: float | Scale | None) -> tuple[float, float, str]:
    """Metres per pixel, relative sd, unit."""
    if scale is None:
        return 1.0, 0.0, "px"
    known = scale if isinstance(scale, Scale) else stated(scale)
    return known.metres_per_pixel, known.relative_sd, "m"


def _measured(
    start: _Start,
    fitted: Fit,
    edges: Edges,
    valid: Mask,
    tine_s: float | None,
    scale: tuple[float, float, str],
) -> HelixMeasurement:
    """Turn a fit into tables."""
    model, (per_pixel, scale_sd, unit) = fitted.model, scale
    lean, lean_sd = _lean(fitted)
    stretch = per_pixel / np.cos(lean)
    table = model.table
    arc = stretch * np.r_[0.0, np.cumsum(0.5 * (table.speed[1:] + table.speed[:-1]) * np.diff(table.s))]
    t = np.arange(0.0, model.axis.s[-1], max(start.r, 2.0))
    s = np.interp(t, table.s, arc)
    resolved = _resolved(t, fitted, edges, valid, start.pitch)
    phase = _phase_table(fitted, t, s, resolved, per_pixel)
    link = _link_table(fitted, t, s, resolved, stretch, np.hypot(scale_sd, np.tan(lean) * lean_sd))
    phase.attrs |= {"unit": unit, "knot_s": t}
    link.attrs |= {"unit": unit, "resolution": _resolution(fitted, s, resolved)}
    inside = t[resolved]
    total, total_sd = _turns(fitted, inside[0], inside[-1])
    length = float(s[resolved][-1] - s[resolved][0])
    cut = np.where(resolved[:, None], 1.0, np.nan)
    strands = [cut * np.column_stack([np.interp(t, table.s, c[:, i]) for i in (0, 1)]) for c in table.strands]
    R, R_sd = np.nanmedian(phase["R"]), np.nanmedian(phase["R_sd"])
    return HelixMeasurement(
        link_density=link,
        phase=phase,
        crossings=_crossing_table(start, fitted, np.interp(start.turns.s, table.s, arc)),
        total_link=total,
        total_link_sd=total_sd,
        handedness="right" if total > 0 else "left",
        R=float(R),
        R_sd=float(R_sd),
        r=float(model.part("radii").mean() * per_pixel),
        pitch=length / abs(total),
        pitch_sd=length / total**2 * float(np.hypot(total_sd, total * scale_sd)),
        lean=lean,
        lean_sd=lean_sd,
        resolution=link.attrs["resolution"],
        tine=None if tine_s is None else float(np.interp(tine_s, table.s, arc)),
        unit=unit,
        warnings=tuple(_warnings(start, fitted, s, resolved, lean, unit)),
        strands=(strands[0], strands[1]),
        fit=fitted,
        length_per_pixel=per_pixel,
    )


def _lean(fitted: Fit) -> tuple[float, float]:
    where = fitted.model.layout.blocks["lean"].start
    sine = float(np.clip(fitted.model.beta[where], -0.9, 0.9))
    sd = float(np.sqrt(fitted.covariance[where, where]))
    return float(np.arcsin(sine)), sd / np.sqrt(1 - sine**2)


def _resolved(t: Array, fitted: Fit, edges: Edges, valid: Mask, pitch: float) -> Mask:
    """Where sections are valid, and edges within an eighth of a pitch are there and fit."""
    order = np.argsort(edges.s)
    place = edges.s[order]
    first, last = (np.searchsorted(place, t + side * pitch / 8) for side in (-1, 1))
    misfit = np.cumsum(np.r_[0, np.abs(fitted.residual[order]) > MISFIT * fitted.noise])
    count = last - first
    bad = (misfit[last] - misfit[first]) / np.maximum(count, 1)
    here = valid[np.minimum(np.rint(t).astype(int), len(valid) - 1)]
    return here & (count > pitch / 8) & (bad < 0.5)


def _phase_table(fitted: Fit, t: Array, s: Array, resolved: Mask, per_pixel: float) -> pd.DataFrame:
    model, v = fitted.model, fitted.model.at(t)
    points = np.column_stack([np.interp(t, model.table.s, model.table.axis[:, i]) for i in (0, 1)])
    frame = pd.DataFrame({
        "s": s,
        "phi": v.phi,
        "sd": _sd(fitted, "phi", t),
        "R": per_pixel * v.R,
        "R_sd": per_pixel * _sd(fitted, "R", t),
    })  # fmt: skip
    frame[~resolved] = np.nan
    return frame.assign(s=s, x=points[:, 0], y=points[:, 1], resolved=resolved)


def _link_table(
    fitted: Fit, t: Array, s: Array, resolved: Mask, stretch: float, common: float
) -> pd.DataFrame:
    """lambda = phi' / 2 pi per length of the axis in space; ``common`` is the relative sd of that length."""
    table = fitted.model.table
    per_length = 1 / (2 * np.pi * stretch * np.interp(t, table.s, table.speed))
    link = np.where(resolved, fitted.model.at(t).dphi * per_length, np.nan)
    sd = np.where(resolved, _sd(fitted, "phi", t, 1) * per_length, np.nan)
    return pd.DataFrame({"s": s, "link": link, "sd": np.hypot(sd, common * link)})


def _sd(fitted: Fit, name: str, t: Array, derivative: int = 0) -> Array:
    where = fitted.model.layout.blocks[name]
    design = basis(getattr(fitted.model.layout, name), t, derivative).toarray()
    return np.sqrt(np.einsum("ij,jk,ik->i", design, fitted.covariance[where, where], design, optimize=True))


def _turns(fitted: Fit, start: float, end: float) -> tuple[float, float]:
    """Link between two places of the starting axis [px], and its sd."""
    where = fitted.model.layout.blocks["phi"]
    design = basis(fitted.model.layout.phi, np.array([start, end])).toarray()
    difference = (design[1] - design[0]) / (2 * np.pi)
    variance = difference @ fitted.covariance[where, where] @ difference
    return float(difference @ fitted.model.part("phi")), float(np.sqrt(max(variance, 0.0)))


def _resolution(fitted: Fit, s: Array, resolved: Mask) -> float:
    """Resolved length per free parameter of the phase."""
    length = float(np.sum(np.diff(s)[resolved[1:] & resolved[:-1]]))
    return length / max(fitted.freedom["phi"] - 1, 1.0)


def _crossing_table(start: _Start, fitted: Fit, s: Array) -> pd.DataFrame:
    front = np.where(np.sin(start.turns.phase) > 0, "a", "b")
    return pd.DataFrame({
        "s": s,
        "phi": start.turns.phase,
        "front": front,
        "sense": start.turns.sense,
        "confidence": start.turns.sure,
    })


def _warnings(
    start: _Start, fitted: Fit, s: Array, resolved: Mask, lean: float, unit: str
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
        f"not resolved from s = {s[a]:.4g} to {s[min(b, len(s) - 1)]:.4g} {unit}"
        for a, b in gaps
    ]
    if fitted.noise > 0.1 * start.r:
        said.append(f"edges scatter by {fitted.noise:.2f} px about the helix; is it one?")
    return said
