"""The study as a whole: all its sets."""

from collections.abc import Sequence
from pathlib import Path

from pydantic import Field, PositiveInt, PrivateAttr, model_validator

from combing.study.plan import Tolerance
from combing.study.sets import CurlSet, ForceSet, LinkSet, Table
from combing.study.sweeps import SweepSet

AnySet = ForceSet | SweepSet | LinkSet | CurlSet


class Study(Table):
    """What is compared with what; made by `load_study`.

    Attributes
    ----------
    title : str
        Heading of the report.
    n_sec : int
        Sections a curl is cut into when its interactions are counted.
    error_bars : bool
        Whether scenes that force, link and curl sets name are simulated with what 95 % bands need
        (`combing.bands`): seven runs for one. Sweeps are ensembles anyway.
    tolerance : float, optional
        Largest error of simulated f and lambda up to the first release: the setting of every
        combing is chosen for it and verified (`combing.tolerance`).
    force, link, curl : list
        The comparisons, each a panel of its figure.
    sweep : list
        Combings that differ in one parameter, each a figure of its own.
    """

    title: str
    n_sec: PositiveInt = 20
    error_bars: bool = False
    tolerance: Tolerance | None = None
    force: list[ForceSet] = Field(default_factory=list)
    sweep: list[SweepSet] = Field(default_factory=list)
    link: list[LinkSet] = Field(default_factory=list)
    curl: list[CurlSet] = Field(default_factory=list)
    _path: Path | None = PrivateAttr(None)

    @property
    def path(self) -> Path | None:
        """File that the study was read from."""
        return self._path

    @model_validator(mode="after")
    def _something(self) -> "Study":
        if not self.sets:
            raise ValueError(
                "nothing to compare: add a [[force]], [[sweep]], [[link]] or [[curl]] table"
            )
        for kind in ("force", "sweep", "link", "curl"):
            _no_name_twice(kind, [one.name for one in getattr(self, kind)])
        return self

    @property
    def sets(self) -> list[AnySet]:
        """All sets, kind by kind."""
        return [*self.force, *self.sweep, *self.link, *self.curl]

    @property
    def simulations(self) -> list[Path]:
        """Every scene and run that the sets name, once each, in order."""
        return list(dict.fromkeys(path for one in self.sets for path in one.scenes))


def _no_name_twice(kind: str, names: Sequence[str]) -> None:
    for number, name in enumerate(names):
        if name in names[:number]:
            first = names.index(name) + 1
            raise ValueError(
                f"[[{kind}]] {first} and {number + 1} are both named {name!r}; they would be drawn "
                "as one: give each a name of its own"
            )
