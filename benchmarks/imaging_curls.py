"""Reached beside asked on rendered curls of twelve strands, whose truth is known.

Run from the checkout:

    OMP_NUM_THREADS=1 python benchmarks/imaging_curls.py [N] [--one-colour]

What varies: the strands (direction sd 0.2 to 0.3 rad at the free ends, widths 4.6 to 6.4 px), which
of twelve colours each has, four grounds, the lamp's direction, ambient light 0.35 to 0.6, highlight
0 to 0.3, light falling off by 0 to 50 %, blur 0.6 to 1.2 px, noise 0.5 to 2 %. With --one-colour
all strands have the colour of blond hair.
"""

import argparse
import time
from typing import NamedTuple

import cv2
import numpy as np
import pandas as pd
from contact_truth import Contacts, score_contacts
from drawn.strands import Look, random_curl, render
from scipy.optimize import linear_sum_assignment
from scipy.spatial import cKDTree

from imaging import Photo, Strand, crossings, interactions, segment, trace, unresolved

STRANDS = 12
SHAPE = (1280, 900)
GROUNDS = [(0.9, 0.9, 0.88), (0.8, 0.85, 0.92), (0.85, 0.9, 0.82), (0.66, 0.68, 0.7)]
NEAR_LINE = 3.0  # px from truth, on 97 % of the length found and 95 % of the truth
NEAR_CROSSING = 8.0  # px
PALETTE = np.array(
    [
        [230, 25, 75], [60, 180, 75], [255, 225, 25], [0, 90, 200], [245, 130, 48], [145, 30, 180],
        [70, 240, 240], [240, 50, 230], [0, 0, 0], [170, 110, 40], [128, 128, 0], [0, 0, 128],
    ]
) / 255  # fmt: skip
BLOND = (0.55, 0.38, 0.16)


class Curl(NamedTuple):
    """A rendered curl and the truth it was drawn from."""

    pixels: np.ndarray
    lines: list[np.ndarray]
    heights: list[np.ndarray]
    radius: float


def varied_look(rng: np.random.Generator) -> Look:
    """Draw ground, lamp, gloss, lens and sensor at random."""
    return Look(
        background=GROUNDS[rng.integers(len(GROUNDS))],
        light=(*rng.uniform(-0.5, 0.5, 2), 0.85),
        ambient=rng.uniform(0.35, 0.6),
        highlight=rng.uniform(0, 0.3),
        blur=rng.uniform(0.6, 1.2),
        noise=rng.uniform(0.005, 0.02),
        uneven=rng.uniform(0, 0.5),
    )


def draw(seed: int, one_colour: bool = False) -> Curl:
    """Draw a curl: strands, their colours and everything of `varied_look` at random."""
    rng = np.random.default_rng(seed)
    lines, heights = random_curl(STRANDS, slope=rng.uniform(0.2, 0.3), rng=rng)
    lines = [line + [SHAPE[1] / 2, 30] for line in lines]
    colours, radius = rng.permutation(PALETTE), rng.uniform(2.3, 3.2)
    if one_colour:
        colours[:] = BLOND
    drawn = render(lines, heights, colours, radius, SHAPE, look=varied_look(rng), rng=rng)
    return Curl(drawn.pixels, lines, heights, radius)


class Score(NamedTuple):
    """What one curl adds to the table; `found`, `true` are interactions of N = 2, 3, 4.

    `interactions` are all that were found, `doubtful` those that rest on unresolved contact.
    """

    strands_right: int
    strands_found: int
    crossings_found: int
    crossings_right: int
    crossings_true: int
    found: tuple[int, ...]
    true: tuple[int, ...]
    interactions: int
    doubtful: int
    contacts: Contacts
    seconds: float


def score(seed: int, one_colour: bool = False) -> Score:
    curl = draw(seed, one_colour)
    start = time.process_time()
    segmentation = segment(Photo(curl.pixels))
    strands = trace(segmentation)
    table = crossings(strands, segmentation)
    contacts = unresolved(strands, table)
    sections = interactions(strands, table=table, contacts=contacts)
    seconds = time.process_time() - start
    truth = crossings(curl.lines)
    places = [t.loc[t["kind"] == "inter", ["x", "y"]].to_numpy() for t in (table, truth)]
    return Score(
        sum(right(line, strands) for line in curl.lines),
        len(strands),
        len(places[0]),
        matched(*places),
        len(places[1]),
        counts(sections),
        counts(interactions(curl.lines, table=truth)),
        int(sections["count"].sum()),
        int(sections["unresolved"].sum()),
        score_contacts(curl.lines, 2 * curl.radius, strands, table, contacts),
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
    parser.add_argument("number", metavar="N", type=int, nargs="?", default=50, help="curls drawn")
    parser.add_argument("--first", type=int, default=1000, help="seed of the first")
    parser.add_argument("--one-colour", action="store_true", help="all strands are blond")
    asked = parser.parse_args()
    number = asked.number
    cv2.setNumThreads(1)
    seeds = range(asked.first, asked.first + number)
    rows = pd.DataFrame([score(seed, asked.one_colour) for seed in seeds], index=seeds)
    print(f"{number} curls of {STRANDS} strands, ground, lamp, gloss, blur, noise, width varied")
    line("strands right", rows["strands_right"].sum() / (STRANDS * number), ">= 0.95")
    line("strands found, of those there", rows["strands_found"].sum() / (STRANDS * number), "-")
    matches = rows["crossings_right"].sum()
    line("crossings: recall", matches / rows["crossings_true"].sum(), "-")
    line("crossings: precision", matches / rows["crossings_found"].sum(), "-")
    found, true = np.array(rows["found"].tolist()), np.array(rows["true"].tolist())
    for column, limit in enumerate(("3", "8", "8")):
        error = found[:, column].sum() / true[:, column].sum() - 1
        line(f"rho_{column + 2}: error over all, %", 100 * error, f"<= {limit}", 1)
    print_contacts(rows)
    megapixels = SHAPE[0] * SHAPE[1] / 1e6
    line(f"CPU s a picture of {megapixels:.1f} Mpx", rows["seconds"].mean(), "-", 2)
    worst = rows.sort_values("strands_right").head(5)
    print("  worst:", {seed: int(n) for seed, n in worst["strands_right"].items()})


def print_contacts(rows: pd.DataFrame) -> None:
    """Print what becomes of near-parallel contact, and how much rests on what is unresolved."""
    sums = Contacts(*np.sum(rows["contacts"].tolist(), axis=0).tolist())
    near = sums.right + sums.open + sums.wrong + sums.lost
    print(f"  {near} near-parallel contacts in truth:")
    line("  right or unresolved", (sums.right + sums.open) / near, "-")
    line("  unresolved", sums.open / near, "-")
    line("  along a strand that was lost", sums.lost / near, "-")
    line("resolved crossings: recall", sums.sure_seen / sums.sure_true, "-")
    line("resolved crossings: precision", sums.sure_right / max(sums.sure_found, 1), "-")
    line("unresolved contacts a curl", sums.stretches / len(rows), "-", 1)
    line("interactions resting on them", rows["doubtful"].sum() / rows["interactions"].sum(), "-")


def line(name: str, reached: float, asked: str, digits: int = 3) -> None:
    print(f"  {name:<36} {reached:>8.{digits}f}   asked {asked}")


if __name__ == "__main__":
    main()
