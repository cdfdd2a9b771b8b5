"""Photographs of simulated strands, drawn off-screen; needs the ``render`` extra (pyvista)."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from combing.camera import Array, Camera
from combing.errors import UserError

SIDES = 32
TILE = 1536
MARKER_DICTIONARY = cv2.aruco.DICT_4X4_50
MARKER_CELLS = 6


@dataclass(frozen=True)
class Tine:
    """The comb's tine: a cylinder round `centre` along `axis` [m]."""

    centre: Array
    axis: Array
    radius: float
    length: float


@dataclass(frozen=True)
class Marker:
    """An ArUco marker of a stated `side` [m] in a plane: corner top left, then right and down."""

    corner: Array
    right: Array
    down: Array
    side: float
    number: int = 0


@dataclass(frozen=True)
class Clamp:
    """The block that holds the roots: a box round `centre` with edges along the axes [m]."""

    centre: Array
    edges: tuple[float, float, float]


def render(
    strands: Sequence[Array],
    radii: Sequence[float],
    colours: Sequence[tuple[float, float, float]],
    camera: Camera,
    *,
    tine: Tine | None = None,
    clamp: Clamp | None = None,
    marker: Marker | None = None,
    background: tuple[float, float, float] = (0.05, 0.05, 0.05),
    supersampling: int = 2,
) -> NDArray:
    """Draw strands as shaded tubes as an ideal camera would see them.

    Parameters
    ----------
    strands : sequence of (n, 3) arrays
        Centrelines [m].
    radii : sequence of float
        Radius of each strand [m].
    colours : sequence of (red, green, blue)
        Colour of each strand, 0 to 1.
    camera : Camera
        Where the picture is taken from.
    tine, clamp, marker : optional
        What else is in the picture.
    background : (red, green, blue)
        Colour behind everything, 0 to 1.
    supersampling : int
        Samples per pixel side before averaging down.

    Returns
    -------
    (h, w, 3) array of uint8
        Red, green, blue.

    Raises
    ------
    combing.errors.UserError
        If pyvista is not installed.
    """
    with _plotter(camera, background) as plotter:
        for strand, radius, colour in zip(strands, radii, colours, strict=True):
            _add_tube(plotter, strand, radius, colour)
        _add_props(plotter, tine, clamp, marker)
        return _drawn_in_tiles(plotter, camera, supersampling)


def load_pyvista() -> Any:
    """Import pyvista, or say in one line how to get it."""
    try:
        import pyvista
    except ImportError as error:
        raise UserError('rendering needs pyvista: pip install "combing[render]"') from error
    return pyvista


@contextmanager
def _plotter(camera: Camera, background: Sequence[float]) -> Iterator[Any]:
    pyvista = load_pyvista()
    from vtkmodules.vtkCommonCore import vtkLogger

    # VTK complains about an absent screen before it falls back to drawing without one.
    vtkLogger.SetStderrVerbosity(vtkLogger.VERBOSITY_OFF)
    plotter = pyvista.Plotter(off_screen=True, window_size=[64, 64], lighting="none")
    try:
        plotter.set_background(background)
        plotter.camera.position = camera.position
        plotter.camera.focal_point = camera.target
        plotter.camera.up = camera.up
        _light(plotter, pyvista, camera)
        yield plotter
    finally:
        plotter.close()


def _drawn_in_tiles(plotter: Any, camera: Camera, supersampling: int) -> NDArray:
    """Draw tile by tile: beyond some size the graphics library returns black without a word."""
    width, height = camera.size
    picture = np.empty((height, width, 3), np.uint8)
    for top in range(0, height, TILE):
        for left in range(0, width, TILE):
            size = (min(TILE, width - left), min(TILE, height - top))
            _aim(plotter, camera, (left, top), size)
            plotter.window_size = [supersampling * edge for edge in size]
            drawn = plotter.screenshot(None, return_img=True)[..., :3]
            tile = cv2.resize(drawn, size, interpolation=cv2.INTER_AREA)
            picture[top : top + size[1], left : left + size[0]] = tile
    return picture


def _aim(plotter: Any, camera: Camera, corner: tuple[int, int], size: tuple[int, int]) -> None:
    """Let the window see one tile of the picture: an off-axis view from the same pinhole."""
    tile = np.array(size)
    offset = 2 * (corner + (tile - 1) / 2 - camera.centre) / tile
    plotter.camera.SetWindowCenter(offset[0], -offset[1])
    half = size[1] * camera.pixel_pitch / (2 * camera.focal_length)
    plotter.camera.view_angle = np.degrees(2 * np.arctan(half))
    plotter.renderer.ResetCameraClippingRange()


def _light(plotter: Any, pyvista: Any, camera: Camera) -> None:
    """Two lamps over the photographer's shoulders: tubes shade without going black."""
    right, down, forward = camera.axes
    for side, intensity in ((-0.8, 0.75), (0.7, 0.45)):
        direction = -forward + side * right - 0.5 * down
        lamp = pyvista.Light(light_type="scene light", intensity=intensity)
        lamp.positional = False
        lamp.position = tuple(np.asarray(camera.target) + direction)
        lamp.focal_point = camera.target
        plotter.add_light(lamp)


def _add_tube(plotter: Any, strand: Array, radius: float, colour: Sequence[float]) -> None:
    line = load_pyvista().lines_from_points(np.asarray(strand))
    tube = line.tube(radius=radius, n_sides=SIDES, capping=True)
    plotter.add_mesh(
        tube,
        color=[float(level) for level in colour],
        smooth_shading=True,
        ambient=0.35,
        diffuse=0.75,
        specular=0.15,
        specular_power=20,
        reset_camera=False,
    )


def _add_props(plotter: Any, tine: Tine | None, clamp: Clamp | None, marker: Marker | None) -> None:
    pyvista = load_pyvista()
    # Matt black, as one paints what must not shine beside coloured strands.
    black = {"color": (0.1, 0.1, 0.1), "ambient": 0.4, "diffuse": 0.4, "reset_camera": False}
    if tine is not None:
        cylinder = pyvista.Cylinder(
            center=tine.centre, direction=tine.axis, radius=tine.radius, height=tine.length
        )
        plotter.add_mesh(cylinder, **black)
    if clamp is not None:
        length, width, height = clamp.edges
        box = pyvista.Cube(center=clamp.centre, x_length=length, y_length=width, z_length=height)
        plotter.add_mesh(box, **black)
    if marker is not None:
        plotter.add_mesh(
            _quad(marker), texture=_pattern(marker), lighting=False, reset_camera=False
        )


def _quad(marker: Marker) -> Any:
    """Return the marker's plane, with a white margin of one cell so that it can be found."""
    cell = marker.side / MARKER_CELLS
    right, down = (
        np.asarray(edge) * (marker.side + 2 * cell) for edge in (marker.right, marker.down)
    )
    corner = np.asarray(marker.corner) - cell * (np.asarray(marker.right) + np.asarray(marker.down))
    corners = np.array([corner + down, corner + down + right, corner + right, corner])
    quad = load_pyvista().PolyData(corners, faces=[4, 0, 1, 2, 3])
    quad.active_texture_coordinates = np.array([[0, 0], [1, 0], [1, 1], [0, 1]], dtype=float)
    return quad


def _pattern(marker: Marker) -> Any:
    dictionary = cv2.aruco.getPredefinedDictionary(MARKER_DICTIONARY)
    side = 32 * MARKER_CELLS
    pattern = cv2.aruco.generateImageMarker(dictionary, marker.number, side)
    framed = cv2.copyMakeBorder(pattern, 32, 32, 32, 32, cv2.BORDER_CONSTANT, value=255)
    return load_pyvista().numpy_to_texture(np.repeat(framed[..., None], 3, axis=2))
