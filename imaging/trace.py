"""Segmentation -> strands: centrelines through crossings, with widths, spread and kind of ends.

Strategy, for each colour: skeletonise what is seen of it; cut the skeleton at its junctions; join
the pieces across junctions and under other strands by one global matching on bending and on how
much of the join lies in the open; move the joined line to the middle between the strand's edges.
"""

from dataclasses import dataclass
from functools import partial

import cv2
import numpy as np

from imaging.branches import End, branches, ends_of
from imaging.centreline import arclength, normals, refine, sample
from imaging.contact import known as know
from imaging.contact import place
from imaging.matching import bridge, chains, join
from imaging.photo import Photo
from imaging.segment import Segmentation

ROUNDS = 2  # of placing strands by what the others leave unexplained
SHORTEST = 5.0  # strand widths; a shorter chain is a speck
WHOLE = 3.0  # strand widths on which most of the width must be seen; else it is another's rim
SEEN = 0.1  # of the length, the same
SHARE = 0.3  # of the longest strand of the same colour; a shorter piece is a remnant


@dataclass(frozen=True)
class Strand:
    """One strand in the picture.

    Attributes
    ----------
    line : (n, 2) float64 array
        Centreline from the upper end (root) to the lower (tip), about 1 px apart; pixel centres
        at integer coordinates, x right, y down [px].
    width, sd : (n,) arrays
        Local width, and standard deviation of the centreline across the strand [px].
    edges : (n,) int array
        How many of the strand's two edges are seen at each point: 0 = hidden, 1, 2.
    colour : int
        Index into the segmentation's colours.
    ends : (str, str)
        ``free``, ``clipped`` by the picture's border, or ``hidden`` under another strand.
    """

    line: np.ndarray
    width: np.ndarray
    sd: np.ndarray
    edges: np.ndarray
    colour: int
    ends: tuple[str, str]


def trace(segmentation: Segmentation, photo: Photo | None = None) -> list[Strand]:
    """Trace every strand of a segmented photograph.

    Parameters
    ----------
    segmentation : Segmentation
    photo : Photo, optional
        Not needed; accepted so that calls read ``trace(segment(photo), photo)``.

    Returns
    -------
    list of Strand
        In the order of the segmentation's colours; longer first within a colour.
    """
    covered = cv2.dilate((segmentation.labels > 0).astype(np.uint8), np.ones((3, 3), np.uint8)) > 0
    coverage = segmentation.membership.sum(axis=0)
    strands = []
    for colour in range(len(segmentation.colours)):
        strands += _strands_of(segmentation, colour, covered, coverage)
    if segmentation.contrast is None:
        return strands
    for _ in range(ROUNDS):
        strands = _settled(strands, segmentation, coverage)
    return strands


def _settled(
    strands: list[Strand], segmentation: Segmentation, coverage: np.ndarray
) -> list[Strand]:
    """Place each strand anew where others hide its edges, all others as they are."""
    picture = segmentation.contrast
    assert picture is not None
    known = [know(s.line, s.width, s.edges, picture) for s in strands]
    found = []
    for number, strand in enumerate(strands):
        if (strand.edges == 2).all():
            found.append(strand)
            continue
        others = [other for i, other in enumerate(known) if i != number]
        fine = refine(
            strand.line,
            segmentation.membership[strand.colour],
            coverage,
            segmentation.width,
            rounds=1,
            place=partial(place, own=known[number], others=others, picture=picture),
        )
        found.append(Strand(*fine, strand.colour, strand.ends))
    return found


def _strands_of(
    segmentation: Segmentation, colour: int, covered: np.ndarray, coverage: np.ndarray
) -> list[Strand]:
    width = segmentation.width
    own = segmentation.membership[colour]
    mask = segmentation.labels == colour + 1
    paths = [_centred(path, own, coverage, width) for path in branches(mask, width)]
    ends = ends_of(paths, width)
    lengths = [arclength(path)[-1] for path in paths]
    found = chains(len(paths), join(ends, lengths, covered, mask, width))
    lines = [_connected(walk, paths, ends) for walk in found]
    strands = [
        _strand(line, own, coverage, segmentation.labels, width, colour)
        for line in _long_enough(lines, width)
    ]
    return [strand for strand in strands if _is_whole(strand, own, width)]


def _is_whole(strand: Strand, own: np.ndarray, width: float) -> bool:
    """Tell a strand from another's rim: both edges, or its colour well to both sides, are seen."""
    aside = 0.35 * width * normals(strand.line)
    beside = np.stack([strand.line - aside, strand.line + aside], axis=1)
    whole = (strand.edges == 2) | (sample(own, beside) >= 0.5).all(axis=1)
    return bool(whole.sum() > max(WHOLE * width, SEEN * len(whole)))


def _centred(path: np.ndarray, own: np.ndarray, coverage: np.ndarray, width: float) -> np.ndarray:
    """Skeleton -> middle of the strand; a skeleton leans away from whatever hides a side."""
    if len(path) <= 1.5 * width:
        return path
    return refine(path, own, coverage, width, rounds=1).line


def _connected(
    walk: list[tuple[int, bool]], paths: list[np.ndarray], ends: list[End]
) -> np.ndarray:
    """Points of a chain of branches with bridges between them."""
    parts = []
    for step, (branch, reverse) in enumerate(walk):
        if step:
            before, was_reverse = walk[step - 1]
            parts.append(
                bridge(ends[2 * before + (not was_reverse)], ends[2 * branch + reverse])[1:-1]
            )
        parts.append(paths[branch][::-1] if reverse else paths[branch])
    return np.concatenate(parts)


def _long_enough(lines: list[np.ndarray], width: float) -> list[np.ndarray]:
    lines = sorted(lines, key=lambda line: -arclength(line)[-1])
    if not lines:
        return []
    least = max(SHORTEST * width, SHARE * arclength(lines[0])[-1])
    return [line for line in lines if arclength(line)[-1] >= least]


def _strand(
    line: np.ndarray,
    own: np.ndarray,
    coverage: np.ndarray,
    labels: np.ndarray,
    width: float,
    colour: int,
) -> Strand:
    if line[0, 1] > line[-1, 1]:
        line = line[::-1]
    line = _extended(_extended(line, own, width)[::-1], own, width)[::-1]
    fine = refine(line, own, coverage, width)
    ends = (_kind(fine.line[::-1], labels, colour, width), _kind(fine.line, labels, colour, width))
    return Strand(*fine, colour, ends)


def _extended(line: np.ndarray, own: np.ndarray, width: float) -> np.ndarray:
    """Lengthen a line beyond its last point for as long as its colour is seen."""
    tail = line[-max(3, int(2 * width)) :]
    direction = tail[-1] - tail[0]
    direction = direction / max(np.hypot(*direction), 1e-9)
    ahead = tail[-1] + np.arange(1, int(3 * width) + 1)[:, None] * direction
    x, y = np.round(ahead).astype(int).T
    inside = (x >= 0) & (y >= 0) & (x < own.shape[1]) & (y < own.shape[0])
    seen = inside & (own[y.clip(0, own.shape[0] - 1), x.clip(0, own.shape[1] - 1)] >= 0.5)
    reach = len(seen) if seen.all() else int(seen.argmin())
    return np.concatenate([line, ahead[:reach]])


def _kind(line: np.ndarray, labels: np.ndarray, colour: int, width: float) -> str:
    """Tell what the last point of a line is: clipped, hidden, or free."""
    height, across = labels.shape
    x, y = line[-1]
    if min(x, y, across - 1 - x, height - 1 - y) < width:
        return "clipped"
    tangent = line[-1] - line[-min(len(line), max(3, int(width)))]
    tangent = tangent / max(np.hypot(*tangent), 1e-9)
    beyond = np.round(line[-1] + 0.75 * width * tangent).astype(int)
    shown = labels[beyond[1].clip(0, height - 1), beyond[0].clip(0, across - 1)]
    return "hidden" if shown not in (0, colour + 1) else "free"
