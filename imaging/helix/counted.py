"""Half-turns counted from the colours along the axis: what a pair tells without any sharp edge.

The phase that `imaging.helix.turning` follows is smoothed by straight lines over a pitch; what is
left about them is the phase's error. Where the edges bear a fit, that takes the place of this.
"""

from dataclasses import dataclass

import numpy as np
import pandas as pd
from scipy.ndimage import gaussian_filter1d, median_filter, uniform_filter1d

from imaging.errors import Unmeasurable
from imaging.helix.axis import Axis, find_axis, sample, smoothed
from imaging.helix.colours import split_colours, with_dim_strands
from imaging.helix.count import HalfTurns
from imaging.helix.find import GAIN, RATIOS, TURNED
from imaging.helix.measurement import HelixMeasurement, crossing_table, gaps
from imaging.helix.pair import THIN, rough_radius, twisted_pair
from imaging.helix.turning import PLACES, WIDE, Turning, turning
from imaging.photo import Photo
from imaging.segment import Segmentation, segment

Array = np.ndarray
Mask = np.ndarray
WINDOW = 1.0  # pitches of a straight line
LEAST_SD = 0.25  # rad; by which the phase errs at least, alike over a quarter of a pitch
UNTOLD = np.radians(6.0)  # sd of a lean out of the picture that nothing tells
FOLLOWED = 0.75  # of what is seen, over half a pitch; less is no pair there
BORNE = 0.5  # of the counted length that edges must resolve to be believed at all
APART = 0.4  # turns by which edges and count may differ
FROM_COLOURS = (
    "half-turns are counted from the colours, as the edges are not sharp enough to be followed; "
    "the link density is that over a pitch, and its sd is wider"
)


@dataclass(frozen=True)
class Counted:
    """Phase along an axis from the colours, lengths in pixels.

    Attributes
    ----------
    axis : Axis
    s, phi, link, link_sd : (n,) arrays
        Arclength of the sections, phase [rad], turns per length and its sd.
    phi_sd : float
    known : (n,) bool array
    turns : HalfTurns
    r, R, pitch : float
    """

    axis: Axis
    s: Array
    phi: Array
    link: Array
    link_sd: Array
    phi_sd: float
    known: Mask
    turns: HalfTurns
    r: float
    R: float
    pitch: float

    def at(self, t: Array) -> tuple[Array, Array, Array, Mask]:
        """Phase, link per pixel, its sd, and whether they are known, at arclengths ``t``."""
        near = np.abs(self.s - np.asarray(t)[:, None]).argmin(axis=1)
        phi, link, sd = (np.interp(t, self.s, v) for v in (self.phi, self.link, self.link_sd))
        return phi, link, sd, self.known[near]


def count_turns(membership: np.ndarray, axis: Axis, r: float) -> Counted | None:
    """Follow the phase along an axis from both strands' coverage (2, h, w); None if none winds."""
    half, s, shown = _sections(membership, axis, r)
    step = (s[-1] - s[0]) / (len(s) - 1) / half
    every = [turning(shown, step * (1 + ratio), ratio) for ratio in RATIOS]
    best = max(every, key=lambda found: found.gain * (1 + found.ratio))
    known = best.winds
    if best.gain * len(s) < GAIN * known.sum() / 2 or known.sum() < 8:
        return None
    r = half / (1 + best.ratio)
    pitch = r / float(np.median(np.abs(best.rate[known])))
    known = _followed(best, known, max(int(pitch / 2 / (step * half)), 1))
    phi, link, link_sd, phi_sd = _smoothed(best.phi, s, known, pitch)
    if known.sum() < 8 or np.abs(np.ptp(phi[known])) < 2 * np.pi * TURNED:
        return None
    turns = _crossings(best, gaussian_filter1d(best.phi, pitch / 8 / (step * half)), s, known)
    return Counted(
        axis, s, phi, link, link_sd, phi_sd, known, turns, r, best.ratio * r, pitch
    )  # fmt: skip


def may_wind(photo: Photo) -> bool:
    """Whether two strands that `segment` tells apart wind, or are too thin here to tell."""
    try:
        plain = segment(photo)
    except Unmeasurable:
        return False
    whole = with_dim_strands(plain)
    return _winds(photo, plain) or (whole is not plain and _winds(photo, whole))


def _winds(photo: Photo, segmentation: Segmentation) -> bool:
    """Tell the same of one segmentation."""
    try:
        seen = split_colours(photo, segmentation)
        membership = seen.membership[list(twisted_pair(seen))]
        r = rough_radius(membership > 0.5)
        if r < THIN:
            return True
        axis = smoothed(find_axis(membership.sum(axis=0), r), 4 * r)
    except Unmeasurable:
        return False
    return count_turns(membership, axis, r) is not None


def _sections(membership: np.ndarray, axis: Axis, r: float) -> tuple[float, Array, Array]:
    """Half width of the pair [px], arclengths, and what each section shows (n, PLACES, 3)."""
    u = np.arange(-6 * r, 6 * r + 0.5, 0.5)
    inside = sample(membership.sum(axis=0)[None], axis, u)[0] > 0.5
    some = inside.any(axis=1)
    low, high = u[np.argmax(inside, axis=1)], u[len(u) - 1 - np.argmax(inside[:, ::-1], axis=1)]
    half = max(float(np.percentile(0.5 * (high - low)[some], 70)), 2.0)
    middle = np.interp(axis.s, axis.s[some], median_filter(0.5 * (low + high)[some], 5))
    middle = gaussian_filter1d(middle, 2 * half, mode="nearest")
    rows = np.unique(np.rint(np.arange(0, axis.s[-1], max(half / 6, 1.0))).astype(int))
    some_rows = Axis(*(part[rows] for part in (axis.s, axis.points, axis.tangents, axis.normals)))
    places = middle[rows, None] + np.linspace(-WIDE, WIDE, PLACES) * half
    two = np.moveaxis(sample(membership, some_rows, places), 0, -1)
    return half, axis.s[rows], np.concatenate([two, 1 - two.sum(axis=-1, keepdims=True)], axis=-1)


def _followed(found: Turning, known: Mask, reach: int) -> Mask:
    """Where the picture is that of two strands, gaps of less than ``reach`` sections filled."""
    good = known & (uniform_filter1d(found.agreement, reach, mode="nearest") > FOLLOWED)
    where = np.flatnonzero(good)
    for before, after in zip(where[:-1], where[1:], strict=True):
        if after - before <= reach:
            good[before:after] = True
    runs = np.flatnonzero(np.diff(np.r_[0, good.astype(int), 0])).reshape(-1, 2)
    for first, end in runs:
        if abs(found.phi[end - 1] - found.phi[first]) < 2 * np.pi:
            good[first:end] = False
    return good


def _smoothed(phi: Array, s: Array, known: Mask, pitch: float) -> tuple[Array, Array, Array, float]:
    """Phase, link, its sd and the phase's sd from straight lines over WINDOW pitches."""
    smooth, link, sd = phi.copy(), np.full(len(s), np.nan), np.full(len(s), np.nan)
    first, end = _near(s, known, WINDOW * pitch / 2)
    length = np.where(known, s[end - 1] - s[first], 0.0)
    slope, smooth[known] = (v[known] for v in _lines(s, phi, first, end))
    link[known] = slope / (2 * np.pi)
    rest = (phi - smooth)[known]
    phi_sd = max(1.5 * float(np.sqrt(np.mean(rest**2))), LEAST_SD) if rest.size else LEAST_SD
    seen = length > 0
    # Slope of n independent values over a length L: sd sqrt(12/n)/L.
    count = np.maximum(4 * length[seen] / pitch, 2.0)
    sd[seen] = phi_sd * np.sqrt(12 / count) / length[seen] / (2 * np.pi)
    return smooth, link, np.hypot(sd, link * UNTOLD**2 / np.sqrt(2)), phi_sd


def _near(s: Array, known: Mask, reach: float) -> tuple[np.ndarray, np.ndarray]:
    """First and end (n,) of the sections within ``reach`` in the same run of known ones."""
    runs = np.flatnonzero(np.diff(np.r_[0, known.astype(int), 0])).reshape(-1, 2)
    low, high = np.zeros((2, len(s)), int) + np.arange(len(s)) + [[0], [1]]
    for a, b in runs:
        low[a:b], high[a:b] = a, b
    first, end = np.searchsorted(s, s - reach), np.searchsorted(s, s + reach, side="right")
    return np.maximum(low, first), np.minimum(high, end)


def _lines(s: Array, y: Array, first: np.ndarray, end: np.ndarray) -> tuple[Array, Array]:
    """Slope of the straight line of least squares through s[first:end], and its value at s."""
    x, centre, level = s - s.mean(), s.mean(), y.mean()
    y = y - level
    n, sx, sy, sxx, sxy = (
        (total := np.r_[0.0, np.cumsum(v)])[end] - total[first]
        for v in (np.ones(len(x)), x, y, x * x, x * y)
    )
    slope = (n * sxy - sx * sy) / np.maximum(n * sxx - sx**2, 1e-300)
    return slope, level + (sy + slope * (n * (s - centre) - sx)) / n


def _crossings(found: Turning, phi: Array, s: Array, known: Mask) -> HalfTurns:
    """Places where one strand lies on the other: odd multiples of pi/2."""
    half = np.floor((phi - np.pi / 2) / np.pi)
    at = np.flatnonzero((np.diff(half) != 0) & known[1:] & known[:-1])
    level = np.pi * np.maximum(half[at], half[at + 1]) + np.pi / 2
    share = (level - phi[at]) / (phi[at + 1] - phi[at])
    place = s[at] + share * (s[at + 1] - s[at])
    return HalfTurns(place, level, np.sign(phi[at + 1] - phi[at]), found.sure[at])


def from_counts(
    counted: Counted, tine: float | None, scale: tuple[float, float, str]
) -> HelixMeasurement:
    """Turn what was counted into a measurement of its own."""
    per_pixel, scale_sd, unit = scale
    t = np.arange(0.0, counted.axis.s[-1], max(counted.r, 2.0))
    phi, link, link_sd, known = counted.at(t)
    rows = np.rint(t).astype(int)
    points, normals = counted.axis.points[rows], counted.axis.normals[rows]
    nothing = np.where(known, 1.0, np.nan)
    phase = pd.DataFrame({
        "s": per_pixel * t, "phi": phi * nothing, "sd": counted.phi_sd * nothing,
        "R": per_pixel * counted.R * nothing, "R_sd": 0.15 * per_pixel * counted.R * nothing,
        "x": points[:, 0], "y": points[:, 1], "resolved": known,
        "by": np.where(known, "half-turns", ""),
    })  # fmt: skip
    sd = np.hypot(link_sd, link * scale_sd) / per_pixel
    density = pd.DataFrame({"s": per_pixel * t, "link": link / per_pixel * nothing,
                            "sd": sd * nothing})  # fmt: skip
    resolution = WINDOW * counted.pitch * per_pixel
    phase.attrs |= {"unit": unit, "knot_s": t}
    density.attrs |= {"unit": unit, "resolution": resolution}
    total = float(np.ptp(phi[known]) / (2 * np.pi)) * np.sign(phi[known][-1] - phi[known][0])
    total_sd = counted.phi_sd * np.sqrt(2) / (2 * np.pi)
    pitch = per_pixel * float(np.ptp(t[known])) / abs(total)
    arm = (counted.R * np.cos(phi) * nothing)[:, None] * normals
    return HelixMeasurement(
        link_density=density, phase=phase,
        crossings=crossing_table(counted.turns, per_pixel * counted.turns.s),
        total_link=float(total), total_link_sd=float(total_sd),
        handedness="right" if total > 0 else "left",
        R=per_pixel * counted.R, R_sd=0.15 * per_pixel * counted.R, r=per_pixel * counted.r,
        pitch=pitch,
        pitch_sd=pitch * float(np.hypot(np.hypot(total_sd / total, scale_sd), UNTOLD**2)),
        lean=0.0, lean_sd=float(UNTOLD), resolution=resolution,
        tine=None if tine is None else per_pixel * tine, unit=unit,
        warnings=(FROM_COLOURS, *gaps(phase["s"].to_numpy(), known, unit, pitch)),
        strands=(points + arm, points - arm), fit=None, length_per_pixel=per_pixel,
    )  # fmt: skip


def borne_out(edges: HelixMeasurement, counted: Counted) -> bool:
    """Whether edges resolve enough of what is counted, and turn by as much."""
    t, here = edges.phase.attrs["knot_s"], edges.phase["resolved"].to_numpy()
    phi, _, _, known = counted.at(t)
    both = here & known
    if both.sum() < BORNE * known.sum() or both.sum() < 2:
        return False
    apart = (edges.phase["phi"].to_numpy() - phi)[both]
    return bool(np.ptp(median_filter(apart, 5)) < 2 * np.pi * APART)
