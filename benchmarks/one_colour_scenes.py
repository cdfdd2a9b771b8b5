"""Drawn strands of one colour: clean crossings, small angles, loops, short contact; a dozen in few.

Angles, places, bends, widths, colour, ground, lamp, blur and noise are drawn at random.
"""

from collections.abc import Callable
from itertools import combinations_with_replacement

import numpy as np
import pandas as pd
from drawn.strands import random_curl, render
from imaging_curls import BLOND, PALETTE, SHAPE, STRANDS, varied_look
from scipy.spatial import cKDTree

from imaging import crossings

SMALL = (420, 420)  # px high and wide
SMALLEST = np.radians(15)  # angle of a clean crossing
FREE = 4.0  # strand widths from a clean crossing to the next, and to any end
BESIDE = 1.8  # strand widths; strands that do not cross there stay as far apart
TRIES = 20000

Lines = list[np.ndarray]
Drawing = tuple[np.ndarray, Lines]  # picture, and the centrelines it was drawn from


def bent(angle: float, length: int, rng: np.random.Generator, bend: float = 0.45) -> np.ndarray:
    """Line of unit steps through the picture's middle, whose direction wanders by about `bend`."""
    u = np.arange(length) / length
    waves = [rng.normal(0, 1 / k) * np.sin(np.pi * k * u + rng.uniform(0, 7)) for k in (1, 2, 3)]
    off = np.sum(waves, axis=0)
    way = angle + bend * (off - off[length // 2])
    line = np.cumsum(np.stack([np.cos(way), np.sin(way)], axis=1), axis=0)
    return line - line[length // 2] + np.array(SMALL) / 2


def across(rng: np.random.Generator) -> np.ndarray:
    """Line through the middle part of the picture, most of the way across."""
    line = bent(rng.uniform(0, np.pi), int(rng.uniform(250, 360)), rng)
    return line + rng.uniform(-70, 70, 2)


def loop(rng: np.random.Generator) -> np.ndarray:
    """Line with one loop of 25 to 45 px radius that crosses itself."""
    radius, turn = rng.uniform(25, 45), np.radians(rng.uniform(220, 310))
    arm = int(rng.uniform(90, 130))
    s = np.arange(int(2 * arm + radius * turn))
    way = rng.uniform(0, 2 * np.pi) + turn * np.clip((s - arm) / (radius * turn), 0, 1)
    line = np.cumsum(np.stack([np.cos(way), np.sin(way)], axis=1), axis=0)
    return line - line.mean(axis=0) + np.array(SMALL) / 2 + rng.uniform(-30, 30, 2)


def clean(rng: np.random.Generator, width: float) -> Lines:
    """Two to six strands, each crossing one before it; all crossings are clean."""
    count, lines = rng.integers(2, 7), [across(rng)]
    for _ in range(TRIES):
        longer = [*lines, across(rng)]
        if is_clean(longer, width) and (crossings(longer)["strand_b"] == len(longer)).any():
            lines = longer
        if len(lines) == count:
            break
    return lines


def small_angle(rng: np.random.Generator, width: float) -> Lines:
    """Two strands that cross once, at 15 to 30 degrees."""
    for _ in range(TRIES):
        angle, turn = rng.uniform(0, np.pi), np.radians(rng.uniform(15, 30))
        lines = [bent(way, int(rng.uniform(280, 340)), rng, 0.2) for way in (angle, angle + turn)]
        if is_clean(lines, width) and len(crossings(lines)) == 1:
            break
    return lines


def loops(rng: np.random.Generator, width: float) -> Lines:
    """Make one strand with a loop and one that crosses it."""
    lines = [loop(rng), across(rng)]
    for _ in range(TRIES):
        if is_clean(lines, width) and set(crossings(lines)["kind"]) == {"self", "inter"}:
            break
        lines = [loop(rng), across(rng)]
    return lines


def contact(rng: np.random.Generator, width: float) -> Lines:
    """Two strands that touch for three to eight widths and part again, half of them crossed."""
    length, together = 330, width * rng.uniform(3, 8)
    s = np.arange(length) - length / 2
    away = np.clip(np.abs(s) - together / 2, 0, None)
    apart = width * rng.uniform(0.9, 1.02) / 2 + rng.uniform(0.25, 0.6) * (np.hypot(away, 20) - 20)
    if rng.random() < 0.5:
        apart *= np.clip(s / (together / 2), -1, 1)
    middle = bent(rng.uniform(0, np.pi), length, rng)
    along = np.gradient(middle, axis=0)
    normal = np.stack([-along[:, 1], along[:, 0]], axis=1)
    return [middle + side * apart[:, None] * normal for side in (-1, 1)]


def is_clean(lines: Lines, width: float) -> bool:
    """Tell whether strands lie in the picture, cross as FREE says, and do not touch elsewhere."""
    every = np.concatenate(lines)
    if every.min() < 2 * width or (every > np.array(SMALL) - 2 * width).any():
        return False
    table = crossings(lines)
    places = table[["x", "y"]].to_numpy(float)
    ends = np.concatenate([line[[0, -1]] for line in lines])
    if len(places):
        apart = cKDTree(np.concatenate([places, ends])).query(places, k=2)[0][:, 1]
        if table["angle"].min() < SMALLEST or apart.min() < FREE * width:
            return False
    return not any(
        _touch(lines, a, b, table, width)
        for a, b in combinations_with_replacement(range(len(lines)), 2)
    )


def _touch(lines: Lines, a: int, b: int, table: pd.DataFrame, width: float) -> bool:
    """Tell whether two strands, or a strand and itself, touch where they do not cross."""
    own = table[(table["strand_a"] == a + 1) & (table["strand_b"] == b + 1)]
    clear = np.ones(len(lines[a]), bool)
    for x, y, angle in own[["x", "y", "angle"]].to_numpy(float):
        reach = (BESIDE + 0.3) * width / np.sin(angle)
        clear &= np.hypot(*(lines[a] - [x, y]).T) > reach
    at = np.flatnonzero(clear)
    if len(at) == 0:
        return True
    near = cKDTree(lines[a][at]).query_ball_point(lines[b], BESIDE * width)
    fold = 6 * width if a == b else -1
    return any(np.abs(at[others] - i).max() > fold for i, others in enumerate(near) if others)


def of_one_colour(scene: Callable[[np.random.Generator, float], Lines], seed: int) -> Drawing:
    """Draw a scene in one colour of the palette, or blond; strands that cross themselves climb."""
    rng = np.random.default_rng(seed)
    radius = rng.uniform(2.3, 3.2)
    lines = scene(rng, 2 * radius)
    heights = [
        20.0 * rank + np.linspace(0, 15, len(line))
        for rank, line in zip(rng.permutation(len(lines)), lines, strict=True)
    ]
    colours = [rng.choice(np.vstack([PALETTE, BLOND]))] * len(lines)
    drawn = render(lines, heights, colours, radius, SMALL, look=varied_look(rng), rng=rng)
    return drawn.pixels, lines


def of_few_colours(number: int, seed: int) -> Drawing:
    """Draw a curl of `imaging_curls.py` in a few colours, as many strands of each."""
    rng = np.random.default_rng(seed)
    lines, heights = random_curl(STRANDS, slope=rng.uniform(0.2, 0.3), rng=rng)
    lines = [line + [SHAPE[1] / 2, 30] for line in lines]
    chosen = np.repeat(rng.permutation(PALETTE)[:number], STRANDS // number, axis=0)
    colours, radius = rng.permutation(chosen), rng.uniform(2.3, 3.2)
    drawn = render(lines, heights, colours, radius, SHAPE, look=varied_look(rng), rng=rng)
    return drawn.pixels, lines
