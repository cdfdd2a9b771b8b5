"""Jams, plateaus and releases in a scaled curve, told from measured noise."""

import numpy as np
import pandas as pd

COLUMNS = ["kind", "x", "f", "d", "F", "prominence", "width", "drop", "release_x"]
FLAT = 0.15  # a plateau's slope, in units of f_max per D


def events(
    curve: pd.DataFrame, *, prominence: float = 7.0, width: float = 0.005, floor: float = 0.02
) -> pd.DataFrame:
    """Return the peaks and plateaus of a scaled curve.

    The curve is put on an even grid and smoothed by a Gaussian of standard deviation ``width``
    in x, so that the answer does not depend on the sampling rate; what the smoothing leaves of
    the measured noise is the scale by which peaks are judged.

    Parameters
    ----------
    curve
        From ``scale``; only x in [0, 1] is searched.
    prominence
        A peak counts when it stands out this many sd of the noise that is left after smoothing
        (7 keeps the largest of several hundred noise wiggles out) ...
    width
        Smoothing length in x; narrower peaks are not resolved.
    floor
        ... and at least this fraction of the largest force.

    Returns
    -------
    DataFrame
        One row per event, by x: ``kind`` (``"jam"``: a peak after which the force falls by over
        30 %; ``"peak"``; ``"plateau"``), position ``x``, ``d`` [m], height ``f``, ``F`` [N],
        ``prominence`` (f), ``width`` (x, at half prominence; a plateau's length), ``drop`` (f lost
        until the next valley) and ``release_x`` (steepest fall). ``attrs``: ``threshold`` (f).
    """
    from scipy.ndimage import gaussian_filter1d

    x, f = _even(curve)
    smooth = gaussian_filter1d(f, width / (x[1] - x[0]), mode="nearest")
    left = _noise_left(curve, width)
    threshold = max(prominence * left, floor * float(smooth.max()))
    rows = _peaks(x, smooth, threshold) + _plateaus(x, smooth, width, left)
    table = pd.DataFrame(rows, columns=COLUMNS)
    table["d"] = table["x"] * curve.attrs.get("D", np.nan)
    table["F"] = table["f"] * curve.attrs.get("B", np.nan) / curve.attrs.get("l0", np.nan) ** 2
    table = table.sort_values("x", ignore_index=True)
    table.attrs = {"threshold": threshold, "noise_left": left, "smoothing": width}
    return table


def _even(curve: pd.DataFrame) -> tuple[np.ndarray, np.ndarray]:
    """Return the curve on an even grid over [0, 1], each cell the mean of its samples."""
    x, f = curve["x"].to_numpy(), curve["f"].to_numpy()
    order = np.argsort(x, kind="stable")
    x, f = x[order], f[order]
    inside = (x >= 0) & (x <= 1)
    count = int(np.clip(inside.sum(), 50, 4000))
    edges = np.linspace(0, 1, count + 1)
    cell = np.clip(np.searchsorted(edges, x[inside], side="right") - 1, 0, count - 1)
    size = np.bincount(cell, minlength=count)
    total = np.bincount(cell, weights=f[inside], minlength=count)
    middle = (edges[1:] + edges[:-1]) / 2
    filled = size > 0
    return middle, np.interp(middle, middle[filled], total[filled] / size[filled])


def _noise_left(curve: pd.DataFrame, width: float) -> float:
    """Return the sd of the noise after smoothing: a Gaussian averages 2 sqrt(pi) w n samples."""
    samples = int(((curve["x"] >= 0) & (curve["x"] <= 1)).sum())
    averaged = max(1.0, 2 * np.sqrt(np.pi) * width * samples)
    return float(curve.attrs.get("f_noise", 0.0)) / np.sqrt(averaged)


def _peaks(x: np.ndarray, f: np.ndarray, threshold: float) -> list[list]:
    """Return the peaks; padding lets a peak count that stands at the end of the record."""
    # Imported late: scipy.signal takes longer to import than most files to read.
    from scipy.signal import find_peaks, peak_widths

    padded = np.concatenate([[f.min()], f, [f.min()]])
    tops, found = find_peaks(padded, prominence=max(threshold, 1e-300))
    widths = peak_widths(padded, tops, 0.5)[0] * (x[1] - x[0])
    tops = tops - 1
    rows = []
    for k, top in enumerate(tops):
        stop = tops[k + 1] if k + 1 < len(tops) else len(f) - 1
        valley = top + int(np.argmin(f[top : stop + 1]))
        drop = float(f[top] - f[valley])
        fall = np.diff(f[top : valley + 1])
        release = float(x[top + int(np.argmin(fall))]) if len(fall) else np.nan
        kind = "jam" if drop > 0.3 * f[top] else "peak"
        rows.append([kind, float(x[top]), float(f[top]), np.nan, np.nan,
                     float(found["prominences"][k]), float(widths[k]), drop, release])  # fmt: skip
    return rows


def _plateaus(x: np.ndarray, f: np.ndarray, width: float, noise: float) -> list[list]:
    """Return the stretches, at least ten smoothing lengths long, in which a high force is flat."""
    from scipy.ndimage import gaussian_filter1d

    slope = np.gradient(gaussian_filter1d(f, 2 * width / (x[1] - x[0]), mode="nearest"), x)
    high = max(0.2 * float(f.max()), 7 * noise)
    flat = (np.abs(slope) < FLAT * f.max()) & (f > high)
    edges = np.flatnonzero(np.diff(np.concatenate([[0], flat.astype(int), [0]])))
    rows = []
    for start, stop in edges.reshape(-1, 2):
        length = float(x[stop - 1] - x[start])
        if length >= max(10 * width, 0.05):
            middle = float(x[start] + length / 2)
            rows.append(["plateau", middle, float(f[start:stop].mean()), np.nan, np.nan,
                         np.nan, length, np.nan, np.nan])  # fmt: skip
    return rows
