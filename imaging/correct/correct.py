"""Corrections applied to a measurement: steps in their order, then colours, then the number."""

from collections import Counter
from collections.abc import Hashable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import pandas as pd

from imaging.correct.anchors import ASKEW, between, direction, place_on, reach
from imaging.correct.named import of_colours, to_number
from imaging.correct.schema import Corrections, Top
from imaging.correct.steps import ALREADY, APPLIED, MISFIT, STEPS, Handled, Outcome, Scene
from imaging.errors import Unmeasurable
from imaging.photo import Photo
from imaging.segment import Segmentation
from imaging.trace import Strand

SAME_PLACE = 2.0  # of an anchor's reach; a crossing moves more than a strand, the flatter the more


@dataclass(frozen=True)
class Hand:
    """What a hand did to a measurement.

    Attributes
    ----------
    by : list of str
        For each strand: empty = as measured; drawn, joined, split, exchanged.
    outcomes : list of Outcome
        Of each step, in order.
    corrections : Corrections
    """

    by: list[str] = field(default_factory=list)
    outcomes: list[Outcome] = field(default_factory=list)
    corrections: Corrections = field(default_factory=Corrections)

    @property
    def applied(self) -> int:
        """How many steps changed something."""
        return sum(one.outcome == APPLIED for one in self.outcomes)

    def tally(self) -> dict[str, int]:
        """Count the steps by their outcome."""
        return dict(Counter(one.outcome for one in self.outcomes))

    def notes(self) -> list[str]:
        """Say what was done by hand, and what no longer fits."""
        if not self.outcomes:
            return []
        done = Counter(one.what.split()[0] for one in self.outcomes if one.outcome == APPLIED)
        notes = [
            "corrected by hand: " + (", ".join(f"{n} {k}" for k, n in done.items()) or "nothing")
        ]
        if already := self.tally().get(ALREADY):
            notes[0] += f"; {already} as measured already"
        return notes + [
            f"correction no longer fits: {one.what}: {one.why}"
            for one in self.outcomes
            if one.outcome == MISFIT
        ]


def correct(
    photo: Photo,
    segmentation: Segmentation,
    strands: Sequence[Strand],
    corrections: Corrections,
) -> tuple[list[Strand], Hand]:
    """Apply what a hand says to the strands of a photograph.

    Parameters
    ----------
    photo : Photo
    segmentation : Segmentation
        Gives the typical width and the colours that strands drawn by hand are told by.
    strands : sequence of Strand
        As measured.
    corrections : Corrections

    Returns
    -------
    strands : list of Strand
    hand : Hand
        What became of each step. Who is on top is applied to crossings by `put_on_top`.

    Raises
    ------
    Unmeasurable
        When the corrections are of a photograph of another size, or leave no strand.
    """
    _refuse_other_size(photo, corrections)
    scene = Scene(photo, segmentation)
    handled, outcomes = [Handled(strand) for strand in strands], list[Outcome]()
    for step in corrections.steps:
        if isinstance(step, Top):
            continue
        handled, outcome, why = STEPS[step.do](handled, step, scene)
        outcomes.append(Outcome(step.told, outcome, why))
    if corrections.colours or corrections.ground:
        handled, told = of_colours(handled, corrections, scene)
        outcomes.append(told)
    if corrections.strands is not None:
        handled, told = to_number(handled, corrections.strands, scene)
        outcomes.append(told)
    if strands and not handled:
        raise Unmeasurable(f"{photo.source}: the corrections leave no strand")
    hand = Hand([one.by for one in handled], outcomes, corrections)
    return [one.strand for one in handled], hand


def _refuse_other_size(photo: Photo, corrections: Corrections) -> None:
    meant = corrections.photograph
    if meant is not None and (meant.height, meant.width) != photo.shape:
        height, width = photo.shape
        raise Unmeasurable(
            f"{photo.source}: its corrections are of {meant.name}, {meant.width} x {meant.height} "
            f"pixels, the photograph (upright) has {width} x {height}; they must agree"
        )


def put_on_top(table: pd.DataFrame, strands: Sequence[Strand], hand: Hand) -> pd.DataFrame:
    """Say who is on top at crossings as the hand does; adds the column ``over_by``.

    Parameters
    ----------
    table : DataFrame
        From `imaging.crossings`.
    strands : sequence of Strand
    hand : Hand
        Outcomes are added to it.

    Returns
    -------
    DataFrame
        ``over`` and ``confidence`` (1, or empty for unknown) as said; ``over_by`` = ``hand`` there.
    """
    table = table.copy()
    table["over_by"] = ""
    for step in hand.corrections.steps:
        if isinstance(step, Top):
            hand.outcomes.append(Outcome(step.told, *_top(table, strands, step)))
    return table


def _top(table: pd.DataFrame, strands: Sequence[Strand], step: Top) -> tuple[str, str]:
    """Say who is on top at one crossing, in place; returns the outcome, and why."""
    best, place, top = np.inf, None, 0
    for at, row in enumerate(table.to_dict("records")):
        if row["kind"] == "inter":
            misfit, over = _top_if_here(row, strands, step)
            if misfit < best:
                best, place, top = misfit, table.index[at], over
    if place is None:
        return MISFIT, "no crossing of strands in these directions is there"
    before = table.loc[place, "over"]
    same = bool(pd.isna(before)) if not step.known else bool(pd.notna(before)) and before == top
    table.loc[place, "over"] = top if step.known else pd.NA
    table.loc[place, "confidence"] = 1.0 if step.known else np.nan
    table.loc[place, "over_by"] = "hand"
    return (ALREADY if same else APPLIED), ""


def _top_if_here(
    row: dict[Hashable, Any], strands: Sequence[Strand], step: Top
) -> tuple[float, int]:
    """How badly a crossing fits what was said (infinite = not at all), and who would be on top."""
    numbers = (row["strand_a"], row["strand_b"])
    a, b = (strands[number - 1] for number in numbers)
    near = SAME_PLACE * max(reach(a), reach(b))
    far = float(np.hypot(row["x"] - step.at[0], row["y"] - step.at[1]))
    if far > near:
        return np.inf, 0
    along = [direction(one, place_on(one, (row["x"], row["y"]))[0]) for one in (a, b)]
    askew = [between(along[i], step.over) + between(along[1 - i], step.under) for i in range(2)]
    over = int(np.argmin(askew))
    if askew[over] > 2 * ASKEW:
        return np.inf, 0
    return far / near + askew[over], numbers[over]
