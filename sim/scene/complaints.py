"""What is wrong with a scene, in one line that a lab user can act on."""

from __future__ import annotations

from collections.abc import Iterator
from difflib import get_close_matches
from typing import Any, get_args

from pydantic import BaseModel, ValidationError

EXPECTED = {
    "model_type": "a table is needed here, [{head}] or {last} = {{...}}",
    "model_attributes_type": "a table is needed here, [{head}] or {last} = {{...}}",
    "list_type": "a list is needed here; if of tables, head each with [[{head}]]",
    "tuple_type": "three numbers in brackets are needed here, [x, y, z]",
    "float_type": "a number is needed here",
    "int_type": "a whole number is needed here",
    "string_type": "a text in quotes is needed here",
    "bool_type": "true or false is needed here",
}


def first_complaint(error: ValidationError, model: type[BaseModel]) -> str:
    """Return one line for the first thing pydantic found wrong: key, value, what would be right."""
    problem = error.errors()[0]
    where, kind, value = problem["loc"], problem["type"], problem["input"]
    key = ".".join(str(part) for part in where) or "scene"
    if kind == "extra_forbidden":
        return f"{key}: unknown key; {_hint(str(where[-1]), _model_at(model, where[:-1]))}"
    if kind == "missing":
        at, index = key.rpartition(".")[::2]
        return f"{at}: {EXPECTED['tuple_type']}" if index.isdigit() else f"{key}: missing"
    if kind == "union_tag_invalid":
        context = problem["ctx"]
        return f"{key}.kind = {context['tag']!r}: choose from {context['expected_tags']}"
    message = problem["msg"].removeprefix("Value error, ")
    if kind in EXPECTED:
        head = ".".join(part for part in where if isinstance(part, str))
        message = EXPECTED[kind].format(head=head, last=where[-1])
    return f"{key}: {message}" if isinstance(value, dict) else f"{key} = {value!r}: {message}"


def _hint(key: str, model: type[BaseModel]) -> str:
    """Return the known key that is most like an unknown one, or all of them."""
    near = get_close_matches(key, model.model_fields, 1)
    return f"did you mean {near[0]}?" if near else f"known: {', '.join(model.model_fields)}"


def _model_at(model: type[BaseModel], where: tuple[int | str, ...]) -> type[BaseModel]:
    """Return the model of the part of a scene at this place."""
    choices = [model]
    for part in where:
        fields = choices[0].model_fields
        if part in fields:
            choices = list(_models(fields[str(part)].annotation)) or choices
        elif isinstance(part, str):  # which of several kinds
            choices = [each for each in choices if each.model_fields["kind"].default == part]
    return choices[0]


def _models(annotation: Any) -> Iterator[type[BaseModel]]:
    """Yield the models within a type."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        yield annotation
    for inner in get_args(annotation):
        yield from _models(inner)
