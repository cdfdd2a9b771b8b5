"""A lab's own files, measured: summaries of its logs and photographs, and its mean curve."""

from dataclasses import dataclass

import numpy as np
import pandas as pd

import instron
from combing.compare.copies import refuse_copied_logs
from combing.compare.link import measure_link
from combing.errors import UserError
from combing.fit.plan import FitPlan
from combing.fit.posterior import Measured
from combing.fit.summaries import FORCE, Shot, of_curve
from combing.photographs import measured_only, tried
from combing.study import tine_positions
from sim.scene import Helix


@dataclass(frozen=True)
class Lab:
    """What a fit is of.

    Attributes
    ----------
    curves : list of DataFrame
        Scaled logs in which combing ended.
    table : DataFrame
        Summaries by specimen, those of FORCE.
    shots : list of Shot
        Photographs that show lambda.
    notes : list of str
        What was left out, and why.
    """

    curves: list[pd.DataFrame]
    table: pd.DataFrame
    shots: list[Shot]
    notes: list[str]

    @property
    def names(self) -> tuple[str, ...]:
        """Names of all summaries."""
        return (*FORCE, *(name for shot in self.shots for name in shot.names))

    @property
    def measured(self) -> Measured:
        """Means over specimens; photographs are of one of them."""
        force = self.table.mean().to_numpy()
        link = [value for shot in self.shots for value in shot.values]
        sd = [value for shot in self.shots for value in shot.sd]
        specimens = np.repeat([float(len(self.table)), 1.0], [len(force), len(link)])
        error = np.concatenate([np.zeros(len(force)), sd])
        return Measured(np.concatenate([force, link]), error, specimens)


def measure_lab(plan: FitPlan) -> Lab:
    """Measure what a fit file names.

    Raises
    ------
    UserError
        In no log combing ends, one log is there twice, or no photograph can be measured.
    instron.RigError, instron.Unreadable, instron.Unscalable
        The rig or a log is at fault.
    """
    rig = instron.load_rig(plan.rig)
    every = [instron.scale(one, rig) for path in plan.logs for one in instron.read(path)]
    refuse_copied_logs(plan.title, every)
    curves = [curve for curve in every if curve.attrs["ended"]]
    notes = [
        f"{curve.attrs.get('source', 'a log')}: combing does not end within it: left out"
        for curve in every
        if not curve.attrs["ended"]
    ]
    if not curves:
        raise UserError(f"{plan.title}: in none of the logs combing ends; there is nothing to fit")
    shots, more = _shots(plan)
    table = pd.DataFrame([of_curve(curve) for curve in curves])
    return Lab(curves, table, shots, notes + more)


def _shots(plan: FitPlan) -> tuple[list[Shot], list[str]]:
    if plan.link is None:
        return [], []
    link, helix = plan.link, plan.nominal.rods[0].shape
    assert isinstance(helix, Helix)  # noqa: S101 (a double helix has two)
    seen = [tried(measure_link, photo, link) for photo in link.photos]
    places, measured, notes = measured_only(link.name, seen)
    positions = [tine_positions(link)[i] for i in places]
    shots = [
        Shot(one.attrs["photo"], d, helix.pitch, helix.height, one)
        for d, one in zip(positions, measured, strict=True)
    ]
    return shots, notes
