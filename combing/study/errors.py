"""What is wrong with a study file, in one line."""

import difflib
from collections.abc import Iterator
from typing import Any, get_args

from pydantic import BaseModel, ValidationError

from combing.errors import UserError


class StudyError(UserError):
    """A study file is wrong; the message names the file, the key, and what would be right."""


def fault(error: ValidationError, model: type[BaseModel]) -> str:
    """Say in one line what is wrong; a misspelt key goes before the key that it leaves missing."""
    faults = error.errors(include_url=False)
    first = min(faults, key=lambda one: one["type"] != "extra_forbidden")
    *place, key = first["loc"] or (model.__name__.lower(),)
    if first["type"] == "extra_forbidden":
        return f"{_place(place)}unknown key {key!r}{_nearest(str(key), place, model)}"
    if first["type"] == "missing":
        return f"{_place(place)}the key {key!r} is missing"
    if first["type"] == "list_type" and not place:
        return f"{key} is a list of tables: write [[{key}]] above each"
    message = first["msg"].removeprefix("Value error, ")
    shown = "" if first["type"] == "value_error" else f", not {first['input']!r}"
    return f"{_place(first['loc'])}{message[0].lower()}{message[1:]}{shown}"


def _place(loc: Any) -> str:
    """Write ('force', 0, 'logs') as ``[[force]] 1: logs: ``."""
    return "".join(f"{part}: " for part in _parts(list(loc)))


def _parts(loc: list[Any]) -> Iterator[str]:
    if len(loc) > 1 and isinstance(loc[1], int):
        yield f"[[{loc[0]}]] {loc[1] + 1}"
        loc = loc[2:]
    # Pydantic adds the tried branch of a union to the place; a user knows only the key.
    yield from (str(part) for part in loc[:1])


def _nearest(key: str, place: list[Any], model: type[BaseModel]) -> str:
    if place:
        annotation = model.model_fields[str(place[0])].annotation
        model = next(one for one in get_args(annotation) if isinstance(one, type(BaseModel)))
    keys = [field.alias or name for name, field in model.model_fields.items()]
    near = difflib.get_close_matches(key, keys, n=1, cutoff=0.5)
    known = ", ".join(keys)
    return f"; did you mean {near[0]!r}?" if near else f"; known are {known}"
