"""Points of a sweep: a preset's parameters by grid, by list, by Latin hypercube; and seeds."""

import difflib
import itertools
from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import lru_cache
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import (
    AfterValidator,
    BeforeValidator,
    ConfigDict,
    Field,
    PositiveInt,
    model_validator,
)

from combing.ensemble import Member, members
from combing.errors import UserError
from combing.study.sets import Table
from combing.tolerance import Setting, as_tolerance, often
from combing.tolerance.front import cheapest
from combing.tolerance.setting import as_row, with_setting
from combing.tolerance.simulate import DOUBLE
from sim import Scene, SceneError
from sim.scene.presets import PRESETS

Preset = Literal["double_helix", "curl"]
Values = Annotated[list[Any], Field(min_length=1)]


def _each_once(seeds: PositiveInt | list[int]) -> PositiveInt | list[int]:
    if isinstance(seeds, list) and len(set(seeds)) < len(seeds):
        raise ValueError(f"a seed is there twice in {seeds}")
    return seeds


def _tolerance(value: Any) -> float:
    try:
        return as_tolerance(value)
    except UserError as error:
        raise ValueError(str(error).removeprefix("tolerance = ")) from None


Tolerance = Annotated[float, BeforeValidator(_tolerance)]
Seeds = Annotated[PositiveInt | list[int], AfterValidator(_each_once)]


def listed(seeds: int | list[int] | None) -> Sequence[int] | None:
    """Return seeds one by one: 5 stands for 1 to 5."""
    return range(1, seeds + 1) if isinstance(seeds, int) else seeds


class Latin(Table):
    """A Latin hypercube: number of points, seed, and [lowest, highest] of every parameter."""

    model_config = ConfigDict(extra="allow", frozen=True)

    points: PositiveInt
    seed: int = 0

    @model_validator(mode="after")
    def _bounds(self) -> "Latin":
        for name, value in self.bounds.items():
            numbers = isinstance(value, list) and all(isinstance(v, int | float) for v in value)
            if not numbers or len(value) != 2 or not value[0] < value[1]:
                raise ValueError(f"{name} = {value!r}: expected [lowest, highest]")
        return self

    @property
    def bounds(self) -> dict[str, Any]:
        """Bounds by name of the parameter."""
        return dict(self.model_extra or {})


class Sweep(Table):
    """A sweep file: a preset and the values its parameters take; read by `load_sweep`.

    Attributes
    ----------
    title : str
        What the sweep is called in messages.
    preset : str
        double_helix or curl.
    fixed : dict
        Parameters that all points share.
    grid : dict of lists
        Every combination of these values.
    lists : dict of lists
        In the file `list`: values side by side, the first with the first.
    latin : Latin
        Points of a Latin hypercube between bounds.
    seeds : int or list of int
        Members of the ensemble at every point (`combing.ensemble`); left out, one run as drawn.
    tolerance : float, optional
        Largest error of f and lambda up to the first release: the setting of every point is chosen
        for it, and verified by a second run of its first member (`combing.tolerance`).
    """

    title: str = "sweep"
    preset: Preset
    fixed: dict[str, Any] = Field(default_factory=dict)
    grid: dict[str, Values] = Field(default_factory=dict)
    lists: dict[str, Values] = Field(default_factory=dict, alias="list")
    latin: Latin | None = None
    seeds: Seeds | None = None
    tolerance: Tolerance | None = None

    @model_validator(mode="after")
    def _points_are_scenes(self) -> "Sweep":
        tables = {"fixed": self.fixed, "grid": self.grid, "list": self.lists}
        tables["latin"] = self.latin.bounds if self.latin else {}
        owner: dict[str, str] = {}
        for table, parameters in tables.items():
            for name in parameters:
                known_parameter(name, self.preset)
                if name in owner:
                    raise ValueError(f"{name} is in [{owner[name]}] and in [{table}]")
                owner[name] = table
        lengths = {name: len(values) for name, values in self.lists.items()}
        if len(set(lengths.values())) > 1:
            raise ValueError(f"list: {_counted(lengths)}; each needs as many values")
        self.members()
        return self

    @property
    def varied(self) -> list[str]:
        """Names of the parameters that differ between points."""
        return [*self.grid, *self.lists, *(self.latin.bounds if self.latin else [])]

    def points(self) -> list[dict[str, Any]]:
        """Return the parameters of every point, `fixed` among them; seeds make several of each."""
        parts = (_grid(self.grid), _rows(self.lists), _hypercube(self.latin, self.preset))
        return [
            {**self.fixed, **a, **b, **c}
            for a, b, c in itertools.product(*(list(part) for part in parts))
        ]

    def members(self) -> list[Member]:
        """Return every run of the sweep."""
        found = []
        for point in self.points():
            try:
                some = members(self.preset, point, listed(self.seeds))
                found += some if self.tolerance is None else accurate(some, self.tolerance)
            except (SceneError, UserError) as error:
                shown = ", ".join(f"{name} = {point[name]!r}" for name in self.varied)
                raise ValueError(f"{error} (at {shown or 'the only point'})") from None
        return found


def accurate(some: Sequence[Member], tolerance: float) -> list[Member]:
    """Return members of one point with the setting that the first is predicted to need.

    Raises
    ------
    UserError
        They are none that the measured front is for.
    """
    setting = _cheapest(some[0].scene.model_dump_json(), tolerance)
    return [
        replace(one, scene=with_setting(often(one.scene), setting), setting=as_row(setting))
        for one in some
    ]


def second(member: Member) -> Member:
    """Return a member at the setting whose every error is twice as large: it verifies the first."""
    setting = Setting(**member.setting or {}).scaled(DOUBLE)
    return replace(member, scene=with_setting(member.scene, setting), setting=as_row(setting))


@lru_cache(maxsize=4096)
def _cheapest(scene: str, tolerance: float) -> Setting:
    return cheapest(Scene.model_validate_json(scene), tolerance)[0]


def known_parameter(name: str, preset: str) -> None:
    """Raise ValueError where a preset has no such parameter, with the nearest that it has."""
    fields = PRESETS[preset].model_fields
    if name == "seed":
        raise ValueError("seed: give seeds = 5, or seeds = [1, 2, 3], outside the tables")
    if name not in fields:
        near = difflib.get_close_matches(name, fields, n=1, cutoff=0.5)
        known = ", ".join(one for one in fields if one != "seed")
        hint = f"did you mean {near[0]!r}?" if near else f"known are {known}"
        raise ValueError(f"{preset} has no parameter {name!r}; {hint}")


def _counted(lengths: dict[str, int]) -> str:
    return ", ".join(f"{name} has {count} values" for name, count in lengths.items())


def _grid(grid: dict[str, list[Any]]) -> Iterator[dict[str, Any]]:
    for values in itertools.product(*grid.values()):
        yield dict(zip(grid, values, strict=True))


def _rows(lists: dict[str, list[Any]]) -> Iterator[dict[str, Any]]:
    if not lists:
        yield {}
    for values in zip(*lists.values(), strict=True):
        yield dict(zip(lists, values, strict=True))


def _hypercube(latin: Latin | None, preset: str) -> Iterator[dict[str, Any]]:
    """Every parameter's range is cut into as many parts as there are points; each is met once."""
    if latin is None or not latin.bounds:
        yield {}
        return
    from scipy.stats import qmc  # half a second that other studies need not wait

    low, high = np.array(list(latin.bounds.values()), dtype=float).T
    unit = qmc.LatinHypercube(d=len(low), rng=np.random.default_rng(latin.seed))
    for row in qmc.scale(unit.random(latin.points), low, high):
        yield {
            name: _typed(name, value, preset) for name, value in zip(latin.bounds, row, strict=True)
        }


def _typed(name: str, value: float, preset: str) -> float | int:
    whole = PRESETS[preset].model_fields[name].annotation is int
    return round(value) if whole else float(f"{value:.6g}")
