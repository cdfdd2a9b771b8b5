"""Strands, crossings and interactions of one photograph as tables in pixels and metres."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd

from imaging.centreline import arclength
from imaging.crossings import crossings
from imaging.interactions import densities, events, interactions
from imaging.photo import Photo
from imaging.scale import (
    Request,
    Scale,
    from_filament,
    from_marker,
    from_ruler,
    stated,
    without_markers,
)
from imaging.segment import Segmentation, segment
from imaging.trace import Strand, trace

OTHER_SECTIONS = (0.5, 2.0)  # times n_sec, to show how much the densities depend on it

DICTIONARY = {
    "photo": "name of the photograph's file",
    "strand": "strand number from 1, as in labels.png and overlay.png",
    "s": "arclength from the root (upper end) [px]",
    "x": "position, right of the first pixel's centre [px]",
    "y": "position, below the first pixel's centre [px]",
    "width": "strand width, half-contrast edge to edge [px]",
    "sd": "standard deviation of the centreline across the strand [px]",
    "edges": "strand edges seen at this point: 2, 1, or 0 = hidden under another strand",
    "s_m, x_m, y_m, width_m, sd_m, s_a_m, s_b_m": "the same in metres (only with a scale)",
    "strand_a, strand_b": "the two strands that cross; equal for a self-crossing",
    "kind": "inter = two strands, self = one strand with itself",
    "s_a, s_b": "arclength of the crossing along each strand [px]",
    "angle": "angle between the strands, 0 to pi/2 [rad]",
    "over": "number of the strand on top; empty = unknown",
    "confidence": "probability that `over` is right",
    "section": "section of the curl's axis from 1 at the roots",
    "N": "strands in one interaction: a component of the section's crossing graph",
    "count": "number of such interactions",
    "density_per_px, density_per_m": "count over the section's (or curl's) length [1/px, 1/m]",
    "rule": "how crossings were gathered into interactions",
    "low, high": "exact 95 % Poisson interval of the density [1/px], or [1/m] with suffix _per_m",
}


@dataclass(frozen=True)
class Measured:
    """Everything measured on one photograph; lengths in pixels, `scale` leads to metres."""

    photo: Photo
    segmentation: Segmentation
    strands: list[Strand]
    crossings: pd.DataFrame
    interactions: pd.DataFrame | None
    densities: pd.DataFrame | None
    scale: Scale | None


def measure(photo: Photo, request: Request | None = None, n_sec: int = 20) -> Measured:
    """Measure strands, crossings and interactions of one photograph.

    Parameters
    ----------
    photo : Photo
    request : Request, optional
        Where the scale comes from (`imaging.scale.parse_scale`); none = pixels only.
    n_sec : int
        Sections of the curl's axis.

    Raises
    ------
    Unmeasurable
        When nothing stands out, or the scale cannot be found.
    """
    scale = None
    if request is not None and request.kind in ("marker", "plane"):
        scale, photo = from_marker(photo, *request.numbers, perspective=request.kind == "plane")
    else:
        photo = without_markers(photo)
    segmentation = segment(photo)
    strands = trace(segmentation, photo)
    if request is not None and scale is None:
        scale = _scale(request, strands)
    table = crossings(strands, segmentation)
    found = dense = None
    if len(strands) > 1:
        found = interactions(strands, n_sec, table=table)
        dense = _all_densities(strands, table, n_sec)
    return Measured(photo, segmentation, strands, table, found, dense, scale)


def _scale(request: Request, strands: list[Strand]) -> Scale:
    if request.kind == "stated":
        return stated(*request.numbers)
    if request.kind == "filament":
        return from_filament(strands, *request.numbers)
    x0, y0, x1, y1, length = request.numbers
    return from_ruler((x0, y0), (x1, y1), length)


def _all_densities(strands: list[Strand], table: pd.DataFrame, n_sec: int) -> pd.DataFrame:
    """Densities by the asked rule, by coarser and finer sections, and without sections."""
    radius = float(np.median(np.concatenate([strand.width for strand in strands]))) / 2
    parts = []
    for number in sorted({n_sec, *(max(1, round(n_sec * factor)) for factor in OTHER_SECTIONS)}):
        parts.append(densities(interactions(strands, number, table=table)))
        parts[-1].insert(0, "rule", f"{number} sections")
    parts.append(densities(events(strands, radius, table=table)))
    parts[-1].insert(0, "rule", "touching overlaps")
    return pd.concat(parts, ignore_index=True)


def strands_table(measured: Measured, name: str) -> pd.DataFrame:
    """Return one row a centreline point: photo, strand, s, x, y, width, sd, edges; _m = metres."""
    parts = [
        _strand_rows(number, strand, measured.scale)
        for number, strand in enumerate(measured.strands, start=1)
    ]
    columns = ["strand", "s", "x", "y", "width", "sd", "edges"]
    table = pd.concat(parts, ignore_index=True) if parts else pd.DataFrame(columns=columns)
    table.insert(0, "photo", name)
    return table


def _strand_rows(number: int, strand: Strand, scale: Scale | None) -> pd.DataFrame:
    rows = pd.DataFrame(
        {
            "strand": number,
            "s": arclength(strand.line),
            "x": strand.line[:, 0],
            "y": strand.line[:, 1],
            "width": strand.width,
            "sd": strand.sd,
            "edges": strand.edges,
        }
    )
    if scale is not None:
        place = scale.metres(strand.line)
        rows["s_m"] = arclength(place)
        rows["x_m"], rows["y_m"] = place.T
        rows["width_m"] = strand.width * scale.metres_per_pixel
        rows["sd_m"] = strand.sd * scale.metres_per_pixel
    return rows


def crossings_table(measured: Measured, name: str) -> pd.DataFrame:
    """Return one row a crossing, in pixels and (with a scale) metres."""
    table = measured.crossings.copy()
    table.insert(0, "photo", name)
    if measured.scale is not None:
        place = measured.scale.metres(table[["x", "y"]].to_numpy(float))
        table["x_m"], table["y_m"] = place.T
        for column in ("s_a", "s_b"):
            table[f"{column}_m"] = table[column] * measured.scale.metres_per_pixel
    return table


def densities_table(found: pd.DataFrame | None, scale: Scale | None, name: str) -> pd.DataFrame:
    """Return interactions or densities with the unit in the columns' names."""
    if found is None:
        return pd.DataFrame(columns=["photo", "N", "count", "density_per_px"])
    table = found.rename(columns={"density": "density_per_px"})
    if scale is not None:
        per_metre = 1 / scale.metres_per_pixel
        for column in ("density_per_px", "low", "high"):
            if column in table:
                table[f"{column.removesuffix('_per_px')}_per_m"] = table[column] * per_metre
    table.insert(0, "photo", name)
    return table


def columns_of(tables: Sequence[pd.DataFrame]) -> str:
    """Return a data dictionary (Markdown) of the columns that occur in these tables."""
    present = {column for table in tables for column in table.columns}
    lines = ["| column | meaning |", "|---|---|"]
    for names, meaning in DICTIONARY.items():
        if present & {name.strip() for name in names.split(",")}:
            lines.append(f"| {names} | {meaning} |")
    return "\n".join(lines) + "\n"
