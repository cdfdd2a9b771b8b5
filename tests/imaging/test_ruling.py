"""A cutting mat's grid is ground, and strands that run straight and square are none."""

import cv2
import numpy as np
import pytest
from drawn.strands import Look, render

from imaging import Photo, crossings, segment, trace
from imaging.measure.quality import notes_on

SHAPE = (300, 340)
COLOURS = [(0.9, 0.1, 0.3), (0.95, 0.8, 0.1), (0.2, 0.4, 0.9)]


def lines() -> list[np.ndarray]:
    """Two wavy strands and one across both."""
    y = np.linspace(15, 285, 400)
    waves = [np.stack([x + 25 * np.sin(y / 45), y], axis=1) for x in (110.0, 220.0)]
    return [*waves, np.stack([np.linspace(25, 315, 400), np.linspace(70, 200, 400)], axis=1)]


def mat(step: float, turned: float, thick: float = 2) -> np.ndarray:
    """Green with light lines, turned by so many degrees."""
    ground = np.empty((*SHAPE, 3))
    ground[:] = (0.1, 0.35, 0.25)
    y, x = np.mgrid[: SHAPE[0], : SHAPE[1]]
    angle = np.radians(turned)
    u, v = x * np.cos(angle) + y * np.sin(angle), y * np.cos(angle) - x * np.sin(angle)
    ground[(u % step < thick) | (v % step < thick)] = (0.85, 0.85, 0.6)
    return ground


@pytest.mark.parametrize(("step", "turned"), [(30, 0), (45, 0), (40, 12)])
def test_the_grid_of_a_cutting_mat_is_ground(step, turned):
    heights = [np.zeros(400), np.zeros(400), np.full(400, 20.0)]
    look = Look(background=mat(step, turned))
    photo = Photo(render(lines(), heights, COLOURS, 4, SHAPE, look=look, rng=3).pixels)
    found = segment(photo)
    strands = trace(found)
    assert len(found.colours) == len(strands) == 3
    assert (crossings(strands, found)["kind"] == "inter").sum() == len(crossings(lines()))
    assert any("grid" in note for note in notes_on(photo, found, strands))


def test_the_grid_is_found_in_a_large_photograph_too():
    heights = [np.zeros(400), np.zeros(400), np.full(400, 20.0)]
    look = Look(background=mat(45, 0, thick=1))
    pixels = render(lines(), heights, COLOURS, 4, SHAPE, look=look, rng=3).pixels
    photo = Photo(cv2.resize(pixels, None, fx=6, fy=6, interpolation=cv2.INTER_CUBIC))
    assert len(segment(photo).colours) == 3


def test_straight_strands_of_several_colours_are_no_grid():
    across = np.linspace(20, 320, 300)
    down = np.linspace(20, 280, 300)
    warp = [np.stack([np.full(300, x), down], axis=1) for x in (60.0, 120.0, 180.0, 240.0)]
    weft = [np.stack([across, np.full(300, y)], axis=1) for y in (60.0, 120.0, 180.0, 240.0)]
    colours = [COLOURS[0]] * 4 + [COLOURS[2]] * 4
    heights = [np.zeros(300)] * 4 + [np.full(300, 20.0)] * 4
    photo = Photo(render(warp + weft, heights, colours, 3, SHAPE, rng=1).pixels)
    assert len(trace(segment(photo))) == 8


def test_plain_ground_has_no_ruling():
    pixels = np.full((*SHAPE, 3), 230, np.uint8)
    cv2.line(pixels, (30, 20), (300, 280), (20, 20, 200), 8, cv2.LINE_AA)
    assert segment(Photo(pixels)).ruling is None
