"""Strands, crossings, interactions and link density of one photograph in pixels and metres."""

from collections.abc import Sequence
from itertools import product

import numpy as np
import pandas as pd

from imaging.helix.measurement import HelixMeasurement
from imaging.measure import Measured
from imaging.measure.unassigned import unassigned_table as places_of
from imaging.scale import Scale
from imaging.trace import Strand
from imaging.trace.centreline import arclength, normals

COVER = 1.96  # sds in a 95 % interval
TANGENT = 1.5  # strand widths; at crossings, where edges are hidden, centrelines waver over less
LINK_COLUMNS = ["strand_a", "strand_b", "s", "x", "y", "link_per_px", "sd_per_px", "R", "R_sd"]
DICTIONARY = {
    "photo": "name of the photograph's file",
    "strand": "strand number from 1, as in labels.png and overlay.jpg",
    "s": "arclength from the root (upper end) [px]; in link.csv along the axis of the pair",
    "x": "position, right of the first pixel's centre [px]; in link.csv of the axis",
    "y": "position, below the first pixel's centre [px]; in link.csv of the axis",
    "width": "strand width, half-contrast edge to edge [px]",
    "sd": "standard deviation of the centreline across the strand [px]",
    "edges": "strand edges seen at this point: 2, 1, or 0 = hidden under another strand",
    "s_m, x_m, y_m, width_m, sd_m, s_a_m, s_b_m, R_m, R_sd_m": (
        "the same as without _m, in metres in the plane of the strands (only with a scale); the "
        "sd of the scale is not in them, see scale_sd"
    ),
    "scale_sd": (
        "relative standard deviation of the scale: of every length in metres of the row, "
        "common to the photograph"
    ),
    "strand_a, strand_b": "the two strands that cross or wind; equal for a self-crossing",
    "kind": "inter = two strands, self = one strand with itself",
    "s_a, s_b": "arclength of the crossing along each strand [px]",
    "angle": "angle between the strands, 0 to pi/2 [rad]; with perspective, in their plane",
    "over": "number of the strand on top; empty = unknown",
    "confidence": "probability that `over` is right",
    "contact": (
        "row of unresolved.csv, from 1, that the crossing lies in, where the number or the place "
        "of crossings is a guess; empty = resolved"
    ),
    "crossings": "crossings of crossings.csv that lie in the unresolved contact; may be 0",
    "s_a_from, s_a_to, s_b_from, s_b_to": "extent of unresolved contact along both strands [px]",
    "x_from, y_from, x_to, y_to": "where on strand_a unresolved contact begins and ends [px]",
    "s_a_from_m, s_a_to_m, s_b_from_m, s_b_to_m, x_from_m, y_from_m, x_to_m, y_to_m": (
        "the same [m] (only with a scale)"
    ),
    "length": "length of a ridge that is seen and belongs to no strand [px]",
    "length_m": "the same [m] (only with a scale)",
    "by": "what a hand did to the strand: drawn, joined, split, exchanged; empty = as measured",
    "over_by": "hand = who is on top was said by hand; empty = as measured",
    "corrections": "corrections by hand that changed something in the photograph",
    "section": "section of the curl's axis from 1 at the roots",
    "N": "strands in one interaction: a component of the section's crossing graph",
    "count": "number of such interactions",
    "unresolved": (
        "how many of `count` rest on unresolved contact: would not be there, or of other strands, "
        "if all strands in it crossed wherever they may, or none did; empty = the rule cannot tell"
    ),
    "density_per_px, density_per_m": "count over the section's (or curl's) length [1/px, 1/m]",
    "rule": "how crossings were gathered into interactions",
    "low, high": "exact 95 % Poisson interval of the density [1/px]",
    "low_per_m, high_per_m": "the same [1/m], widened by the sd of the scale",
    "link_per_px, link_per_m": (
        "link density lambda [1/px, 1/m], right-handed > 0; empty = not resolved"
    ),
    "sd_per_px, sd_per_m": "its standard deviation; per metre with that of the scale",
    "R, R_sd": "helix radius and its standard deviation [px]",
}


def strands_table(measured: Measured, name: str) -> pd.DataFrame:
    """Return one row a centreline point: photo, strand, s, x, y, width, sd, edges; _m = metres."""
    handled = zip(measured.strands, measured.hand.by, strict=True)
    parts = [
        _strand_rows(number, strand, measured.scale).assign(by=by)
        for number, (strand, by) in enumerate(handled, start=1)
    ]
    return _finished(pd.concat(parts, ignore_index=True), measured, name)


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
        pixel = scale.step(strand.line, normals(strand.line))
        rows["s_m"] = arclength(place)
        rows["x_m"], rows["y_m"] = place.T
        rows["width_m"] = strand.width * pixel
        rows["sd_m"] = strand.sd * pixel
    return rows


def crossings_table(measured: Measured, name: str) -> pd.DataFrame:
    """Return one row a crossing, in pixels and (with a scale) metres."""
    table = measured.crossings.copy()
    if measured.scale is not None:
        scale = measured.scale
        x, y = scale.metres(table[["x", "y"]].to_numpy(float)).T
        table = table.assign(x_m=x, y_m=y)
        places = [scale.metres(strand.line) for strand in measured.strands]
        lengths = [arclength(place) for place in places]
        for which in "ab":
            table[f"s_{which}_m"] = _along(measured.strands, table, which, lengths)
        if scale.plane is not None:
            pairs = zip(measured.strands, places, strict=True)
            headings = [_heading(place, strand.width) for strand, place in pairs]
            heading = [_along(measured.strands, table, which, headings) for which in "ab"]
            turned = np.abs(np.mod(np.subtract(*heading) + np.pi / 2, np.pi) - np.pi / 2)
            table["angle"] = turned
    return _finished(table, measured, name)


def unresolved_table(measured: Measured, name: str) -> pd.DataFrame:
    """Return one row a stretch of unresolved contact, in pixels and (with a scale) metres."""
    table = measured.unresolved.copy()
    if measured.scale is not None:
        scale = measured.scale
        lengths = [arclength(scale.metres(strand.line)) for strand in measured.strands]
        for which, end in product("ab", ("from", "to")):
            at = table.rename(columns={f"s_{which}_{end}": f"s_{which}"})
            table[f"s_{which}_{end}_m"] = _along(measured.strands, at, which, lengths)
        for end in ("from", "to"):
            places = scale.metres(table[[f"x_{end}", f"y_{end}"]].to_numpy(float))
            table[[f"x_{end}_m", f"y_{end}_m"]] = places
    return _finished(table, measured, name)


def unassigned_table(measured: Measured, name: str) -> pd.DataFrame:
    """Return one row a ridge that is seen and belongs to no strand, its middle and its length."""
    table = places_of(measured.unassigned)
    if measured.scale is not None:
        scale = measured.scale
        x, y = scale.metres(table[["x", "y"]].to_numpy(float)).T
        lengths = [arclength(scale.metres(line))[-1] for line in measured.unassigned]
        table = table.assign(x_m=x, y_m=y, length_m=np.array(lengths, float))
    return _finished(table, measured, name)


def _along(
    strands: Sequence[Strand], table: pd.DataFrame, which: str, quantities: Sequence[np.ndarray]
) -> np.ndarray:
    """Interpolate what is known along each strand at the crossings' arclengths (n,)."""
    values = np.empty(len(table))
    for number, (strand, quantity) in enumerate(zip(strands, quantities, strict=True), start=1):
        own = (table[f"strand_{which}"] == number).to_numpy()
        values[own] = np.interp(table[f"s_{which}"][own], arclength(strand.line), quantity)
    return values


def _heading(place: np.ndarray, width: np.ndarray) -> np.ndarray:
    """Direction of a centreline [rad], by chords of TANGENT widths on both sides."""
    reach = max(1, round(TANGENT * float(np.median(width))))  # points are about a pixel apart
    at = np.arange(len(place))
    last = len(place) - 1
    x, y = (place[np.minimum(at + reach, last)] - place[np.maximum(at - reach, 0)]).T
    return np.unwrap(np.arctan2(y, x))


def densities_table(found: pd.DataFrame | None, measured: Measured, name: str) -> pd.DataFrame:
    """Return interactions or densities with the unit in the columns' names."""
    if found is None:
        found = pd.DataFrame({"N": [], "count": [], "density": []}).astype({"N": int, "count": int})
    table = found.rename(columns={"density": "density_per_px"})
    if measured.scale is not None:
        per_metre = 1 / measured.scale.metres_per_pixel
        density = table["density_per_px"] * per_metre
        table["density_per_m"] = density
        if "low" in table:
            low, high = table["low"] * per_metre, table["high"] * per_metre
            reach = COVER * measured.scale_sd
            table["low_per_m"] = (density - np.hypot(density - low, reach * density)).clip(lower=0)
            table["high_per_m"] = density + np.hypot(high - density, reach * high)
    return _finished(table, measured, name)


def link_table(measured: Measured, name: str) -> pd.DataFrame:
    """Return lambda(s) with R for every pair of strands that wind; no rows where none do."""
    if not measured.links:
        empty = pd.DataFrame({column: np.empty(0) for column in LINK_COLUMNS})
        return _finished(empty.astype({"strand_a": int, "strand_b": int}), measured, name)
    parts = [
        _link_rows(helix, measured).assign(strand_a=a, strand_b=b)
        for (a, b), helix in measured.links.items()
    ]
    rows = pd.concat(parts, ignore_index=True)
    rest = [column for column in rows if column not in LINK_COLUMNS]
    return _finished(rows[LINK_COLUMNS + rest], measured, name)


def _link_rows(helix: HelixMeasurement, measured: Measured) -> pd.DataFrame:
    link, phase, scale = helix.link_density, helix.phase, measured.scale
    rows = pd.DataFrame(
        {
            "s": link["s"],
            "x": phase["x"],
            "y": phase["y"],
            "link_per_px": link["link"],
            "sd_per_px": link["sd"],
            "R": phase["R"],
            "R_sd": phase["R_sd"],
        }
    )
    if scale is not None:
        axis = helix.axis
        across = normals(axis)
        along = scale.step(axis, np.stack([across[:, 1], -across[:, 0]], axis=1))
        # The axis may lean out of the picture: its own length over that in the picture.
        longer = helix.link_density["s"].iloc[-1] / arclength(axis)[-1]
        rows["s_m"] = longer * arclength(scale.metres(axis))
        rows["x_m"], rows["y_m"] = scale.metres(axis).T
        rows["link_per_m"] = rows["link_per_px"] / along
        rows["sd_per_m"] = np.hypot(
            rows["sd_per_px"] / along, measured.scale_sd * rows["link_per_m"]
        )
        step = scale.step(axis, across)
        rows["R_m"], rows["R_sd_m"] = rows["R"] * step, rows["R_sd"] * step
    return rows


def _finished(table: pd.DataFrame, measured: Measured, name: str) -> pd.DataFrame:
    """Put the photograph's name first; last, corrections and the scale's relative sd, if any."""
    table = table.copy()
    table.insert(0, "photo", pd.Series(name, table.index, str))
    if measured.hand.outcomes:
        table["corrections"] = measured.hand.applied
    return table if measured.scale is None else table.assign(scale_sd=measured.scale_sd)


def columns_of(tables: Sequence[pd.DataFrame]) -> str:
    """Return a data dictionary (Markdown) of the columns that occur in these tables."""
    present = {column for table in tables for column in table.columns}
    lines = ["| column | meaning |", "|---|---|"]
    for names, meaning in DICTIONARY.items():
        if present & {name.strip() for name in names.split(",")}:
            lines.append(f"| {names} | {meaning} |")
    return "\n".join(lines) + "\n"
