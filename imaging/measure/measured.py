"""Everything that `combing photo` tells of one photograph, in one call."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import pandas as pd

from imaging.correct import Corrections, Hand, beside, correct, put_on_top, read_corrections
from imaging.count.crossings import crossings
from imaging.count.interactions import densities, events, interactions
from imaging.count.unresolved import contact_notes, contact_of, hidden_ends, unresolved
from imaging.errors import Unmeasurable
from imaging.helix.measurement import HelixMeasurement
from imaging.helix.winding import Pair, winding_pairs, wound
from imaging.measure.doubts import doubt_notes
from imaging.measure.quality import exposure, notes_on
from imaging.measure.unassigned import unassigned, unassigned_notes, unassigned_table
from imaging.photo import Photo
from imaging.scale import Request, Scale, calibrate, from_filament
from imaging.segment import Segmentation, segment
from imaging.trace import Strand, trace

OTHER_SECTIONS = (0.5, 2.0)  # times n_sec, to show how much the densities depend on it
BESIDE = "beside"  # the corrections file that lies beside the photograph
EVERY = 25  # centreline points between those at which the scale's sd is averaged


@dataclass(frozen=True)
class Measured:
    """Everything measured on one photograph; lengths in pixels, `scale` leads to metres.

    Attributes
    ----------
    photo : Photo
    segmentation : Segmentation
    strands : list of Strand
    crossings : DataFrame
        From `imaging.crossings`, and ``contact``: the row of `unresolved`, from 1, it lies in.
    unresolved : DataFrame
        From `imaging.unresolved`: contact of which the picture does not tell how often, or where,
        the strands cross.
    interactions, densities : DataFrame or None
        By section and summed; None where there are fewer than two strands. Where the scale has
        perspective, sections are cut in the plane of the strands, and a pixel is the mean one.
    scale : Scale or None
    links : dict
        A `HelixMeasurement` [px] for every pair of strands that wind round each other.
    notes : list of str
        What makes the numbers doubtful, and where.
    hand : Hand
        What was corrected by hand, and what no longer fits.
    unassigned : list of (n, 2) array
        Lines along what stands out from the ground and belongs to no strand [px].
    """

    photo: Photo
    segmentation: Segmentation
    strands: list[Strand]
    crossings: pd.DataFrame
    unresolved: pd.DataFrame
    interactions: pd.DataFrame | None
    densities: pd.DataFrame | None
    scale: Scale | None
    links: dict[Pair, HelixMeasurement] = field(default_factory=dict)
    notes: list[str] = field(default_factory=list)
    hand: Hand = field(default_factory=Hand)
    unassigned: list[np.ndarray] = field(default_factory=list)

    @property
    def scale_sd(self) -> float:
        """Relative sd of the scale, mean over the strands; 0 without a scale."""
        if self.scale is None:
            return 0.0
        points = np.concatenate([strand.line[::EVERY] for strand in self.strands])
        return float(self.scale.sd_at(points).mean())


def measure(
    photo: Photo,
    request: Request | None = None,
    n_sec: int = 20,
    *,
    corrections: Corrections | str | Path | None = BESIDE,
) -> Measured:
    """Measure strands, crossings, interactions and link density of one photograph.

    Parameters
    ----------
    photo : Photo
    request : Request, optional
        Where the scale comes from (`imaging.scale.parse_scale`); none = pixels only.
    n_sec : int
        Sections of the curl's axis.
    corrections : Corrections, path or None
        What a hand says of the photograph; a file of `imaging.read_corrections`, or None. By
        default the file beside the photograph, ``PHOTO.corrections.json``, if there is one.

    Raises
    ------
    Unmeasurable
        When nothing stands out, the scale cannot be found, or the corrections are of another
        photograph or cannot be read.
    """
    said = corrections_for(photo, corrections)
    scale, photo = calibrate(photo, request)
    segmentation, strands, hand = strands_of(photo, said)
    if request is not None and scale is None:
        scale = from_filament(full_widths(strands), *request.numbers)
        scale = scale.with_doubt(request.length_sd)
    table = put_on_top(crossings(strands, segmentation), strands, hand)
    contacts = unresolved(strands, table)
    table["contact"] = contact_of(table, contacts)
    found = dense = None
    if len(strands) > 1:
        lines, flat, flat_contacts = _in_plane(strands, table, contacts, scale)
        found = interactions(lines, n_sec, table=flat, contacts=flat_contacts)
        dense = _all_densities(lines, flat, flat_contacts, n_sec, _radius(strands))
    links, winding = wound(photo, strands, winding_pairs(table))
    notes = hand.notes() + notes_on(photo, segmentation, strands)
    notes += contact_notes(contacts, found)
    notes += hidden_ends(strands) + doubt_notes(strands) + winding
    left = unassigned(segmentation, strands)
    notes += unassigned_notes(unassigned_table(left))
    return Measured(
        photo, segmentation, strands, table, contacts, found, dense, scale, links, notes, hand, left
    )


def corrections_for(photo: Photo, asked: Corrections | str | Path | None = BESIDE) -> Corrections:
    """Find what a hand says of a photograph: as given, from a file, or from the file beside it."""
    if isinstance(asked, Corrections):
        return asked
    path = beside(photo.source) if asked == BESIDE else asked
    return Corrections() if path is None else read_corrections(path)


def strands_of(
    photo: Photo, said: Corrections | None = None
) -> tuple[Segmentation, list[Strand], Hand]:
    """Find the strands of a photograph and correct them as a hand says.

    Parameters
    ----------
    photo : Photo
    said : Corrections, optional
        By default those beside the photograph.

    Raises
    ------
    Unmeasurable
        When nothing stands out, or the corrections are of another photograph.
    """
    said = corrections_for(photo) if said is None else said
    try:
        segmentation = segment(photo)
    except Unmeasurable as error:
        reason = exposure(photo)
        raise Unmeasurable(f"{error} ({reason})") if reason else error from None
    strands, hand = correct(photo, segmentation, trace(segmentation, photo), said)
    if not strands:
        raise Unmeasurable(f"{photo.source}: what stands out cannot be followed as a strand")
    return segmentation, strands, hand


def _in_plane(
    strands: list[Strand], table: pd.DataFrame, contacts: pd.DataFrame, scale: Scale | None
) -> tuple[list[np.ndarray], pd.DataFrame, pd.DataFrame]:
    """Centrelines, crossings and contacts as seen from straight above, in mean pixels."""
    lines = [strand.line for strand in strands]
    if scale is None or scale.plane is None:
        return lines, table, contacts
    pixel = scale.metres_per_pixel
    table, contacts = table.copy(), contacts.copy()
    for moved, end in ((table, ""), (contacts, "_from"), (contacts, "_to")):
        columns = [f"x{end}", f"y{end}"]
        moved[columns] = scale.metres(moved[columns].to_numpy(float)) / pixel
    return [scale.metres(line) / pixel for line in lines], table, contacts


def _radius(strands: list[Strand]) -> float:
    return float(np.median(np.concatenate([strand.width for strand in strands]))) / 2


def _all_densities(
    lines: list[np.ndarray],
    table: pd.DataFrame,
    contacts: pd.DataFrame,
    n_sec: int,
    radius: float,
) -> pd.DataFrame:
    """Densities by the asked rule, by coarser and finer sections, and without sections."""
    parts = []
    for number in sorted({n_sec, *(max(1, round(n_sec * factor)) for factor in OTHER_SECTIONS)}):
        parts.append(densities(interactions(lines, number, table=table, contacts=contacts)))
        parts[-1].insert(0, "rule", f"{number} sections")
    parts.append(densities(events(lines, radius, table=table)))
    parts[-1].insert(0, "rule", "touching overlaps")
    return pd.concat(parts, ignore_index=True)


def full_widths(strands: Sequence[Strand]) -> np.ndarray:
    """Median width [px] of each strand of which some place is seen in full width."""
    whole = [s.width[s.edges == 2] for s in strands]
    return np.array([np.median(width) for width in whole if len(width)])
