"""A fit from beginning to end: measure the lab, simulate what is missing, train, infer, write."""

import json
import logging
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from scipy import stats

import instron
import sim
from combing.compare.agreement import disagreements, of_rig, of_scene
from combing.compare.comparison import says_synthetic
from combing.errors import UserError
from combing.figures.fit import draw_fit
from combing.figures.style import save
from combing.fit.curves import fitted_curve
from combing.fit.emulator import Emulator, needs_sklearn, train
from combing.fit.lab import Lab, measure_lab
from combing.fit.plan import FEWEST, FitPlan
from combing.fit.posterior import Posterior, chi_squared, distances, posterior
from combing.fit.summaries import LEVEL, of_run
from combing.runs import scaled
from combing.sweep import Store, simulate_points
from combing.tables import write_table
from combing.tolerance.front import predicted_seconds
from combing.workers import cores
from combing.writing import write_text

WIDER = 2.0  # times that repeats scatter more than members: said
DOUBTFUL = 0.01  # probability of a misfit, below which the model does not reproduce the lab
log = logging.getLogger("combing")


@dataclass(frozen=True)
class Fit:
    """What was found.

    Attributes
    ----------
    lab : Lab
    emulator : Emulator
    posterior, level_alone : Posterior
        By all summaries; by mean and highest force alone, which a lab without photographs that
        looks at f_max alone has.
    curve : DataFrame
        F over x: the lab's mean and sd, the best one with its 95 % band for one more specimen.
    residuals : DataFrame
        Every summary: the lab's, the emulator's at the best point, the difference in sd.
    facts : dict
        Everything that is said, in plain values.
    """

    lab: Lab
    emulator: Emulator
    posterior: Posterior
    level_alone: Posterior
    curve: pd.DataFrame
    residuals: pd.DataFrame
    facts: dict[str, Any]


def make_fit(plan: FitPlan, out: Path, *, jobs: int | None = None, quiet: bool = False) -> Fit:
    """Fit friction and factor to a lab, and write figure and tables.

    Finished runs in ``out/runs`` are used again, so a call that was stopped goes on. What it will
    cost is logged on the logger ``combing`` before it begins.

    Parameters
    ----------
    plan : FitPlan
        From `load_fit`.
    out : Path
        Folder of the results.
    jobs : int, optional
        Simulations at once; as many as there are cores when absent.
    quiet : bool
        Show no progress.

    Raises
    ------
    UserError
        scikit-learn is not installed, rig and scene disagree, nothing can be fitted, or too many
        simulations failed.
    instron.RigError, instron.Unreadable, instron.Unscalable
        The rig or a log is at fault.
    """
    needs_sklearn()
    stated = [of_rig(plan.rig), of_scene("[fixed]", plan.nominal)]
    notes = disagreements(plan.title, stated, plan.allow_different)
    lab = measure_lab(plan)
    store = Store(out)
    say_cost(plan, store, jobs)
    simulate_points([one for some in plan.members() for one in some], store, jobs=jobs, quiet=quiet)
    runs = _simulated(plan, store, lab)
    span = float(np.log(plan.factor[0])), float(np.log(plan.factor[1]))
    emulator = train(runs.unit, runs.values, lab.names, LEVEL, span)
    found = posterior(emulator, lab.measured, plan.friction, plan.factor)
    only = [lab.names.index(name) for name in LEVEL]
    level = posterior(emulator, lab.measured, plan.friction, plan.factor, only=only)
    residuals, probability = misfit(emulator, lab, found)
    notes += [*lab.notes, *runs.notes, *_doubts(residuals, probability, lab, runs.values)]
    facts = _facts(plan, found, lab, probability, [*notes, *untold(found)])
    curves = [[scaled(run) for run in some] for some in runs.runs]
    curve = fitted_curve(plan, lab.curves, runs.unit, curves, found)
    fit = Fit(lab, emulator, found, level, curve, residuals, facts)
    _write(fit, out)
    return fit


def say_cost(plan: FitPlan, store: Store, jobs: int | None) -> None:
    """Say how many runs are missing, and about how long they will take."""
    members = [one for some in plan.members() for one in some]
    missing = list(store.missing(members).values())
    if not missing:
        log.info("all %d runs are there", len(members))
        return
    seconds = sum(predicted_seconds(one.scene) for one in missing[:: plan.seeds]) * plan.seeds
    workers = min(jobs or cores(), len(missing))
    log.info(
        "%d points of %d members, %d runs to simulate: about %.2g minutes of processor time, "
        "%.2g minutes on %d core%s",
        plan.points, plan.seeds, len(missing), seconds / 60, seconds / 60 / workers, workers,
        "s" if workers > 1 else "",
    )  # fmt: skip


@dataclass(frozen=True)
class _Runs:
    """Runs by point, where there are any: place in the unit square, runs, summaries; and notes."""

    unit: np.ndarray
    runs: list[list[sim.Run]]
    values: list[np.ndarray]
    notes: list[str]


def _simulated(plan: FitPlan, store: Store, lab: Lab) -> _Runs:
    """Read what was simulated; a run that failed, or in which combing does not end, is noted."""
    unit, runs, values, notes = [], [], [], []
    for at, some in zip(plan.unit(), plan.members(), strict=True):
        there, found = [], []
        for one in some:
            try:
                if not store.path(one).exists():
                    raise UserError(str(store.failure(one)))
                run = sim.open_run(store.path(one))
                found.append(list(of_run(run, lab.shots).values()))
                there.append(run)
            except (UserError, instron.Unscalable) as error:
                notes.append(f"{store.path(one).name} is left out: {error}")
        if there:
            unit.append(at)
            runs.append(there)
            values.append(np.array(found))
    if sum(len(one) > 1 for one in runs) < FEWEST:
        raise UserError(
            f"{plan.title}: {sum(map(len, runs))} runs are left, too few for an emulator; at least "
            f"{FEWEST} points of two members are needed: {'; '.join(notes[:1])}"
        )
    return _Runs(np.array(unit), runs, values, notes)


def misfit(emulator: Emulator, lab: Lab, found: Posterior) -> tuple[pd.DataFrame, float]:
    """Return every summary beside the emulator's at the best point, and how likely it all is.

    The probability of a chi-squared at least as large, Hotelling's with the scatter's degrees of
    freedom, two parameters being fitted.
    """
    unit = found.unit_of(*found.best)[None]
    apart, spread = distances(emulator, lab.measured, unit)
    sd = np.sqrt(np.diag(spread[0]))
    table = pd.DataFrame(
        {
            "summary": emulator.names,
            "lab": lab.measured.values,
            "model": lab.measured.values - apart[0],
            "sd": sd,
            "apart": apart[0] / sd,
            "specimens": lab.measured.specimens.astype(int),
        }
    )
    free, known = len(sd) - 2, emulator.freedom
    squares = float(chi_squared(apart, spread)[0])
    if known <= free:
        return table, float(stats.chi2.sf(squares, free))
    scale = (known - free + 1) / (known * free)
    return table, float(stats.f.sf(squares * scale, free, known - free + 1))


def _doubts(
    residuals: pd.DataFrame, probability: float, lab: Lab, values: list[np.ndarray]
) -> list[str]:
    """Say so where the model does not reproduce the lab, or repeats scatter more than members."""
    notes = []
    if probability < DOUBTFUL:
        worst = residuals.iloc[int(residuals["apart"].abs().to_numpy().argmax())]
        notes.append(
            f"the model does not reproduce this lab (p = {probability:.1g}; farthest off: "
            f"{worst['summary']}, by {abs(worst['apart']):.1f} sd): the region holds nothing then"
        )
    if len(lab.table) > 2:
        apart = np.concatenate([some[:, 0] - some[:, 0].mean() for some in values])
        pooled = np.sqrt(np.sum(apart**2) / sum(len(some) - 1 for some in values))
        ratio = float(lab.table.iloc[:, 0].std(ddof=1)) / pooled
        if ratio > WIDER:
            notes.append(
                f"the mean force of the repeats scatters {ratio:.1f} times as much as that of "
                "simulated specimens (imperfection): the region is too small"
            )
    return notes


def untold(found: Posterior) -> list[str]:
    """Say what the data do not tell."""
    notes = []
    for name, one in zip(("friction", "factor"), found.intervals(), strict=True):
        open_ends = [
            end
            for end, closed in (("below", one.bounded_below), ("above", one.bounded_above))
            if not closed
        ]
        if open_ends:
            notes.append(
                f"the data do not bound {name} {' or '.join(open_ends)}: what its interval says "
                "there is the range of the fit file"
            )
    if abs(found.correlation()) > 0.7:
        (a, b), (c, d) = found.ridge()[[0, -1]]
        notes.append(
            f"friction and factor trade against each other (correlation {found.correlation():.2f}),"
            f" along a ridge from ({a:.3g}, {b:.3g}) to ({c:.3g}, {d:.3g}): neither interval holds "
            "without the other"
        )
    return notes


def _facts(
    plan: FitPlan, found: Posterior, lab: Lab, probability: float, notes: list[str]
) -> dict[str, Any]:
    friction, factor = found.intervals()
    return {
        "title": plan.title,
        "friction": friction._asdict(),
        "factor": factor._asdict(),
        "best": dict(zip(("friction", "factor"), found.best, strict=True)),
        "correlation": found.correlation(),
        "region_share_of_prior": found.share,
        "probability_of_misfit": probability,
        "specimens": len(lab.table),
        "photographs": len(lab.shots),
        "prior": {"friction": plan.friction, "factor": plan.factor},
        "rigidity_of_rig": instron.load_rig(plan.rig).rigidity,
        "notes": notes,
    }


def _write(fit: Fit, out: Path) -> None:
    found = fit.posterior
    friction, factor = np.meshgrid(*found.axes, indexing="ij")
    density = pd.DataFrame(
        {
            "friction": friction.ravel(),
            "factor": factor.ravel(),
            "probability": found.mass.ravel(),
            "probability_by_level_alone": fit.level_alone.mass.ravel(),
        }
    )
    ridge = pd.DataFrame(found.ridge(), columns=["friction", "factor"])
    write_table(out / "posterior.csv", density, ["probability of every cell of the grid"])
    write_table(out / "ridge.csv", ridge, ["mean log factor at every friction"])
    write_table(out / "curve.csv", fit.curve, ["F in N over x = d/D; bands at 95 %"])
    write_table(out / "summaries.csv", fit.residuals, ["in N, m; apart in sd"])
    write_text(out / "fit.json", json.dumps(fit.facts, indent=1) + "\n")
    synthetic = any(says_synthetic(curve.attrs.get("metadata", {})) for curve in fit.lab.curves)
    save(draw_fit(fit, synthetic=synthetic), out, "fit", synthetic=synthetic)
