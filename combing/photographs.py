"""Photographs as a user names them: files, folders, patterns; and their scale for a comparison."""

import glob
import hashlib
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TypeVar

import pandas as pd

import imaging
from combing.errors import UserError, is_users_fault
from imaging.photo.decode import SUFFIXES

T = TypeVar("T")


def find_photographs(names: Sequence[str]) -> list[Path]:
    """Replace folders, patterns and numbered sequences by the photographs they stand for.

    Parameters
    ----------
    names : sequence of str
        Files; folders (all photographs directly in them); patterns with ``*``, ``?``, ``[...]``;
        sequences like ``frame_%04d.png``. Numbers in names count as numbers: 2 comes before 10.

    Raises
    ------
    UserError
        When a name stands for nothing.
    """
    found = [path for name in names for path in _meant_by(name)]
    return list(dict.fromkeys(found))


def _meant_by(name: str) -> list[Path]:
    path = Path(name)
    if path.is_dir():
        inside = [p for p in path.iterdir() if p.suffix.lower() in SUFFIXES and p.name[0] != "."]
        if not inside:
            raise UserError(f"{path}: no photographs ({', '.join(SUFFIXES)}) in it")
        return sorted(inside, key=_by_number)
    if path.exists() or path.is_symlink():
        return [path]
    pattern = re.sub(r"%0?(\d*)d", lambda width: "[0-9]" * int(width[1] or 0) or "*", name)
    matches = sorted(map(Path, glob.glob(pattern)), key=_by_number)  # noqa: PTH207 - also absolute
    if not matches:
        raise UserError(f"{path}: no such file; give photographs, folders or patterns")
    return matches


def _by_number(path: Path) -> list[tuple[int, str]]:
    """Key under which frame_2 sorts before frame_10."""
    parts = re.split(r"(\d+)", path.name.casefold())
    return [(int(part), "") if part.isdecimal() else (-1, part) for part in parts]


@dataclass(frozen=True)
class Refused:
    """A photograph that cannot be measured, and why."""

    photo: Path
    reason: str


def tried(measure: Callable[..., T], path: Path, *arguments: object) -> T | Refused:
    """Measure a photograph; one that cannot be measured does not stop a study of many."""
    try:
        return measure(path, *arguments)
    except Exception as error:
        if not is_users_fault(error):
            raise
        return Refused(path, str(error))


def measured_only(
    name: str, found: Sequence[pd.DataFrame | Refused]
) -> tuple[list[int], list[pd.DataFrame], list[str]]:
    """Part what was measured in a set of photographs from what was refused.

    Returns
    -------
    places : list of int
        Where in `found` the measured ones stand.
    measured : list of DataFrame
    notes : list of str
        Which photographs were left out, and why.

    Raises
    ------
    UserError
        When there are photographs and none of them could be measured.
    """
    notes = [
        f"{name}, {one.photo.stem}: left out, {one.reason}"
        for one in found
        if isinstance(one, Refused)
    ]
    places = [i for i, one in enumerate(found) if not isinstance(one, Refused)]
    if found and not places:
        raise UserError(f"none of the photographs could be measured: {notes[0]}")
    return places, [one for one in found if not isinstance(one, Refused)], notes


def content_of(photo: imaging.Photo) -> str:
    """Return a hash of a photograph's pixels, whatever its file is called."""
    return hashlib.sha256(photo.pixels.tobytes()).hexdigest()
