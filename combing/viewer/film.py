"""A film of a run: strands over its force curve, a frame a snapshot; needs ``combing[render]``."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from itertools import chain
from pathlib import Path

import cv2
import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from numpy.typing import NDArray
from PIL import Image

import sim
from combing.camera import Camera, facing
from combing.errors import UserError
from combing.figures.style import SIMULATION, STRANDS, paper_style
from combing.render import Tine, render
from combing.runs import tine_at
from sim.records.files import replacing

Picture = NDArray[np.uint8]

COLOURS = 64  # colours of a gif
SIZE, CURVE = (720, 720), (720, 240)  # px, of the strands and of the curve below them
LASTS = 8.0  # s
MARK = tuple(int(255 * part) for part in to_rgb(SIMULATION))


def film(run: sim.Run, path: Path, *, progress: Callable[[float], object] = lambda _: None) -> None:
    """Write a film of all snapshots, eight seconds long or as slow as twelve frames a second.

    Parameters
    ----------
    run : sim.Run
    path : Path
        A ``.mp4`` (H.264) or a ``.gif``; it appears whole or not at all.
    progress : callable
        Given the share that is done.

    Raises
    ------
    UserError
        The ending is neither, or the ``render`` extra is not installed.
    """
    write = {".mp4": _write_mp4, ".gif": _write_gif}.get(path.suffix)
    if write is None:
        raise UserError(f"{path}: a film ends in .mp4 or .gif")
    rate = max(12.0, len(run.times) / LASTS)
    with replacing(path) as temporary:
        write(temporary, _counted(run, progress), rate)


def _counted(run: sim.Run, progress: Callable[[float], object]) -> Iterator[Picture]:
    for number, frame in enumerate(frames(run), start=1):
        yield frame
        progress(number / len(run.times))


def _write_mp4(path: Path, shots: Iterator[Picture], rate: float) -> None:
    try:
        import imageio_ffmpeg
    except ImportError as error:
        raise UserError('a film needs imageio-ffmpeg: pip install "combing[render]"') from error
    first = next(shots)
    writer = imageio_ffmpeg.write_frames(
        str(path), first.shape[1::-1], fps=rate, codec="libx264", output_params=["-f", "mp4"]
    )
    writer.send(None)
    try:
        for shot in chain([first], shots):
            writer.send(shot)
    finally:
        writer.close()


def _write_gif(path: Path, shots: Iterator[Picture], rate: float) -> None:
    first, *others = [Image.fromarray(shot).quantize(COLOURS) for shot in shots]
    first.save(path, format="GIF", save_all=True, append_images=others, duration=1e3 / rate, loop=0)


def frames(run: sim.Run) -> Iterator[Picture]:
    """Draw every snapshot, (h, w, 3) red, green, blue; the curve is there where a tine combs."""
    camera, curve = _camera(run), _curve(run) if run.scene.tines else None
    radii = np.asarray(run.data["radius"]).tolist()
    colours = [to_rgb(STRANDS[k % len(STRANDS)]) for k in range(len(radii))]
    for snapshot in range(len(run.times)):
        picture = render(
            run.strands(snapshot), radii, colours, camera, tine=_tine(run, snapshot),
            background=(1.0, 1.0, 1.0),
        )  # fmt: skip
        if curve is not None:
            below = _marked(*curve, 1e3 * float(run.displacements[snapshot]))
            picture = np.vstack([picture, below])
        yield np.ascontiguousarray(picture, np.uint8)


def _camera(run: sim.Run) -> Camera:
    """Look at all that ever moves, along the tine."""
    places = np.asarray(run.data["position"]).reshape(-1, 3)
    low, high = places.min(axis=0), places.max(axis=0)
    span = float((high - low).max())
    axis = np.array(run.scene.tines[0].axis) if run.scene.tines else np.array([0.0, 1.0, 0.0])
    up = np.array([0.0, 0.0, 1.0])
    towards = -axis + 0.35 * np.cross(axis, up)
    return facing(
        (low + high) / 2,
        towards,
        up,
        distance=3 * span,
        pixel_size=1.15 * span / SIZE[1],
        size=SIZE,
    )


def _tine(run: sim.Run, snapshot: int) -> Tine | None:
    if not run.scene.tines:
        return None
    tine = run.scene.tines[0]
    centre, axis = tine_at(run, float(run.displacements[snapshot]))
    span = float(np.ptp(np.asarray(run.data["position"])[..., 2]))
    return Tine(centre, axis, tine.radius, min(tine.length, span / 4))


def _curve(run: sim.Run) -> tuple[Picture, Callable[[float], int]]:
    """Draw the force over the travel; return the picture and where in it a travel [mm] is."""
    log = run.force_log()
    with paper_style():
        figure = Figure(figsize=(CURVE[0] / 100, CURVE[1] / 100), dpi=100, layout="constrained")
        canvas = FigureCanvasAgg(figure)
        panel = figure.subplots()
        panel.plot(1e3 * log["displacement"], log["force"], color="black", lw=0.8)
        panel.set(xlabel="tine displacement $d$ (mm)", ylabel="force $F$ (N)")
        panel.set_xlim(0, 1e3 * float(run.displacements.max()))
        canvas.draw()
    picture = np.asarray(canvas.buffer_rgba())[..., :3].copy()
    left, right = (float(panel.transData.transform((d, 0.0))[0]) for d in panel.get_xlim())
    furthest = panel.get_xlim()[1]
    return picture, lambda d: round(left + (right - left) * d / furthest)


def _marked(picture: Picture, across: Callable[[float], int], d: float) -> Picture:
    column, marked = across(d), picture.copy()
    cv2.line(marked, (column, 4), (column, picture.shape[0] - 46), MARK, 2)
    return marked
