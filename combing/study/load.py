"""Read study files and sweep files."""

import tomllib
from pathlib import Path
from typing import Any, TypeVar

from pydantic import ValidationError

from combing.study.errors import StudyError, fault
from combing.study.plan import Sweep
from combing.study.positions import tine_positions
from combing.study.sets import Table
from combing.study.study import Study

T = TypeVar("T", bound=Table)
LOGS = {"force": "logs", "sweep": "logs", "link": "log"}  # what a set's rig is for


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
    study = load_table(Path(path), Study)
    study._path = Path(path)
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
    return load_table(Path(path), Sweep)


def load_table(path: Path, model: type[T]) -> T:
    """Read a TOML file as a model, as `load_study` does; names in it are relative to the file.

    Raises
    ------
    StudyError
        As of `load_study`.
    """
    what = model.__name__.lower().removesuffix("plan")
    if not path.is_file():
        raise StudyError(f"{path}: there is no such {what} file")
    try:
        content = tomllib.loads(path.read_text(encoding="utf-8"))
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise StudyError(f"{path}: not TOML: {error}") from error
    try:
        content = _with_rig(content, path)
        return model.model_validate(content, context={"folder": path.parent.resolve()})
    except ValidationError as error:
        raise StudyError(f"{path}: {fault(error, model)}") from error


def _with_rig(content: dict[str, Any], path: Path) -> dict[str, Any]:
    """Name the file's own table [rig] in every set of logs that names no rig."""
    if not isinstance(content.get("rig"), dict):
        return content
    if "logs" in content:  # a fit file is one set itself
        return content | {"rig": path.name}
    sets = [one for kind, logs in LOGS.items() for one in content.get(kind, []) if logs in one]
    if not sets:
        raise StudyError(f"{path}: [rig]: there is no set with logs that need it")
    for one in sets:
        one.setdefault("rig", path.name)
    return {key: value for key, value in content.items() if key != "rig"}
