"""Where the tine was in each photograph of a set: stated, or from the log of the machine."""

from datetime import datetime
from pathlib import Path

import numpy as np
import pandas as pd
from PIL import Image

import instron
from combing.study.errors import StudyError
from combing.study.sets import LinkSet
from combing.tables import read_table

STAMPS = (0x9003, 0x9291)  # EXIF DateTimeOriginal and SubSecTimeOriginal
EXIF = 0x8769  # the directory they are in


def tine_positions(link: LinkSet) -> list[float]:
    """Tine displacement d [m] of each photograph, in the order of ``link.photos``.

    Raises
    ------
    StudyError
        If the list or the table does not hold one number per photograph, a photograph has no time
        stamp, or was not taken while the log ran.
    instron.Unreadable, instron.Unscalable
        If the log is at fault.
    """
    if link.log_began is not None:
        stamps = [(stamp(photo) - link.log_began).total_seconds() for photo in link.photos]
        return _by_log(link, "time", stamps)
    if isinstance(link.positions, Path):
        return _from_table(link, link.positions)
    given = link.positions if link.x is None else link.x
    if given is None or len(given) != len(link.photos):
        raise StudyError(
            f"[[link]] {link.name!r}: {len(link.photos)} photographs but "
            f"{len(given or [])} positions; give one d per photograph, in the order of names"
        )
    return given if link.x is None else [x * _combed(link) for x in given]


def combed(link: LinkSet) -> float | None:
    """D, the displacement at which combing ends [m]: as stated, or the log's; None if unknown."""
    return _combed(link) if link.combed or link.log else None


def _combed(link: LinkSet) -> float:
    return link.combed or float(_curve(link)[1].attrs["D"])


def _from_table(link: LinkSet, path: Path) -> list[float]:
    columns = pd.Index(read_table(path, ["photo"]).columns)
    known = ["d", "displacement", "time"] if link.log else ["d"]
    column = next((name for name in known if name in columns), "d")
    found = [_looked_up(photo.name, path, column) for photo in link.photos]
    return found if column == "d" else _by_log(link, column, found)


def _looked_up(photo: str, path: Path, column: str) -> float:
    table = read_table(path, ["photo", column])
    rows = table.loc[table["photo"] == photo, column]
    if len(rows) != 1 or not pd.api.types.is_numeric_dtype(rows):
        raise StudyError(
            f"{path}: needs one row with a number {column} for {photo}, has {len(rows)}"
        )
    return float(rows.iloc[0])


def _by_log(link: LinkSet, column: str, readings: list[float]) -> list[float]:
    """Look up d where the machine showed these times [s] or displacements [m]."""
    stroke, curve = _curve(link)
    there = stroke[column].to_numpy(float)
    order = np.argsort(there, kind="stable")
    room = 0.02 * np.ptp(there)  # a photograph just before the start or after the end
    for photo, reading in zip(link.photos, readings, strict=True):
        if not there.min() - room <= reading <= there.max() + room:
            raise StudyError(
                f"[[link]] {link.name!r}: {photo.name} is of {column} = {reading:.6g}, the stroke "
                f"in {link.log and link.log.name} of {there.min():.6g} to {there.max():.6g}; "
                + ("log_began is the camera's time when the log's is 0" if column == "time"
                   else "displacements are in metres, as the machine showed them")
            )  # fmt: skip
    return [float(d) for d in np.interp(readings, there[order], curve["d"].to_numpy()[order])]


def _curve(link: LinkSet) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Return the first stroke of the log, and the same rows scaled."""
    assert link.log is not None  # noqa: S101 - LinkSet refuses it
    assert link.rig is not None  # noqa: S101
    logs = instron.read(link.log)
    if len(logs) > 1:
        raise StudyError(f"{link.log}: holds {len(logs)} specimens; the photographs are of one")
    stroke = instron.strokes(logs[0])[0]
    return stroke, instron.scale(logs[0], instron.load_rig(link.rig))


def stamp(photo: Path) -> datetime:
    """Return when a photograph was taken, by its camera's clock.

    Raises
    ------
    StudyError
        If it does not say.
    """
    with Image.open(photo) as image:
        tags = image.getexif().get_ifd(EXIF)
    text, fraction = (str(tags.get(tag, "")).strip("\0 ") for tag in STAMPS)
    try:
        return datetime.strptime(f"{text}.{fraction or 0}", "%Y:%m:%d %H:%M:%S.%f")  # noqa: DTZ007
    except ValueError:
        raise StudyError(
            f"{photo}: its EXIF does not say when it was taken; give positions instead of log_began"
        ) from None
