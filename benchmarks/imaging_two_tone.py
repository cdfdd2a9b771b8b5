"""Curls of twelve strands of which three change their colour along their length.

Run from the checkout:

    OMP_NUM_THREADS=1 python benchmarks/imaging_two_tone.py [N]

The change is sharp or blends over 20 or 80 px, and lies anywhere from 30 to 70 % of the length: in
sight, or beneath other strands. Everything else varies as in `imaging_curls.py`.
"""

import argparse
from typing import NamedTuple

import cv2
import numpy as np
import pandas as pd
from drawn.strands import random_curl, render
from imaging_curls import PALETTE, SHAPE, STRANDS, line, right, varied_look
from scipy.spatial import cKDTree

from imaging import Photo, segment, trace

CHANGING = (1, 5, 9)  # strands that change their colour
SECOND = np.array([[128, 128, 128], [250, 170, 180], [0, 128, 128]]) / 255
BLENDS = (0.1, 5.0, 20.0)  # px; a quarter of the length over which colours blend
CLEAR = 1.5  # strand widths from the change to the nearest other strand's middle: in sight


class Score(NamedTuple):
    """Strands of one curl that are right, by kind; strands found with two colours."""

    plain: int
    in_sight: int
    in_sight_right: int
    hidden: int
    hidden_right: int
    found: int


def draw(seed: int) -> tuple[np.ndarray, list[np.ndarray], dict[int, bool]]:
    """Return a picture, its strands, and whether each change of colour is in sight."""
    rng = np.random.default_rng(seed)
    lines, heights = random_curl(STRANDS, slope=rng.uniform(0.2, 0.3), rng=rng)
    lines = [line + [SHAPE[1] / 2, 30] for line in lines]
    radius, first = rng.uniform(2.3, 3.2), rng.permutation(PALETTE)
    colours, sight = list(first), {}
    for number, second in zip(CHANGING, rng.permutation(SECOND), strict=True):
        s = np.arange(len(lines[number]))
        at = round(rng.uniform(0.3, 0.7) * len(s))
        share = 1 / (1 + np.exp(np.clip((at - s) / rng.choice(BLENDS), -50, 50)))
        colours[number] = first[number] + (second - first[number]) * share[:, None]
        others = np.concatenate(lines[:number] + lines[number + 1 :])
        sight[number] = cKDTree(others).query(lines[number][at])[0] > CLEAR * 2 * radius
    drawn = render(lines, heights, colours, radius, SHAPE, look=varied_look(rng), rng=rng)
    return drawn.pixels, lines, sight


def score(seed: int) -> Score:
    pixels, lines, sight = draw(seed)
    strands = trace(segment(Photo(pixels)))
    good = [right(line, strands) for line in lines]
    return Score(
        sum(good[i] for i in range(STRANDS) if i not in sight),
        sum(sight.values()),
        sum(good[i] for i in sight if sight[i]),
        len(sight) - sum(sight.values()),
        sum(good[i] for i in sight if not sight[i]),
        sum(len(np.unique(strand.tones)) > 1 for strand in strands),
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("number", metavar="N", type=int, nargs="?", default=25, help="curls drawn")
    parser.add_argument("--first", type=int, default=100, help="seed of the first")
    asked = parser.parse_args()
    cv2.setNumThreads(1)
    seeds = range(asked.first, asked.first + asked.number)
    total = pd.DataFrame([score(seed) for seed in seeds]).sum()
    changing = len(CHANGING) * asked.number
    print(f"{asked.number} curls of {STRANDS} strands, {len(CHANGING)} of two colours")
    line("strands of one colour right", total["plain"] / (STRANDS * asked.number - changing), "-")
    line(f"change in sight ({total['in_sight']}): right",
         total["in_sight_right"] / total["in_sight"], "-")  # fmt: skip
    line(f"hidden or in contact ({total['hidden']}): right",
         total["hidden_right"] / total["hidden"], "-")  # fmt: skip
    line("found with two colours, of those there", total["found"] / changing, "-")


if __name__ == "__main__":
    main()
