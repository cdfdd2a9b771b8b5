"""From a force log to the scaled curve f(x): zero, start and end of combing, noise."""

from dataclasses import dataclass

import numpy as np
import pandas as pd

from instron.errors import Unscalable
from instron.rig import Rig

QUIET = 0.05  # the share of the stroke at its end that is looked at for a quiet force
FIRST = 0.01  # the share of the rows at its start that count as before combing
COARSE = 0.01


def scale(log: pd.DataFrame, rig: Rig) -> pd.DataFrame:
    """Return the scaled curve of a force log, measured or simulated.

    The outward stroke is kept (up to the farthest crosshead position). ``d`` is the displacement
    from the first row, ``F`` the force from its zero, positive where it resists combing;
    ``x = d/D`` and ``f = l0^2 F/B``, with ``D`` where combing ends: from there on the force stays
    below ``max(end_fraction * peak, end_sigma * noise)``.

    Parameters
    ----------
    log
        Columns ``displacement`` [m] and ``force`` [N] (``time`` is not needed).
    rig
        Rigidity and rules.

    Returns
    -------
    DataFrame
        Columns ``x``, ``f``, ``d`` [m], ``F`` [N]. ``attrs``: ``D`` [m], ``D_low``, ``D_high``
        (threshold doubled and halved), ``B``, ``l0``, ``noise`` (sd of F) [N], ``f_noise``,
        ``f_relative`` (standard uncertainty of f from r and E), ``f_max``, ``W`` [J], ``w``,
        ``rules``, ``warnings``, and the log's own.

    Raises
    ------
    Unscalable
        When the crosshead does not move or no force stands out of the noise.
    """
    d, F, direction = _stroke(log)
    noise = noise_of(F)
    zero = _zero(F, noise, rig)
    F = F - zero.level
    sign = rig.force_sign or (1 if F.max() >= -F.min() else -1)
    F = sign * F
    d = d - rig.compliance * F
    d = d - (_toe(d, F) if rig.toe == "tangent" else d[0])
    ends = _ends(d, F, noise, rig, _name(log))
    f = rig.l0**2 / rig.rigidity * F
    curve = pd.DataFrame({"x": d / ends.D, "f": f, "d": d, "F": F})
    curve.attrs = dict(log.attrs) | _facts(curve, rig, noise, ends)
    curve.attrs["rules"] = {
        "zero": zero.rule,
        "zero_force": float(np.mean(zero.level)),
        "direction": f"{direction}, force x {sign:+d}",
        "end": f"force stays below {ends.threshold:.3g} N ({ends.rule})",
        "compliance": rig.compliance,
        "toe": rig.toe,
    }
    curve.attrs["warnings"] = [
        *log.attrs.get("warnings", []), *zero.warnings, *ends.warnings, *_coarse(F, noise)
    ]  # fmt: skip
    return curve


def noise_of(F: np.ndarray) -> float:
    """Return the standard deviation of white noise on a smooth signal [unit of F].

    From second differences, whose noise has the variance 6 sigma^2, by the median absolute
    deviation, which a few jumps at releases do not move.
    """
    if len(F) < 5:
        return 0.0
    second = np.diff(F, n=2)
    return float(1.4826 * np.median(np.abs(second - np.median(second))) / np.sqrt(6))


def work(curve: pd.DataFrame) -> tuple[float, float]:
    """Return ``W = integral F dd`` [J] and ``w = integral f dx``, up to the end of combing."""
    inside = curve["x"].to_numpy() <= 1
    part = curve[inside]
    return _area(part["F"], part["d"]), _area(part["f"], part["x"])


def _area(y: pd.Series, x: pd.Series) -> float:
    """Return the integral of y over x by the trapezoidal rule."""
    height, step = y.to_numpy(), np.diff(x.to_numpy())
    return float(np.sum(step * (height[1:] + height[:-1])) / 2)


@dataclass(frozen=True)
class _Zero:
    level: np.ndarray | float
    rule: str
    warnings: list[str]


@dataclass(frozen=True)
class _Ends:
    D: float
    low: float
    high: float
    threshold: float
    rule: str
    warnings: list[str]


def _name(log: pd.DataFrame) -> str:
    return str(log.attrs.get("specimen", log.attrs.get("source", "force log")))


def _stroke(log: pd.DataFrame) -> tuple[np.ndarray, np.ndarray, str]:
    """Return displacement (growing outward) and force up to the farthest position."""
    d = log["displacement"].to_numpy(dtype=float)
    F = log["force"].to_numpy(dtype=float)
    good = np.isfinite(d) & np.isfinite(F)
    d, F = d[good], F[good]
    if len(d) < 5 or np.ptp(d) == 0:
        raise Unscalable(f"{_name(log)}: the crosshead does not move in {len(d)} rows")
    outward = 1 if d.max() - d[0] >= d[0] - d.min() else -1
    d = outward * d
    last = len(d) - int(np.argmax(d[::-1]))
    if last < 5:
        raise Unscalable(f"{_name(log)}: the crosshead only returns; no outward stroke")
    return d[:last], F[:last], f"displacement x {outward:+d}, {last} of {len(good)} rows"


def _zero(F: np.ndarray, noise: float, rig: Rig) -> _Zero:
    """Return the force at which the load cell reads nothing, by the rig's rule."""
    size, first = max(3, int(QUIET * len(F))), max(3, int(FIRST * len(F)))
    start, free = float(np.median(F[:first])), float(np.median(F[-size:]))
    if rig.zero == "none":
        return _Zero(0.0, "none", [])
    if rig.zero == "start":
        return _Zero(start, f"start: median of the first {first} rows", [])
    if rig.zero == "drift":
        return _Zero(np.linspace(start, free, len(F)), "drift: line from start to free end", [])
    if rig.zero == "free" or _is_quiet(F[-size:], np.ptp(F), noise):
        return _Zero(free, f"free: median of the last {size} rows", [])
    return _Zero(0.0, "none (auto: the end is not quiet)", [
        "the log does not end at a quiet force, so the file's own zero is kept"
    ])  # fmt: skip


def _is_quiet(end: np.ndarray, span: float, noise: float) -> bool:
    """Tell whether the force at the end neither falls nor wanders: the tine is free."""
    half = len(end) // 2
    step = abs(float(np.median(end[:half]) - np.median(end[half:])))
    return step <= max(0.01 * span, 3 * noise) and np.ptp(end) <= max(0.05 * span, 12 * noise)


def _toe(d: np.ndarray, F: np.ndarray) -> float:
    """Return where the steepest tangent of the first rise meets zero force."""
    rise = slice(0, max(3, int(np.argmax(F)) + 1))
    slope = np.gradient(F[rise], d[rise], edge_order=1)
    steepest = int(np.nanargmax(np.where(np.isfinite(slope), slope, -np.inf)))
    return float(d[rise][steepest] - F[rise][steepest] / slope[steepest])


def _ends(d: np.ndarray, F: np.ndarray, noise: float, rig: Rig, name: str) -> _Ends:
    """Return the end of combing by the threshold rule, and how it moves with the threshold."""
    peak = float(F.max())
    if peak <= 0 or peak < rig.end_sigma * noise:
        raise Unscalable(f"{name}: the peak force {peak:.3g} N does not stand out of the noise")
    by_noise = rig.end_sigma * noise > rig.end_fraction * peak
    rule = f"{rig.end_sigma:g} x noise" if by_noise else f"{rig.end_fraction:.0%} of the peak"
    threshold = max(rig.end_sigma * noise, rig.end_fraction * peak)
    # Half the threshold, but not so low that noise itself crosses it.
    lower = max(0.5 * threshold, min(4.0, rig.end_sigma) * noise)
    D, low, high = (_last_above(d, F, level) for level in (threshold, 2 * threshold, lower))
    if D <= 0:
        raise Unscalable(f"{name}: the force is above {threshold:.3g} N only at the start")
    notes = []
    if F[-1] > threshold:
        notes.append("the log stops before combing ends: D is the last displacement")
    elif high - low > 0.05 * D:
        notes.append(f"D depends on the threshold: {low:.4g} to {high:.4g} m")
    return _Ends(D, low, high, threshold, rule, notes)


def _last_above(d: np.ndarray, F: np.ndarray, threshold: float) -> float:
    """Return the displacement at which F last falls through the threshold, interpolated."""
    above = np.flatnonzero(threshold < F)
    if not len(above):
        return 0.0
    i = above[-1]
    if i + 1 == len(F):
        return float(d[i])
    return float(d[i] + (d[i + 1] - d[i]) * (F[i] - threshold) / (F[i] - F[i + 1]))


def _facts(curve: pd.DataFrame, rig: Rig, noise: float, ends: _Ends) -> dict[str, float]:
    per_newton = rig.l0**2 / rig.rigidity
    W, w = work(curve)
    return {
        "D": ends.D,
        "D_low": ends.low,
        "D_high": ends.high,
        "B": rig.rigidity,
        "l0": rig.l0,
        "noise": noise,
        "f_noise": per_newton * noise,
        "f_relative": rig.relative_uncertainty,
        "f_max": float(curve["f"].max()),
        "W": W,
        "w": w,
    }


def _coarse(F: np.ndarray, noise: float) -> list[str]:
    """Warn when the file's last digit is coarser than 1 % of the peak."""
    steps = np.diff(np.unique(np.round(F, 12)))
    digit = float(steps.min()) if len(steps) else 0.0
    if digit > COARSE * F.max():
        return [f"the last digit of the force, {digit:.3g} N, is over 1 % of the peak"]
    return []
