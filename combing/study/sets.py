"""What a study holds: sets of force logs, photographs and scenes that are compared."""

import unicodedata
from pathlib import Path
from typing import Annotated, Literal

from pydantic import (
    AfterValidator,
    BaseModel,
    ConfigDict,
    Field,
    PositiveFloat,
    PositiveInt,
    model_validator,
)

from combing.study.files import File, FileOrNumbers, Files

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
    marker_side: PositiveFloat | None = None
    pixel_size: PositiveFloat | None = None
    strands: PositiveInt | None = None
    truth: File | None = None

    @property
    def data(self) -> list[Path]:
        """Files that hold measurements."""
        return self.photos

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
    rig : Path, optional
        Rig whose r, P, R and turns the photographs and the scene are held against.
    truth : Path, optional
        Table of the true link density of each photograph (photo, s, link), if it is known.
    allow_different : list of str
        What rig, scene and photographs may state differently: r, P, R, turns.
    """

    positions: FileOrNumbers
    before: File | None = None
    rig: File | None = None
    root: Literal["top", "bottom", "left", "right"] = "top"
    simulation: File | None = None
    photograph_simulation: bool = False
    allow_different: list[Facts] = Field(default_factory=list)

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
    marker_side, pixel_size : float
        Scale of the photographs: side of the ArUco marker in them [m], or size of a pixel [m].
    strands : int, optional
        Number of strands in a curl, to check the photographs against.
    simulations : list of Path
        Scenes or finished runs, one curl each.
    truth : Path, optional
        Table of the true counts (photo, section, N, count), if they are known.
    allow_different : list of str
        "strands": scenes may have another number of them.
    """

    simulations: Files | None = None
    allow_different: list[Facts] = Field(default_factory=list)

    @property
    def scenes(self) -> list[Path]:
        """Scenes and runs that belong to the set."""
        return self.simulations or []
