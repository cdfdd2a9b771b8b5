"""One function for each kind of step a hand makes: strands in, strands out, and what became of it.

A step that is done already (the program got better) is said to be so; one that fits nothing that is
there is left out, and the reason is told.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from imaging.correct.anchors import apart, beside, ending, passing, share_along
from imaging.correct.schema import Anchor, Delete, Draw, Exchange, Join, Only, Split
from imaging.correct.snap import snap
from imaging.photo import Photo
from imaging.segment import Segmentation
from imaging.trace import Strand

APPLIED, ALREADY, MISFIT = "applied", "already so", "no longer fits"
COVERED = 0.8  # of a line's length along a strand, for the two to be the same
SAME = 0.95  # of a drawn line along a strand, for it to be drawn already
PIECE = 0.6  # of a strand's length along a drawn line, for it to be a piece of what was drawn
CLOSE = 1.5  # px; of strands along a line to be deleted, those farther than twice the next stay
TOUCH = 2.5  # px between two ends that need no bridge
MEND = 3.0  # strand widths to both sides of a join that are measured anew


class Scene(NamedTuple):
    """What steps need of a photograph besides its strands."""

    photo: Photo
    segmentation: Segmentation

    @property
    def width(self) -> float:
        """Typical strand width [px]."""
        return self.segmentation.width


@dataclass(frozen=True)
class Handled:
    """A strand, and whether a hand made or changed it.

    Attributes
    ----------
    strand : Strand
    by : str
        Empty = as measured; ``drawn``, ``joined``, ``split``, ``exchanged``.
    """

    strand: Strand
    by: str = ""


@dataclass(frozen=True)
class Outcome:
    """What became of a step: ``applied``, ``already so`` or ``no longer fits``, and why."""

    what: str
    outcome: str
    why: str = ""


class Result(NamedTuple):
    """What became of a step: strands after it, outcome, and why."""

    strands: list[Handled]
    outcome: str = APPLIED
    why: str = ""


def delete(strands: list[Handled], step: Delete, scene: Scene) -> Result:
    """Take away the strand along a line, unless it is mostly another by now."""
    line = np.array(step.line)
    plain = _plain(strands)
    near = {
        i: apart(one.line, line)
        for i, one in enumerate(plain)
        if share_along(one.line, line, beside(one)) >= PIECE
    }
    gone = {i for i, far in near.items() if far <= max(CLOSE, 2 * min(near.values()))}
    if gone:
        return Result([one for i, one in enumerate(strands) if i not in gone])
    if any(share_along(line, one.line, beside(one)) >= 1 - PIECE for one in plain):
        return Result(strands, MISFIT, "the strand there is mostly another by now")
    return Result(strands, ALREADY, "no strand lies there")


def split(strands: list[Handled], step: Split, scene: Scene) -> Result:
    """Cut a strand in two."""
    found = passing(_plain(strands), step.here)
    if found is None:
        return Result(strands, MISFIT, "no strand passes there in that direction")
    number, at = found
    strand = strands[number].strand
    if min(at, len(strand.line) - 1 - at) < max(TOUCH, scene.width):
        return Result(strands, ALREADY, "a strand ends there")
    parts = [Handled(part, "split") for part in cut(strand, at)]
    return Result(strands[:number] + parts + strands[number + 1 :])


def join(strands: list[Handled], step: Join, scene: Scene) -> Result:
    """Let one strand go on as another."""
    plain = _plain(strands)
    first, second = ending(plain, step.start), ending(plain, step.to)
    if first is None or second is None:
        if _is_one(plain, step.start, step.to):
            return Result(strands, ALREADY, "one strand passes both places")
        which = step.start if first is None else step.to
        return Result(strands, MISFIT, f"no strand ends near {_at(which)} in that direction")
    if first[0] == second[0]:
        if first[1] == second[1]:
            return Result(strands, MISFIT, "both places are the same end of one strand")
        return Result(strands, MISFIT, "both ends are of one strand; a ring is not a strand")
    a, b = plain[first[0]], plain[second[0]]
    through = np.reshape(np.array(step.through, float), (-1, 2))
    whole = connected(turned(a, not first[1]), turned(b, second[1]), through, scene)
    return Result(_replaced(strands, (first[0], second[0]), [Handled(whole, "joined")]))


def exchange(strands: list[Handled], step: Exchange, scene: Scene) -> Result:
    """Let two strands that touch go on as each other."""
    plain = _plain(strands)
    found = [(passing(plain, way.start), passing(plain, way.to)) for way in step.ways]
    if any(place is None for ways in found for place in ways):
        return Result(strands, MISFIT, "there are no two strands there that could be exchanged")
    (come, go), (other_come, other_go) = ([p for p in ways if p is not None] for ways in found)
    if come[0] == go[0] and other_come[0] == other_go[0]:
        return Result(strands, ALREADY, "they go on so")
    if {come[0], go[0]} != {other_come[0], other_go[0]} or come[0] == other_come[0]:
        return Result(strands, MISFIT, "the places lie on other strands by now")
    made = [_exchanged(plain, start, end, step.at, scene)
            for start, end in ((come, go), (other_come, other_go))]  # fmt: skip
    return Result(
        _replaced(strands, (come[0], other_come[0]), [Handled(one, "exchanged") for one in made])
    )


def _exchanged(
    plain: list[Strand],
    start: tuple[int, int],
    end: tuple[int, int],
    at: tuple[float, float],
    scene: Scene,
) -> Strand:
    """Come along one strand by a point of it as far as `at`, and go on along the other."""
    halves = []
    for (number, passed), stays_first in ((start, True), (end, False)):
        strand = plain[number]
        middle = int(np.hypot(*(strand.line - at).T).argmin())
        before, after = cut(strand, min(max(middle, 2), len(strand.line) - 3), upright=False)
        half = before if passed <= middle else after
        halves.append(turned(half, (passed <= middle) != stays_first))
    return connected(halves[0], halves[1], np.empty((0, 2)), scene)


def draw(strands: list[Handled], step: Draw, scene: Scene) -> Result:
    """Add the strand along a line; what lies along it and was not drawn are pieces of it."""
    line = np.array(step.points)
    for one in strands:
        if one.by != "drawn" and share_along(line, one.strand.line, beside(one.strand)) >= SAME:
            return Result(strands, ALREADY, "a strand lies there")
    made = measured_by_hand(line, scene)
    rest = [
        one
        for one in strands
        if one.by == "drawn" or share_along(one.strand.line, made.line, beside(one.strand)) < PIECE
    ]
    return Result([*rest, Handled(made, "drawn")])


def only(strands: list[Handled], step: Only, scene: Scene) -> Result:
    """Keep the strands along these lines, draw those that are missing, and take away all others."""
    left, kept = list(strands), []
    for points in step.lines:
        line = np.array(points)
        same = [one for one in left if _same(one.strand, line)]
        best = max(same, key=lambda one: len(one.strand.line), default=None)
        kept.append(best or Handled(measured_by_hand(line, scene), "drawn"))
        left = [one for one in left if one is not best]
    if len(kept) == len(strands) and not any(one.by == "drawn" for one in kept):
        return Result(strands, ALREADY, "these are the strands")
    return Result(kept)


def _same(strand: Strand, line: np.ndarray) -> bool:
    near = beside(strand)
    return min(share_along(strand.line, line, near), share_along(line, strand.line, near)) > COVERED


def cut(strand: Strand, at: int, upright: bool = True) -> tuple[Strand, Strand]:
    """Part a strand between its points `at` and `at` + 1; what was nearer keeps its doubts."""
    closest = [int(np.hypot(*(strand.line - doubt).T).argmin()) for doubt in strand.doubts]
    first = np.array([place <= at for place in closest], bool)
    parts = []
    for rows, mine, ends in (
        (slice(None, at + 1), first, (strand.ends[0], "free")),
        (slice(at + 1, None), ~first, ("free", strand.ends[1])),
    ):
        part = replace(
            strand, **{name: getattr(strand, name)[rows] for name in ALONG_LINE},
            ends=ends, doubts=strand.doubts[mine],
        )  # fmt: skip
        parts.append(_upright(part) if upright else part)
    return parts[0], parts[1]


ALONG_LINE = ("line", "width", "sd", "edges", "tones")


def turned(strand: Strand, around: bool = True) -> Strand:
    """Return a strand from its other end, if `around`."""
    if not around:
        return strand
    backwards = {name: getattr(strand, name)[::-1] for name in ALONG_LINE}
    return replace(strand, **backwards, ends=strand.ends[::-1], doubts=strand.doubts[::-1])


def _upright(strand: Strand) -> Strand:
    """Root, the upper end, first."""
    return turned(strand, bool(strand.line[0, 1] > strand.line[-1, 1]))


def connected(first: Strand, second: Strand, through: np.ndarray, scene: Scene) -> Strand:
    """Join the end of one strand to the beginning of another; what lies between is measured."""
    gap = float(np.hypot(*(second.line[0] - first.line[-1])))
    kink = _heading(first, -1) @ _heading(second, 0) < np.cos(0.35)
    if gap <= TOUCH and not len(through) and not kink:
        return _upright(_glued([first, second]))
    back = int(MEND * scene.width) if not len(through) else 0
    head = min(back, len(first.line) - 3) if len(first.line) > 3 else 0
    tail = min(back, len(second.line) - 3) if len(second.line) > 3 else 0
    first = _kept(first, slice(None, len(first.line) - head))
    second = _kept(second, slice(tail, None))
    bridge = np.concatenate([first.line[-1:], through, second.line[:1]])
    if not len(through):
        bridge = _arc(first, second)
    middle = measured_by_hand(bridge, scene)
    if np.hypot(*(middle.line[0] - bridge[0])) > np.hypot(*(middle.line[-1] - bridge[0])):
        middle = turned(middle)
    inner = _kept(middle, slice(1, -1))
    inner = replace(inner, tones=np.full(len(inner.line), first.colour))
    parts = [first, inner, second] if len(inner.line) else [first, second]
    return _upright(_glued(parts))


def _kept(strand: Strand, rows: slice) -> Strand:
    return replace(strand, **{name: getattr(strand, name)[rows] for name in ALONG_LINE})


def _glued(parts: Sequence[Strand]) -> Strand:
    whole = {name: np.concatenate([getattr(p, name) for p in parts]) for name in ALONG_LINE}
    doubts = np.concatenate([part.doubts for part in parts])
    return replace(parts[0], **whole, ends=(parts[0].ends[0], parts[-1].ends[1]), doubts=doubts)


def _heading(strand: Strand, at: int) -> np.ndarray:
    line = strand.line[-9:] if at else strand.line[:9]
    chord = line[-1] - line[0]
    return chord / max(float(np.hypot(*chord)), 1e-9)


def _arc(first: Strand, second: Strand) -> np.ndarray:
    """Cubic from the end of one strand to the beginning of another, in their directions."""
    p, q = first.line[-1], second.line[0]
    far = float(np.hypot(*(q - p)))
    u, v = far * _heading(first, -1), far * _heading(second, 0)
    t = np.linspace(0, 1, max(int(far), 2))[:, None]
    return (
        (2 * t**3 - 3 * t**2 + 1) * p + (t**3 - 2 * t**2 + t) * u
        + (3 * t**2 - 2 * t**3) * q + (t**3 - t**2) * v
    )  # fmt: skip


def measured_by_hand(points: np.ndarray, scene: Scene) -> Strand:
    """Measure the strand beneath a line drawn by hand."""
    found, colour = snap(scene.photo, points, scene.width)
    colours = scene.segmentation.colours
    tone = int(np.linalg.norm(colours - colour, axis=1).argmin())
    ends = tuple("clipped" if _at_border(p, scene) else "free" for p in found.line[[0, -1]])
    return _upright(Strand(*found, np.full(len(found.line), tone), (ends[0], ends[1])))


def _at_border(point: np.ndarray, scene: Scene) -> bool:
    height, width = scene.photo.shape
    x, y = point
    return bool(min(x, y, width - 1 - x, height - 1 - y) < scene.width)


def _plain(strands: Sequence[Handled]) -> list[Strand]:
    return [one.strand for one in strands]


def _replaced(
    strands: list[Handled], old: tuple[int, int], new: Sequence[Handled]
) -> list[Handled]:
    """Put new strands where the first of the old ones were."""
    places = sorted(old)
    rest = list(strands)
    for place in reversed(places):
        del rest[place]
    for place, one in zip(places, new, strict=False):
        rest.insert(place, one)
    return rest


def _is_one(plain: Sequence[Strand], a: Anchor, b: Anchor) -> bool:
    """Tell whether one strand passes both places."""
    found = {which: passing(plain, here) for which, here in (("a", a), ("b", b))}
    first, second = found["a"], found["b"]
    return first is not None and second is not None and first[0] == second[0]


def _at(here: Anchor) -> str:
    return f"({here.at[0]:.0f}, {here.at[1]:.0f})"


STEPS: dict[str, Callable[..., Result]] = {
    "delete": delete, "split": split, "join": join, "exchange": exchange, "draw": draw,
    "only": only,
}  # fmt: skip
