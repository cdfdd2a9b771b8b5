"""Scale from photographed boards, markers and strands whose truth is known: asked beside reached.

Run from the checkout:

    OMP_NUM_THREADS=1 python benchmarks/imaging_scale.py [BOARDS]

BOARDS (40) photographs of a ChArUco board, and half as many of a grid of markers, are drawn with
varied perspective, lens, size and place.
"""

import argparse
from collections.abc import Callable
from typing import Any

import cv2
import numpy as np
from drawn.board import camera, local_scale, photograph_board
from drawn.strands import Look, render

from imaging import Photo, segment, trace
from imaging.measure.measured import full_widths
from imaging.scale import Scale, from_filament, from_marker, from_ruler
from imaging.scale.board import from_charuco, from_grid

SHAPE = (900, 1200)
SQUARES, SIDE, MARKER = (7, 5), 0.015, 0.011  # m
MARKERS, GAP = (6, 4), 0.004
WHERE = np.stack(np.meshgrid(np.linspace(0, 1199, 7), np.linspace(0, 899, 5)), -1).reshape(-1, 2)


def varied(
    rng: np.random.Generator, size: tuple[float, float]
) -> tuple[np.ndarray, tuple[float, float]]:
    """Choose a homography and a lens: turned, leaning by up to 20 degrees, barrel or cushion."""
    turn, pixel = rng.uniform(-0.4, 0.4), rng.uniform(1.2e-4, 2e-4)
    rotation = pixel * np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])
    middle = np.array([SHAPE[1], SHAPE[0]]) * rng.uniform(0.35, 0.65, 2)
    homography = np.eye(3)
    homography[:2, :2], homography[:2, 2] = rotation, np.array(size) / 2 - rotation @ middle
    homography[2, :2] = rng.uniform(-1e-4, 1e-4, 2)
    return homography, (rng.uniform(-0.08, 0.08), rng.uniform(-0.02, 0.02))


def boards(number: int) -> None:
    known = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_5X5_100)
    size = (SQUARES[0] * SIDE, SQUARES[1] * SIDE)
    charuco = cv2.aruco.CharucoBoard(SQUARES, SIDE, MARKER, known)
    one("ChArUco", number, charuco, size, lambda p: from_charuco(p, SQUARES, SIDE, MARKER))
    grid = cv2.aruco.GridBoard(MARKERS, SIDE, GAP, known)
    size = (MARKERS[0] * (SIDE + GAP) - GAP, MARKERS[1] * (SIDE + GAP) - GAP)
    one("marker grid", number // 2, grid, size, lambda p: from_grid(p, MARKERS, SIDE, GAP))


def one(
    name: str,
    number: int,
    board: Any,
    size: tuple[float, float],
    find: Callable[[Photo], tuple[Scale, Photo]],
) -> None:
    near, single, inside = [], [], []
    for seed in range(number):
        rng = np.random.default_rng(seed)
        way = camera(*varied(rng, size), SHAPE)
        scale, _ = find(photograph_board(board, size, way, SHAPE, rng=rng))
        assert scale.plane is not None
        true = local_scale(way, WHERE)
        reached, sd = scale.plane.local(WHERE)
        error = reached / true - 1
        inside.append(np.abs(error) < 1.96 * sd)
        near.append(error[sd < 1e-3])
        single.append(scale.metres_per_pixel / true - 1)
    line(f"{name}, {number} boards: truth within 95 % intervals, %", 100 * np.mean(inside),
         ">= 90", 1)  # fmt: skip
    line("   error where sd < 0.1 %, RMS %", 100 * rms(np.concatenate(near)), "-", 4)
    line("   one number for the picture instead, RMS %", 100 * rms(np.concatenate(single)), "-", 2)


def markers(number: int = 40) -> None:
    known = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_4X4_50)
    z, errors = [], []
    for seed in range(number):
        rng = np.random.default_rng(seed)
        side = float(rng.uniform(60, 160))  # px
        way = camera(np.diag([1 / side, 1 / side, 1]) @ _moved(rng), (0.0, 0.0), (400, 600))
        board = cv2.aruco.GridBoard((1, 1), 1.0, 0.5, known)
        blur = rng.uniform(0.5, 1.5)
        photo = photograph_board(
            board, (1.0, 1.0), way, (400, 600), grain=1 / 6, blur=blur, rng=rng
        )
        scale, _ = from_marker(photo, 1.0)
        errors.append(scale.metres_per_pixel * side - 1)
        z.append(errors[-1] / scale.relative_sd)
    line("single marker, side 60 - 160 px: error, RMS %", 100 * rms(np.array(errors)), "-", 3)
    line("   truth within 95 % intervals, %", 100 * np.mean(np.abs(z) < 1.96), ">= 90", 1)


def _moved(rng: np.random.Generator) -> np.ndarray:
    turn = rng.uniform(-0.5, 0.5)
    cos, sin = np.cos(turn), np.sin(turn)
    return np.array(
        [[cos, -sin, -220 * cos + 120 * sin], [sin, cos, -220 * sin - 120 * cos], [0, 0, 1]]
    )


def filaments() -> None:
    errors, z = [], []
    for background in ((0.95, 0.95, 0.93), (0.08, 0.08, 0.09), (0.5, 0.5, 0.5)):
        for radius in (3.0, 6.0):
            lines = [np.linspace([40, 30 + 60 * i], [360, 50 + 60 * i], 400) for i in range(3)]
            colours = [(0.85, 0.1, 0.2), (0.9, 0.8, 0.1), (0.1, 0.3, 0.8)]
            drawn = render(lines, [np.zeros(400)] * 3, colours, radius, (240, 400),
                           look=Look(background=background), rng=1)  # fmt: skip
            photo = Photo(drawn.pixels)
            scale = from_filament(full_widths(trace(segment(photo), photo)), 1.0)
            errors.append(scale.metres_per_pixel * 2 * radius - 1)
            z.append(errors[-1] / scale.relative_sd)
    line("filament diameter: error, worst %", 100 * max(errors, key=abs), "-", 1)
    line("   truth within 95 % intervals, %", 100 * np.mean(np.abs(z) < 1.96), ">= 90", 1)


def rulers(number: int = 400) -> None:
    rng = np.random.default_rng(0)
    ends = np.array([[100.0, 200.0], [900.0, 260.0]])
    clicks = np.round(ends + rng.normal(0, 0.6, (number, 2, 2)))  # a careful hand, whole pixels
    true = 0.05 / np.hypot(*(ends[1] - ends[0]))
    scales = [from_ruler(a, b, 0.05) for a, b in clicks]
    z = np.array([(s.metres_per_pixel / true - 1) / s.relative_sd for s in scales])
    line("ruler of 800 px clicked: truth within 95 % intervals, %", 100 * np.mean(np.abs(z) < 1.96),
         "90 - 98", 1)  # fmt: skip


def rms(errors: np.ndarray) -> float:
    return float(np.sqrt(np.mean(np.square(errors))))


def line(name: str, reached: float, asked: str, digits: int) -> None:
    print(f"  {name:<56} {reached:>9.{digits}f}   asked {asked}", flush=True)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("boards", metavar="BOARDS", type=int, nargs="?", default=40)
    number = parser.parse_args().boards
    cv2.setNumThreads(1)
    print("scale")
    boards(number)
    markers()
    filaments()
    rulers()


if __name__ == "__main__":
    main()
