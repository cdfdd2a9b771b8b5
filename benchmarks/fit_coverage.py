"""Coverage of `combing fit`: how often its 95 % region holds what a virtual lab was made with.

    PYTHONPATH=. python benchmarks/fit_coverage.py OUT [labs [jobs]]

Short helices (P/r = 18, 35 mm). A lab is two specimens on a machine with offset, drift and noise,
and the link density at two places of the tine, as a photograph would show it, off by 3 %. `labs` of
them are simulated at friction and factor that the emulator has not seen; four times as many are
drawn from the emulator itself. Runs are kept in OUT: stopped, the same command goes on.
"""

import sys
from pathlib import Path

import numpy as np
import pandas as pd
from scipy import stats

import instron
import sim
from combing.ensemble import Member, members
from combing.fit import Emulator, FitPlan, load_fit, posterior
from combing.fit.emulator import train
from combing.fit.plan import from_unit
from combing.fit.posterior import Measured
from combing.fit.summaries import FORCE, LEVEL, Shot, of_curve, of_run
from combing.sweep import Store, simulate_points
from combing.virtual_lab.machine import draw_cell, record

RIG = "r = 4.25e-4\nE = 2.8e9\n"
FIT = """\
logs = "rig.toml"  # any file: the labs are made here
rig = "rig.toml"
friction = [0.0, 0.4]
factor = [0.03, 0.3]
points = 48
seeds = 2
[fixed]
pi1 = 18
height = 0.035
elements_per_pitch = 8
speed = 0.4
snapshots = 33
imperfection = 0.02
"""
TINE = (0.004, 0.010)  # m; where the photographs are taken
BLUR = 0.03  # sd of lambda over lambda_0 in a photograph
SPECIMENS = 2
CHEAP = 4  # labs of the emulator for each simulated one


def planned(out: Path) -> FitPlan:
    """Return the fit, whose files are written into a folder."""
    out.mkdir(parents=True, exist_ok=True)
    (out / "rig.toml").write_text(RIG)
    (out / "fit.toml").write_text(FIT)
    return load_fit(out / "fit.toml")


def lab_points(plan: FitPlan, labs: int) -> np.ndarray:
    """Return friction and factor of every lab, drawn from the prior."""
    drawn = np.random.default_rng(2021).random((labs, 2))
    return from_unit(drawn, plan.friction, plan.factor)


def specimens(plan: FitPlan, labs: np.ndarray) -> list[list[Member]]:
    """Return the specimens of every lab."""
    return [
        members(
            "double_helix",
            {**plan.fixed, "friction": friction, "E": factor * plan.young},
            [1000 + 10 * k + one for one in range(SPECIMENS)],
        )
        for k, (friction, factor) in enumerate(labs)
    ]


def photographed(plan: FitPlan) -> list[Shot]:
    shape = plan.nominal.rods[0].shape
    return [Shot(f"d = {1e3 * d:g} mm", d, shape.pitch, shape.height) for d in TINE]


def lab_of(runs: list[sim.Run], shots: list[Shot], rig: instron.Rig, rng) -> Measured:
    """Return what a lab measures: logs of the machine, link density with an error."""
    logs = []
    for run in runs:
        true = run.force_log()
        log = record(true, draw_cell(rng), samples=len(true), rng=rng)
        log.attrs["source"] = "virtual machine"
        logs.append(list(of_curve(instron.scale(log, rig)).values()))
    link = np.array([value for shot in shots for _, value in shot.of(runs[0])])
    return _measured(np.mean(logs, axis=0), link + rng.normal(0, BLUR, len(link)))


def drawn_lab(emulator: Emulator, at: np.ndarray, rng) -> Measured:
    """Return a lab that is drawn from the emulator at a point of the unit square."""
    mean, doubt = (one[0] for one in emulator.mean(at[None]))
    scatter = emulator.scatter(at[None])[0]
    truth = rng.multivariate_normal(mean, doubt)
    each = rng.multivariate_normal(truth, scatter, SPECIMENS)
    link = each[0, len(FORCE) :]
    return _measured(each[:, : len(FORCE)].mean(axis=0), link + rng.normal(0, BLUR, len(link)))


def _measured(force: np.ndarray, link: np.ndarray) -> Measured:
    error = np.repeat([0.0, BLUR], [len(force), len(link)])
    count = np.repeat([float(SPECIMENS), 1.0], [len(force), len(link)])
    return Measured(np.concatenate([force, link]), error, count)


def judged(emulator: Emulator, plan: FitPlan, lab: Measured, true: np.ndarray) -> dict[str, float]:
    found = posterior(emulator, lab, plan.friction, plan.factor)
    one, other = found.rank(*true)
    low = found.intervals()
    return {
        "friction": true[0],
        "factor": true[1],
        "held": found.holds(*true),
        "rank_friction": one,
        "rank_factor": other,
        "width_friction": low[0].high - low[0].low,
        "width_factor": low[1].high / low[1].low,
        "correlation": found.correlation(),
    }


def said(name: str, table: pd.DataFrame) -> None:
    held, n = int(table["held"].sum()), len(table)
    test = stats.binomtest(held, n, 0.95)
    between = test.proportion_ci(0.95)
    print(f"{name}: {held} of {n} regions hold the truth ({held / n:.0%}; "
          f"{between.low:.0%} to {between.high:.0%}), p of 95 % = {test.pvalue:.2g}")  # fmt: skip
    for one in ("friction", "factor"):
        ranks = table[f"rank_{one}"]
        counts = np.histogram(ranks, np.linspace(0, 1, 11))[0]
        p = stats.kstest(ranks, "uniform").pvalue
        print(f"  ranks of {one}: {' '.join(map(str, counts))}; p of even ranks = {p:.2g}")
    print(
        f"  median width: friction {table['width_friction'].median():.3f}, factor x "
        f"{table['width_factor'].median():.2f}; correlation {table['correlation'].median():.2f}"
    )


def simulated(
    plan: FitPlan, out: Path, labs: int, jobs: int | None
) -> tuple[Emulator, list, np.ndarray]:
    """Simulate points and labs; return the emulator, the labs' runs and what they are of."""
    store, true = Store(out), lab_points(plan, labs)
    wanted = [*plan.members(), *specimens(plan, true)]
    simulate_points([one for some in wanted for one in some], store, jobs=jobs)
    runs = [[sim.open_run(store.path(one)) for one in some] for some in wanted]
    shots, points = photographed(plan), len(plan.members())
    values = [
        np.array([list(of_run(run, shots).values()) for run in some]) for some in runs[:points]
    ]
    names = (*FORCE, *(name for shot in shots for name in shot.names))
    span = float(np.log(plan.factor[0])), float(np.log(plan.factor[1]))
    return train(plan.unit(), values, names, LEVEL, span), runs[points:], true


def draw_ranks(tables: dict[str, pd.DataFrame], path: Path) -> None:
    """Draw the rank histograms, with the band that 95 % of even ranks keep to."""
    from combing.figures.style import BAND, SIMULATION, new_figure, paper_style

    with paper_style():
        figure, panels = new_figure(len(tables), 2, 1.7)
        places = [(name, one) for name in tables for one in ("friction", "factor")]
        for panel, (name, one) in zip(panels, places, strict=True):
            ranks = tables[name][f"rank_{one}"]
            panel.axhspan(*stats.binom.ppf([0.025, 0.975], len(ranks), 0.1), color=BAND, lw=0)
            panel.hist(ranks, np.linspace(0, 1, 11), color=SIMULATION, rwidth=0.9)
            panel.set(title=f"{one}, {len(ranks)} labs {name}", xlabel="rank of the truth")
        figure.savefig(path)


def main() -> None:
    out, labs = Path(sys.argv[1]), int(sys.argv[2]) if len(sys.argv) > 2 else 60
    jobs = int(sys.argv[3]) if len(sys.argv) > 3 else None
    plan = planned(out)
    emulator, runs, true = simulated(plan, out, labs, jobs)
    rig, rng, shots = instron.load_rig(plan.rig), np.random.default_rng(7), photographed(plan)
    rows = [
        judged(emulator, plan, lab_of(r, shots, rig, rng), t)
        for r, t in zip(runs, true, strict=True)
    ]
    unit = rng.random((CHEAP * labs, 2))
    points = from_unit(unit, plan.friction, plan.factor)
    cheap = [
        judged(emulator, plan, drawn_lab(emulator, u, rng), t)
        for u, t in zip(unit, points, strict=True)
    ]
    tables = {"simulated": pd.DataFrame(rows), "of the emulator": pd.DataFrame(cheap)}
    for name, table in tables.items():
        said(f"labs {name}", table)
        table.to_csv(out / f"labs_{name.split()[0]}.csv", index=False)
    draw_ranks(tables, out / "fit_ranks.png")


if __name__ == "__main__":
    main()
