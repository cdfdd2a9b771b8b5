"""Measure the front that `combing simulate --tolerance` chooses from.

    python benchmarks/tolerance_front.py [FOLDER]

Combings of short double helices up to their first release, on combinations of the knobs, each
against a much finer run. Writes combing/tolerance/front.csv and prints the Pareto front. Runs are
kept in FOLDER (by default a temporary one) and not made again; processor time is that of one core.
"""

import sys
import tempfile
import time
from pathlib import Path

import pandas as pd

import combing.tolerance
import sim
from combing.accuracy.summary import about_machine
from combing.progress import Bar
from combing.runs import model_version, run_name
from combing.tables import write_table
from combing.tolerance.errors import apart
from combing.tolerance.front import pareto
from combing.tolerance.setting import Setting, as_row, with_setting, work
from sim.compilation import compile_for
from sim.explicit import Explicit

# Drawn so that the first release is what they end with.
SCENES = {
    "P/r = 18": {"pi1": 18, "height": 0.03, "snapshots": 33},
    "P/r = 24": {"pi1": 24, "height": 0.035, "snapshots": 33},
}
REACH = {"P/r = 18": 0.0115, "P/r = 24": 0.0125}  # m of the tine's way that are simulated
REFERENCE = Setting(elements=32, safety=0.95, speed=0.1, stiffness=1.0)
ELEMENTS = (6, 8, 12, 16, 24)
SETTINGS = [
    *(Setting(n, 0.95, speed, 0.3) for n in ELEMENTS for speed in (0.2, 0.4, 0.8)),
    *(Setting(n, 0.95, 0.2, 1.0) for n in ELEMENTS),
    Setting(12, 0.5, 0.4, 0.3),
]


def scene_of(name, setting):
    whole = with_setting(sim.double_helix(**SCENES[name]), setting)
    tine = whole.tines[0]
    ramp = tine.ramp_at(setting.speed)
    duration = tine.insertion + 0.5 * ramp + REACH[name] / setting.speed
    return whole.model_copy(update={"duration": duration})


def simulated(scene, folder):
    """Return a run and its processor time, out of the folder if it is there."""
    path = folder / run_name(scene)
    if not path.exists():
        compile_for(scene)
        Explicit(scene).advance(1)
        began = time.process_time()
        run = sim.simulate(scene)
        run.data.attrs["processor_time_s"] = time.process_time() - began
        run.save(path)
    run = sim.open_run(path)
    return run, float(run.data.attrs["processor_time_s"])


def rows(folder):
    points = [(name, setting) for name in SCENES for setting in SETTINGS]
    for name, setting in Bar(iterable=points, total=len(points), desc="front"):
        scene = scene_of(name, setting)
        try:
            run, seconds = simulated(scene, folder)
        except sim.Unstable:
            continue
        reference, _ = simulated(scene_of(name, REFERENCE), folder)
        error = apart(run, reference)
        yield as_row(setting) | {"scene": name, "force": error.force, "link": error.link,
                                 "seconds": seconds, "work": work(scene)}  # fmt: skip


def main():
    with tempfile.TemporaryDirectory() as temporary:
        found = pd.DataFrame(rows(Path(sys.argv[1] if len(sys.argv) > 1 else temporary)))
    print(found.to_string(index=False, float_format="%.4g"))
    knobs = list(as_row(REFERENCE))
    whole = found.groupby(knobs).filter(lambda part: len(part) == len(SCENES))
    front = whole.groupby(knobs, as_index=False).agg(
        {"force": "max", "link": "max", "seconds": "mean", "work": "mean"}
    )
    about = [
        f"solver {model_version()}",
        about_machine(),
        f"up to the first release of {', '.join(SCENES)}; errors from {REFERENCE}",
    ]
    write_table(Path(combing.tolerance.__file__).with_name("front.csv"), front, about)
    front["error"] = front[["force", "link"]].max(axis=1)
    print(pareto(front).to_string(index=False, float_format="%.4g"))


if __name__ == "__main__":
    main()
