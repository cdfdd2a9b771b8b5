"""Photographs of simulated strands as a camera on a tripod would take them."""

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import ExifTags, Image
from scipy.interpolate import CubicSpline

from combing.camera import Array, Camera, Sensor, back_project, expose, facing, project
from combing.render import Clamp, Marker, Tine, render

DISTANCE = 0.7
MARGIN = 60  # pixels round what is to be seen
CLAMP_HEIGHT = 0.006
MARKER_SIDE = 0.008
MARKER_GAP = 0.006  # from the axis of the clamp to the marker
CLOTH = (0.09, 0.09, 0.09)
NYLON = [(0.85, 0.13, 0.1), (0.1, 0.32, 0.85)]
LARGE = 8e6  # px; larger pictures are stored as cameras store them: colour in half the pixels.
# Edges of a helix are measured to hundredths of one: so stored, its R is off by up to 7 %.
STORED = {True: {"quality": 75, "subsampling": 2}, False: {"quality": 92, "subsampling": 0}}
FINER = 8
UP = np.array([0.0, 0, 1])


def smooth(strand: Array) -> Array:
    """Lay a cubic spline through a strand's nodes: what hangs before the camera has no corners."""
    lengths = np.linalg.norm(np.diff(strand, axis=0), axis=1)
    at = np.concatenate([[0], np.cumsum(lengths)])
    nodes = np.arange(len(strand))
    finer = np.interp(np.linspace(0, nodes[-1], FINER * nodes[-1] + 1), nodes, at)
    return CubicSpline(at, strand)(finer)


def broadside(strands: Sequence[Array]) -> Array:
    """Horizontal direction from which hanging strands show their bends: that of least spread."""
    points = np.concatenate(list(strands))[:, :2]
    values, vectors = np.linalg.eigh(np.cov(points.T))
    return np.append(vectors[:, np.argmin(values)], 0.0)


def marker_beside_clamp(strands: Sequence[Array], towards: Array) -> Marker:
    """Return a marker level with the clamp, on the side that the strands leave free."""
    right = np.cross(UP, towards)
    across = np.concatenate(list(strands)) @ right
    start = MARKER_GAP if across.max() < -across.min() else -MARKER_GAP - MARKER_SIDE
    return Marker(corner=start * right + 0.001 * UP, right=right, down=-UP, side=MARKER_SIDE)


def frame(strands: Sequence[Array], towards: Array, pixel_size: float) -> Camera:
    """Place a camera so that hanging strands, their clamp and the marker fill the picture.

    Parameters
    ----------
    strands : sequence of (n, 3) arrays
        Strands [m] that hang from the origin along -z.
    towards : (3,) array
        Horizontal direction from the strands to the camera.
    pixel_size : float
        Size of a pixel in the vertical plane through the clamp that faces the camera [m].
    """
    marker = marker_beside_clamp(strands, towards)
    far = marker.corner + 1.2 * MARKER_SIDE * np.array([marker.right, marker.down])
    wanted = np.concatenate([*strands, far, [marker.corner - 0.2 * MARKER_SIDE * marker.right]])
    wanted = np.vstack([wanted, CLAMP_HEIGHT / 2 * UP])
    camera = facing(np.zeros(3), towards, UP, distance=DISTANCE, pixel_size=pixel_size, size=(2, 2))
    for _ in range(3):
        seen = project(wanted, camera)
        low, high = seen.min(axis=0) - MARGIN, seen.max(axis=0) + MARGIN
        centre = back_project((low + high)[None] / 2, camera, np.zeros(3), towards)[0]
        width, height = (int(edge) for edge in np.ceil(high - low))
        camera = facing(
            centre, towards, UP, distance=DISTANCE, pixel_size=pixel_size, size=(width, height)
        )
    return camera


def photograph(
    strands: Sequence[Array],
    radius: float,
    colours: Sequence[tuple[float, float, float]],
    camera: Camera,
    *,
    tine: Tine | None = None,
    sensor: Sensor | None = None,
    rng: np.random.Generator | int | None,
) -> NDArray[np.uint8]:
    """Render and expose a photograph with the clamp and a marker beside it (h, w, 3)."""
    width = 2.2 * max(np.abs(strand[0, :2]).max() for strand in strands) + 0.004
    ideal = render(
        strands,
        [radius] * len(strands),
        colours,
        camera,
        tine=tine,
        clamp=Clamp(np.array([0, 0, CLAMP_HEIGHT / 2]), (width, width, CLAMP_HEIGHT)),
        marker=marker_beside_clamp(strands, -camera.axes[2]),
        background=CLOTH,
    )
    return expose(ideal, sensor or Sensor(), rng=rng)


def save_photo(path: Path, pixels: NDArray[np.uint8], facts: dict[str, Any]) -> None:
    """Write a JPEG whose EXIF says that it is synthetic, and how it was made."""
    exif = Image.Exif()
    exif[ExifTags.Base.ImageDescription] = f"synthetic photograph (virtual lab): {facts['what']}"
    exif[ExifTags.Base.Make] = "combing virtual lab"
    exif[ExifTags.Base.Software] = "combing"
    exif.get_ifd(ExifTags.IFD.Exif)[ExifTags.Base.UserComment] = json.dumps(facts).encode("ascii")
    partial = path.with_name(f".{path.name}.partial")
    image = Image.fromarray(pixels)
    stored = STORED[image.width * image.height > LARGE]
    image.save(partial, "JPEG", **stored, optimize=True, exif=exif)
    partial.replace(path)
