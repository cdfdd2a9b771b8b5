"""Scale, lens and perspective recovered from rendered boards and from noisy corners."""

import cv2
import numpy as np
import pytest
from drawn.board import Way, camera, local_scale, photograph_board

from imaging import Photo, Unmeasurable
from imaging.scale.board import from_charuco, from_grid
from imaging.scale.plane import fit_plane

SHAPE = (700, 900)
SQUARES, SIDE, MARKER = (7, 5), 0.015, 0.011
TILTED = np.array([[1.9e-4, 2e-5, -0.025], [-1e-5, 2e-4, -0.02], [9e-5, -6e-5, 1]])
LENS = (-0.06, 0.01)
GRID = np.stack(np.meshgrid(np.linspace(20, 880, 6), np.linspace(20, 680, 5)), -1).reshape(-1, 2)


def way(homography: np.ndarray = TILTED, lens: tuple[float, float] = LENS) -> Way:
    return camera(homography, lens, SHAPE)


def local(metres: Way) -> np.ndarray:
    return local_scale(metres, GRID)


def photographed(board, size: tuple[float, float], metres: Way) -> Photo:
    return photograph_board(board, size, metres, SHAPE, rng=1)


def charuco(dictionary: int = cv2.aruco.DICT_5X5_100, legacy: bool = False):
    known = cv2.aruco.getPredefinedDictionary(dictionary)
    board = cv2.aruco.CharucoBoard(SQUARES, SIDE, MARKER, known)
    board.setLegacyPattern(legacy)
    return board


def test_the_drawn_camera_moves_points_as_brown_says():
    centre, corner = (np.array(SHAPE[::-1]) - 1) / 2, np.array([SHAPE[1] - 1, SHAPE[0] - 1.0])
    lens = camera(np.eye(3), (0.1, -0.02), SHAPE)
    rho = np.hypot(*(corner - centre)) / (np.hypot(*SHAPE) / 2)
    for part in (1.0, 0.5):
        point = centre + part * (corner - centre)
        moved = 1 + 0.1 * (part * rho) ** 2 - 0.02 * (part * rho) ** 4
        np.testing.assert_allclose(lens(point[None])[0] - centre, moved * (point - centre))


@pytest.fixture(scope="module")
def tilted() -> Photo:
    return photographed(charuco(), (7 * SIDE, 5 * SIDE), way())


def test_charuco_board_gives_the_scale_everywhere_within_its_sd(tilted):
    scale, _ = from_charuco(tilted, SQUARES, SIDE, MARKER)
    true = local(way())
    found, sd = scale.plane.local(GRID)
    assert np.ptp(true) / true.mean() > 0.1  # the plane does lean
    assert (np.abs(found / true - 1) < 2 * sd).all()
    assert sd.max() < 0.03
    assert sd.min() < 3e-4
    assert abs(scale.metres_per_pixel / true.mean() - 1) < scale.relative_sd


def test_lengths_on_the_board_are_true_across_the_picture(tilted):
    scale, _ = from_charuco(tilted, SQUARES, SIDE, MARKER)
    way_there = way()
    ends = np.array([[150.0, 150.0], [750.0, 550.0]])
    length = np.hypot(*np.diff(scale.metres(ends), axis=0)[0])
    assert length == pytest.approx(np.hypot(*np.diff(way_there(ends), axis=0)[0]), rel=1e-3)
    apart = np.hypot(*np.diff(ends, axis=0)[0]) * scale.metres_per_pixel
    assert abs(apart / length - 1) > 5e-3  # what one number for the whole picture would say


def test_the_board_is_hidden(tilted):
    _, photo = from_charuco(tilted, SQUARES, SIDE, MARKER)
    dark = tilted.pixels[..., 0] < 100
    assert dark.sum() > 5000
    assert not (dark & ~photo.ignore).any()
    assert (~photo.ignore).mean() > 0.2


def test_an_older_board_is_known_too():
    straight = way(np.array([[2e-4, 0, -0.04], [0, 2e-4, -0.025], [0, 0, 1]]), (0, 0))
    squares = (7, 6)  # the patterns differ where rows are even in number
    known = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_4X4_50)
    board = cv2.aruco.CharucoBoard(squares, SIDE, MARKER, known)
    board.setLegacyPattern(True)
    photo = photographed(board, (7 * SIDE, 6 * SIDE), straight)
    scale, _ = from_charuco(photo, squares, SIDE, MARKER)
    assert scale.plane.local(np.array([[450.0, 350.0]]))[0] == pytest.approx(2e-4, rel=1e-3)


def test_grid_of_markers():
    metres = way()
    known = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_6X6_250)
    board = cv2.aruco.GridBoard((4, 3), 0.018, 0.005, known)
    photo = photographed(board, (4 * 0.023 - 0.005, 3 * 0.023 - 0.005), metres)
    scale, _ = from_grid(photo, (4, 3), 0.018, 0.005)
    found, sd = scale.plane.local(GRID)
    assert (np.abs(found / local(metres) - 1) < 2 * sd).all()


def test_the_stated_sd_covers_the_truth_as_often_as_it_says():
    metres, true = way(), local(way())
    x, y = np.meshgrid(np.linspace(180, 720, 6), np.linspace(150, 560, 4))
    corners = np.stack([x.ravel(), y.ravel()], axis=1)
    places, rng = metres(corners), np.random.default_rng(3)
    inside = []
    for _ in range(40):
        noisy = corners + rng.normal(0, 0.2, corners.shape)
        found, sd = fit_plane(noisy, places, SHAPE, 0.15, lens=True).local(GRID)
        inside.append(np.abs(found / true - 1) < 1.96 * sd)
    assert 0.90 < np.mean(inside) < 0.995


@pytest.mark.parametrize(
    ("squares", "side", "marker", "reason"),
    [
        ((3, 2), SIDE, MARKER, "0 of the 2 corners .* at least 8"),
        (SQUARES, MARKER, SIDE, "markers must be smaller than squares"),
        ((1, 1), SIDE, MARKER, "2 x 2 or more"),
        (SQUARES, 2 * SIDE, MARKER, "markers measure 2[12].* mm, not 11 mm"),
        (SQUARES, SIDE, MARKER / 2, "markers measure 1[01].* mm, not 5.5 mm"),
    ],
)
def test_a_board_that_is_not_as_stated_is_refused(tilted, squares, side, marker, reason):
    with pytest.raises(Unmeasurable, match=reason):
        from_charuco(tilted, squares, side, marker)


def test_no_board_is_refused():
    blank = Photo(np.full((*SHAPE, 3), 235, np.uint8), "blank.png")
    with pytest.raises(Unmeasurable, match="blank.png: no board found"):
        from_charuco(blank, SQUARES, SIDE, MARKER)
