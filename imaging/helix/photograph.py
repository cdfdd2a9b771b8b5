"""Two twisted strands in a photograph -> axis, radius, phase, link density, each with its sd."""

from dataclasses import replace
from typing import Any

import cv2
import numpy as np
from scipy.spatial import cKDTree
from threadpoolctl import threadpool_limits

from imaging.errors import Unmeasurable
from imaging.helix.axis import Axis, closed, find_axis, sample, smoothed
from imaging.helix.colours import split_colours, with_dim_strands
from imaging.helix.count import (
    HalfTurns,
    Look,
    first_phase,
    half_turns,
    helix_radius,
    look,
    spread_apart,
    strand_radius,
)
from imaging.helix.counted import borne_out, count_turns, from_counts, may_wind
from imaging.helix.edges import Edges, doubted, edges_in_light, find_edges
from imaging.helix.find import Pair, coarse, find_pairs, segmentation_of
from imaging.helix.fit import Fit, fit, fit_best, widened
from imaging.helix.measurement import HelixMeasurement, Start, measurement_of
from imaging.helix.model import Layout, Model, offsets
from imaging.helix.pair import THIN, linear_light, pair_membership, rough_radius, twisted_pair
from imaging.helix.prior import PENALISED, Prior, first_prior
from imaging.helix.sides import with_sides
from imaging.helix.splines import knots
from imaging.photo import Photo
from imaging.scale import Scale, stated
from imaging.segment import Segmentation, segment

Array = np.ndarray
Mask = np.ndarray
SLOPED = 5.5  # px; strands thinner than this show too little of a slope beside an edge
ENOUGH = 0.5  # of the edges that coverage shows; where fewer are clear in the light it is too dim
NOTHING_WINDS = "no two strands of different colours are seen to wind round each other"
FOUR_STRANDS = (
    "four strands wind here, two by two (a pair folded and plied back on itself); only a double "
    "helix of two strands is measured"
)
UNSEEN = (
    "no tine is seen; it is taken to be where strands that lie apart come together towards the tip"
)
RIMS = (0.1, 0.25)  # px; by which coverage errs with the phase, before a dark ground and in contact
SHADED = (0.5, 0.05)  # px; by which shading moves edges in the light: both strands', one's alone
A_TURN = 3  # crossings
END = 0.25  # pitch; cut ends and clamps are no helix


def helix(
    picture: Photo | Segmentation,
    *,
    pair: int = 0,
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
        A photograph's strands are told apart, and their border found, from its colours.
    pair : int
        Which of the pairs that wind in a photograph, counted from 0 from the most turns.
    colours : (i, j), optional
        The two strands among a segmentation's colours; by default the two that touch along the
        greatest length.
    scale : float or Scale, optional
        Pixels per metre, or a measured scale, whose sd is carried on. Without it lengths are in
        pixels.
    root : {"top", "bottom", "left", "right"}
        The side of the picture towards which the clamped end lies.
    tine : (x, y) or (x, y, radius), optional
        Where the tine crosses the pair [px]; by default what else covers it between its ends, else
        where strands that lie apart come together again on the tip's side, which is warned of.

    Returns
    -------
    HelixMeasurement

    Raises
    ------
    Unmeasurable
        When there are not two strands, they do not twist, or they are too thin.
    """
    if isinstance(picture, Photo):
        found = helices(picture, scale=scale, root=root, tine=tine, only=pair)
        return _or_raise(found[0])
    return _measured(None, picture, colours, scale, root, tine)


def helices(
    photo: Photo,
    *,
    scale: float | Scale | None = None,
    root: str = "top",
    tine: tuple[float, ...] | None = None,
    only: int | None = None,
) -> list[HelixMeasurement | Unmeasurable]:
    """Measure every pair of strands that wind in a photograph, those of the most turns first.

    Parameters
    ----------
    photo, scale, root, tine
        As for `helix`.
    only : int, optional
        Measure this pair alone, counted from 0.

    Returns
    -------
    list of HelixMeasurement or Unmeasurable
        A pair that could not be measured is there with the reason.

    Raises
    ------
    Unmeasurable
        When nothing winds.
    """
    pairs, perhaps = find_pairs(photo)
    if not pairs:
        # Looked at in full, twelve megapixels of cables took a minute to be refused.
        if not perhaps or ((small := coarse(photo)) is not photo and not may_wind(small)):
            raise Unmeasurable(f"{photo.source}: {NOTHING_WINDS}")
        return [_segmented(photo, scale, root, tine)]
    if only is not None and not 0 <= only < len(pairs):
        raise Unmeasurable(f"pair {only + 1} asked for; {len(pairs)} wind in {photo.source}")
    wanted = pairs if only is None else [pairs[only]]
    found = [_attempt(photo, pair, None, scale, root, tine) for pair in wanted]
    if len(pairs) == 1 and isinstance(found[0], Unmeasurable) and not pairs[0].four:
        found = [_segmented(photo, scale, root, tine)]
    one = found[0]
    if only is not None and len(pairs) > 1 and isinstance(one, HelixMeasurement):
        said = f"{len(pairs)} pairs wind in this picture; this is number {only + 1}"
        found[0] = replace(one, warnings=(*one.warnings, said))
    return found


def _segmented(photo: Photo, *how: Any) -> HelixMeasurement | Unmeasurable:
    """Measure the pair in all that `segment` tells apart, at last with dim strands."""
    try:
        plain = segment(photo)
    except Unmeasurable as error:
        return error
    found = _attempt(photo, split_colours(photo, plain), None, *how)
    whole = with_dim_strands(plain)
    if isinstance(found, Unmeasurable) and whole is not plain:
        return _attempt(photo, split_colours(photo, whole), None, *how)
    return found


def _or_raise(found: HelixMeasurement | Unmeasurable) -> HelixMeasurement:
    if isinstance(found, Unmeasurable):
        raise found
    return found


def _attempt(photo: Photo, pair: Pair | Segmentation, *how: Any) -> HelixMeasurement | Unmeasurable:
    """Measure one pair, or say why it cannot be."""
    try:
        if isinstance(pair, Segmentation):
            return _measured(photo, pair, *how)
        if pair.four:
            return Unmeasurable(f"{photo.source}: {FOUR_STRANDS}")
        return _measured(photo, segmentation_of(photo, pair), *how)
    except Unmeasurable as error:
        return error


def _measured(
    photo: Photo | None,
    segmentation: Segmentation,
    colours: tuple[int, int] | None,
    scale: float | Scale | None,
    root: str,
    tine: tuple[float, ...] | None,
) -> HelixMeasurement:
    """Measure the pair that a segmentation shows."""
    pair = twisted_pair(segmentation, colours)
    membership = pair_membership(segmentation, pair, photo)
    others = _others(segmentation, pair)
    r = rough_radius(membership > 0.5)
    if r < THIN:
        raise Unmeasurable(
            f"the strands are {2 * r:.1f} px wide; a link density needs at least {2 * THIN:.0f} px"
        )
    bar = _bar(others, r) if tine is None else _disc(tine, r, others.shape)
    plain = find_axis(membership.sum(axis=0), r, root=root)
    reason, start, by_edges, axis = None, None, None, smoothed(plain, 4 * r)
    try:
        start = _first_look(membership, plain, bar, r)
        axis = start.axis
        by_edges = _by_edges(photo, segmentation, pair, membership, start, bar, tine, scale)
    except Unmeasurable as error:
        reason = error
    counted = count_turns(membership, axis, r)
    if counted is None:
        if by_edges is None:
            raise reason or Unmeasurable(NOTHING_WINDS)
        return with_sides(by_edges, membership, axis)
    if by_edges is None or not borne_out(by_edges, counted):
        place = None if tine is None else nearest(axis, tine)
        place = place if start is None else _tine(start, bar, tine)[1]
        by_edges = from_counts(counted, place, _per_pixel(scale))
    return with_sides(by_edges, membership, axis)


def _by_edges(
    photo: Photo | None,
    segmentation: Segmentation,
    pair: tuple[int, int],
    membership: np.ndarray,
    start: Start,
    bar: Mask,
    tine: tuple[float, ...] | None,
    scale: float | Scale | None,
) -> HelixMeasurement:
    """Measure by a fit to the edges."""
    hidden, tine_s = _tine(start, bar, tine)
    parted = _parted(start) if tine_s is None else None
    # Matrices of a few hundred rows: a second BLAS thread costs five times the time it saves.
    with threadpool_limits(limits=1, user_api="blas"):
        try:
            light = _light(photo, segmentation, pair)
            fitted, edges, valid = _fit_all(membership, light, start, hidden)
        except np.linalg.LinAlgError as error:
            raise Unmeasurable("the edges that can be seen determine no helix") from error
    place = tine_s if parted is None else parted
    found = measurement_of(start, fitted, edges, valid, place, _per_pixel(scale))
    return found if parted is None else replace(found, warnings=(*found.warnings, UNSEEN))


def _light(photo: Photo | None, segmentation: Segmentation, pair: tuple[int, int]) -> Array | None:
    """Light (c, h, w), its coding (gamma 2.2) undone, of strands that are lighter than the ground.

    Shading then moves the place of half the light by much. On a lighter ground it hardly does, and
    coverage, which is all there is without a photograph, tells more of narrow strips.
    """
    if photo is None:
        return None
    light = linear_light(photo)
    labels, seen = (every[::3, ::3] for every in (segmentation.labels, light))
    ground, strands = (seen[np.isin(labels, which)] for which in (0, np.add(pair, 1)))
    if np.median(ground.sum(axis=1)) > np.median(strands.sum(axis=1)):
        return None
    return np.ascontiguousarray(np.moveaxis(light, -1, 0))


def _others(segmentation: Segmentation, pair: tuple[int, int]) -> Mask:
    """Return what stands out from the background and is neither strand of the pair."""
    others = (segmentation.labels > 0) & ~np.isin(segmentation.labels, np.add(pair, 1))
    return others if segmentation.blocks is None else others | segmentation.blocks


def _first_look(membership: np.ndarray, axis: Axis, bar: Mask, r: float) -> Start:
    """Axis, radii and half-turns read off without a model."""
    r, seen, turns = _sides(membership, axis, r)
    R = max(helix_radius(seen, turns), 0.5 * r)
    pitch = 2 * float(np.median(np.diff(turns.s)))
    # Smoothing cuts the corner of a kink, where sections would then be aslant and look too wide.
    spread = spread_apart(seen, R, 0.5 * pitch, _covered(bar, axis, r))
    smooth = smoothed(axis, pitch / 4)
    place = _places(smooth, axis)
    turns = replace(turns, s=np.interp(turns.s, place, smooth.s))
    middle = offsets(smooth, np.interp(axis.s, place, smooth.s), axis.points)
    return Start(smooth, r, R, pitch, middle, np.interp(place, axis.s, spread) > 0.5, turns)


def _places(axis: Axis, other: Axis) -> Array:
    """Arclengths on another axis of the points nearest to this one's, never falling."""
    _, nearest = cKDTree(other.points).query(axis.points)
    return np.maximum.accumulate(other.s[nearest])


def _sides(membership: np.ndarray, axis: Axis, r: float) -> tuple[float, Look, HalfTurns]:
    u = np.arange(-6 * r, 6 * r + 0.5, 0.5)
    profiles = sample(membership, axis, u)
    r = strand_radius(profiles, u)
    seen = look(axis.s, u, profiles, r)
    return r, seen, half_turns(seen, r)


def _tine(start: Start, bar: Mask, given: tuple[float, ...] | None) -> tuple[Mask, float | None]:
    """Sections a tine hides, and its arclength [px]."""
    s = start.axis.s
    if given is not None:
        centre = nearest(start.axis, given)
        reach = given[2] if len(given) > 2 else 2 * start.r
        return np.abs(s - centre) <= reach + 2, centre
    covered = _inner(_covered(bar, start.axis, start.r))
    if not covered.any():
        return np.zeros(len(s), dtype=bool), None
    return np.convolve(covered, np.ones(5), mode="same") > 0, float(np.median(s[covered]))


def nearest(axis: Axis, place: tuple[float, ...]) -> float:
    """Arclength [px] of the point of an axis that is nearest to (x, y)."""
    return float(axis.s[np.argmin(np.linalg.norm(axis.points - place[:2], axis=1))])


def _inner(covered: Mask) -> Mask:
    """Leave out what reaches an end of the axis: a clamp or a cut, no tine."""
    seen = np.flatnonzero(~covered)
    inner = np.zeros_like(covered)
    if len(seen):
        inner[seen[0] : seen[-1]] = covered[seen[0] : seen[-1]]
    return inner


def _disc(tine: tuple[float, ...], r: float, shape: tuple[int, ...]) -> Mask:
    """Draw where a given tine (x, y) or (x, y, radius) is; two strand radii if not said."""
    y, x = np.ogrid[: shape[0], : shape[1]]
    reach = tine[2] if len(tine) > 2 else 2 * r
    return np.asarray(np.hypot(x - tine[0], y - tine[1]) <= reach)


def _parted(start: Start) -> float | None:
    """Arclength [px] where strands that something holds apart come together, seen from the root.

    Strands that splay to their tips do not come together. Half a pitch on either side of what
    lies apart is counted as spread.
    """
    runs = np.flatnonzero(np.diff(np.r_[0, start.spread.astype(int), 0])).reshape(-1, 2)
    after_root = runs[(runs[:, 0] > 0) & (runs[:, 1] < len(start.spread))]
    if not len(after_root):
        return None
    first, end = after_root[-1]
    return float(start.axis.s[max(end - int(start.pitch / 2), first)])


def _covered(bar: Mask, axis: Axis, r: float) -> Mask:
    """Sections of which a bar hides more than half a strand's width."""
    u = np.arange(-2 * r, 2 * r + 1, 1.0)
    return (sample(bar[None].astype(np.float32), axis, u)[0] > 0.5).sum(axis=1) > r


def _bar(mask: Mask, r: float) -> Mask:
    """Keep the blobs that are thicker than a strand: a tine, not a highlight.

    Where they cross the strands, whose colours may leave a hole in them, they are closed.
    """
    _, blobs = cv2.connectedComponents(mask.astype(np.uint8))
    depth = cv2.distanceTransform(mask.astype(np.uint8), cv2.DIST_L2, 5)
    thick = np.zeros(blobs.max() + 1, dtype=bool)
    thick[np.unique(blobs[depth > 1.2 * r])] = True
    thick[0] = False
    return (
        closed(thick[blobs], min(1.5 * float(depth.max()), 8 * r)) if thick.any() else thick[blobs]
    )


def _fit_all(
    membership: np.ndarray, light: Array | None, start: Start, hidden: Mask
) -> tuple[Fit, Edges, Mask]:
    """Fit, look for the edges again where the fit says they are, fit again."""
    model = _first_model(start, membership.shape[1:])
    s = start.axis.s
    valid = ~start.spread & ~hidden
    end = max(2 * start.r, END * start.pitch)
    valid &= (s > end) & (s < s[-1] - end)
    valid &= _long_enough(valid, start)
    if not valid.any():
        raise Unmeasurable(
            "no stretch of a pitch shows the strands twisted at a steady radius; "
            "nothing can be measured"
        )
    held = _held(model, valid)
    edges = find_edges(membership, model, valid, max(2.0, 0.7 * start.r))
    prior = replace(first_prior(model, held), seen=_seen(model, valid, start))
    fitted = fit(model, edges, prior)
    gate = max(2.0, 0.35 * start.r)
    rims = RIMS if light is not None else (0.0, 0.0)
    in_light = None
    if light is not None and start.r >= SLOPED:
        shaded = replace(prior, shading=SHADED)
        in_light = _fit_in_light(membership, light, fitted.model, shaded, valid, gate, held)
    if in_light is None:
        edges = doubted(find_edges(membership, fitted.model, valid, gate), rims)
        fitted = fit_best(fitted, edges, held)
        edges = doubted(find_edges(membership, fitted.model, valid, gate), rims)
    else:
        fitted, edges = in_light
    fitted = fit(fitted.model, edges, fitted.prior, rounds=4)
    return widened(fitted, edges), edges, valid


def _fit_in_light(
    membership: np.ndarray,
    light: Array,
    model: Model,
    prior: Prior,
    valid: Mask,
    gate: float,
    held: dict[str, Mask],
) -> tuple[Fit, Edges] | None:
    """Fit to edges sought in the light; None where too few of them are clear."""
    edges, blur = edges_in_light(light, model, valid, gate)
    fitted = fit(model, edges, prior)
    edges, _ = edges_in_light(light, fitted.model, valid, gate, blur)
    if len(edges.s) < ENOUGH * len(find_edges(membership, fitted.model, valid, gate).s):
        return None
    fitted = fit_best(fitted, edges, held)
    return fitted, edges_in_light(light, fitted.model, valid, gate, blur)[0]


def _first_model(start: Start, shape: tuple[int, ...]) -> Model:
    """Splines through the first phase: 24 knots a pitch, 8 for the axis, 4 for R and the lean."""
    axis, end = start.axis, start.axis.s[-1]
    layout = Layout(
        *(knots(0.0, end, start.pitch / n) for n in (24, 8, 4, 4)),
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


def _long_enough(valid: Mask, start: Start) -> Mask:
    """Keep stretches of at least a pitch and a turn; in less, phase and radius are not told apart.

    The strands of a turn cross three times, at both its ends and between.
    """
    edges = np.flatnonzero(np.diff(np.r_[0, valid.astype(int), 0]))
    keep = np.zeros_like(valid)
    for a, b in edges.reshape(-1, 2):
        inside = (start.turns.s >= start.axis.s[a]) & (start.turns.s <= start.axis.s[b - 1])
        if b - a > start.pitch and inside.sum() >= A_TURN:
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


def _seen(model: Model, valid: Mask, start: Start) -> tuple[Array, Array]:
    """Weights [1/px^2] and values [px] that hold the axis to the middle of what is seen.

    To within a strand's radius, and only farther than half a pitch from what is fitted.
    """
    s, fitted = start.axis.s, start.axis.s[valid]
    middles = model.layout.mid[2:-2]
    after = np.searchsorted(fitted, middles)
    away = np.minimum(
        np.abs(middles - fitted[np.clip(after, 0, len(fitted) - 1)]),
        np.abs(middles - fitted[np.clip(after - 1, 0, len(fitted) - 1)]),
    )
    return (away > start.pitch / 2) / start.r**2, np.interp(middles, s, start.middle)


def _per_pixel(scale: float | Scale | None) -> tuple[float, float, str]:
    """Metres per pixel, relative sd, unit."""
    if scale is None:
        return 1.0, 0.0, "px"
    known = scale if isinstance(scale, Scale) else stated(scale)
    return known.metres_per_pixel, known.relative_sd, "m"
