"""Do intervals and confidences mean what they say? Small curls rendered in many ways.

Run from the checkout:

    OMP_NUM_THREADS=1 python benchmarks/imaging_calibration.py [N]

Prints how much of the truth the 95 % intervals of the centrelines and of rho_N hold, and how often
`over` is right for each confidence stated. What varies is that of `imaging_curls.py`; each curl has
six strands 420 px long.
"""

import argparse
from typing import NamedTuple

import cv2
import numpy as np
import pandas as pd
from drawn.strands import random_curl, render
from imaging_curls import PALETTE, varied_look
from scipy.spatial import cKDTree

from imaging import Photo, Segmentation, Strand, crossings, densities, interactions, segment, trace
from imaging.trace.centreline import arclength, resample

STRANDS = 6
SHAPE = (460, 320)
MISTAKEN = 3.0  # px; a strand whose median error is larger is a wrong strand, counted apart
ENDS = 5  # points at each end that are not judged: the line may stop early
NEAR = 8.0  # px from a true crossing of the same pair
BINS = [0.5, 0.7, 0.8, 0.9, 0.95, 0.98, 1.001]


class Curl(NamedTuple):
    """A curl measured, and its truth."""

    lines: list[np.ndarray]
    heights: list[np.ndarray]
    radius: float
    segmentation: Segmentation
    strands: list[Strand]


def measure(seed: int) -> Curl:
    rng = np.random.default_rng(seed)
    slope = rng.uniform(0.25, 0.6)
    lines, heights = random_curl(STRANDS, 420, 110, slope=slope, correlation=60, rng=rng)
    lines = [line + [SHAPE[1] / 2, 20] for line in lines]
    colours = rng.permutation(PALETTE)[:STRANDS]
    radius = rng.uniform(2.3, 4.5)
    drawn = render(lines, heights, colours, radius, SHAPE, look=varied_look(rng), rng=rng)
    segmentation = segment(Photo(drawn.pixels))
    return Curl(lines, heights, radius, segmentation, trace(segmentation))


def owners(curl: Curl) -> list[int]:
    """Find the true strand nearest to each strand found, -1 for none."""
    trees = [cKDTree(line) for line in curl.lines]
    far = [[np.median(tree.query(s.line)[0]) for tree in trees] for s in curl.strands]
    return [int(np.argmin(f)) if min(f) < MISTAKEN else -1 for f in far]


def points(curl: Curl) -> pd.DataFrame:
    """Error, sd and number of edges seen, of each point of each strand found."""
    parts = []
    for strand, owner in zip(curl.strands, owners(curl), strict=True):
        if owner >= 0:
            error = cKDTree(resample(curl.lines[owner], 0.05)).query(strand.line)[0]
            columns = {"error": error, "sd": strand.sd, "edges": strand.edges}
            parts.append(pd.DataFrame(columns)[ENDS:-ENDS])
    return pd.concat(parts, ignore_index=True)


def answers(curl: Curl) -> pd.DataFrame:
    """Stated confidence and whether `over` is right, of each crossing that is really there.

    A pair is mixed where one strand is on top at one crossing and the other at another.
    """
    owner = owners(curl)
    truth = crossings(curl.lines)
    rows = []
    for found in crossings(curl.strands, curl.segmentation).query("kind == 'inter'").itertuples():
        pair = owner[found.strand_a - 1], owner[found.strand_b - 1]
        true = _top(curl, pair, truth, found.x, found.y)
        if true is not None:
            known = not pd.isna(found.over)
            right = known and owner[found.over - 1] == true
            rows.append((found.confidence, known, right, *sorted(pair), true))
    table = pd.DataFrame(rows, columns=["confidence", "known", "right", "a", "b", "top"])
    tops = table.groupby(["a", "b"])["top"].transform("nunique")
    return table.assign(mixed=tops > 1)


def _top(curl: Curl, pair: tuple[int, int], truth: pd.DataFrame, x: float, y: float) -> int | None:
    """Which of the two really is on top at a crossing; None where that has no answer."""
    a, b = sorted(pair)
    if a < 0 or a == b:
        return None
    there = truth[(truth["strand_a"] == a + 1) & (truth["strand_b"] == b + 1)]
    far = np.hypot(there["x"] - x, there["y"] - y)
    if len(far) == 0 or far.min() > NEAR:
        return None
    hit = there.loc[far.idxmin()]
    level = [_height(curl, k, hit[s]) for k, s in ((a, "s_a"), (b, "s_b"))]
    if abs(level[0] - level[1]) < 2 * curl.radius:  # tubes that pass through each other
        return None
    return a if level[0] > level[1] else b


def rate_held(number: int, n_sec: int) -> float:
    """How often a curl's 95 % interval of rho_N, N = 2..5, holds the mean of all curls like it."""
    tables = []
    for seed in range(number):
        lines, _ = random_curl(12, rng=seed)
        tables.append(densities(interactions(lines, n_sec)).set_index("N").loc[2:5])
    rate = np.mean([table["density"] for table in tables], axis=0)
    return float(np.mean([(table["low"] <= rate) & (rate <= table["high"]) for table in tables]))


def print_centrelines(table: pd.DataFrame) -> None:
    inside = table["error"] < 1.96 * table["sd"]
    print(f"centreline: 95 % intervals hold {100 * inside.mean():.1f} % of {len(table)} points")
    for edges, name in ((2, "both edges seen"), (1, "one edge seen"), (0, "hidden")):
        own = table["edges"] == edges
        error = np.sqrt((table["error"][own] ** 2).mean())
        share = 100 * inside[own].mean()
        print(f"  {name:<16} {own.sum():>8} points, RMS {error:.2f} px, {share:.1f} %")


def _height(curl: Curl, strand: int, s: float) -> float:
    """Return how high a true strand lies at an arclength [px]."""
    return float(np.interp(s, arclength(curl.lines[strand]), curl.heights[strand]))


def print_reliability(table: pd.DataFrame) -> None:
    known = table[table["known"]]
    print(
        f"over/under: {len(table)} crossings, {1 - len(known) / len(table):.3f} unknown,", end=" "
    )
    print(f"{known['right'].mean():.4f} right of those answered")
    for mixed in (False, True):
        own = known[known["mixed"] == mixed]
        name = "mixed" if mixed else "one always on top"
        print(f"  pairs {name}: {own['right'].mean():.4f} right of {len(own)}")
    for low, high in zip(BINS, BINS[1:], strict=False):
        own = known[(known["confidence"] >= low) & (known["confidence"] < high)]
        if len(own):
            stated, right = own["confidence"].mean(), own["right"].mean()
            print(f"  stated {stated:.3f}: right {right:.3f} of {len(own)}")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("number", metavar="N", type=int, nargs="?", default=200, help="renders")
    parser.add_argument("--first", type=int, default=5000, help="seed of the first")
    asked = parser.parse_args()
    cv2.setNumThreads(1)
    curls = [measure(seed) for seed in range(asked.first, asked.first + asked.number)]
    owned = [owner for curl in curls for owner in owners(curl)]
    there, wrong = STRANDS * asked.number, owned.count(-1)
    print(f"{asked.number} renders: {len(owned)} strands found of {there}, {wrong} wrong")
    print_centrelines(pd.concat([points(curl) for curl in curls]))
    print_reliability(pd.concat([answers(curl) for curl in curls]))
    for n_sec in (10, 20, 40):
        held = rate_held(asked.number, n_sec)
        print(f"rho_N, {n_sec} sections: 95 % intervals hold {100 * held:.1f} % of the mean rates")


if __name__ == "__main__":
    main()
