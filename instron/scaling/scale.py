"""From a force log to the scaled curve f(x): stroke, zero, noise, end of combing, highest force."""

from dataclasses import dataclass, replace

import numpy as np
import pandas as pd

from instron.errors import Unscalable
from instron.scaling.average import Profile, profile
from instron.scaling.ends import End, find_end
from instron.scaling.noise import SLOW, Noise, last_digit, of_free_end, quietest, swings
from instron.scaling.peak import Peak, highest
from instron.scaling.rig import Rig
from instron.scaling.strokes import name_of, strokes
from instron.scaling.toe import Toe, find_toe
from instron.scaling.zero import Zero, find_zero

COARSE = 0.01
AGREE = 0.02  # relative change of f_max or W by another zero that is worth a warning


def scale(log: pd.DataFrame, rig: Rig) -> pd.DataFrame:
    """Return the scaled curve of a force log, measured or simulated.

    The first outward stroke is kept. ``d`` is the displacement from its first row, ``F`` the force
    from its zero, positive where it resists combing; ``x = d/D`` and ``f = l0^2 F/B``. Highest
    force, D and noise are those of F averaged over one length along d: the rig's
    ``average_over``, 3 r by default, or the distance of two rows where that is larger.

    Parameters
    ----------
    log
        Columns ``displacement`` [m] and ``force`` [N] (``time`` is not needed).
    rig
        Rigidity and rules.

    Returns
    -------
    DataFrame
        Columns ``x``, ``f``, ``d`` [m], ``F`` [N], by row of the log. ``attrs``: ``average_over``
        [m]; ``D`` [m] with its 95 % interval ``D_low``, ``D_high``; ``f_max`` (see
        ``peak.highest``) with ``f_max_low``, ``f_max_high``, and its place ``x_max``; ``noise``,
        ``noise_averaged`` (sd of a reading and of the averaged force) [N] and ``f_noise``,
        ``f_noise_averaged``; ``f_relative`` (standard uncertainty of f from r and E); ``W`` [J],
        ``w``; ``ended`` (whether combing ends within the log); ``B``, ``l0``, ``rules``,
        ``warnings``, and the log's own.

    Raises
    ------
    Unscalable
        When the crosshead does not move, no force stands out of the noise, or the rig asks for a
        tangent where there is none.
    """
    every = strokes(log)
    curve = _scale_stroke(every[0], rig)
    if len(every) > 1:
        curve.attrs["warnings"].append(
            f"the crosshead turns back: the first of {len(every)} outward strokes is taken"
            " (instron.strokes gives all)"
        )
    return curve


def work(curve: pd.DataFrame) -> tuple[float, float]:
    """Return ``W = integral F dd`` [J] and ``w = integral f dx``, up to the end of combing."""
    part = curve[curve["x"] <= 1]
    return _area(part["F"], part["d"]), _area(part["f"], part["x"])


def _area(y: pd.Series, x: pd.Series) -> float:
    """Return the integral of y over x by the trapezoidal rule."""
    height, step = y.to_numpy(), np.diff(x.to_numpy())
    return float(np.sum(step * (height[1:] + height[:-1])) / 2)


@dataclass(frozen=True)
class _Stroke:
    """A stroke with its zero taken off, averaged; ``travel`` is the crosshead's, ``d`` the tine's.

    What is averaged is averaged along the crosshead's travel, which grows, whatever gives way.
    """

    travel: np.ndarray
    d: np.ndarray
    F: np.ndarray
    smooth: np.ndarray
    profile: Profile
    length: float
    step: float
    zero: Zero
    noise: Noise
    end: End
    doubt: Noise  # what noise may be, if slower than it seems
    slack: float  # of the travel, taken off d [m]


def _scale_stroke(log: pd.DataFrame, rig: Rig) -> pd.DataFrame:
    stroke = _measure(log, rig)
    end, noise = stroke.end, stroke.noise
    f = rig.l0**2 / rig.rigidity * stroke.F
    curve = pd.DataFrame({"x": stroke.d / end.D, "f": f, "d": stroke.d, "F": stroke.F})
    peak, place = _peak(stroke)
    curve.attrs = dict(log.attrs) | _facts(curve, rig, stroke, peak, place)
    curve.attrs["rules"] = {
        "average": f"over {stroke.length:.4g} m of d",
        "zero": stroke.zero.rule,
        "zero_force": float(np.mean(stroke.zero.level)),
        "direction": f"displacement x {log.attrs['direction']:+d}, {len(log)} of"
        f" {log.attrs['rows']} rows, force x {stroke.zero.sign:+d}",
        "end": f"force stays below {end.threshold:.3g} N ({end.rule})",
        "noise": noise.where,
        "compliance": rig.compliance,
        "toe": rig.toe if rig.toe == "none" else f"tangent, {stroke.slack:.4g} m of slack",
    }
    curve.attrs["warnings"] = [
        *log.attrs.get("warnings", []), *stroke.zero.warnings, *end.warnings,
        *_averaging(stroke, log, rig), *_slow(stroke), *_coarse(stroke),
        *_apart(log, rig, stroke, curve),
    ]  # fmt: skip
    return curve


def _measure(log: pd.DataFrame, rig: Rig) -> _Stroke:
    """Average, find zero, noise and end; again once the rows of the free tine are known."""
    travel = log["displacement"].to_numpy()
    raw = log["force"].to_numpy(dtype=float)
    step = float(np.median(np.diff(np.unique(travel))))
    length = max(_asked(log, rig), step)
    source = profile(travel, raw)
    smooth = source.mean(travel, length)
    noise, after = quietest(raw, length / step), 0
    for _ in range(3):
        zero = find_zero(raw, smooth, noise.averaged, length / step, rig, after)
        F, averaged = zero.sign * (raw - zero.level), zero.sign * (smooth - zero.level)
        d = travel - rig.compliance * F
        toe = Toe(d[0], d[0], d[0])
        if rig.toe == "tangent":
            unsure = _median_doubt(zero, noise, length / step)
            toe = find_toe(d, F, averaged, length, noise, unsure, name_of(log))
        d = d - toe.foot
        end = find_end(d, F, averaged, length, noise, rig, name_of(log))
        beyond = d > end.D + length
        free = of_free_end(raw[beyond], length / step) if end.ended else None
        if free is None or free == noise:
            break
        noise, after = free, int(beyond.sum())
    unsure = _zero_at(zero, noise, length / step, float(np.mean(d <= end.D)))
    if end.ended:
        end = find_end(d, F, averaged, length, noise, rig, name_of(log), unsure)
    end, doubt = _swinging(d, F, averaged, length, step, noise, end)
    end = _beside(end, toe)
    return _Stroke(travel, d, F, averaged, profile(travel, F), length, step, zero, noise, end,
                   doubt, -float(d[0]))  # fmt: skip


def _beside(end: End, toe: Toe) -> End:
    """Return an end whose interval holds that of the place from which d counts."""
    early, late = toe.high - toe.foot, toe.foot - toe.low
    low, high = np.hypot(end.D - end.low, early), np.hypot(end.high - end.D, late)
    return replace(end, low=float(end.D - low), high=float(end.D + high))


def _zero_at(zero: Zero, noise: Noise, rows: float, place: float) -> float:
    """Return the standard uncertainty of the zero at a place, as a share of the record [N].

    Of what start and end differ a steady drift leaves the more the farther the zero was taken; it
    may also have come at once, anywhere: a uniform distribution twice as wide.
    """
    if zero.rule == "none":
        return 0.0
    far = place if zero.rule.startswith("start") else 1 - place
    return float(np.hypot(_median_doubt(zero, noise, rows), 2 * far * zero.drift))


def _median_doubt(zero: Zero, noise: Noise, rows: float) -> float:
    """Return the sd of a zero that is a median of coloured noise: of independent averages."""
    if not zero.rule.startswith(("free", "drift")):
        return 0.0
    return 1.25 * noise.averaged * (rows / zero.rows) ** 0.5


def _swinging(
    d: np.ndarray,
    F: np.ndarray,
    smooth: np.ndarray,
    length: float,
    step: float,
    noise: Noise,
    end: End,
) -> tuple[End, Noise]:
    """Return an end whose interval holds that slow noise was taken for combing, and that noise."""
    found = swings(F, smooth, length / step)
    if found is None or found[1].averaged < noise.averaged:
        return end, noise
    first, swinging = found
    if not end.ended or d[first] >= end.D:
        return end, swinging
    return replace(end, low=min(end.low, float(d[first]) - length)), swinging


def _asked(log: pd.DataFrame, rig: Rig) -> float:
    """Return the averaging length that rig or log ask for [m]."""
    own = log.attrs.get("r") if rig.average_over is None and rig.r is None else None
    return 3 * own if own else rig.averaging_length


def _peak(stroke: _Stroke) -> tuple[Peak, float]:
    """Return the highest averaged force up to the end of combing, and its place d [m]."""
    combing = stroke.travel[stroke.d <= stroke.end.D]
    places = stroke.profile.places(stroke.length, float(combing[-1]))
    F = stroke.profile.mean(places, stroke.length)
    top = int(np.argmax(F))
    noise, zero = stroke.noise, stroke.zero
    unsure = _median_doubt(zero, noise, stroke.length / stroke.step)
    unsure = float(np.hypot(unsure, zero.drift))
    place = float(np.interp(places[top], stroke.travel, stroke.d))
    peak, wide = (highest(F, n.averaged, n.freedom, unsure) for n in (noise, stroke.doubt))
    return Peak(peak.F, min(peak.low, wide.low), max(peak.high, wide.high)), place


def _facts(
    curve: pd.DataFrame, rig: Rig, stroke: _Stroke, peak: Peak, place: float
) -> dict[str, object]:
    per_newton = rig.l0**2 / rig.rigidity
    W, w = work(curve)
    end, noise = stroke.end, stroke.noise
    return {
        "average_over": stroke.length,
        "D": end.D,
        "D_low": end.low,
        "D_high": end.high,
        "ended": end.ended,
        "B": rig.rigidity,
        "l0": rig.l0,
        "noise": noise.sd,
        "noise_averaged": noise.averaged,
        "f_noise": per_newton * noise.sd,
        "f_noise_averaged": per_newton * noise.averaged,
        "f_relative": rig.relative_uncertainty,
        "f_max": per_newton * peak.F,
        "f_max_low": per_newton * peak.low,
        "f_max_high": per_newton * peak.high,
        "x_max": place / end.D,
        "W": W,
        "w": w,
    }


def _averaging(stroke: _Stroke, log: pd.DataFrame, rig: Rig) -> list[str]:
    """Say so where the averaging length is not the one that was asked for, or nobody asked."""
    asked = _asked(log, rig)
    if stroke.length > asked:
        return [f"a row every {stroke.step:.3g} m is coarser than the averaging length"
                f" {asked:.3g} m: F is averaged over {stroke.length:.3g} m"]  # fmt: skip
    if rig.average_over is None and rig.r is None and "r" not in log.attrs:
        return [f"the rig gives neither r nor average_over: F is averaged over {asked:.4g} m"]
    return []


def _slow(stroke: _Stroke) -> list[str]:
    """Say so where averaging does not lower the noise: too few swings of it tell its size."""
    noise = stroke.noise
    if stroke.length < 3 * stroke.step or noise.averaged <= SLOW * noise.sd:
        return []
    if noise.averaged < 0.01 * stroke.smooth.max():
        return []
    return [f"noise of {noise.sd:.2g} N is as slow as the averaging length: it may be twice as"
            " large, and the intervals of f_max and D hold less often than 95 %"]  # fmt: skip


def _apart(log: pd.DataFrame, rig: Rig, stroke: _Stroke, curve: pd.DataFrame) -> list[str]:
    """Say what another zero would give where start and end of the log disagree."""
    zero = stroke.zero
    if not zero.suspect or rig.zero not in ("auto", "free", "drift") or not stroke.end.ended:
        return []
    drift = zero.rule.startswith("drift")
    other = rig.model_copy(update={"zero": "free" if drift else "drift"})
    found = _scale_stroke_quietly(log, other)
    if found is None:
        return []
    changes = [found[key] / curve.attrs[key] - 1 for key in ("f_max", "W")]
    if max(map(abs, changes)) < AGREE:
        return []
    sd = abs(zero.free - zero.start) / max(stroke.noise.averaged, 1e-300)
    what = "a drift, taken off as a line" if drift else "the start is no zero, or the cell drifts"
    return [
        f"start and end differ by {zero.free - zero.start:.3g} N ({min(sd, 9999):.0f} sd): {what};"
        f" zero = '{other.zero}' would give f_max {changes[0]:+.0%} and W {changes[1]:+.0%}"
    ]


def _scale_stroke_quietly(log: pd.DataFrame, rig: Rig) -> dict[str, float] | None:
    """Return f_max and W with another rig, None where that does not work out."""
    try:
        stroke = _measure(log, rig)
    except Unscalable:
        return None
    inside = stroke.d <= stroke.end.D
    W = _area(pd.Series(stroke.F[inside]), pd.Series(stroke.d[inside]))
    return {"f_max": rig.l0**2 / rig.rigidity * _peak(stroke)[0].F, "W": W}


def _coarse(stroke: _Stroke) -> list[str]:
    """Warn when the file's last digit is coarser than 1 % of the peak."""
    digit = last_digit(stroke.F)
    if digit > COARSE * stroke.smooth.max():
        return [f"the last digit of the force, {digit:.3g} N, is over 1 % of the peak"]
    return []
