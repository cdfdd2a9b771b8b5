"""Read a study file."""

import tomllib
from pathlib import Path

from pydantic import ValidationError

from combing.study.errors import StudyError, fault
from combing.study.positions import tine_positions
from combing.study.sets import Study


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
    path = Path(path)
    if not path.is_file():
        raise StudyError(f"{path}: there is no such study file")
    try:
        content = tomllib.loads(path.read_text(encoding="utf-8"))
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise StudyError(f"{path}: not TOML: {error}") from error
    try:
        study = Study.model_validate(content, context={"folder": path.parent.resolve()})
    except ValidationError as error:
        raise StudyError(f"{path}: {fault(error, Study)}") from error
    for link in study.link:
        tine_positions(link)
    return study
