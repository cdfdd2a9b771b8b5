"""Pictures of a measured double helix: over the photograph, along the axis, through a series."""

import cv2
import numpy as np
from matplotlib.figure import Figure

from imaging.helix.measurement import HelixMeasurement
from imaging.helix.sequence import HelixSequence, kymograph
from imaging.photo import Photo

Array = np.ndarray
AXIS, STRANDS = (255, 255, 255), ((255, 190, 0), (0, 230, 255))  # white; amber a, cyan b
SHIFT = 4  # fractional bits of OpenCV's drawing coordinates


def draw_helix_overlay(photo: Photo, measured: HelixMeasurement) -> np.ndarray:
    """Draw axis, outlines of both strands and crossings over a photograph, (h, w, 3) RGB.

    The outline of strand a is amber, of b cyan; a crossing carries the colour of the strand in
    front. Thin pictures are enlarged so that lines do not hide the strands.
    """
    zoom = max(1, int(np.ceil(12 / (measured.r / measured.length_per_pixel))))
    size = (zoom * photo.shape[1], zoom * photo.shape[0])
    pixels = np.round(255 * photo.rgb()).astype(np.uint8)
    canvas = cv2.resize(pixels, size, interpolation=cv2.INTER_NEAREST)
    radius = measured.r / measured.length_per_pixel
    for strand, colour in zip(measured.strands, STRANDS, strict=True):
        for side in (-radius, radius):
            _line(canvas, _beside(strand, side), colour, zoom)
    _line(canvas, measured.axis, AXIS, zoom)
    for _, crossing in measured.crossings.iterrows():
        colour = STRANDS[0] if crossing["front"] == "a" else STRANDS[1]
        row = int(np.abs(measured.phase["s"] - crossing["s"]).argmin())
        _dot(canvas, measured.axis[row], 0.35 * radius * zoom, colour, zoom)
    return canvas


def link_figure(measured: HelixMeasurement) -> Figure:
    """Link density with its 95 % band and helix radius along the axis; grey: not resolved."""
    figure = Figure(figsize=(7, 5), layout="constrained")
    upper, lower = figure.subplots(2, 1, sharex=True, height_ratios=(2, 1))
    factor, unit = _readable(measured.unit)
    link, phase = measured.link_density, measured.phase
    s = factor * link["s"]
    _band(upper, s, link["link"], link["sd"])
    upper.set_ylabel(f"link density $\\lambda$ [1/{measured.unit}]")
    upper.set_title(
        f"{measured.handedness}-handed, {abs(measured.total_link):.2f} turns, "
        f"pitch {factor * measured.pitch:.4g} {unit}, R/r {measured.R / measured.r:.3f}"
    )
    _limit(upper, link["link"])
    _band(lower, s, factor * phase["R"], factor * phase["R_sd"])
    lower.set_ylabel(f"radius $R$ [{unit}]")
    _limit(lower, factor * phase["R"])
    lower.set_xlabel(f"arclength $s$ from the root [{unit}]; grey: not resolved")
    lower.set_xlim(0, s.iloc[-1])
    for axes in (upper, lower):
        _shade(axes, s.to_numpy(), phase["resolved"].to_numpy())
        if measured.tine is not None:
            axes.axvline(factor * measured.tine, color="0.3", ls=":", label="tine")
    if measured.tine is not None:
        upper.legend(frameon=False)
    return figure


def sequence_figure(sequence: HelixSequence) -> Figure:
    """Change of link density along the axis for every tine position (the paper's Fig. 2e).

    With 95 % bands; behind a tine each value is the mean over a pitch.
    """
    figure = Figure(figsize=(7, 4), layout="constrained")
    axes = figure.subplots()
    factor, unit = _readable(sequence.measurements[0].unit)
    frames = sequence.profiles.groupby("frame")
    for number, (_, frame) in enumerate(frames):
        colour = f"C{number % 10}"
        s = factor * frame["s"]
        label = f"x = {frame['x'].iloc[0]:.3g}"
        _band(axes, s, frame["change"], frame["change_sd"], color=colour, label=label)
        jump = sequence.jumps.iloc[number]
        if np.isfinite(jump["tine"]):
            axes.axvline(factor * jump["tine"], color=colour, ls=":", lw=0.8)
    axes.axhline(0, color="0.6", lw=0.8)
    axes.set_xlabel(f"arclength $s$ from the root [{unit}]")
    axes.set_ylabel(r"change of link density $\Delta\lambda/\lambda_0$")
    axes.set_xlim(0, factor * sequence.profiles["s"].max())
    _limit(axes, sequence.profiles["change"])
    figure.legend(loc="outside right upper", frameon=False, title="dotted: tine")
    return figure


def kymograph_figure(sequence: HelixSequence) -> Figure:
    """Change of link density as colour over arclength and tine position."""
    x, s, change = kymograph(sequence)
    factor, unit = _readable(sequence.measurements[0].unit)
    figure = Figure(figsize=(7, 4), layout="constrained")
    axes = figure.subplots()
    largest = float(np.nanmax(np.abs(change))) if np.isfinite(change).any() else 1.0
    rows = np.arange(len(x))
    picture = axes.pcolormesh(
        factor * s, rows, change, cmap="RdBu_r", vmin=-largest, vmax=largest, shading="nearest"
    )
    tine = sequence.jumps.sort_values(["x", "frame"])["tine"]
    axes.plot(factor * tine, rows, "k|", ms=14, label="tine")
    axes.set_facecolor("0.85")
    axes.set_yticks(rows, [f"{value:.3g}" for value in x])
    axes.set_xlabel(f"arclength $s$ from the root [{unit}]")
    axes.set_ylabel("tine position $x = d/D$")
    axes.set_title("grey: not resolved", fontsize="small")
    figure.colorbar(picture, label=r"change of link density $\Delta\lambda/\lambda_0$")
    return figure


def _readable(unit: str) -> tuple[float, str]:
    """Return the factor from metres to millimetres, or 1 for pixels, and the unit's name."""
    return (1e3, "mm") if unit == "m" else (1.0, "px")


def _band(axes, s, value, sd, **style) -> None:  # type: ignore[no-untyped-def]
    (line,) = axes.plot(s, value, lw=1.4, **style)
    axes.fill_between(s, value - 1.96 * sd, value + 1.96 * sd, alpha=0.3, color=line.get_color())


def _limit(axes, values) -> None:  # type: ignore[no-untyped-def]
    """Show the values, not the widest of their bands, and at least +-10 % about the middle."""
    known = np.asarray(values, dtype=float)
    known = known[np.isfinite(known)]
    if not known.size:
        return
    low, high = known.min(), known.max()
    room = max(0.3 * (high - low), 0.1 * abs(float(np.median(known))), 1e-6)
    axes.set_ylim(low - room, high + room)


def _shade(axes, s: Array, resolved: np.ndarray) -> None:  # type: ignore[no-untyped-def]
    """Grey where nothing is resolved."""
    gaps = np.flatnonzero(np.diff(np.r_[1, resolved.astype(int), 1])).reshape(-1, 2)
    for first, end in gaps:
        axes.axvspan(s[max(first - 1, 0)], s[min(end, len(s) - 1)], color="0.9", lw=0, zorder=0)


def _beside(strand: Array, distance: float) -> Array:
    along = np.gradient(strand, axis=0)
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    return strand + distance * np.column_stack([along[:, 1], -along[:, 0]])


def _to_canvas(points: Array, zoom: int) -> np.ndarray:
    """Picture points -> fixed-point canvas coordinates, whose pixels are 1/zoom as wide."""
    return np.round((zoom * (points + 0.5) - 0.5) * (1 << SHIFT)).astype(np.int32)


def _line(canvas: np.ndarray, points: Array, colour: tuple[int, int, int], zoom: int) -> None:
    known = np.isfinite(points).all(axis=1)
    runs = np.flatnonzero(np.diff(np.r_[0, known.astype(int), 0])).reshape(-1, 2)
    for a, b in runs:
        cv2.polylines(canvas, [_to_canvas(points[a:b], zoom)], False, colour, 1, cv2.LINE_AA, SHIFT)


def _dot(
    canvas: np.ndarray, point: Array, radius: float, colour: tuple[int, int, int], zoom: int
) -> None:
    x, y = (int(v) for v in _to_canvas(point[None], zoom)[0])
    cv2.circle(canvas, (x, y), int(radius * (1 << SHIFT)), colour, -1, cv2.LINE_AA, SHIFT)
