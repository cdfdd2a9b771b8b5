"""Photographs of simulated strands as a camera on a tripod would take them."""

import json
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import ExifTags, Image

from combing.camera import Array, Camera, Sensor, back_project, expose, facing, project
from combing.render import Clamp, Marker, Tine, render

DISTANCE = 0.7
MARGIN = 60  # pixels round what is to be seen
CLAMP_HEIGHT = 0.006
MARKER_SIDE = 0.008
CLOTH = (0.09, 0.09, 0.09)
NYLON = [(0.85, 0.13, 0.1), (0.1, 0.32, 0.85)]
JPEG_QUALITY = 92


def frame(configurations: Iterable[Sequence[Array]], towards: Array, pixel_size: float) -> Camera:
    """Place a camera so that hanging strands fill an upright picture in every configuration.

    Parameters
    ----------
    configurations : iterable of lists of (n, 3) arrays
        Strands [m] that hang from the origin along -z.
    towards : (3,) array
        Horizontal direction from the strands to the camera.
    pixel_size : float
        Size of a pixel in the plane of the clamp that faces the camera [m].
    """
    points = np.concatenate([strand for strands in configurations for strand in strands])
    right = np.cross([0, 0, 1], towards)
    half = max(np.abs(points @ right).max() * 1.05, 1.7 * MARKER_SIDE)
    top, bottom = CLAMP_HEIGHT / 2, points[:, 2].min()
    width = 2 * int(np.ceil(half / pixel_size) + MARGIN)
    height = int(np.ceil((top - bottom) / pixel_size)) + MARGIN
    centre = np.array([0, 0, (top + bottom - MARGIN * pixel_size) / 2])
    up = np.array([0.0, 0, 1])
    return facing(
        centre, towards, up, distance=DISTANCE, pixel_size=pixel_size, size=(width, height)
    )


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
        marker=marker_beside_clamp(camera),
        background=CLOTH,
    )
    return expose(ideal, sensor or Sensor(), rng=rng)


def marker_beside_clamp(camera: Camera) -> Marker:
    """Return a marker in the upper right corner, in the vertical plane of the clamp."""
    right, down, forward = camera.axes
    corner = np.array([[camera.size[0] - MARGIN, MARGIN]])
    at = back_project(corner, camera, np.zeros(3), forward)[0] - MARKER_SIDE * right
    return Marker(corner=at, right=right, down=down, side=MARKER_SIDE)


def seen(strands: Sequence[Array], camera: Camera) -> list[Array]:
    """Project every strand to picture points (n, 2) [px]."""
    return [project(strand, camera) for strand in strands]


def save_photo(path: Path, pixels: NDArray[np.uint8], facts: dict[str, Any]) -> None:
    """Write a JPEG whose EXIF says that it is synthetic, and how it was made."""
    exif = Image.Exif()
    exif[ExifTags.Base.ImageDescription] = f"synthetic photograph (virtual lab): {facts['what']}"
    exif[ExifTags.Base.Make] = "combing virtual lab"
    exif[ExifTags.Base.Software] = "combing"
    exif.get_ifd(ExifTags.IFD.Exif)[ExifTags.Base.UserComment] = json.dumps(facts).encode("ascii")
    partial = path.with_name(f".{path.name}.partial")
    image = Image.fromarray(pixels)
    image.save(partial, "JPEG", quality=JPEG_QUALITY, subsampling=0, exif=exif)
    partial.replace(path)
