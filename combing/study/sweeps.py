"""A set of several values: one parameter of a helix changes, log by log and run by run."""

from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Field, FiniteFloat, ValidationInfo, model_validator

from combing.ensemble import Member, members
from combing.study.files import each_once, folder_of, matches
from combing.study.plan import Seeds, known_parameter, listed
from combing.study.sets import Facts, Name, Table
from sim import SceneError
from sim.scene.presets import DoubleHelix

VALUE = "{value}"  # stands for each value in the names of files
REPEATS = 5  # members of an ensemble where the study does not say


def _values(value: Any) -> Any:
    if isinstance(value, list) and len(set(map(str, value))) < len(value):
        raise ValueError(f"a value is there twice in {value}")
    return value


def _logs(value: Any, info: ValidationInfo) -> dict[float, list[Path]]:
    patterns = [value] if isinstance(value, str) else value
    if not isinstance(patterns, list) or not all(isinstance(one, str) for one in patterns):
        raise ValueError(f"expected a pattern such as 'pi{VALUE}_*.csv', or a list of them")
    if not all(VALUE in one for one in patterns):
        raise ValueError(
            f"write {VALUE} where the value stands in the names, as in 'pi{VALUE}.csv'"
        )
    named = [
        (one, _filled(pattern, one)) for one in info.data.get("values", []) for pattern in patterns
    ]
    found = each_once([pattern for _, pattern in named], folder_of(info))
    logs: dict[float, list[Path]] = {}
    for (one, _), paths in zip(named, found, strict=True):
        logs.setdefault(one, []).extend(paths)
    return logs


def _rigs(value: Any, info: ValidationInfo) -> dict[float, Path]:
    if not isinstance(value, str):
        raise ValueError("expected a file name in quotes")
    values = info.data.get("values", [])
    return {one: matches(_filled(value, one), folder_of(info))[0] for one in values}


def _filled(pattern: str, value: float) -> str:
    return pattern.replace(VALUE, f"{value:g}")


class SweepSet(Table):
    """Combings that differ in one parameter, in one pair of axes, colour by value.

    Attributes
    ----------
    name : str
        Title of the figure.
    over : str
        Parameter of the preset that changes: pi1, pi2, pi3, q, friction, ...
    values : list of float
        What it takes, in the order of the legend.
    logs : dict
        Machine exports of every value. In the file a pattern that holds {value}.
    rig : dict
        Rig of every value. In the file one rig, whose shape of the helix then follows from the
        parameters, or a name that holds {value}.
    fixed : dict
        The preset's other parameters.
    seeds : int or list of int
        Members of the simulated ensemble at every value (`combing.ensemble`).
    simulate : bool
        Whether there are simulations at all.
    representative : float, optional
        Value of which one curve is drawn in black; the middle one when absent.
    allow_different : list of str
        What rigs and scenes may state differently: r, P, R, turns.
    """

    name: Name
    over: str
    values: Annotated[list[FiniteFloat], Field(min_length=1), BeforeValidator(_values)]
    logs: Annotated[dict[float, list[Path]] | None, BeforeValidator(_logs)] = None
    rig: Annotated[dict[float, Path] | None, BeforeValidator(_rigs)] = None
    preset: Literal["double_helix"] = "double_helix"
    fixed: dict[str, Any] = Field(default_factory=dict)
    seeds: Seeds = REPEATS
    simulate: bool = True
    representative: float | None = None
    allow_different: list[Facts] = Field(default_factory=list)

    @model_validator(mode="after")
    def _complete(self) -> "SweepSet":
        for name in (self.over, *self.fixed):
            known_parameter(name, self.preset)
        if self.over in self.fixed:
            raise ValueError(f"{self.over} is in over and in fixed")
        if self.logs is not None and self.rig is None:
            raise ValueError("rig: the logs need one, with r and E, or B")
        if self.logs is None and not self.simulate:
            raise ValueError("nothing to draw: name logs, or leave out simulate = false")
        if self.representative is not None and self.representative not in self.values:
            raise ValueError(f"representative = {self.representative:g} is not among the values")
        try:
            self.members()
        except SceneError as error:
            raise ValueError(str(error)) from None
        return self

    @property
    def black(self) -> float:
        """Value of which one curve is drawn in black."""
        middle = self.values[len(self.values) // 2]
        return middle if self.representative is None else self.representative

    @property
    def data(self) -> list[Path]:
        """Files that hold measurements."""
        return [path for paths in (self.logs or {}).values() for path in paths]

    @property
    def named(self) -> list[Path]:
        """All files that the set names."""
        return [*self.data, *(self.rig or {}).values()]

    @property
    def scenes(self) -> list[Path]:
        """Scene files: there are none, the parameters are in the study."""
        return []

    @property
    def rig_for_all(self) -> bool:
        """Whether one rig serves all values."""
        return len(set((self.rig or {}).values())) == 1 and len(self.values) > 1

    def nominal(self, value: float) -> Member:
        """Return the scene of a value without imperfections."""
        return members(self.preset, {**self.fixed, self.over: value}, None)[0]

    def helix(self, value: float) -> DoubleHelix:
        """Return the preset's parameters at a value."""
        return DoubleHelix(**{**self.fixed, self.over: value})

    def members(self) -> dict[tuple[float, int], Member]:
        """Return every run by value and seed."""
        return {
            (value, member.seed or 0): member
            for value in self.values
            for member in members(self.preset, {**self.fixed, self.over: value}, listed(self.seeds))
        }
