"""The sets of a study as jobs: each is checked, measured and compared on its own.

What is wrong with one set stops that set and no other (`combing.compare.bench`).
"""

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, Protocol

import pandas as pd

import sim
from combing.compare.agreement import Statement, disagreements, of_photograph, of_rig, of_scene
from combing.compare.comparison import Comparison
from combing.compare.copies import refuse_copied_logs, refuse_copies
from combing.compare.curl import compare_curl, measure_curl
from combing.compare.force import compare_force, measure_force
from combing.compare.link import compare_link, measure_link
from combing.compare.sweep import Curves, compare_sweep, measure_sweep
from combing.photographs import Refused, tried
from combing.study import CurlSet, ForceSet, LinkSet, Study, SweepSet

Tick = Callable[[], None]
Runs = Mapping[Any, sim.Run]
Scenes = Mapping[Any, sim.Scene]


class Job(Protocol):
    """What the bench asks of a set.

    Attributes
    ----------
    kind : str
        Which figure it belongs to: force, sweep, link or interactions.
    chosen : ForceSet, SweepSet, LinkSet or CurlSet
        The set as the study states it.
    scenes : mapping
        What is simulated for it, by a key that says in messages which scene it is.
    alike : mapping
        What scenes that differ in their seed alone have in common, by key.
    photographs : int
        How many photographs are measured.
    """

    kind: str
    chosen: Any
    scenes: Scenes

    @property
    def alike(self) -> Mapping[Any, Any]: ...  # noqa: D102

    @property
    def photographs(self) -> int: ...  # noqa: D102

    def check(self) -> list[str]:
        """Return notes on what the set's files state; raise UserError where they disagree."""
        ...

    def measure(self, tick: Tick) -> Any:
        """Return what is measured of the experiment; `tick` is called at every photograph."""
        ...

    def count(self, measured: Any) -> dict[str, int]:
        """Return how many of each kind of thing the set holds."""
        ...

    def compare(self, measured: Any, there: list, runs: Runs) -> Comparison:
        """Compare with the runs of the scenes that are `there`: fewer where some failed."""
        ...


class ForceJob:
    """Force logs beside a simulation and Love's curve."""

    kind, photographs = "force", 0
    alike: Mapping[Any, Any] = {}

    def __init__(self, chosen: ForceSet, scenes: Scenes) -> None:
        self.chosen, self.scenes = chosen, _own(chosen, scenes)

    def check(self) -> list[str]:
        """Hold rig and scene against each other."""
        stated = [of_rig(self.chosen.rig), *_of_scenes(self.scenes)]
        return disagreements(self.chosen.name, stated, self.chosen.allow_different)

    def measure(self, tick: Tick) -> list[pd.DataFrame]:
        """Scale every log; the same readings twice are refused."""
        curves = measure_force(self.chosen)
        refuse_copied_logs(self.chosen.name, curves)
        return curves

    def count(self, measured: list[pd.DataFrame]) -> dict[str, int]:
        """Count files and the specimens in them."""
        return {"files": len(self.chosen.logs), "specimens": len(measured)}

    def compare(self, measured: list[pd.DataFrame], there: list, runs: Runs) -> Comparison:
        """Compare curves."""
        simulation = there[0] if there else None
        chosen = self.chosen.model_copy(update={"simulation": simulation})
        return compare_force(chosen, measured, runs)


class SweepJob:
    """Force logs and simulations that differ in one parameter."""

    kind, photographs = "sweep", 0

    def __init__(self, chosen: SweepSet) -> None:
        self.chosen = chosen
        members = chosen.members() if chosen.simulate else {}
        self._keys = {f"{chosen.over} = {v:g}, seed {k}": (v, k) for v, k in members}
        self.scenes: Scenes = {
            (chosen.name, text): members[key].scene for text, key in self._keys.items()
        }

    @property
    def alike(self) -> Mapping[Any, Any]:
        """Members of one value."""
        return {key: (self.chosen.name, self._keys[key[1]][0]) for key in self.scenes}

    def check(self) -> list[str]:
        """Hold the rig of every value against its scene; one rig for all states r alone."""
        chosen, notes = self.chosen, []
        for value, path in (chosen.rig or {}).items():
            rig = of_rig(path)
            if chosen.rig_for_all:
                facts = {key: fact for key, fact in rig.facts.items() if key == "r"}
                rig = Statement(rig.source, facts, rig.tolerance)
            scene = of_scene(f"{chosen.over} = {value:g}", chosen.nominal(value).scene)
            notes += disagreements(chosen.name, [rig, scene], chosen.allow_different)
        return notes

    def measure(self, tick: Tick) -> Curves:
        """Scale every log; the same readings twice are refused, whatever their value."""
        curves = measure_sweep(self.chosen)
        refuse_copied_logs(self.chosen.name, [one for some in curves.values() for one in some])
        return curves

    def count(self, measured: Curves) -> dict[str, int]:
        """Count files and the specimens in them."""
        specimens = sum(len(some) for some in measured.values())
        return {"files": len(self.chosen.data), "specimens": specimens}

    def compare(self, measured: Curves, there: list, runs: Runs) -> Comparison:
        """Compare curves."""
        found = {self._keys[key[1]]: runs[key] for key in there}
        return compare_sweep(self.chosen, measured, found)


Photographed = tuple[pd.DataFrame | Refused | None, list[pd.DataFrame | Refused]]


class LinkJob:
    """Photographs of a double helix beside a simulation."""

    kind = "link"
    alike: Mapping[Any, Any] = {}

    def __init__(self, chosen: LinkSet, scenes: Scenes) -> None:
        self.chosen, self.scenes = chosen, _own(chosen, scenes)
        self._stated: list[Statement] = []

    @property
    def photographs(self) -> int:
        """With the one before the tine."""
        return len(self.chosen.photos) + bool(self.chosen.before)

    def check(self) -> list[str]:
        """Hold rig and scene against each other."""
        self._stated = _of_scenes(self.scenes)
        if self.chosen.rig is not None:
            self._stated.insert(0, of_rig(self.chosen.rig))
        return disagreements(self.chosen.name, self._stated, self.chosen.allow_different)

    def measure(self, tick: Tick) -> Photographed:
        """Measure every photograph that can be; the same picture twice is refused."""
        chosen = self.chosen
        before = _counted(tick, measure_link, chosen.before, chosen) if chosen.before else None
        found = [_counted(tick, measure_link, photo, chosen) for photo in chosen.photos]
        _refuse_copied_photographs(chosen.name, [before, *found], "photo")
        return before, found

    def count(self, measured: Photographed) -> dict[str, int]:
        """Count photographs, and those that could be measured."""
        before, found = measured
        return _photographs_counted([*found, *([before] if self.chosen.before else [])])

    def compare(self, measured: Photographed, there: list, runs: Runs) -> Comparison:
        """Hold the photograph before the tine against rig and scene, then compare."""
        before, found = measured
        notes = []
        if isinstance(before, pd.DataFrame):
            for other in self._stated:
                stated = [of_photograph(before), other]
                notes += disagreements(self.chosen.name, stated, self.chosen.allow_different)
        simulation = there[0] if there else None
        chosen = self.chosen.model_copy(update={"simulation": simulation})
        result = compare_link(chosen, before, found, runs)
        result.notes.extend(notes)
        return result


class CurlJob:
    """Photographs of curls beside simulated curls."""

    kind = "interactions"
    alike: Mapping[Any, Any] = {}

    def __init__(self, chosen: CurlSet, scenes: Scenes, n_sec: int) -> None:
        self.chosen, self.scenes, self.n_sec = chosen, _own(chosen, scenes), n_sec

    @property
    def photographs(self) -> int:
        """One curl each."""
        return len(self.chosen.photos)

    def check(self) -> list[str]:
        """Refuse a scene that is there twice, or has another number of strands than stated."""
        chosen = self.chosen
        asked = [
            (path.name, scene.model_copy(update={"title": ""}).model_dump_json())
            for path, scene in self.scenes.items()
        ]
        refuse_copies(chosen.name, "scene", asked)
        if chosen.strands is None:
            return []
        notes = []
        for stated in _of_scenes(self.scenes):
            study = Statement("the study", {"strands": chosen.strands}, stated.tolerance)
            notes += disagreements(chosen.name, [study, stated], chosen.allow_different)
        return notes

    def measure(self, tick: Tick) -> list[pd.DataFrame | Refused]:
        """Measure every photograph that can be; the same picture twice is refused."""
        chosen = self.chosen
        found = [_counted(tick, measure_curl, photo, chosen, self.n_sec) for photo in chosen.photos]
        _refuse_copied_photographs(chosen.name, found, "sample")
        return found

    def count(self, measured: list[pd.DataFrame | Refused]) -> dict[str, int]:
        """Count photographs, and those that could be measured."""
        return _photographs_counted(measured)

    def compare(
        self, measured: list[pd.DataFrame | Refused], there: list, runs: Runs
    ) -> Comparison:
        """Compare densities."""
        chosen = self.chosen.model_copy(update={"simulations": there})
        return compare_curl(chosen, measured, runs, self.n_sec)


def all_jobs(study: Study, scenes: Scenes) -> list[Job]:
    """Return a job for every set of a study; `scenes` are those that its files hold, by path."""
    return [
        *(ForceJob(one, scenes) for one in study.force),
        *(SweepJob(one) for one in study.sweep),
        *(LinkJob(one, scenes) for one in study.link),
        *(CurlJob(one, scenes, study.n_sec) for one in study.curl),
    ]


def label(key: Any) -> str:
    """Say which scene a key stands for: its file, or the set and what sets it apart there."""
    return key.name if isinstance(key, Path) else ", ".join(key)


def _own(chosen: ForceSet | LinkSet | CurlSet, scenes: Scenes) -> Scenes:
    return {path: scenes[path] for path in chosen.scenes}


def _of_scenes(scenes: Scenes) -> list[Statement]:
    return [of_scene(path.name, scene) for path, scene in scenes.items()]


def _counted(tick: Tick, measure: Callable[..., pd.DataFrame], path: Path, *arguments: Any) -> Any:
    result = tried(measure, path, *arguments)
    tick()
    return result


def _refuse_copied_photographs(name: str, found: list, label: str) -> None:
    seen = [one.attrs for one in found if isinstance(one, pd.DataFrame)]
    refuse_copies(name, "picture", [(facts[label], facts["content"]) for facts in seen])


def _photographs_counted(found: list) -> dict[str, int]:
    measured = sum(isinstance(one, pd.DataFrame) for one in found)
    return {"photographs": len(found), "measured": measured}
