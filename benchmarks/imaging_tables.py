"""Cables on laboratory tables: how many are followed, and how much else is taken for one.

    OMP_NUM_THREADS=1 python benchmarks/imaging_tables.py [N] [--first SEED] [--hard] [--sheet FILE]

draws N pictures on each ground of `drawn.tables` (cables plain, glossy, striped, banded, fuzzy and
plied). A cable is followed when one strand covers 85 % of its length within 1.2 radii; a strand is
false when less than half of it lies on cables. `--hard` draws them under one lamp, with dark
shadows to one side. `--sheet` writes a contact sheet: pictures, and what was followed.
"""

import argparse
import time
from pathlib import Path

import cv2
import numpy as np
from drawn.tables import GROUNDS, Table, draw_table
from scipy.spatial import cKDTree

from imaging import Photo, Strand, Unmeasurable, segment, trace

FOLLOWED = 0.85  # of a cable's length
TILE = 352, 264  # px


def traced(pixels: np.ndarray) -> list[Strand]:
    """Strands of a picture, none where it is refused."""
    photo = Photo(pixels)
    try:
        return trace(segment(photo), photo)
    except Unmeasurable:
        return []


def score(table: Table, strands: list[Strand]) -> tuple[int, int]:
    """How many cables are followed, and how many strands are false."""
    followed = 0
    for line, radius in zip(table.lines, table.radii, strict=True):
        reach = max(1.2 * radius, 3)
        far = [cKDTree(s.line).query(line[::4], distance_upper_bound=reach)[0] for s in strands]
        followed += max((np.isfinite(away).mean() for away in far), default=0) >= FOLLOWED
    cables, near = cKDTree(np.concatenate(table.lines)), 1.3 * max(table.radii)
    false = sum((cables.query(s.line)[0] < near).mean() < 0.5 for s in strands)
    return followed, false


def tile(table: Table, strands: list[Strand], says: str) -> np.ndarray:
    """Picture beside what was followed in it."""
    drawn = table.pixels[..., ::-1].copy()
    rng = np.random.default_rng(0)
    for strand in strands:
        points = np.rint(strand.line).astype(np.int32)
        cv2.polylines(drawn, [points], False, rng.integers(0, 256, 3).tolist(), 2)
    for colour, thick in (((0, 0, 0), 4), ((255, 255, 255), 1)):
        cv2.putText(drawn, says, (6, 20), cv2.FONT_HERSHEY_SIMPLEX, 0.6, colour, thick)
    both = [table.pixels[..., ::-1], drawn]
    return np.hstack([cv2.resize(one, TILE, interpolation=cv2.INTER_AREA) for one in both])


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("n", type=int, nargs="?", default=3)
    parser.add_argument("--first", type=int, default=1000)
    parser.add_argument("--hard", action="store_true")
    parser.add_argument("--sheet", type=Path)
    asked = parser.parse_args()
    rows, total = [], np.zeros(4, int)
    began = time.process_time()
    for ground in GROUNDS:
        sums, tiles = np.zeros(4, int), []
        for seed in range(asked.first, asked.first + asked.n):
            table = draw_table(ground, seed, hard=asked.hard)
            strands = traced(table.pixels)
            followed, false = score(table, strands)
            sums += [followed, len(table.lines), false, len(strands)]
            tiles.append(tile(table, strands, f"{ground}: {followed}/{len(table.lines)}, {false}"))
        print(
            f"{ground:12s} followed {sums[0]} of {sums[1]}, false {sums[2]} of {sums[3]}",
            flush=True,
        )
        rows.append(np.hstack(tiles))
        total += sums
    share = 100 * total[::2] / total[1::2]
    print(f"followed {total[0]} of {total[1]} ({share[0]:.0f} %, goal 90)")
    print(f"false {total[2]} of {total[3]} strands ({share[1]:.1f} %, goal 3)")
    each = (time.process_time() - began) / asked.n / len(GROUNDS)
    print(f"{each:.2f} s a picture, drawing included")
    if asked.sheet:
        cv2.imwrite(str(asked.sheet), np.vstack(rows))


if __name__ == "__main__":
    main()
