"""What a study holds: sets of force logs, photographs and scenes that are compared."""

import unicodedata
from datetime import datetime
from pathlib import Path
from typing import Annotated, Literal, cast

from pydantic import (
    AfterValidator,
    BaseModel,
    ConfigDict,
    Field,
    FiniteFloat,
    PositiveFloat,
    PositiveInt,
    model_validator,
)

from combing.study.files import File, FileOrNumbers, Files, Region, Scale
from combing.view import View
from imaging.scale import Request

SCALE_FORM = "41px/mm"
Tine = tuple[float, float] | tuple[float, float, float]
Facts = Literal["r", "P", "R", "turns", "strands"]


def _name(text: str) -> str:
    """Trim a name; refuse what tables and spreadsheets would take for something else."""
    name = unicodedata.normalize("NFC", " ".join(text.split()))
    if not name:
        raise ValueError("a name in quotes is needed: it is the title of the panel")
    if name[0] in "=@":
        raise ValueError(f"{name!r} begins with {name[0]!r}: a spreadsheet takes it for a formula")
    return name


Name = Annotated[str, AfterValidator(_name)]


class Table(BaseModel):
    """A table of the file: fixed once read, unknown keys are errors."""

    model_config = ConfigDict(extra="forbid", frozen=True)


class _Set(Table):
    name: Name

    @property
    def named(self) -> list[Path]:
        """All files that the set names."""
        fields = [getattr(self, key) for key in type(self).model_fields]
        lists = [one if isinstance(one, list) else [one] for one in fields]
        return [path for paths in lists for path in paths if isinstance(path, Path)]


class ForceSet(_Set):
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
    allow_different : list of str
        What rig and scene may state differently: r, P, R, turns.
    """

    logs: Files
    rig: File
    simulation: File | None = None
    active_length: PositiveFloat | None = None
    truth: File | None = None
    allow_different: list[Facts] = Field(default_factory=list)

    @property
    def data(self) -> list[Path]:
        """Files that hold measurements."""
        return self.logs

    @property
    def scenes(self) -> list[Path]:
        """Scenes and runs that belong to the set."""
        return [self.simulation] if self.simulation else []


class _Photographs(_Set):
    photos: Files
    scale: Scale | None = None
    marker_side: PositiveFloat | None = None
    pixel_size: PositiveFloat | None = None
    roi: Region | None = None
    ignore: File | None = None
    strands: PositiveInt | None = None
    truth: File | None = None

    @property
    def data(self) -> list[Path]:
        """Files that hold measurements."""
        return self.photos

    @property
    def view(self) -> View:
        """How the photographs are looked at."""
        scale = self.scale
        if self.marker_side is not None:
            scale = Request("marker", (self.marker_side,))
        if self.pixel_size is not None:
            scale = Request("stated", (1 / self.pixel_size,))
        return View(scale, self.roi, self.ignore)

    @property
    def named(self) -> list[Path]:
        """All files that the set names."""
        board = self.scale.board if self.scale else None
        return [*super().named, *([Path(board)] if board else [])]

    @model_validator(mode="after")
    def _one_scale(self) -> "_Photographs":
        given = [self.scale, self.marker_side, self.pixel_size]
        if sum(one is not None for one in given) != 1:
            raise ValueError(f'give the scale: marker_side, pixel_size or scale = "{SCALE_FORM}"')
        return self


class LinkSet(_Photographs):
    """Photographs of a double helix with the tine at known places, beside their simulation.

    Attributes
    ----------
    name : str
        Title of the panel.
    photos : list of Path
        Photographs, one per tine position.
    positions : list of float or Path, optional
        Tine displacement d [m] of each photograph, or a CSV table with columns photo and d; beside
        a log also photo and displacement [m], or photo and time [s], as the log has them.
    x : list of float, optional
        Instead of positions: x = d/D of each photograph, where D is known.
    combed : float, optional
        D, the displacement at which combing ends [m]; by default the log's.
    log : Path, optional
        Machine export of the combing that was photographed; its rig is `rig`.
    log_began : datetime, optional
        What the camera's clock showed when the log's time was 0: then the photographs are placed
        by their own time stamps.
    before : Path, optional
        Photograph before the tine was inserted: the reference link density.
    root : str
        Side of the picture where the clamp is: top, bottom, left or right.
    pair : int
        Which of several pairs that wind, from the one of the most turns.
    tine : list of float, or one for each photograph
        Where the tine crosses, x, y or x, y, radius [px]; found where it is left out.
    marker_side, pixel_size, scale
        Scale of the photographs: side of the ArUco marker in them [m], size of a pixel [m], or any
        other in the words of ``combing photo --scale``.
    roi, ignore
        Where to look: x0, y0, x1, y1 [px] or a mask picture; a mask of what to ignore.
    simulation : Path, optional
        Scene (``.toml``) to simulate or finished run (``.nc``).
    photograph_simulation : bool
        Also render the simulation and measure the picture, to know the error of the imaging.
    rig : Path, optional
        Rig whose r, P, R and turns the photographs and the scene are held against.
    truth : Path, optional
        Table of the true link density of each photograph (photo, s, link), if it is known.
    allow_different : list of str
        What rig, scene and photographs may state differently: r, P, R, turns.
    """

    positions: FileOrNumbers | None = None
    x: list[FiniteFloat] | None = None
    combed: PositiveFloat | None = None
    log: File | None = None
    log_began: datetime | None = None
    before: File | None = None
    rig: File | None = None
    root: Literal["top", "bottom", "left", "right"] = "top"
    pair: PositiveInt = 1
    tine: Tine | list[Tine] | None = None
    simulation: File | None = None
    photograph_simulation: bool = False
    allow_different: list[Facts] = Field(default_factory=list)

    @model_validator(mode="after")
    def _placed_once(self) -> "LinkSet":
        ways = {"positions": self.positions, "x": self.x, "log_began": self.log_began}
        given = [name for name, value in ways.items() if value is not None]
        if not given:
            raise ValueError(
                "the key 'positions' is missing: where the tine was; or x, or log and log_began"
            )
        if len(given) > 1:
            raise ValueError(f"{' and '.join(given)} both say where the tine was; give one")
        if self.log_began and not self.log:
            raise ValueError("log_began: needs the log that began then")
        if self.log and not self.rig:
            raise ValueError("rig: the log needs one, with r and E, or B")
        if self.x is not None and not (self.combed or self.log):
            raise ValueError("x: d = x D needs D: give combed = D in metres, or the log")
        return self

    @model_validator(mode="after")
    def _a_tine_each(self) -> "LinkSet":
        tines = self.tine if self.tine and isinstance(self.tine[0], tuple) else None
        if tines is not None and len(tines) != len(self.photos):
            raise ValueError(
                f"tine: {len(tines)} places for {len(self.photos)} photographs; give one, or one "
                "for each in the order of names"
            )
        return self

    def tine_in(self, photo: Path) -> tuple[float, ...] | None:
        """Return where the tine crosses in a photograph [px], if the study says so."""
        if self.tine is None or photo == self.before:
            return None
        one = self.tine[self.photos.index(photo)] if isinstance(self.tine, list) else self.tine
        return cast(tuple[float, ...], one)

    @model_validator(mode="after")
    def _before_is_not_among_photos(self) -> "LinkSet":
        if self.before and self.before.resolve() in {one.resolve() for one in self.photos}:
            raise ValueError(f"before: {self.before.name} is also among the photos")
        return self

    @property
    def scenes(self) -> list[Path]:
        """Scenes and runs that belong to the set."""
        return [self.simulation] if self.simulation else []


class CurlSet(_Photographs):
    """Photographs of curls of coloured strands, beside simulated curls.

    Attributes
    ----------
    name : str
        Title of the panel.
    photos : list of Path
        Photographs, one curl each.
    marker_side, pixel_size, scale
        Scale of the photographs: side of the ArUco marker in them [m], size of a pixel [m], or any
        other in the words of ``combing photo --scale``.
    roi, ignore
        Where to look: x0, y0, x1, y1 [px] or a mask picture; a mask of what to ignore.
    colours : list of str, optional
        Colours of the strands, #rrggbb; others are left out.
    strands : int, optional
        Number of strands in a curl, to check the photographs against.
    simulations : list of Path
        Scenes or finished runs, one curl each.
    truth : Path, optional
        Table of the true counts (photo, section, N, count), if they are known.
    allow_different : list of str
        "strands": scenes may have another number of them.
    """

    colours: list[str] | None = None
    simulations: Files | None = None
    allow_different: list[Facts] = Field(default_factory=list)

    @property
    def scenes(self) -> list[Path]:
        """Scenes and runs that belong to the set."""
        return self.simulations or []
