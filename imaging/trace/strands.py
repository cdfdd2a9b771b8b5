"""Segmentation -> strands: centrelines through crossings, with widths, spread and kind of ends.

Strategy: skeletonise what is seen of each colour; cut the skeletons at their junctions; join the
pieces across junctions and under other strands by one global matching on bending and on how much of
the join lies in the open, and two colours where one strand changes from one to the other; move the
joined lines to the middle between the strand's edges.
"""

from dataclasses import dataclass, field, replace
from functools import partial

import cv2
import numpy as np
from scipy.spatial import cKDTree

from imaging.photo import Photo
from imaging.segment import Segmentation
from imaging.trace.branches import End, branches, ends_of
from imaging.trace.centreline import (
    Sections,
    arclength,
    centred,
    dense,
    normals,
    refine,
    sample,
    sections_of,
    settle,
)
from imaging.trace.chain import Chain, connected, main_tone
from imaging.trace.contact import Known, moved, place
from imaging.trace.contact import known as know
from imaging.trace.corners import without_corners
from imaging.trace.crest_chains import ridge_chains
from imaging.trace.doubled import broad_parts, drawn, hold_apart, is_in, keep_sides, stems
from imaging.trace.exchange import bundled_chains
from imaging.trace.matching import Gain, chains, doubtful, join, refund, within_colour
from imaging.trace.tips import led_on
from imaging.trace.two_tone import beneath, head_on, own_membership

CREST = 4.0  # relative sd of a ridge's crest, where no edge is seen
COURSE = 0.0  # the same of strands of one colour that run together: their whole course is known
ROUNDS = 2  # of placing strands by what the others leave unexplained
SHORTEST = 5.0  # strand widths; a shorter chain is a speck
WHOLE = 3.0  # strand widths on which most of the width must be seen; else it is another's rim
SEEN = 0.1  # of the length, the same
ALONE = 10.0  # strand widths; what is longer and ends in the open is a strand, however short
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
    tones : (n,) int array
        Index of the strand's colour at each point into the segmentation's colours; one and the same
        unless the strand changes its colour.
    ends : (str, str)
        ``free``, ``clipped`` by the picture's border, or ``hidden`` under another strand.
    doubts : (k, 2) array
        Places where its going on as it does is a guess: another strand of its colour could, or its
        colour changes where it is not seen [px].
    """

    line: np.ndarray
    width: np.ndarray
    sd: np.ndarray
    edges: np.ndarray
    tones: np.ndarray
    ends: tuple[str, str]
    doubts: np.ndarray = field(default_factory=lambda: np.empty((0, 2)))

    @property
    def colour(self) -> int:
        """The colour that most of the strand has."""
        return main_tone(self.tones)


Draft = tuple[Strand, Sections]  # a strand, and its cross-sections


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
    covered = cv2.dilate(segmentation.labels, np.ones((3, 3), np.uint8)) > 0
    coverage = segmentation.coverage
    if coverage is None:
        coverage = segmentation.membership.sum(axis=0)
    chained, rough = _chained(segmentation, covered, coverage)
    drafts = [_strand(chain, segmentation, coverage, rough) for chain in chained]
    drafts = [draft for draft in drafts if _is_whole(draft[0], segmentation, coverage)]
    drafts = _with_tips(drafts, segmentation, covered, coverage, rough)
    strands = [strand for strand, _ in drafts]
    if segmentation.contrast is None or rough == COURSE:
        return strands
    return _settled(strands, [sections for _, sections in drafts], segmentation, coverage)


def _with_tips(
    drafts: list[Draft],
    segmentation: Segmentation,
    covered: np.ndarray,
    coverage: np.ndarray,
    rough: float | None,
) -> list[Draft]:
    """Lead strands that disappear under others on to where they show again."""
    found = list(drafts)
    for colour in range(len(segmentation.colours)):
        own = {n: strand for n, (strand, _) in enumerate(found) if colour in strand.tones}
        hidden = [
            (n, last)
            for n, strand in own.items()
            for last in (False, True)
            if strand.ends[last] == "hidden" and strand.tones[-last] == colour
        ]
        if not hidden:
            continue
        lines = {n: strand.line for n, strand in own.items()}
        seen = segmentation.labels == colour + 1
        for n, line in led_on(lines, hidden, seen, covered, segmentation.width).items():
            tones = _nearest_tones(line, own[n].line, own[n].tones)
            found[n] = _strand(Chain(line, tones, own[n].doubts), segmentation, coverage, rough)
    return found


def _settled(
    strands: list[Strand], found: list[Sections], segmentation: Segmentation, coverage: np.ndarray
) -> list[Strand]:
    """Place each strand anew where others hide its edges, all others as they are; in rounds."""
    picture, width = segmentation.contrast, segmentation.width
    assert picture is not None
    owns = [own_membership(segmentation, coverage, s.line, s.tones) for s in strands]
    known = [know(one.line, one.width, one.edges, picture) for one in found]
    for _ in range(ROUNDS):
        found = [
            settle(
                one, own, coverage, width, partial(place, own=it, others=others, picture=picture)
            )
            if (one.sd != 1).any()
            else one
            for one, own, it, others in zip(found, owns, known, _all_but_each(known), strict=True)
        ]
        known = [moved(it, one.line) for it, one in zip(known, found, strict=True)]
    return [_placed(strand, one, width) for strand, one in zip(strands, found, strict=True)]


def _all_but_each(known: list[Known]) -> list[list[Known]]:
    return [known[:i] + known[i + 1 :] for i in range(len(known))]


def _placed(strand: Strand, found: Sections, width: float) -> Strand:
    fine = dense(found, width)
    tones = _nearest_tones(fine.line, strand.line, strand.tones)
    return replace(strand, **fine._asdict(), tones=tones)


def _nearest_tones(line: np.ndarray, known: np.ndarray, tones: np.ndarray) -> np.ndarray:
    """Colours (n,) along a line, from those at the points of another close to it."""
    if (tones == tones[0]).all():
        return np.full(len(line), tones[0])
    return tones[cKDTree(known).query(line)[1]]


def _chained(
    segmentation: Segmentation, covered: np.ndarray, coverage: np.ndarray
) -> tuple[list[Chain], float | None]:
    """Chains of pieces that are long enough to be a strand, and the sd of lines where none shows.

    It is relative to where both edges show; None where lines between pieces are but bridges.
    """
    if segmentation.pieces is not None:
        return ridge_chains(segmentation.pieces, covered, segmentation.width), CREST
    if len(segmentation.colours) == 1:
        bundled = bundled_chains(segmentation, coverage)
        if bundled is not None:
            return _long_enough(bundled, segmentation.labels, segmentation.width), COURSE
    pieces = _pieces(segmentation, coverage)
    ends = ends_of([path for path, _ in pieces], segmentation.width)
    refunds, gains, guesses = _choices(pieces, ends, segmentation, covered, coverage)
    joins = join(ends, refunds, gains)
    unsure = doubtful(joins, gains) | (set(joins) & guesses)
    walks = chains(len(pieces), joins)
    found = [connected(walk, pieces, ends, unsure) for walk in walks]
    return _long_enough(found, segmentation.labels, segmentation.width), None


def _choices(
    pieces: list[tuple[np.ndarray, int]],
    ends: list[End],
    segmentation: Segmentation,
    covered: np.ndarray,
    coverage: np.ndarray,
) -> tuple[list[float], list[Gain], set[tuple[int, int]]]:
    """Tell what may be left out, what may be joined, and which joins change colour unseen."""
    width, labels = segmentation.width, segmentation.labels
    colours = np.array([colour for _, colour in pieces], int)
    seen = head_on(ends, np.repeat(colours, 2), coverage, width)
    known = {(i, j) for i, j, _ in seen}
    unseen = [
        gain
        for gain in beneath(ends, np.repeat(colours, 2), labels, width)
        if gain[:2] not in known
    ]
    refunds, gains = [], seen + unseen
    for colour in range(len(segmentation.colours)):
        first, last = np.searchsorted(colours, [colour, colour + 1]).tolist()
        paths, own_ends = [path for path, _ in pieces[first:last]], ends[2 * first : 2 * last]
        broad = broad_parts(labels == colour + 1, width)
        double = stems(own_ends, width) | np.array([is_in(path, broad) for path in paths], bool)
        single = [path for path, two in zip(paths, double, strict=True) if not two]
        own = drawn(single, labels.shape, width)
        if broad.any():
            own &= ~broad
        apart = [
            i
            for i in np.flatnonzero(double).tolist()
            if hold_apart(paths[i], segmentation.membership[colour], coverage, width)
        ]
        within = within_colour(own_ends, covered, own, width)
        within = keep_sides(within, own_ends, apart, width)
        lengths = [float(arclength(path)[-1]) for path in paths]
        refunds += [refund(*piece, width) for piece in zip(lengths, double.tolist(), strict=True)]
        gains += [(i + 2 * first, j + 2 * first, gain) for i, j, gain in within]
    return refunds, gains, {(i, j) for i, j, _ in unseen}


def _pieces(segmentation: Segmentation, coverage: np.ndarray) -> list[tuple[np.ndarray, int]]:
    """Pieces of the centrelines of all colours, each with its colour, in the colours' order."""
    pieces = []
    for colour, own in enumerate(segmentation.membership):
        whole = branches(segmentation.labels == colour + 1, segmentation.width)
        paths = [part for path in whole for part in without_corners(path, segmentation.width)]
        centred_paths = _centred(paths, own, coverage, segmentation.width)
        pieces += [(path, colour) for path in centred_paths]
    return pieces


def _is_whole(strand: Strand, segmentation: Segmentation, coverage: np.ndarray) -> bool:
    """Tell a strand from another's rim: both edges, or its colour well to both sides, are seen."""
    width = segmentation.width
    own = own_membership(segmentation, coverage, strand.line, strand.tones)
    aside = 0.35 * width * normals(strand.line)
    beside = np.stack([strand.line - aside, strand.line + aside], axis=1)
    whole = (strand.edges == 2) | (sample(own, beside) >= 0.5).all(axis=1)
    return bool(whole.sum() > max(WHOLE * width, SEEN * len(whole)))


def _centred(
    paths: list[np.ndarray], own: np.ndarray, coverage: np.ndarray, width: float
) -> list[np.ndarray]:
    """Skeletons -> middles of strands; a skeleton leans away from whatever hides a side."""
    long = [i for i, path in enumerate(paths) if len(path) > 1.5 * width]
    found = dict(zip(long, centred([paths[i] for i in long], own, coverage, width), strict=True))
    return [found.get(i, path) for i, path in enumerate(paths)]


def _long_enough(chained: list[Chain], labels: np.ndarray, width: float) -> list[Chain]:
    """Drop specks and remnants; the rest in the order of the colours, longer first.

    A remnant ends under another strand; what ends in the open at both ends may be a short strand.
    """
    longest: dict[int, float] = {}
    ranked = []
    for chain in chained:
        colour, length = main_tone(chain.tones), float(arclength(chain.line)[-1])
        longest[colour] = max(longest.get(colour, 0), length)
        ranked.append((colour, length, chain))
    ranked.sort(key=lambda one: (one[0], -one[1]))
    return [
        chain
        for colour, length, chain in ranked
        if length >= max(SHORTEST * width, SHARE * longest[colour])
        or (length >= ALONE * width and _in_the_open(chain.line, labels, colour, width))
    ]


def _in_the_open(line: np.ndarray, labels: np.ndarray, colour: int, width: float) -> bool:
    return all(_kind(way, labels, colour, width) == "free" for way in (line, line[::-1]))


def _strand(
    chain: Chain, segmentation: Segmentation, coverage: np.ndarray, rough: float | None
) -> Draft:
    """Strand along a chain, and its cross-sections."""
    width, labels = segmentation.width, segmentation.labels
    line, tones, doubts = chain
    if line[0, 1] > line[-1, 1]:
        line, tones, doubts = line[::-1], tones[::-1], doubts[::-1]
    own = own_membership(segmentation, coverage, line, tones)
    longer = _extended(_extended(line, own, width)[::-1], own, width)[::-1]
    if rough == COURSE:
        found = sections_of(longer, own, coverage, width)
    else:
        found = refine(longer, own, coverage, width, rough)
    fine = dense(found, width)
    ends = (
        _kind(fine.line[::-1], labels, tones[0], width),
        _kind(fine.line, labels, tones[-1], width),
    )
    return Strand(*fine, _nearest_tones(fine.line, line, tones), ends, doubts), found


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
