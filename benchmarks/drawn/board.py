"""Photographs of boards through a lens that is known, to test the scale that is read off them."""

from collections.abc import Callable
from typing import Any

import cv2
import numpy as np

from imaging.photo import Photo

FINE = 2  # samples per pixel and direction
DENSITY = 4.5  # drawn pixels of the board to one of the photograph, at least
PAPER = 235

Way = Callable[[np.ndarray], np.ndarray]


def camera(homography: np.ndarray, lens: tuple[float, float], shape: tuple[int, int]) -> Way:
    """Return the way from picture points (n, 2) to metres in the plane of the board.

    Parameters
    ----------
    homography : (3, 3) array
        From ideal picture points to metres.
    lens : (k1, k2)
        A point at distance rho from the middle (1 = the corner) is ideally at
        rho (1 + k1 rho^2 + k2 rho^4).
    shape : (h, w)
        Of the picture.
    """
    centre = np.array([shape[1] - 1, shape[0] - 1]) / 2
    radius = np.hypot(*shape) / 2

    def metres(points: np.ndarray) -> np.ndarray:
        away = (points - centre) / radius
        rho = np.hypot(*away.T)[:, None]
        ideal = centre + radius * away * (1 + lens[0] * rho**2 + lens[1] * rho**4)
        return cv2.perspectiveTransform(ideal[None], homography)[0]

    return metres


def local_scale(metres: Way, points: np.ndarray) -> np.ndarray:
    """Metres per pixel at picture points: root of the area of a square of one pixel."""
    east, south = (metres(points + half) - metres(points - half) for half in 0.5 * np.eye(2))
    return np.sqrt(np.abs(east[:, 0] * south[:, 1] - east[:, 1] * south[:, 0]))


def photograph_board(
    board: Any,
    size: tuple[float, float],
    metres: Way,
    shape: tuple[int, int],
    *,
    grain: float = 1e-3,
    blur: float = 0.8,
    noise: float = 0.02,
    rng: np.random.Generator | int | None = None,
) -> Photo:
    """Photograph a flat OpenCV board, whose corner is the origin, on white paper.

    Parameters
    ----------
    board : cv2.aruco.CharucoBoard or cv2.aruco.GridBoard
    size : (width, height)
        Of the board [m].
    metres : callable
        From `camera`.
    shape : (h, w)
    grain : float
        Length of which all lengths of the board are whole multiples [m].
    blur : float
        Sd of the focus blur [px].
    noise : float
        Sd of the sensor noise, of full scale.
    rng : seed or Generator, optional
    """
    middle = np.array([[shape[1] / 2, shape[0] / 2]])
    # OpenCV draws squares to whole pixels: theirs must be whole, or the board is not as stated.
    density = np.ceil(DENSITY / local_scale(metres, middle)[0] * grain) / grain
    flat = board.generateImage(tuple(round(density * one) for one in size), marginSize=0)
    y, x = (np.mgrid[: FINE * shape[0], : FINE * shape[1]] + 0.5) / FINE - 0.5
    places = density * metres(np.stack([x.ravel(), y.ravel()], axis=1)) - 0.5
    at = places.reshape(*x.shape, 2).astype(np.float32)
    fine = cv2.remap(
        flat, at[..., 0], at[..., 1], cv2.INTER_LINEAR,
        borderMode=cv2.BORDER_CONSTANT, borderValue=PAPER,
    )  # fmt: skip
    seen = cv2.resize(fine, shape[::-1], interpolation=cv2.INTER_AREA)
    seen = cv2.GaussianBlur(seen.astype(np.float32), (0, 0), blur)
    noisy = seen + np.random.default_rng(rng).normal(0, 255 * noise, shape)
    grey = np.clip(np.round(noisy), 0, 255).astype(np.uint8)
    return Photo(np.repeat(grey[..., None], 3, axis=2), "board")
