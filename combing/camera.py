"""A pinhole camera and a sensor: from space to the picture plane and back, and what a chip adds."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Camera:
    """A pinhole camera without distortion, looking from `position` towards `target`.

    Parameters
    ----------
    position, target : sequence of 3 floats
        The pinhole and a point on the optical axis [m].
    up : sequence of 3 floats
        Direction that points up in the picture; need not be perpendicular to the axis.
    focal_length : float
        Distance from the pinhole to the sensor [m].
    pixel_pitch : float
        Distance between pixel centres on the sensor [m].
    size : (int, int)
        Width and height of the picture [px].

    Notes
    -----
    Picture points are pixel centres at integer coordinates, x right and y down; the optical axis
    meets the picture at ``((width - 1) / 2, (height - 1) / 2)``.
    """

    position: tuple[float, float, float]
    target: tuple[float, float, float]
    up: tuple[float, float, float]
    focal_length: float
    pixel_pitch: float
    size: tuple[int, int]

    @property
    def axes(self) -> Array:
        """Unit vectors (3, 3) in space: rows are picture right, picture down, and forward."""
        forward = _unit(np.subtract(self.target, self.position))
        right = _unit(np.cross(forward, self.up))
        return np.stack([right, np.cross(forward, right), forward])

    @property
    def centre(self) -> Array:
        """Where the optical axis meets the picture (2,) [px]."""
        return (np.array(self.size) - 1) / 2


def facing(
    centre: Array,
    towards: Array,
    up: Array,
    *,
    distance: float,
    pixel_size: float,
    size: tuple[int, int],
    focal_length: float = 0.1,
) -> Camera:
    """Place a camera `distance` before `centre` so that a pixel there covers `pixel_size`.

    Parameters
    ----------
    centre : (3,) array
        The point in the middle of the picture [m].
    towards : (3,) array
        Direction from `centre` to the camera.
    up : (3,) array
        Direction that points up in the picture.
    distance, pixel_size, focal_length : float
        Object distance, object size of one pixel at that distance, and focal length [m].
    size : (int, int)
        Width and height of the picture [px].
    """
    position = np.asarray(centre) + distance * _unit(np.asarray(towards, dtype=float))
    return Camera(
        position=_triple(position),
        target=_triple(centre),
        up=_triple(up),
        focal_length=focal_length,
        pixel_pitch=pixel_size * focal_length / distance,
        size=size,
    )


def depth(points: Array, camera: Camera) -> Array:
    """Distance of points (n, 3) from the pinhole along the optical axis (n,) [m]."""
    return (np.asarray(points) - camera.position) @ camera.axes[2]


def project(points: Array, camera: Camera) -> Array:
    """Project points (n, 3) [m] to picture points (n, 2) [px].

    Raises
    ------
    ValueError
        If a point lies behind the camera.
    """
    right, down, ahead = camera.axes @ (np.asarray(points) - camera.position).T
    if np.any(ahead <= 0):
        raise ValueError("a point lies behind the camera")
    scale = camera.focal_length / camera.pixel_pitch
    return camera.centre + scale * np.stack([right / ahead, down / ahead], axis=1)


def back_project(pixels: Array, camera: Camera, origin: Array, normal: Array) -> Array:
    """Meet the sight lines of picture points (n, 2) with a plane in space, as points (n, 3) [m].

    Parameters
    ----------
    pixels : (n, 2) array
        Picture points [px].
    camera : Camera
        The camera.
    origin, normal : (3,) arrays
        A point of the plane [m] and its normal.
    """
    offset = (np.asarray(pixels) - camera.centre) * camera.pixel_pitch / camera.focal_length
    rays = np.column_stack([offset, np.ones(len(offset))]) @ camera.axes
    to_plane = np.dot(np.asarray(origin) - camera.position, normal) / (rays @ np.asarray(normal))
    return camera.position + rays * to_plane[:, None]


@dataclass(frozen=True)
class Sensor:
    """What light and chip do to an ideal picture; every length is in pixels.

    Parameters
    ----------
    blur : float
        Standard deviation of the point spread [px].
    noise : float
        Standard deviation of the noise at full scale, as a fraction of full scale; it falls with
        the square root of the brightness down to `dark_noise`.
    dark_noise : float
        Standard deviation of the noise in the dark, as a fraction of full scale.
    uneven : float
        Relative brightness change of the lighting from the middle to the corners.
    vignette : float
        Relative loss of light in the corners of the picture.
    """

    blur: float = 1.0
    noise: float = 0.02
    dark_noise: float = 0.005
    uneven: float = 0.2
    vignette: float = 0.15


def expose(ideal: NDArray, sensor: Sensor, *, rng: np.random.Generator | int | None) -> NDArray:
    """Turn an ideal picture (h, w, 3) uint8 into what the camera would have recorded, uint8.

    The light is multiplied by a smooth slope and bend with a direction drawn from `rng`, then by
    the vignette; blur comes before noise, as on a chip.
    """
    rng = np.random.default_rng(rng)
    light = ideal.astype(np.float32) / 255 * _lighting(ideal.shape[:2], sensor, rng)[..., None]
    for channel in range(3):
        light[..., channel] = ndimage.gaussian_filter(light[..., channel], sensor.blur)
    spread = np.hypot(sensor.dark_noise, sensor.noise * np.sqrt(np.clip(light, 0, 1)))
    light += spread * rng.standard_normal(light.shape, dtype=np.float32)
    return np.round(255 * np.clip(light, 0, 1)).astype(np.uint8)


def _lighting(shape: tuple[int, int], sensor: Sensor, rng: np.random.Generator) -> NDArray:
    y, x = (np.linspace(-1, 1, n, dtype=np.float32) for n in shape)
    turn = rng.uniform(0, 2 * np.pi)
    along = np.cos(turn) * x[None, :] + np.sin(turn) * y[:, None]
    radius = (x[None, :] ** 2 + y[:, None] ** 2) / 2
    return (1 + sensor.uneven * (along - along**2 / 2)) * (1 - sensor.vignette * radius)


def _unit(vector: Array) -> Array:
    return vector / np.linalg.norm(vector)


def _triple(vector: Array) -> tuple[float, float, float]:
    x, y, z = (float(value) for value in vector)
    return x, y, z
