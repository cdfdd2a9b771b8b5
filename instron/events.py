"""Jams, plateaus and releases in a scaled curve, told from measured noise."""

import numpy as np
import pandas as pd

from instron.scaling.average import FINE, averaged, profile

COLUMNS = ["kind", "x", "f", "d", "F", "prominence", "width", "drop", "release_x"]
FLAT = 0.15  # a plateau's slope, in units of f_max per D


def events(
    curve: pd.DataFrame, *, prominence: float = 7.0, width: float = 0.0125, floor: float = 0.02
) -> pd.DataFrame:
    """Return the peaks and plateaus of a scaled curve.

    Peaks are those of f averaged over the curve's own length, so that the answer does not depend on
    the sampling rate; the noise that averaging leaves is the scale by which they are judged.

    Parameters
    ----------
    curve
        From ``scale``; only x in [0, 1] is searched.
    prominence
        A peak counts when it stands out this many sd of the noise of the averaged force
        (7 keeps the largest of several hundred noise wiggles out) ...
    width
        Averaging length in x of a curve that does not say its own (columns ``x`` and ``f``,
        attribute ``f_noise``).
    floor
        ... and at least this fraction of the largest force.

    Returns
    -------
    DataFrame
        One row per event, by x: ``kind`` (``"jam"``: a peak after which the force falls by over
        30 %; ``"peak"``; ``"plateau"``), position ``x``, ``d`` [m], height ``f``, ``F`` [N],
        ``prominence`` (f), ``width`` (x, at half prominence; a plateau's length), ``drop`` (f lost
        until the next valley) and ``release_x`` (steepest fall). ``attrs``: ``threshold`` (f),
        ``noise_left`` (f), ``smoothing`` (x).
    """
    x, f, width, left = _smooth(curve, width)
    threshold = max(prominence * left, floor * float(f.max()))
    rows = []
    if len(x) > 2:
        rows = _peaks(x, f, threshold) + _plateaus(x, f, width, left)
    table = pd.DataFrame(rows, columns=COLUMNS)
    table["d"] = table["x"] * curve.attrs.get("D", np.nan)
    table["F"] = table["f"] * curve.attrs.get("B", np.nan) / curve.attrs.get("l0", np.nan) ** 2
    table = table.sort_values("x", ignore_index=True)
    table.attrs = {"threshold": threshold, "noise_left": left, "smoothing": width}
    return table


def _smooth(curve: pd.DataFrame, width: float) -> tuple[np.ndarray, np.ndarray, float, float]:
    """Return x and averaged f on an even grid, the averaging length in x, and the noise left."""
    facts = curve.attrs
    if "average_over" in facts:
        table = averaged(curve)
        x, f = table["x"].to_numpy(), table["f"].to_numpy()
        return x, f, facts["average_over"] / facts["D"], facts["f_noise_averaged"]
    source = profile(curve["x"].to_numpy(), curve["f"].to_numpy())
    x = np.linspace(0, 1, int(FINE / width) + 1)
    samples = int(((curve["x"] >= 0) & (curve["x"] <= 1)).sum())
    left = float(facts.get("f_noise", 0.0)) / np.sqrt(max(1.0, width * samples))
    return x, source.mean(x, width), width, left


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
    """Return the stretches, at least four averaging lengths long, in which a high force is flat."""
    around = np.pad(f, FINE // 2, mode="edge")
    slope = (around[FINE:] - around[:-FINE]) / width
    high = max(0.2 * float(f.max()), 7 * noise)
    flat = (np.abs(slope) < FLAT * f.max()) & (f > high)
    edges = np.flatnonzero(np.diff(np.concatenate([[0], flat.astype(int), [0]])))
    rows = []
    for start, stop in edges.reshape(-1, 2):
        length = float(x[stop - 1] - x[start])
        if length >= max(4 * width, 0.05):
            middle = float(x[start] + length / 2)
            rows.append(["plateau", middle, float(f[start:stop].mean()), np.nan, np.nan,
                         np.nan, length, np.nan, np.nan])  # fmt: skip
    return rows
