"""Files as a study names them: relative to it, by patterns, each once."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any

from pydantic import BeforeValidator, ValidationInfo

from imaging.errors import Unmeasurable
from imaging.photo.region import Box, parse_region
from imaging.scale import FORMS, Request, parse_scale


def folder_of(info: ValidationInfo) -> Path:
    """Folder that paths are relative to: the study file's; this one where there is no file."""
    return (info.context or {}).get("folder", Path())


def _file(value: Any, info: ValidationInfo) -> Path:
    if not isinstance(value, str):
        raise ValueError("expected a file name in quotes")
    path = folder_of(info) / value
    if not path.is_file():
        raise ValueError(f"there is no file {path}")
    return path


def _files(value: Any, info: ValidationInfo) -> list[Path]:
    patterns = [value] if isinstance(value, str) else value
    if not isinstance(patterns, list) or not all(isinstance(one, str) for one in patterns):
        raise ValueError("expected a file name, a pattern with *, or a list of them")
    return [path for found in each_once(patterns, folder_of(info)) for path in found]


def each_once(patterns: Sequence[str], folder: Path) -> list[list[Path]]:
    """Return the files that each pattern stands for; raise ValueError where one is named twice."""
    named: dict[Path, tuple[str, Path]] = {}
    found = []
    for pattern in patterns:
        found.append(matches(pattern, folder))
        for path in found[-1]:
            if path.resolve() in named:
                raise ValueError(_twice(path, pattern, *named[path.resolve()]))
            named[path.resolve()] = (pattern, path)
    return found


def _twice(path: Path, pattern: str, before: str, other: Path) -> str:
    if path == other:
        by = f"by {before!r} and by {pattern!r}" if pattern != before else f"twice by {pattern!r}"
        return f"{path.name} is named {by} and would count twice"
    return f"{path.name} and {other.name} are one file and would count twice"


def _file_or_numbers(value: Any, info: ValidationInfo) -> Any:
    return _file(value, info) if isinstance(value, str) else value


def _scale(value: Any, info: ValidationInfo) -> Request:
    """Read a scale in the words of the command line; its board's photograph is the study's."""
    if not isinstance(value, str):
        raise ValueError(f"expected a scale in quotes: {FORMS}")
    request = _understood(parse_scale, value)
    return replace(request, board=str(_file(request.board, info))) if request.board else request


def _region(value: Any, info: ValidationInfo) -> Box | Path:
    if isinstance(value, list):
        value = ",".join(map(str, value))
    if isinstance(value, str) and "," in value:
        return _understood(parse_region, value)
    return _file(value, info)


def _understood(parse: Callable[[str], Any], text: str) -> Any:
    try:
        return parse(text)
    except Unmeasurable as error:
        raise ValueError(str(error)) from None


def matches(pattern: str, folder: Path) -> list[Path]:
    """Return the files that a pattern stands for, sorted; raise ValueError where there are none."""
    absolute = Path(pattern).is_absolute()
    root = Path(Path(pattern).anchor) if absolute else folder
    relative = str(Path(pattern).relative_to(root)) if absolute else pattern
    found = sorted(path for path in root.glob(relative) if path.is_file())
    if not found:
        raise ValueError(f"no file matches {root / relative}")
    return found


File = Annotated[Path, BeforeValidator(_file)]
Files = Annotated[list[Path], BeforeValidator(_files)]
FileOrNumbers = Annotated[list[float] | Path, BeforeValidator(_file_or_numbers)]
Scale = Annotated[Request, BeforeValidator(_scale)]
Region = Annotated[Any, BeforeValidator(_region)]
