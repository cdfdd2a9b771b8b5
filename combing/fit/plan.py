"""A fit file: a lab's logs and photographs, and which simulations they are held against."""

import math
from pathlib import Path
from typing import Annotated, Any

import numpy as np
from pydantic import (
    BeforeValidator,
    Field,
    FiniteFloat,
    PositiveInt,
    model_validator,
)

import instron
import sim
from combing.ensemble import Member, members
from combing.study.files import File, Files
from combing.study.load import load_table
from combing.study.plan import known_parameter
from combing.study.sets import Facts, LinkSet, Table
from sim import SceneError
from sim.scene.presets import DoubleHelix

FITTED = ("friction", "E")  # what the preset calls them: E = factor times the rig's
FEWEST = 12  # points from which an emulator of two parameters is worth the name
PHOTOGRAPHS = "photographs"


def _named(value: Any) -> Any:
    return {"name": PHOTOGRAPHS, **value} if isinstance(value, dict) else value


def _range(value: Any) -> Any:
    if not isinstance(value, list) or len(value) != 2 or not value[0] < value[1]:
        raise ValueError(f"expected [lowest, highest], not {value!r}")
    return value


class FitPlan(Table):
    """A fit file; read by `load_fit`.

    Attributes
    ----------
    title : str
        Heading of the figure.
    logs : list of Path
        Machine exports; each specimen in them is one repeat.
    rig : Path
        TOML that `instron.load_rig` reads; its E (or B) is what `factor` multiplies.
    fixed : dict
        The other parameters of the preset double_helix.
    friction : (float, float)
        Range of the friction coefficient, evenly likely before the data are seen.
    factor : (float, float)
        Range of bending rigidity over the rig's; every ratio is evenly likely beforehand.
    points : int
        Simulated pairs of both, a Latin hypercube.
    seeds : int
        Members at every point (`combing.ensemble`), which tell the scatter of specimens.
    link : LinkSet, optional
        Photographs, with the keys of a study's [[link]].
    allow_different : list of str
        What rig and scene may state differently: r, P, R, turns.
    """

    title: str = "fit"
    logs: Files
    rig: File
    fixed: dict[str, Any] = Field(default_factory=dict)
    friction: Annotated[tuple[FiniteFloat, FiniteFloat], BeforeValidator(_range)] = (0.0, 0.4)
    factor: Annotated[tuple[FiniteFloat, FiniteFloat], BeforeValidator(_range)] = (0.02, 2.0)
    points: Annotated[PositiveInt, Field(ge=FEWEST)] = 48
    seeds: Annotated[PositiveInt, Field(ge=2)] = 2
    link: Annotated[LinkSet | None, BeforeValidator(_named)] = None
    allow_different: list[Facts] = Field(default_factory=list)

    @model_validator(mode="after")
    def _fits(self) -> "FitPlan":
        for name in self.fixed:
            known_parameter(name, "double_helix")
            if name in FITTED:
                raise ValueError(f"fixed: {name} is what is fitted; give its range instead")
        if self.friction[0] < 0:
            raise ValueError(f"friction: {self.friction[0]:g} is below 0")
        if self.factor[0] <= 0:
            raise ValueError(f"factor: {self.factor[0]:g} is not above 0")
        if self.link is not None and self.link.simulation is not None:
            raise ValueError("link: a fit simulates by itself; leave out 'simulation'")
        try:
            self.members()
        except SceneError as error:
            raise ValueError(f"fixed: {error}") from None
        return self

    @property
    def young(self) -> float:
        """E at which a strand of the scene has the rig's rigidity [Pa]."""
        r = float(self.fixed.get("r", DoubleHelix.model_fields["r"].default))
        return instron.load_rig(self.rig).rigidity * 4 / (math.pi * r**4)

    @property
    def nominal(self) -> sim.Scene:
        """The helix that was combed, without imperfections or friction."""
        return members("double_helix", self.fixed, None)[0].scene

    def unit(self) -> np.ndarray:
        """Return every point in the unit square of (friction, log factor), (points, 2)."""
        from scipy.stats import qmc  # half a second that --help need not wait

        return qmc.LatinHypercube(d=2, rng=np.random.default_rng(0)).random(self.points)

    def members(self) -> list[list[Member]]:
        """Return every run, point by point.

        No two points have a seed in common: the same few specimens everywhere would pass for the
        mean of all, and their differences for the scatter.
        """
        at = from_unit(self.unit(), self.friction, self.factor)
        return [
            members(
                "double_helix",
                {**self.fixed, "friction": float(friction), "E": float(factor * self.young)},
                range(1 + k * self.seeds, 1 + (k + 1) * self.seeds),
            )
            for k, (friction, factor) in enumerate(at)
        ]


def from_unit(
    unit: np.ndarray, friction: tuple[float, float], factor: tuple[float, float]
) -> np.ndarray:
    """Return (friction, factor) of points in the unit square: even in friction and log factor."""
    low, high = friction
    span = np.log(factor)
    return np.column_stack(
        [low + unit[:, 0] * (high - low), np.exp(span[0] + unit[:, 1] * (span[1] - span[0]))]
    )


def load_fit(path: Path) -> FitPlan:
    """Read a fit file.

    Parameters
    ----------
    path : Path
        TOML file; paths in it are relative to it.

    Raises
    ------
    StudyError
        If the file does not exist or is not TOML, a key or a parameter is unknown or missing, a
        value is wrong, or a named file does not exist.
    """
    return load_table(Path(path), FitPlan)
