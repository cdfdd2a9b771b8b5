"""What comes of strands in light, on grounds and with clutter as a laboratory has them.

Run from the checkout:

    OMP_NUM_THREADS=1 python benchmarks/imaging_light.py [--drawings N] [--only TEXT] [--sheet FILE]

The scenes are those of `light_scenes.py`, N drawings of each. A strand is right that is followed
from end to end, one found is false that follows no strand of the truth: 97 % of it within 0.38
widths (3 px at a width of 8) of one, and 95 % of that one within as much of it.
What is said are the notes and refusals, but for those on ends, contact and guesses, which the
curves call for in any light.
"""

import argparse
from pathlib import Path
from typing import NamedTuple

import cv2
import numpy as np
from imaging_curls import matched
from imaging_one_colour import follows_one
from light_scenes import SCENES, draw
from PIL import Image

from imaging import Photo, Unmeasurable, crossings
from imaging.measure import measure

USUAL = ("strand", "contact", "interaction", "unresolved", "pair")
RADIUS = 4.0  # px, of the strands for which `follows_one` is meant
TILE = (250, 330)  # of the sheet, width and height [px]
ACROSS = 6  # tiles
COLOURS = 128  # of the sheet


class Score(NamedTuple):
    """Strands and crossings of one picture; what is said of it; the picture with what was found."""

    true: int
    right: int
    false: int
    crossings: tuple[int, int, int]
    said: list[str]
    overlay: np.ndarray


def score(name: str, seed: int) -> Score:
    pixels, truth = draw(SCENES[name], seed)
    table = crossings(truth)
    there = table.loc[table["kind"] == "inter", ["x", "y"]].to_numpy(float)
    try:
        found = measure(Photo(pixels))
    except Unmeasurable as error:
        return Score(len(truth), 0, 0, (0, 0, len(there)), [f"refused: {error}"], pixels)
    table = found.crossings
    seen = table.loc[table["kind"] == "inter", ["x", "y"]].to_numpy(float)
    said = [note for note in found.notes if not note.startswith(USUAL)]
    lines = [strand.line for strand in found.strands]
    unit = RADIUS / float(np.mean(SCENES[name].radii))
    scaled = [line * unit for line in lines]
    follows = [[follows_one(line, [one * unit]) for one in truth] for line in scaled]
    return Score(
        len(truth),
        int(np.any(follows, axis=0).sum()),
        int((~np.any(follows, axis=1)).sum()),
        (matched(seen, there) if len(seen) and len(there) else 0, len(seen), len(there)),
        said,
        drawn_over(pixels, lines),
    )


def drawn_over(pixels: np.ndarray, lines: list[np.ndarray]) -> np.ndarray:
    """Picture with a thin line of black and white dashes along every strand found, numbered."""
    over = pixels.copy()
    for number, line in enumerate(lines, start=1):
        fixed = np.round(line * 8).astype(np.int32)
        for start in range(0, len(fixed), 12):
            shade = (255,) * 3 if start // 12 % 2 else (0,) * 3
            dash = [fixed[start : start + 13]]
            cv2.polylines(over, dash, False, shade, 1, cv2.LINE_AA, 3)
        x, y = np.round(line[0]).astype(int).tolist()
        cv2.putText(over, str(number), (x, y - 4), cv2.FONT_HERSHEY_SIMPLEX, 0.7, (255, 0, 0), 2)
    return over


def tile(name: str, one: Score) -> np.ndarray:
    wide, high = TILE
    scale = min(wide / one.overlay.shape[1], high / one.overlay.shape[0])
    small = cv2.resize(one.overlay, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA)
    card = np.full((high + 26, wide + 6, 3), 255, np.uint8)
    card[26 : 26 + small.shape[0], : small.shape[1]] = small
    text = f"{name}: {one.right} of {one.true}" + (f", {one.false} false" if one.false else "")
    cv2.putText(card, text, (2, 18), cv2.FONT_HERSHEY_SIMPLEX, 0.36, (0, 0, 0), 1, cv2.LINE_AA)
    return card


def report(name: str, scores: list[Score]) -> None:
    total, good = sum(s.true for s in scores), sum(s.right for s in scores)
    false = sum(s.false for s in scores)
    hit, seen, there = np.sum([s.crossings for s in scores], axis=0).tolist()
    said = dict.fromkeys(note.split(";")[0][:90] for s in scores for note in s.said)
    print(
        f"{name:<36}{good:>3} of {total:<3}{false:>4}   {hit:>3} of {there:<3} {seen - hit:>4}   "
        + ("; ".join(said) or "-"),
        flush=True,
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--drawings", metavar="N", type=int, default=3, help="of each scene")
    parser.add_argument("--only", default="", help="scenes whose name holds this")
    parser.add_argument("--sheet", type=Path, help="picture to draw one of each scene in")
    asked = parser.parse_args()
    cv2.setNumThreads(1)
    print(f"{'scene':<36}{'strands right':<10} false  crossings  false  said")
    tiles = []
    for name in (name for name in SCENES if asked.only in name):
        scores = [score(name, seed) for seed in range(1, asked.drawings + 1)]
        report(name, scores)
        tiles.append(tile(name, min(scores, key=lambda s: s.right - s.false)))
    if asked.sheet:
        tiles += [np.full_like(tiles[0], 255)] * (-len(tiles) % ACROSS)
        rows = [np.hstack(tiles[i : i + ACROSS]) for i in range(0, len(tiles), ACROSS)]
        few = Image.fromarray(np.vstack(rows)).quantize(COLOURS)
        few.save(asked.sheet, optimize=True)


if __name__ == "__main__":
    main()
