"""Lens and perspective: from picture points to metres in the plane of a board.

A point at distance rho from the middle of the picture (1 = the corner) is moved along its radius by
1 + k1 rho^2 + k2 rho^4 (Brown's radial terms, written from the picture to the ideal one, so that no
equation has to be solved), then carried over by a homography. One picture of a flat board gives
the ten numbers and their covariance; the focal length is not needed and not asked for.
"""

from dataclasses import dataclass

import cv2
import numpy as np
from scipy.optimize import least_squares

LENS_SD = 0.1  # what is thought of k1 and k2 beforehand: lenses move the corner by up to a tenth
LEAST_SD = 0.05  # px; corners are not better than this, whatever their residuals
STEP = 1e-6  # of parameters that are all of order 1, for numerical derivatives
NUMBERS = 10  # eight of the homography, two of the lens


@dataclass(frozen=True)
class Plane:
    """The way from picture points to metres, and how well it is known.

    Attributes
    ----------
    theta : (10,) array
        Homography row by row (its last entry is 1), k1, k2; for picture points less `centre` over
        `radius`, giving lengths in `unit`.
    covariance : (10, 10) array
    centre : (2,) array
        Middle of the picture [px].
    radius : float
        From there to the corner [px].
    unit : float
        Metres in one unit of what the homography gives.
    corner_sd : float
        Scatter of the board's corners about the fit [px].
    """

    theta: np.ndarray
    covariance: np.ndarray
    centre: np.ndarray
    radius: float
    unit: float
    corner_sd: float

    def metres(self, points: np.ndarray) -> np.ndarray:
        """Carry picture points (n, 2) over to the plane [m]."""
        return self.unit * _carry(self.theta, self._scaled(points))

    def local(self, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Metres per pixel at picture points (square root of the area ratio), and relative sd."""
        q = self._scaled(points)
        stretch = _stretch(self.theta, q)
        steps = STEP * np.eye(NUMBERS)
        slope = np.stack([np.log(_stretch(self.theta + d, q) / stretch) / STEP for d in steps], -1)
        variance = np.einsum("ni,ij,nj->n", slope, self.covariance, slope)
        return self.unit / self.radius * stretch, np.sqrt(np.maximum(variance, 0))

    def _scaled(self, points: np.ndarray) -> np.ndarray:
        return (np.asarray(points, float).reshape(-1, 2) - self.centre) / self.radius


def fit_plane(
    corners: np.ndarray,
    places: np.ndarray,
    shape: tuple[int, int],
    corner_sd: float,
    *,
    lens: bool,
    alike: int = 1,
) -> Plane:
    """Fit the plane of a board.

    Parameters
    ----------
    corners : (n, 2) array
        In the picture [px], n >= 4, not all on a line.
    places : (n, 2) array
        The same corners on the board [m].
    shape : (h, w)
        Of the picture.
    corner_sd : float
        What to take for the corners' sd where n is too small to show it [px].
    lens : bool
        Also fit the lens; else it is taken to be ideal.
    alike : int
        Corners that err alike, as those of one marker do, and count as one.
    """
    height, width = shape
    centre = np.array([width - 1, height - 1]) / 2
    radius = float(np.hypot(width, height) / 2)
    unit = float(np.ptp(places, axis=0).max())
    q, target = (corners - centre) / radius, places / unit
    homography = cv2.findHomography(q, target)[0]
    start = np.r_[homography.ravel()[:8] / homography[2, 2], 0, 0]
    weight = (radius / _stretch(start, q))[:, None]  # from the plane's unit to pixels

    def residuals(theta: np.ndarray, sd: float) -> np.ndarray:
        off = (_carry(theta, q) - target) * weight
        return np.r_[off.ravel() / sd, theta[8:] / (LENS_SD if lens else 1e-9)]

    found = least_squares(residuals, start, args=(corner_sd,), x_scale="jac")
    spare = target.size - (NUMBERS if lens else 8)
    if spare > 0:
        scatter = np.sqrt(np.sum(found.fun[:-2] ** 2) / spare) * corner_sd
        corner_sd = max(float(scatter), LEAST_SD)
        found = least_squares(residuals, found.x, args=(corner_sd,), x_scale="jac")
    covariance = alike * np.linalg.inv(found.jac.T @ found.jac)
    return Plane(found.x, covariance, centre, radius, unit, corner_sd)


def _carry(theta: np.ndarray, q: np.ndarray) -> np.ndarray:
    square = (q**2).sum(axis=1, keepdims=True)
    ideal = q * (1 + theta[8] * square + theta[9] * square**2)
    above = ideal @ theta[[0, 1, 3, 4]].reshape(2, 2).T + theta[[2, 5]]
    return above / (1 + ideal @ theta[6:8])[:, None]


def _stretch(theta: np.ndarray, q: np.ndarray) -> np.ndarray:
    """Square root of the area that a small square becomes, over its own (n,)."""
    east, south = (
        (_carry(theta, q + step) - _carry(theta, q - step)) / (2 * STEP)
        for step in STEP * np.eye(2)
    )
    return np.sqrt(np.abs(east[:, 0] * south[:, 1] - east[:, 1] * south[:, 0]))
