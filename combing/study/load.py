"""Read study files and sweep files."""

import tomllib
from pathlib import Path
from typing import TypeVar

from pydantic import ValidationError

from combing.study.errors import StudyError, fault
from combing.study.plan import Sweep
from combing.study.positions import tine_positions
from combing.study.sets import Table
from combing.study.study import Study

T = TypeVar("T", bound=Table)


def load_study(path: Path) -> Study:
    """Read a study file.

    Parameters
    ----------
    path : Path
        TOML file.

    Raises
    ------
    StudyError
        If the file does not exist or is not TOML, a key is unknown or missing, a value has the
        wrong type, a named file does not exist or is named twice, or two sets have one name.
    """
    study = _load(Path(path), Study)
    for link in study.link:
        tine_positions(link)
    return study


def load_sweep(path: Path) -> Sweep:
    """Read a sweep file.

    Parameters
    ----------
    path : Path
        TOML file.

    Raises
    ------
    StudyError
        If the file does not exist or is not TOML, a key or a parameter is unknown, a value has the
        wrong type, or a point is no scene.
    """
    return _load(Path(path), Sweep)


def _load(path: Path, model: type[T]) -> T:
    what = model.__name__.lower()
    if not path.is_file():
        raise StudyError(f"{path}: there is no such {what} file")
    try:
        content = tomllib.loads(path.read_text(encoding="utf-8"))
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise StudyError(f"{path}: not TOML: {error}") from error
    try:
        return model.model_validate(content, context={"folder": path.parent.resolve()})
    except ValidationError as error:
        raise StudyError(f"{path}: {fault(error, model)}") from error
