"""What a hand says of a photograph: a JSON file beside it, in pixels of the upright photograph.

Everything is anchored to places and directions in the picture, not to numbers of strands, so that
it can be said again of a better measurement of the same photograph.
"""

import json
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field, PositiveInt, ValidationError, model_validator

from imaging.errors import Unmeasurable

SUFFIX = ".corrections.json"

Number = Annotated[float, Field(allow_inf_nan=False)]
Point = tuple[Number, Number]
Line = Annotated[list[Point], Field(min_length=2)]
Colour = Annotated[str, Field(pattern=r"^#[0-9a-fA-F]{6}$")]  # sRGB


class _Table(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True, populate_by_name=True)


class Anchor(_Table):
    """A place on a strand and the strand's direction there.

    Attributes
    ----------
    at : (x, y)
        Picture point [px].
    along : (dx, dy)
        Direction in the picture. In `Join` it points out of the strand's end.
    """

    at: Point
    along: Point

    @model_validator(mode="after")
    def _a_direction(self) -> "Anchor":
        if not any(self.along):
            raise ValueError("a direction along the strand is needed; (0, 0) is none")
        return self


class _Step(_Table):
    """One thing a hand did; `place` is where."""

    do: str

    @property
    def place(self) -> Point:
        """Where in the picture [px]."""
        raise NotImplementedError

    @property
    def told(self) -> str:
        """What is done, and where, in a few words."""
        return f"{self.do} at ({self.place[0]:.0f}, {self.place[1]:.0f})"


class Delete(_Step):
    """The strand along `line` is none."""

    do: Literal["delete"] = "delete"
    line: Line

    @property
    def place(self) -> Point:
        """The middle of the strand [px]."""
        return self.line[len(self.line) // 2]


class Split(_Step):
    """The strand that passes here is two, which end here."""

    do: Literal["split"] = "split"
    here: Anchor

    @property
    def place(self) -> Point:
        """Where the strand ends [px]."""
        return self.here.at


class Join(_Step):
    """The strand that ends at `from` goes on at `to`, by way of the points `through`."""

    do: Literal["join"] = "join"
    start: Anchor = Field(alias="from")
    to: Anchor
    through: list[Point] = []

    @property
    def place(self) -> Point:
        """Where the first strand ends [px]."""
        return self.start.at


class Way(_Table):
    """What comes by `start` goes on by `to`; both some widths away from where strands touch."""

    start: Anchor = Field(alias="from")
    to: Anchor


class Exchange(_Step):
    """Two strands that touch at `at` go on as each other."""

    do: Literal["exchange"] = "exchange"
    at: Point
    ways: tuple[Way, Way]

    @property
    def place(self) -> Point:
        """Where the strands touch [px]."""
        return self.at


class Draw(_Step):
    """There is a strand along `points`; what lies along it are pieces of it."""

    do: Literal["draw"] = "draw"
    points: Line

    @property
    def place(self) -> Point:
        """The middle of the line [px]."""
        return self.points[len(self.points) // 2]


class Only(_Step):
    """There are strands along these lines and no others."""

    do: Literal["only"] = "only"
    lines: list[Line] = Field(min_length=1)

    @property
    def told(self) -> str:
        """How many strands there are."""
        return f"{self.do} {len(self.lines)} strands"


class Top(_Step):
    """At the crossing `at`, the strand along `over` lies on that along `under`, or who knows."""

    do: Literal["top"] = "top"
    at: Point
    over: Point
    under: Point
    known: bool = True

    @property
    def place(self) -> Point:
        """The crossing [px]."""
        return self.at


Step = Annotated[Delete | Split | Join | Exchange | Draw | Only | Top, Field(discriminator="do")]


class Photograph(_Table):
    """Which photograph is spoken of: its name and size [px], upright."""

    name: str
    width: PositiveInt
    height: PositiveInt


class Corrections(_Table):
    """What a hand says of one photograph.

    Attributes
    ----------
    photograph : Photograph, optional
        A photograph of another size is refused.
    ground, colours : list of str
        sRGB colours ``#rrggbb`` of the ground and of the strands.
    strands : int, optional
        How many strands there are.
    steps : list
        `Delete`, `Split`, `Join`, `Exchange`, `Draw`, `Only`, `Top`, in the order they were made.
    """

    format: Literal["combing corrections"] = "combing corrections"
    version: Literal[1] = 1
    photograph: Photograph | None = None
    ground: list[Colour] = []
    colours: list[Colour] = []
    strands: PositiveInt | None = None
    steps: list[Step] = []

    def __bool__(self) -> bool:
        """Tell whether anything is said."""
        return bool(self.ground or self.colours or self.strands or self.steps)


def parse_corrections(text: str, source: str) -> Corrections:
    """Read corrections from JSON.

    Raises
    ------
    Unmeasurable
        When it is not JSON, or not corrections; names `source`, the key and the wrong value.
    """
    try:
        return _checked(json.loads(text), source)
    except json.JSONDecodeError as error:
        raise Unmeasurable(
            f"{source}, line {error.lineno}, column {error.colno}: not JSON ({error.msg}); "
            "corrections are written by `combing edit`"
        ) from None


def told_besides(corrections: Corrections, more: dict[str, Any], source: str) -> Corrections:
    """Return corrections with some of their keys said anew; `source` is named where that is wrong.

    Raises
    ------
    Unmeasurable
        When a value is wrong.
    """
    checked = _checked(more, source)
    return corrections.model_copy(update={key: getattr(checked, key) for key in more})


def _checked(value: Any, source: str) -> Corrections:
    try:
        return Corrections.model_validate(value)
    except ValidationError as error:
        first = error.errors(include_url=False)[0]
        key = _key(first["loc"])
        message = f"{source}: {key}: {first['msg']}, not {_short(first['input'])}"
        raise Unmeasurable(message) from None


def _key(loc: tuple[int | str, ...]) -> str:
    """Write a place in the file as ``steps[2].at``; the name of a kind of step is no key."""
    words = ["corrections"]
    for before, part in zip(("", *loc), loc, strict=False):
        if isinstance(part, int):
            words[-1] += f"[{part}]"
        elif not isinstance(before, int) or part not in KINDS:
            words.append(part)
    return ".".join(words[1:] if len(words) > 1 and words[0] == "corrections" else words)


KINDS = {"delete", "split", "join", "exchange", "draw", "only", "top"}


def _short(value: Any) -> str:
    text = repr(value)
    return text if len(text) <= 60 else text[:57] + "..."


def written(corrections: Corrections) -> str:
    """Return corrections as the text of a JSON file."""
    return corrections.model_dump_json(indent=1, by_alias=True, exclude_none=True) + "\n"


def beside(photograph: str | Path) -> Path | None:
    """Return the corrections file that lies beside a photograph, or None.

    ``curl.jpg.corrections.json``, else ``curl.corrections.json``; of a page of a TIFF
    ``stack.tif, page 3.corrections.json`` only.
    """
    path = Path(photograph)
    if not path.name:
        return None
    names = [path.name + SUFFIX]
    if " " not in path.suffix:  # what is said of all of stack is not said of a page
        names.append(path.stem + SUFFIX)
    return next((p for name in names if (p := path.with_name(name)).is_file()), None)
