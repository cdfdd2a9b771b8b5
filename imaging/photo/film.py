"""Films: their frames upright, one after the other, each with its own time."""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np

from imaging.errors import Unmeasurable

ENDINGS = {
    ".avi", ".m4v", ".mkv", ".mov", ".mp4", ".mpeg", ".mpg", ".mts", ".webm", ".wmv",
}  # fmt: skip
QUIET = 4  # frames after the first that tell the noise
HELD = 3  # frames in a row
LEAST = 3.0  # grey levels of 255
THUMBNAIL = 160  # px, the longer side


@dataclass(frozen=True)
class Frame:
    """A frame of a film.

    Attributes
    ----------
    number : int
        From 0.
    time : float
        Since the film's first frame [s], as the film has it: frames need not be equally far apart.
    pixels : (h, w, 3) uint8 array
        Blue, green, red, as OpenCV has them.
    """

    number: int
    time: float
    pixels: np.ndarray


def is_film(path: Path) -> bool:
    """Tell a film from a photograph by the ending of its name."""
    return path.suffix.lower() in ENDINGS


def frame_count(path: Path) -> int:
    """Return how many frames a film says that it has; 0 where it does not."""
    capture = _opened(path)
    count = int(capture.get(cv2.CAP_PROP_FRAME_COUNT))
    capture.release()
    return max(count, 0)


def frames(path: Path) -> Iterator[Frame]:
    """Read a film from its first frame to its last, one at a time.

    Raises
    ------
    Unmeasurable
        If it cannot be opened or holds no frame.
    """
    capture, number, first = _opened(path), 0, 0.0
    rate = capture.get(cv2.CAP_PROP_FPS) or 25.0
    try:
        while capture.grab():
            stamp = capture.get(cv2.CAP_PROP_POS_MSEC) / 1e3
            first = stamp if number == 0 else first
            # Some containers keep no times: the frames are then as far apart as the film says.
            time = stamp - first if stamp > first or number == 0 else number / rate
            yield Frame(number, time, capture.retrieve()[1])
            number += 1
    finally:
        capture.release()
    if number == 0:
        raise Unmeasurable(f"{path}: holds no frame that can be read")


def _opened(path: Path) -> cv2.VideoCapture:
    if not path.is_file():
        raise Unmeasurable(f"{path}: no such file")
    capture = cv2.VideoCapture(str(path))
    if not capture.isOpened():
        raise Unmeasurable(f"{path}: is no film that OpenCV can read")
    capture.set(cv2.CAP_PROP_ORIENTATION_AUTO, 1)  # as a telephone held it
    return capture


class Motion:
    """When something begins to move before a camera that stands still.

    A thumbnail, whose pixels are means over many, is compared with the first one: something moves
    from the first of HELD frames on in which some of it differs by more than the noise of frames
    that follow each other at first.
    """

    def __init__(self, start: float | None = None) -> None:
        self.start = start
        self._first: np.ndarray | None = None
        self._noise: list[float] = []
        self._since: list[float] = []

    def seen(self, frame: Frame) -> float | None:
        """Look at the next frame; return the time of the start [s] as soon as it is known."""
        if self.start is None:
            self._look(frame.time, _thumbnail(frame.pixels))
        return self.start

    def _look(self, time: float, small: np.ndarray) -> None:
        if self._first is None:
            self._first = small
            return
        change = float(np.abs(small - self._first).max())
        if len(self._noise) < QUIET:
            self._noise.append(change)
        moved = change > 3 * max(self._noise) + LEAST
        self._since = [*self._since, time] if moved else []
        if len(self._since) == HELD:
            self.start = self._since[0]


def _thumbnail(pixels: np.ndarray) -> np.ndarray:
    scale = min(THUMBNAIL / max(pixels.shape[:2]), 1.0)
    grey = cv2.cvtColor(pixels, cv2.COLOR_BGR2GRAY)
    return cv2.resize(grey, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA).astype(float)
