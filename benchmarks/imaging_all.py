"""Every number of the imaging beside its goal, and contact sheets of overlays, good and bad.

Run from the checkout:

    OMP_NUM_THREADS=1 python benchmarks/imaging_all.py [--sheets FOLDER] [--only-sheets]
        [--only SCRIPT]

It runs every other ``benchmarks/imaging_*.py`` as a new process, on the drawings that the
documentation tells of, and adds the peak memory. (A script named imaging.py would hide the package
from those beside it.)
"""

import argparse
import os
import re
import resource
import subprocess
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import cv2
import imaging_curls
import imaging_mbest
import numpy as np
import pandas as pd
from drawn.strands import Look, random_curl, render
from PIL import Image

from imaging import Photo, crossings, read_photo, segment, trace, unresolved
from imaging.measure import measure
from imaging.report.overlay import draw_overlay

HERE = Path(__file__).parent
GOOD, BAD = 4, 8  # tiles on a sheet
CURLS = 12  # drawn curls from which the sheet's are chosen
SIX = 6  # strands in the pictures of bad light
COLUMNS, TILE = 4, (300, 400)  # px wide and high
STRIP = 22  # px; the caption under a tile
RUNS: dict[str, list[list[str]]] = {
    "imaging_curls.py": [["50", "--first", "1012"], ["25", "--first", "1012", "--one-colour"]],
    "imaging_calibration.py": [["200", "--first", "6100"]],
}  # of which nothing was set; scripts not named here run without arguments
INKS = 200  # colours of a sheet, so that it stays small


class Tile(NamedTuple):
    """An overlay to be shown: how bad it is, what is said under it, how it is drawn."""

    badness: float
    caption: str
    draw: Callable[[], np.ndarray]


def run_all(only: str | None) -> None:
    """Run the other benchmarks (or only one of them) one after the other."""
    one_thread = os.environ | {"OMP_NUM_THREADS": "1", "PYTHONPATH": str(HERE.parent)}
    names = sorted({path.name for path in HERE.glob("imaging_*.py")} - {Path(__file__).name})
    for name in [only] if only else names:
        for arguments in RUNS.get(name, [[]]):
            print(f"\n== {' '.join([name, *arguments])}", flush=True)
            subprocess.run([sys.executable, name, *arguments], cwd=HERE, env=one_thread, check=True)
            used = resource.getrusage(resource.RUSAGE_CHILDREN)
            print(f"  (peak memory so far {used.ru_maxrss / 2**20:.2f} GB)", flush=True)


def overlay(photo: Photo) -> np.ndarray:
    found = segment(photo)
    strands = trace(found, photo)
    table = crossings(strands, found)
    return draw_overlay(photo, found, strands, table, unresolved(strands, table))


def mbest_tiles() -> list[Tile]:
    """Real photographs, judged by what is missed and, where nothing is, by the worst mask."""
    truth = pd.read_csv(imaging_mbest.FOLDER / "crossings.csv")
    tiles = []
    for group in imaging_mbest.DICE_ASKED:
        for number in range(30):
            one = imaging_mbest.score(group, number, truth, None)
            wrong = one.known + one.found - 2 * one.right + one.answered - one.over_right
            caption = f"{group}-{number}: Dice {one.dice:.3f}, {one.right} of {one.known} crossings"
            if not one.strands_right:
                caption += ", strands WRONG"
            path = imaging_mbest.FOLDER / group / "images" / f"img{number}.jpg"
            badness = 100 * (not one.strands_right) + 10 * wrong + 1 - one.dice
            tiles.append(Tile(badness, caption, lambda path=path: overlay(read_photo(path))))
    return tiles


def curl_tiles() -> list[Tile]:
    """Drawn curls, judged by strands that are wrong, then by crossings."""
    tiles = []
    for seed in range(CURLS):
        one = imaging_curls.score(seed)
        missed = one.crossings_true - one.crossings_right
        false = one.crossings_found - one.crossings_right
        caption = (
            f"{one.strands_right} of {imaging_curls.STRANDS} strands, {one.crossings_true} "
            f"crossings, -{missed} +{false}"
        )
        badness = 100 * (imaging_curls.STRANDS - one.strands_right) + missed + false
        pixels = imaging_curls.draw(seed).pixels
        tiles.append(Tile(badness, caption, lambda pixels=pixels: overlay(Photo(pixels))))
    return tiles


def hard_tiles() -> list[Tile]:
    """Draw six strands in good light and in conditions that a laboratory should avoid."""
    looks: dict[str, dict[str, Any]] = {
        "good light": {},
        "on black": {"background": (0.04, 0.04, 0.05)},
        "on grey": {"background": (0.45, 0.45, 0.45)},
        "half in the dark": {"uneven": 0.9},
        "glossy": {"highlight": 0.8},
        "blur 2 px": {"blur": 2.0},
        "blur 3.5 px": {"blur": 3.5},
        "noise 8 %": {"noise": 0.08},
    }
    tiles = []
    for rank, (name, changes) in enumerate(looks.items()):
        lines, heights = random_curl(SIX, 420, 150, rng=3)
        lines = [line + [160, 20] for line in lines]
        colours = imaging_curls.PALETTE[:SIX]
        look = Look(**changes)
        photo = Photo(render(lines, heights, colours, 2.8, (460, 320), look=look, rng=3).pixels)
        right, notes = hard_score(photo, lines)
        caption = f"{name}: {right} of {SIX} strands{notes}"
        tiles.append(Tile(rank, caption, lambda photo=photo: overlay(photo)))
    return tiles


def hard_score(photo: Photo, lines: list[np.ndarray]) -> tuple[int, str]:
    """Strands that are right, and the first word of each note."""
    found = measure(photo)
    right = sum(imaging_curls.right(line, found.strands) for line in lines)
    return right, "".join(f", {re.split('[:;,]', note)[0]}" for note in found.notes)


def sheet(tiles: Sequence[Tile], path: Path) -> None:
    """Draw the best tiles first, then the worst, the very worst last, as a small PNG."""
    ranked = sorted(tiles, key=lambda tile: tile.badness)
    shown = [_drawn(tile) for tile in [*ranked[:GOOD], *ranked[GOOD:][-BAD:]]]
    shown += [np.full_like(shown[0], 255)] * (-len(shown) % COLUMNS)
    rows = [np.hstack(shown[i : i + COLUMNS]) for i in range(0, len(shown), COLUMNS)]
    picture = Image.fromarray(np.vstack(rows))
    few = picture.quantize(INKS, Image.Quantize.MAXCOVERAGE, dither=Image.Dither.NONE)
    few.save(path, optimize=True)
    print(f"{path}: {path.stat().st_size / 1e3:.0f} kB")


def _drawn(tile: Tile) -> np.ndarray:
    width, height = TILE
    whole = tile.draw()
    factor = min(width / whole.shape[1], height / whole.shape[0])
    size = (round(factor * whole.shape[1]), round(factor * whole.shape[0]))
    small = cv2.resize(whole, size, interpolation=cv2.INTER_AREA)
    field = np.full((height + STRIP, width, 3), 255, np.uint8)
    x = (width - size[0]) // 2
    field[: size[1], x : x + size[0]] = small
    place = (4, height + STRIP - 7)
    cv2.putText(
        field, tile.caption, place, cv2.FONT_HERSHEY_SIMPLEX, 0.38, (0, 0, 0), 1, cv2.LINE_AA
    )
    return field


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--sheets", type=Path, help="folder for the contact sheets")
    parser.add_argument("--only-sheets", action="store_true", help="run no benchmark")
    parser.add_argument("--only", metavar="SCRIPT", help="run one benchmark, as it is run here")
    asked = parser.parse_args()
    cv2.setNumThreads(1)
    if not asked.only_sheets:
        run_all(asked.only)
    if asked.sheets is not None:
        asked.sheets.mkdir(parents=True, exist_ok=True)
        if imaging_mbest.FOLDER.is_dir():
            sheet(mbest_tiles(), asked.sheets / "imaging_mbest.png")
        sheet(curl_tiles(), asked.sheets / "imaging_curls.png")
        sheet(hard_tiles(), asked.sheets / "imaging_hard.png")


if __name__ == "__main__":
    main()
