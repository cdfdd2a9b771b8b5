"""Pictures of a measurement: lines and crossings drawn over the photograph, labels."""

import base64
from collections.abc import Hashable, Sequence
from typing import Any

import cv2
import numpy as np
import pandas as pd
from scipy.spatial import cKDTree

from imaging.photo import Photo
from imaging.segment import Segmentation
from imaging.trace import Strand
from imaging.trace.centreline import arclength, normals

SUBPIXEL_BITS = 4
RING = "#ff00c8"  # a colour strands seldom have
RING_RADIUS = 1.1  # strand widths
QUALITY = 85  # of a photograph's JPEG
OFF = 0.05  # px by which a line of the SVG may be off
ASIDE = 1.4  # strand widths from a centreline to the outline of unresolved contact


def labels_picture(segmentation: Segmentation, strands: Sequence[Strand]) -> np.ndarray:
    """Return the number of the strand on top in each pixel, 0 = background, shape (h, w).

    uint8 for up to 255 strands, else uint16. Where several strands share a colour, a pixel belongs
    to the nearest of them.
    """
    kind = np.uint8 if len(strands) < 256 else np.uint16
    picture = np.zeros(segmentation.labels.shape, kind)
    for colour in np.unique(np.concatenate([strand.tones for strand in strands])):
        own = [i for i, strand in enumerate(strands) if (strand.tones == colour).any()]
        ys, xs = np.nonzero(segmentation.labels == colour + 1)
        points = np.stack([xs, ys], axis=1)
        parts = [strands[i].line[strands[i].tones == colour] for i in own]
        far = np.stack([cKDTree(part).query(points)[0] for part in parts])
        picture[ys, xs] = np.array(own)[far.argmin(axis=0)] + 1
    return picture


def draw_overlay(
    photo: Photo,
    segmentation: Segmentation,
    strands: Sequence[Strand],
    crossings: pd.DataFrame,
    contacts: pd.DataFrame | None = None,
    unassigned: Sequence[np.ndarray] = (),
) -> np.ndarray:
    """Draw centrelines, strand numbers and crossings over the photograph, (h, w, 3) uint8 RGB.

    A crossing is a ring; the bar in it lies along the strand on top, and is missing when unknown.
    Unresolved contact (of `imaging.unresolved`) is outlined; what is seen and belongs to no strand
    (lines of `Measured.unassigned`) is dashed.
    """
    picture = photo.eight_bits().copy()
    thick = _thickness(segmentation)
    for strand in strands:
        ink = _ink(segmentation.colours[strand.colour])
        for run in _seen_runs(strand):
            cv2.polylines(
                picture, [_fixed(run)], False, ink, thick, cv2.LINE_AA, shift=SUBPIXEL_BITS
            )
    ring = tuple(int(RING[i : i + 2], 16) for i in (1, 3, 5))
    radius = int(2**SUBPIXEL_BITS * RING_RADIUS * segmentation.width)
    for x, y in crossings[["x", "y"]].to_numpy():
        centre = tuple(_fixed(np.array([x, y])).tolist())
        cv2.circle(picture, centre, radius, ring, thick, cv2.LINE_AA, shift=SUBPIXEL_BITS)
    for bar in _top_bars(strands, crossings, RING_RADIUS * segmentation.width):
        cv2.polylines(picture, [_fixed(bar)], False, ring, thick, cv2.LINE_AA, shift=SUBPIXEL_BITS)
    for outline in _outlines(strands, contacts, segmentation.width):
        cv2.polylines(
            picture, [_fixed(outline)], True, ring, thick, cv2.LINE_AA, shift=SUBPIXEL_BITS
        )
    dashes = [_fixed(dash) for line in unassigned for dash in _dashes(line, segmentation.width)]
    cv2.polylines(picture, dashes, False, ring, thick, cv2.LINE_AA, shift=SUBPIXEL_BITS)
    for number, strand in enumerate(strands, start=1):
        _write_number(picture, number, strand.line[0])
    return picture


def _top_bars(
    strands: Sequence[Strand], crossings: pd.DataFrame, radius: float
) -> list[np.ndarray]:
    """Across each ring, a line (2, 2) along the strand on top."""
    bars = []
    for row in crossings[crossings["over"].notna()].to_dict("records"):
        which = "a" if row["over"] == row["strand_a"] else "b"
        line = strands[row["over"] - 1].line
        at = int(np.searchsorted(arclength(line), row[f"s_{which}"]))
        ends = line[[max(at - 3, 0), min(at + 3, len(line) - 1)]]
        along = np.subtract(*ends[::-1])
        reach = radius * along / max(float(np.hypot(*along)), 1e-9)
        bars.append(np.array([row["x"], row["y"]]) + np.stack([-reach, reach]))
    return bars


def _outlines(
    strands: Sequence[Strand], contacts: pd.DataFrame | None, width: float
) -> list[np.ndarray]:
    """Outline each stretch of unresolved contact along its first strand, (n, 2) all of them."""
    outlines = []
    for row in [] if contacts is None else contacts.to_dict("records"):
        line = strands[row["strand_a"] - 1].line
        s = arclength(line)
        at = (s >= row["s_a_from"] - width) & (s <= row["s_a_to"] + width)
        aside = ASIDE * width * normals(line)[at]
        outlines.append(np.concatenate([line[at] + aside, (line[at] - aside)[::-1]]))
    return outlines


def _dashes(line: np.ndarray, width: float) -> list[np.ndarray]:
    """Cut a line of a point a pixel into dashes as long as strands are wide, and gaps."""
    step = max(2, round(width))
    return [line[start : start + step] for start in range(0, len(line), 2 * step)]


def _thickness(segmentation: Segmentation) -> int:
    """Return a line width [px] that leaves the strand's own colour to be seen on both sides."""
    return max(1, round(segmentation.width / 6))


def _ink(lab: np.ndarray) -> tuple[int, int, int]:
    """Black on light strands, white on dark ones."""
    return (0, 0, 0) if lab[0] > 55 else (255, 255, 255)


def _fixed(points: np.ndarray) -> np.ndarray:
    return np.round(points * 2**SUBPIXEL_BITS).astype(np.int32)


def _seen_runs(strand: Strand) -> list[np.ndarray]:
    """Cut a centreline into the runs that are seen: hidden parts stay blank."""
    seen = strand.edges > 0
    cuts = np.flatnonzero(np.diff(seen.astype(int))) + 1
    runs = np.split(strand.line, cuts)
    return [run for run, shown in zip(runs, seen[np.r_[0, cuts]], strict=True) if shown]


def _write_number(picture: np.ndarray, number: int, root: np.ndarray) -> None:
    """Write a strand's number above its root; neighbours' numbers take turns in three rows."""
    height, width = picture.shape[:2]
    scale = 0.45 * max(1.0, height / 2500)
    thick = max(1, round(scale))
    (w, h), _ = cv2.getTextSize(str(number), cv2.FONT_HERSHEY_SIMPLEX, scale, thick)
    x = int(np.clip(root[0] - w / 2, 1, max(width - w - 1, 1)))
    y = int(np.clip(root[1] - 3 - number % 3 * (h + 7), h + 2, height - 2))
    cv2.rectangle(picture, (x - 2, y - h - 2), (x + w + 2, y + 3), (255, 255, 255), -1)
    cv2.putText(
        picture, str(number), (x, y), cv2.FONT_HERSHEY_SIMPLEX, scale, (0, 0, 0), thick, cv2.LINE_AA
    )


def overlay_svg(
    photo: Photo,
    segmentation: Segmentation,
    strands: Sequence[Strand],
    crossings: pd.DataFrame,
    contacts: pd.DataFrame | None = None,
    unassigned: Sequence[np.ndarray] = (),
) -> str:
    """Return the overlay as one SVG file: the photograph below, lines that can be edited above.

    SVG counts from the corner of the first pixel: picture points are shifted by half a pixel.
    """
    height, width = photo.shape
    jpeg = base64.b64encode(as_jpeg(photo.eight_bits())).decode()
    lines = [_svg_strand(i, s, segmentation) for i, s in enumerate(strands, start=1)]
    radius = RING_RADIUS * segmentation.width
    rings = [_svg_ring(row, radius) for row in crossings.to_dict("records")]
    return "\n".join(
        [
            f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" '
            f'width="{width}" height="{height}">',
            f'<image width="{width}" height="{height}" href="data:image/jpeg;base64,{jpeg}"/>',
            f'<g fill="none" stroke-width="{_thickness(segmentation)}">',
            *lines,
            "</g>",
            f'<g fill="none" stroke="{RING}" stroke-width="{_thickness(segmentation)}">',
            *rings,
            *(_svg_bar(bar) for bar in _top_bars(strands, crossings, radius)),
            *_svg_contacts(strands, contacts, segmentation.width),
            *(_svg_unassigned(line, segmentation.width) for line in unassigned),
            "</g>",
            "</svg>",
            "",
        ]
    )


def as_jpeg(rgb: np.ndarray) -> bytes:
    """Encode a picture (h, w, 3) as JPEG, a tenth of a photograph's PNG."""
    bgr = np.ascontiguousarray(rgb[..., ::-1])
    return cv2.imencode(".jpg", bgr, [cv2.IMWRITE_JPEG_QUALITY, QUALITY])[1].tobytes()


def few_points(line: np.ndarray, off: float) -> np.ndarray:
    """Leave points out of a line of which none is farther than `off` [px] from what is left."""
    if len(line) < 3:
        return line
    return cv2.approxPolyDP(line.astype(np.float32)[:, None], off, False)[:, 0]


def _svg_strand(number: int, strand: Strand, segmentation: Segmentation) -> str:
    red, green, blue = _ink(segmentation.colours[strand.colour])
    ink = f"#{red:02x}{green:02x}{blue:02x}"
    points = " ".join(f"{x:.2f},{y:.2f}" for x, y in few_points(strand.line, OFF) + 0.5)
    return f'<polyline stroke="{ink}" points="{points}"><title>strand {number}</title></polyline>'


def _svg_bar(bar: np.ndarray) -> str:
    (x1, y1), (x2, y2) = bar + 0.5
    return f'<line x1="{x1:.2f}" y1="{y1:.2f}" x2="{x2:.2f}" y2="{y2:.2f}"/>'


def _svg_contacts(
    strands: Sequence[Strand], contacts: pd.DataFrame | None, width: float
) -> list[str]:
    """Outlines that say which strands are in unresolved contact."""
    drawn = []
    for number, outline in enumerate(_outlines(strands, contacts, width)):
        assert contacts is not None
        pair = contacts.iloc[number]
        points = " ".join(f"{x:.2f},{y:.2f}" for x, y in outline + 0.5)
        title = f"{pair['strand_a']} and {pair['strand_b']}: unresolved contact"
        drawn.append(f'<polygon points="{points}"><title>{title}</title></polygon>')
    return drawn


def _svg_unassigned(line: np.ndarray, width: float) -> str:
    points = " ".join(f"{x:.2f},{y:.2f}" for x, y in few_points(line, OFF) + 0.5)
    dash = f'stroke-dasharray="{width:.1f}"'
    return f'<polyline {dash} points="{points}"><title>unassigned</title></polyline>'


def _svg_ring(row: dict[Hashable, Any], radius: float) -> str:
    over = "unknown" if pd.isna(row["over"]) else f"strand {row['over']}"
    title = f"{row['strand_a']} x {row['strand_b']}, on top: {over}"
    centre = f'cx="{row["x"] + 0.5:.2f}" cy="{row["y"] + 0.5:.2f}"'
    return f'<circle {centre} r="{radius:.1f}"><title>{title}</title></circle>'
