"""What is known of the strands as a whole: their colours, the ground's, and their number."""

from typing import NamedTuple

import cv2
import numpy as np

from imaging.correct.anchors import direction
from imaging.correct.schema import Corrections
from imaging.correct.steps import (
    ALREADY,
    APPLIED,
    MISFIT,
    Handled,
    Outcome,
    Scene,
    connected,
    turned,
)
from imaging.photo import Photo
from imaging.trace import Strand
from imaging.trace.centreline import arclength

FAR = 25.0  # Lab units, lightness halved; a strand farther from every named colour is none
LIKE_GROUND = 10.0  # the same; a strand nearer to the named ground is the ground's
GAP = 12.0  # strand widths that a join may bridge
TURN = 1.2  # rad that it may turn by
COLOUR = 30.0  # Lab units that it may change by
PRICE = 0.5  # of a join that bridges, turns and changes as much as it may, beside a median strand


def of_colours(
    strands: list[Handled], said: Corrections, scene: Scene
) -> tuple[list[Handled], Outcome]:
    """Take away what is not of the strands' colours, or is of the ground's."""
    what = f"colours {len(said.colours)} of strands, {len(said.ground)} of the ground"
    named, ground = _lab(said.colours), _lab(said.ground)
    kept = [
        one for one in strands if one.by or _may_be(_colour(one.strand, scene.photo), named, ground)
    ]
    gone = len(strands) - len(kept)
    if not gone:
        return strands, Outcome(what, ALREADY, "all strands are of these")
    return kept, Outcome(what, APPLIED, f"{gone} of {len(strands)} were of another colour")


def _may_be(colour: np.ndarray, named: np.ndarray, ground: np.ndarray) -> bool:
    """Tell whether a strand may have a colour; only the ground, or only strands, may be named."""
    to_ground = _apart(colour, ground).min(initial=np.inf)
    to_named = _apart(colour, named).min(initial=np.inf)
    if not len(named):
        return bool(to_ground > LIKE_GROUND)
    return bool(to_named <= min(FAR, to_ground))


def _apart(colour: np.ndarray, others: np.ndarray) -> np.ndarray:
    return np.linalg.norm((others - colour) * [0.5, 1, 1], axis=1)


def _lab(colours: list[str]) -> np.ndarray:
    """Lab (n, 3) of ``#rrggbb``."""
    if not colours:
        return np.empty((0, 3))
    rgb = [[int(colour[i : i + 2], 16) for i in (1, 3, 5)] for colour in colours]
    return cv2.cvtColor(np.array([rgb], np.float32) / 255, cv2.COLOR_RGB2Lab)[0]


def _colour(strand: Strand, photo: Photo) -> np.ndarray:
    """Median Lab colour along a centreline, where it is seen."""
    seen = strand.line[strand.edges > 0] if (strand.edges > 0).any() else strand.line
    x, y = np.rint(seen).astype(int).T
    height, width = photo.shape
    rgb = photo.pixels[y.clip(0, height - 1), x.clip(0, width - 1)].astype(np.float32)
    rgb /= np.iinfo(photo.pixels.dtype).max
    return np.median(cv2.cvtColor(rgb[None], cv2.COLOR_RGB2Lab)[0], axis=0)


class _Move(NamedTuple):
    """Leave out a strand (`other` is None), or join two at these ends; True = the last point."""

    price: float
    one: int
    other: int | None = None
    last: bool = True
    other_last: bool = False


def to_number(strands: list[Handled], number: int, scene: Scene) -> tuple[list[Handled], Outcome]:
    """Join pieces and leave out short ones, the cheapest first, until so many strands are left.

    A join is the dearer the wider its gap, the sharper its turn and the more the colour changes; to
    leave out a strand, the longer it is. What a hand made is not left out.
    """
    what = f"strands {number}"
    before, joined = len(strands), 0
    if before == number:
        return strands, Outcome(what, ALREADY, "as many were found")
    while len(strands) > number:
        move = min(_moves(strands, scene), default=None, key=lambda one: one.price)
        if move is None:
            break
        joined += move.other is not None
        strands = _moved(strands, move, scene)
    left = before - joined - len(strands)
    why = f"{before} found, {joined} joined, {left} left out"
    if len(strands) == number:
        return strands, Outcome(what, APPLIED, why)
    return strands, Outcome(what, MISFIT, f"{why}: {len(strands)} there; draw or split the others")


def _moves(strands: list[Handled], scene: Scene) -> list[_Move]:
    plain = [one.strand for one in strands]
    typical = float(np.median([arclength(strand.line)[-1] for strand in plain]))
    moves = [
        _Move(float(arclength(one.strand.line)[-1]) / typical, i)
        for i, one in enumerate(strands)
        if not one.by
    ]
    colours = [_colour(strand, scene.photo) for strand in plain]
    ends = [(i, last) for i in range(len(plain)) for last in (False, True)]
    for (i, last), (j, other_last) in ((a, b) for a in ends for b in ends if a[0] < b[0]):
        share = _misfit(plain[i], last, plain[j], other_last, scene.width)
        share = max(share, float(_apart(colours[i], colours[j][None])[0]) / COLOUR)
        if share < 1:
            moves.append(_Move(PRICE * share, i, j, last, other_last))
    return moves


def _misfit(a: Strand, last: bool, b: Strand, other_last: bool, width: float) -> float:
    """How much of the gap and turn that are allowed a join takes; more than 1 = it is none."""
    if "clipped" in (a.ends[last], b.ends[other_last]):
        return np.inf
    p, q = a.line[-last], b.line[-other_last]
    gap = float(np.hypot(*(q - p)))
    if gap > GAP * width:
        return np.inf
    out = direction(a, len(a.line) - 1 if last else 0) * (1 if last else -1)
    on = direction(b, len(b.line) - 1 if other_last else 0) * (-1 if other_last else 1)
    turns = [_turn(out, on)]
    if gap > 1.5 * width:
        turns += [_turn(out, q - p), _turn(q - p, on)]
    return max(gap / (GAP * width), max(turns) / TURN)


def _turn(a: np.ndarray, b: np.ndarray) -> float:
    cosine = a @ b / max(float(np.hypot(*a) * np.hypot(*b)), 1e-9)
    return float(np.arccos(np.clip(cosine, -1, 1)))


def _moved(strands: list[Handled], move: _Move, scene: Scene) -> list[Handled]:
    rest = [one for i, one in enumerate(strands) if i not in (move.one, move.other)]
    if move.other is None:
        return rest
    first = turned(strands[move.one].strand, not move.last)
    second = turned(strands[move.other].strand, move.other_last)
    whole = connected(first, second, np.empty((0, 2)), scene)
    by = strands[move.one].by or strands[move.other].by or "joined"
    rest.insert(move.one, Handled(whole, by))
    return rest
