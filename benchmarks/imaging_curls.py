"""Reached beside asked on rendered curls of twelve strands, whose truth is known.

Run from the checkout:

    OMP_NUM_THREADS=1 python benchmarks/imaging_curls.py [N]
"""

import argparse
import time
from typing import NamedTuple

import cv2
import numpy as np
import pandas as pd
from scipy.optimize import linear_sum_assignment
from scipy.spatial import cKDTree

from imaging import Photo, Strand, crossings, interactions, segment, trace
from imaging.synthetic import random_curl, render

STRANDS = 12
SLOPE = 0.25  # rad; sd of the direction at the free ends
RADIUS = 2.5  # px
SHAPE = (1280, 900)
NEAR_LINE = 3.0  # px from truth, on 97 % of the length found and 95 % of the truth
NEAR_CROSSING = 8.0  # px
PALETTE = np.array(
    [
        [230, 25, 75], [60, 180, 75], [255, 225, 25], [0, 90, 200], [245, 130, 48], [145, 30, 180],
        [70, 240, 240], [240, 50, 230], [0, 0, 0], [170, 110, 40], [128, 128, 0], [0, 0, 128],
    ]
) / 255  # fmt: skip


class Score(NamedTuple):
    """What one curl adds to the table; `rho` are numbers of interactions of N = 2, 3, 4."""

    strands_right: int
    crossings_found: int
    crossings_right: int
    crossings_true: int
    found: tuple[int, ...]
    true: tuple[int, ...]
    seconds: float


def score(seed: int) -> Score:
    rng = np.random.default_rng(seed)
    lines, heights = random_curl(STRANDS, slope=SLOPE, rng=rng)
    lines = [line + [SHAPE[1] / 2, 30] for line in lines]
    drawn = render(lines, heights, PALETTE, RADIUS, SHAPE, rng=rng)
    start = time.process_time()
    segmentation = segment(Photo(drawn.pixels))
    strands = trace(segmentation)
    table = crossings(strands, segmentation)
    sections = interactions(strands, table=table)
    seconds = time.process_time() - start
    truth = crossings(lines)
    places = [t.loc[t["kind"] == "inter", ["x", "y"]].to_numpy() for t in (table, truth)]
    return Score(
        sum(right(line, strands) for line in lines),
        len(places[0]),
        matched(*places),
        len(places[1]),
        counts(sections),
        counts(interactions(lines, table=truth)),
        seconds,
    )


def right(truth: np.ndarray, strands: list[Strand]) -> bool:
    """Tell whether one of the strands follows the truth from end to end."""
    tree = cKDTree(truth)
    nearest = min(strands, key=lambda s: float(np.median(tree.query(s.line)[0])))
    off = tree.query(nearest.line)[0]
    missed = cKDTree(nearest.line).query(truth)[0]
    return bool((off < NEAR_LINE).mean() > 0.97 and (missed < NEAR_LINE).mean() > 0.95)


def matched(found: np.ndarray, truth: np.ndarray) -> int:
    """Count crossings that pair off within NEAR_CROSSING."""
    far = np.hypot(*(found[:, None] - truth[None]).transpose(2, 0, 1))
    rows, columns = linear_sum_assignment(np.minimum(far, 10 * NEAR_CROSSING))
    return int((far[rows, columns] < NEAR_CROSSING).sum())


def counts(sections: pd.DataFrame) -> tuple[int, ...]:
    total = sections.groupby("N")["count"].sum()
    return tuple(int(total.get(n, 0)) for n in (2, 3, 4))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("number", metavar="N", type=int, nargs="?", default=6, help="curls drawn")
    number = parser.parse_args().number
    cv2.setNumThreads(1)
    rows = pd.DataFrame([score(seed) for seed in range(number)])
    print(f"{number} curls of {STRANDS} strands, {2 * RADIUS:g} px wide, direction sd {SLOPE} rad")
    line("strands right", rows["strands_right"].sum() / (STRANDS * number), ">= 0.95")
    matches = rows["crossings_right"].sum()
    line("crossings: recall", matches / rows["crossings_true"].sum(), "-")
    line("crossings: precision", matches / rows["crossings_found"].sum(), "-")
    found, true = np.array(rows["found"].tolist()), np.array(rows["true"].tolist())
    for column, asked in enumerate(("3", "8", "8")):
        error = found[:, column].sum() / true[:, column].sum() - 1
        line(f"rho_{column + 2}: error over all, %", 100 * error, f"<= {asked}", 1)
    megapixels = SHAPE[0] * SHAPE[1] / 1e6
    line(f"CPU s a picture of {megapixels:.1f} Mpx", rows["seconds"].mean(), "-", 2)


def line(name: str, reached: float, asked: str, digits: int = 3) -> None:
    print(f"  {name:<36} {reached:>8.{digits}f}   asked {asked}")


if __name__ == "__main__":
    main()
