"""The study file: which photographs, force logs and scenes are compared, and how.

A study is a TOML file; paths in it are relative to it and may hold ``*``. See ``docs/study.md``.
"""

import difflib
import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Annotated, Any, Literal, get_args

import pandas as pd
from pydantic import (
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Field,
    PositiveFloat,
    PositiveInt,
    ValidationError,
    ValidationInfo,
    model_validator,
)

from combing.errors import UserError
from combing.tables import read_table


class StudyError(UserError):
    """A study file is wrong; the message names the file, the key, and what would be right."""


def _folder(info: ValidationInfo) -> Path:
    return (info.context or {})["folder"]


def _file(value: Any, info: ValidationInfo) -> Path:
    if not isinstance(value, str):
        raise ValueError("expected a file name in quotes")
    path = _folder(info) / value
    if not path.is_file():
        raise ValueError(f"there is no file {path}")
    return path


def _files(value: Any, info: ValidationInfo) -> list[Path]:
    patterns = [value] if isinstance(value, str) else value
    if not isinstance(patterns, list) or not all(isinstance(one, str) for one in patterns):
        raise ValueError("expected a file name, a pattern with *, or a list of them")
    return [path for pattern in patterns for path in _matches(pattern, _folder(info))]


def _file_or_numbers(value: Any, info: ValidationInfo) -> Any:
    return _file(value, info) if isinstance(value, str) else value


def _matches(pattern: str, folder: Path) -> list[Path]:
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


class _Table(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True)


class ForceSet(_Table):
    """Repeats of one combing on the testing machine, beside their simulation and Love's curve.

    Attributes
    ----------
    name : str
        Title of the panel.
    logs : list of Path
        Machine exports; each specimen in them is one repeat.
    rig : Path
        TOML that `instron.load_rig` reads.
    simulation : Path, optional
        Scene (``.toml``) to simulate or finished run (``.nc``).
    active_length : float, optional
        Helix length that stretches in Love's curve [m]; the whole helix when absent.
    truth : Path, optional
        Table of the true force of each log (log, time, displacement, force), if it is known.
    """

    name: str
    logs: Files
    rig: File
    simulation: File | None = None
    active_length: PositiveFloat | None = None
    truth: File | None = None


class _Photographs(_Table):
    name: str
    photos: Files
    marker_side: PositiveFloat | None = None
    pixel_size: PositiveFloat | None = None
    strands: PositiveInt | None = None
    truth: File | None = None

    @model_validator(mode="after")
    def _one_scale(self) -> "_Photographs":
        if (self.marker_side is None) == (self.pixel_size is None):
            raise ValueError("give the scale: either marker_side or pixel_size, in metres")
        return self


class LinkSet(_Photographs):
    """Photographs of a double helix with the tine at known places, beside their simulation.

    Attributes
    ----------
    name : str
        Title of the panel.
    photos : list of Path
        Photographs, one per tine position.
    positions : list of float or Path
        Tine displacement d [m] of each photograph, or a CSV table with columns photo and d.
    before : Path, optional
        Photograph before the tine was inserted: the reference link density.
    root : str
        Side of the picture where the clamp is: top, bottom, left or right.
    marker_side, pixel_size : float
        Scale of the photographs: side of the ArUco marker in them [m], or size of a pixel [m].
    simulation : Path, optional
        Scene (``.toml``) to simulate or finished run (``.nc``).
    photograph_simulation : bool
        Also render the simulation and measure the picture, to know the error of the imaging.
    truth : Path, optional
        Table of the true link density of each photograph (photo, s, link), if it is known.
    """

    positions: FileOrNumbers
    before: File | None = None
    root: Literal["top", "bottom", "left", "right"] = "top"
    simulation: File | None = None
    photograph_simulation: bool = False


class CurlSet(_Photographs):
    """Photographs of curls of coloured strands, beside simulated curls.

    Attributes
    ----------
    name : str
        Title of the panel.
    photos : list of Path
        Photographs, one curl each.
    marker_side, pixel_size : float
        Scale of the photographs: side of the ArUco marker in them [m], or size of a pixel [m].
    strands : int, optional
        Number of strands in a curl, to check the photographs against.
    simulations : list of Path
        Scenes or finished runs, one curl each.
    truth : Path, optional
        Table of the true counts (photo, section, N, count), if they are known.
    """

    simulations: Files | None = None


class Study(_Table):
    """What is compared with what; made by `load_study`.

    Attributes
    ----------
    title : str
        Heading of the report.
    n_sec : int
        Sections a curl is cut into when its interactions are counted.
    force, link, curl : list
        The comparisons, each a panel of its figure.
    """

    title: str
    n_sec: PositiveInt = 20
    force: list[ForceSet] = Field(default_factory=list)
    link: list[LinkSet] = Field(default_factory=list)
    curl: list[CurlSet] = Field(default_factory=list)

    @model_validator(mode="after")
    def _something(self) -> "Study":
        if not (self.force or self.link or self.curl):
            raise ValueError("nothing to compare: add a [[force]], [[link]] or [[curl]] table")
        return self

    @property
    def simulations(self) -> list[Path]:
        """Every scene and run that the comparisons name, once each, in order."""
        named = [one.simulation for one in self.force if one.simulation]
        named += [one.simulation for one in self.link if one.simulation]
        named += [path for one in self.curl for path in one.simulations or []]
        return list(dict.fromkeys(named))


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
        wrong type, or a named file does not exist.
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
        raise StudyError(f"{path}: {_fault(error)}") from error
    for link in study.link:
        tine_positions(link)
    return study


def tine_positions(link: LinkSet) -> list[float]:
    """Tine displacement d [m] of each photograph, in the order of ``link.photos``.

    Raises
    ------
    StudyError
        If the list or the table does not hold one number per photograph.
    """
    if isinstance(link.positions, Path):
        return [_looked_up(photo.name, link.positions) for photo in link.photos]
    if len(link.positions) != len(link.photos):
        raise StudyError(
            f"[[link]] {link.name!r}: {len(link.photos)} photographs but "
            f"{len(link.positions)} positions; give one d per photograph, in the order of names"
        )
    return link.positions


def _looked_up(photo: str, path: Path) -> float:
    table = read_table(path, ["photo", "d"])
    rows = table.loc[table["photo"] == photo, "d"]
    if len(rows) != 1 or not pd.api.types.is_numeric_dtype(rows):
        raise StudyError(f"{path}: needs one row with a number d for {photo}, has {len(rows)}")
    return float(rows.iloc[0])


def _fault(error: ValidationError) -> str:
    """Say in one line what is wrong; a misspelt key goes before the key that it leaves missing."""
    faults = error.errors(include_url=False)
    fault = min(faults, key=lambda one: one["type"] != "extra_forbidden")
    *place, key = fault["loc"] or ("study",)
    if fault["type"] == "extra_forbidden":
        return f"{_place(place)}unknown key {key!r}{_nearest(str(key), place)}"
    if fault["type"] == "missing":
        return f"{_place(place)}the key {key!r} is missing"
    if fault["type"] == "list_type" and not place:
        return f"{key} is a list of tables: write [[{key}]] above each"
    message = fault["msg"].removeprefix("Value error, ")
    shown = "" if fault["type"] == "value_error" else f", not {fault['input']!r}"
    return f"{_place(fault['loc'])}{message[0].lower()}{message[1:]}{shown}"


def _place(loc: Any) -> str:
    """Write ('force', 0, 'logs') as ``[[force]] 1: logs: ``."""
    return "".join(f"{part}: " for part in _parts(list(loc)))


def _parts(loc: list[Any]) -> Iterator[str]:
    if len(loc) > 1 and isinstance(loc[1], int):
        yield f"[[{loc[0]}]] {loc[1] + 1}"
        loc = loc[2:]
    # Pydantic adds the tried branch of a union to the place; a user knows only the key.
    yield from (str(part) for part in loc[:1])


def _nearest(key: str, place: list[Any]) -> str:
    model: type[BaseModel] = Study
    if place:
        (model,) = get_args(Study.model_fields[str(place[0])].annotation)
    near = difflib.get_close_matches(key, model.model_fields, n=1, cutoff=0.5)
    known = ", ".join(model.model_fields)
    return f"; did you mean {near[0]!r}?" if near else f"; known are {known}"
