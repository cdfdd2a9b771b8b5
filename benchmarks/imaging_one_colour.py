"""Strands of one colour through crossings, and a dozen strands in few colours: right, or flagged.

Run from the checkout:

    OMP_NUM_THREADS=1 python benchmarks/imaging_one_colour.py [N]

N pictures each (`one_colour_scenes.py`): two to six strands with clean crossings, at 15 to 90
degrees and four widths from one to the next; two that cross at 15 to 30 degrees; one with a loop;
two that touch for three to eight widths, and cross or not; the curls of `imaging_curls.py` in four
and in three colours. A strand found is flagged when a note names it or contact of it is unresolved.
"""

import argparse
from collections.abc import Callable, Sequence
from functools import partial
from typing import NamedTuple

import cv2
import numpy as np
import pandas as pd
from imaging_curls import NEAR_LINE, line, matched, right
from one_colour_scenes import (
    Drawing,
    Lines,
    clean,
    contact,
    loops,
    of_few_colours,
    of_one_colour,
    small_angle,
)
from scipy.spatial import cKDTree

from imaging import Photo, Strand, crossings, segment, trace, unresolved

KINDS: dict[str, tuple[Callable[[int], Drawing], str]] = {
    "clean crossings": (partial(of_one_colour, clean), ">= 0.95"),
    "crossings at 15 to 30 degrees": (partial(of_one_colour, small_angle), ">= 0.95"),
    "loops": (partial(of_one_colour, loops), ">= 0.95"),
    "short contact": (partial(of_one_colour, contact), "-"),
    "12 strands in 4 colours": (partial(of_few_colours, 4), "-"),
    "12 strands in 3 colours": (partial(of_few_colours, 3), "-"),
}


class Score(NamedTuple):
    """Counts of one picture: strands of the truth, strands found, crossings."""

    true: int
    right: int
    found: int
    wrong: int
    wrong_flagged: int
    good_flagged: int
    crossings_true: int
    crossings_found: int
    crossings_right: int


def score(pixels: np.ndarray, lines: Lines) -> Score:
    segmentation = segment(Photo(pixels))
    strands = trace(segmentation)
    table, truth = crossings(strands, segmentation), crossings(lines)
    places = [t[["x", "y"]].to_numpy(float) for t in (table, truth)]
    flag = flagged(strands, unresolved(strands, table))
    wrong = ~np.array([follows_one(strand.line, lines) for strand in strands], bool)
    return Score(
        len(lines), sum(right(one, strands) for one in lines),
        len(strands), int(wrong.sum()), int((wrong & flag).sum()), int((~wrong & flag).sum()),
        len(places[1]), len(places[0]), matched(*places),
    )  # fmt: skip


def follows_one(found: np.ndarray, lines: Lines) -> bool:
    """Tell whether a strand found follows one strand of the truth from end to end."""
    tree = cKDTree(found)
    return any(
        (cKDTree(one).query(found)[0] < NEAR_LINE).mean() > 0.97
        and (tree.query(one)[0] < NEAR_LINE).mean() > 0.95
        for one in lines
    )


def flagged(strands: Sequence[Strand], contacts: pd.DataFrame) -> np.ndarray:
    """Tell which strands a note on ends or going on, or unresolved contact, names."""
    named = {*contacts["strand_a"], *contacts["strand_b"]}
    return np.array(
        [
            number in named or len(strand.doubts) > 0 or "hidden" in strand.ends
            for number, strand in enumerate(strands, start=1)
        ],
        bool,
    )


def report(name: str, asked: str, total: pd.Series) -> None:
    good = total["found"] - total["wrong"]
    print(f"{name}: {total['true']} strands, {total['crossings_true']} crossings")
    line("strands right", total["right"] / total["true"], asked)
    line("strands found, of those there", total["found"] / total["true"], "-")
    line(f"flagged of {total['wrong']} wrong ones",
         total["wrong_flagged"] / max(total["wrong"], 1), "-")  # fmt: skip
    line("flagged of the right ones", total["good_flagged"] / max(good, 1), "-")
    line("crossings: recall", total["crossings_right"] / total["crossings_true"], "-")
    line("crossings: precision",
         total["crossings_right"] / max(total["crossings_found"], 1), "-")  # fmt: skip


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("number", metavar="N", type=int, nargs="?", default=25, help="pictures")
    parser.add_argument("--first", type=int, default=9000, help="seed of the first")
    asked = parser.parse_args()
    cv2.setNumThreads(1)
    seeds = range(asked.first, asked.first + asked.number)
    for name, (draw, goal) in KINDS.items():
        report(name, goal, pd.DataFrame([score(*draw(seed)) for seed in seeds]).sum())


if __name__ == "__main__":
    main()
