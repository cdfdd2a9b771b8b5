"""How often the 95 % bands of simulations hold what they have not seen.

    python benchmarks/band_coverage.py [FOLDER]

A unit is a scene, a group of seeds and a quantity. Spread: five members make the band, a sixth is
held against it; no member serves twice. Mesh: a member on the preset's mesh and on the coarser one
make the band, the same member on twice as many elements is held against it, at places before the
first release. Runs are kept in FOLDER (by default a temporary one).
"""

import sys
import tempfile
from pathlib import Path

import numpy as np
import pandas as pd
from scipy.stats import binomtest

import sim
from combing.bands.bands import make_bands
from combing.bands.quantities import Quantities
from combing.bands.scenes import coarser
from combing.ensemble import IMPERFECTION, perturbed
from combing.runs import trying

BRIEF = {"speed": 0.8, "snapshots": 9}
SCENES = {
    "P/r = 18": {"pi1": 18, "height": 0.03},
    "P/r = 24": {"pi1": 24, "height": 0.035},
    "P/r = 24, mu = 0.1": {"pi1": 24, "height": 0.035, "friction": 0.1},
    "P/r = 30": {"pi1": 30, "height": 0.04},
    "R/r = 1.2": {"pi1": 24, "pi2": 1.2, "height": 0.035},
}
GROUPS, MEMBERS = 8, 5
FINE = 4  # members of each scene that are also run on twice the elements
LEVEL = 0.95


def all_scenes():
    """Return every scene by (name, group, member): member -1 coarser, -2 finer than member 0."""
    found = {}
    for name, parameters in SCENES.items():
        base = sim.double_helix(**parameters, **BRIEF)
        for group in range(GROUPS):
            for member in range(MEMBERS + 1):
                seed = 1 + group * (MEMBERS + 1) + member
                found[name, group, member] = perturbed(base, seed)
        for group in range(FINE):
            found[name, group, -1] = coarser(found[name, group, 0])
            found[name, group, -2] = coarser(found[name, group, 0], 0.5)
    return found


def inside(row, value):
    return row["low"] <= value <= row["high"]


def nearest(table, column, value):
    return table.iloc[(table[column] - value).abs().argmin()]


def spread_units(runs, name, group):
    """Hold member 0 against the band of members 1 to 5, themselves about member 1."""
    own = {k: runs.get((name, group, k)) for k in range(MEMBERS + 1)}
    if any(run is None for run in own.values()):
        return
    bands = make_bands({0: own[1]} | {k: own[k] for k in range(1, MEMBERS + 1)}, IMPERFECTION)
    fresh = Quantities(own[0])
    for _, row in bands.numbers.iterrows():
        if row["quantity"] in ("f_max", "D"):
            yield row["quantity"], inside(row, fresh.scalars()[row["quantity"]])
    D = float(bands.numbers.set_index("quantity").loc["D", "mean"])
    row = nearest(bands.force, "d", 0.95 * D)
    yield "f near the end", inside(row, fresh.force(np.array([row["d"]]))[0])
    last = bands.link[bands.link["snapshot"] == bands.link["snapshot"].max()]
    row = nearest(last, "s", 0.3 * last["s"].max())
    pitch = own[0].scene.rods[0].shape.pitch
    yield "lambda in the end", inside(row, fresh.link(-1, np.array([row["s"]]), pitch)[1, 0])


def mesh_units(runs, name, group):
    """Hold the finer run of member 0 against the band by its own and the coarser mesh."""
    own = {k: runs.get((name, group, k)) for k in (0, -1, -2)}
    if any(run is None for run in own.values()):
        return
    bands, fine = make_bands({0: own[0], -1: own[-1]}, 0.0), Quantities(own[-2])
    last = min(bands.about["mesh_to"], fine.jam[0] or np.inf)
    for share in (0.4, 0.9):
        row = nearest(bands.force, "d", share * last)
        yield f"f at {share:g} of the way", inside(row, fine.force(np.array([row["d"]]))[0])
    pitch = own[0].scene.rods[0].shape.pitch
    smooth = bands.link[(bands.link["kind"] == "mesh") & (bands.link["displacement"] > 0)]
    for share in (0.3, 0.7):
        table = smooth[smooth["snapshot"] == smooth["snapshot"].max()]
        if len(table):
            row = nearest(table, "s", share * table["s"].max())
            found = fine.link(int(row["snapshot"]), np.array([row["s"]]), pitch)[1, 0]
            yield f"lambda at {share:g} of the length", inside(row, found)


def report(units):
    """Print the share inside for every quantity and in all, with a binomial test of LEVEL."""
    print(f"{'kind':8s} {'quantity':26s} inside   of  share    95 % interval    p of {LEVEL:g}")
    groups = [*units.groupby(["kind", "quantity"], sort=False), *units.groupby("kind", sort=False)]
    for key, rows in [*groups, ("all", units)]:
        kind, quantity = key if isinstance(key, tuple) and len(key) == 2 else (key, "all")
        kind = kind if isinstance(kind, str) else kind[0]
        held, count = int(rows["inside"].sum()), len(rows)
        test = binomtest(held, count, LEVEL)
        low, high = test.proportion_ci(method="wilson")
        print(f"{kind:8s} {quantity:26s} {held:6d} {count:4d} {held / count:6.1%}   "
              f"{low:5.1%} to {high:6.1%}   {test.pvalue:.2g}")  # fmt: skip
    print("\nby scene: " + ", ".join(
        f"{name} {rows['inside'].mean():.0%}" for name, rows in units.groupby("scene", sort=False)
    ))  # fmt: skip


def main():
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(sys.argv[1]) if len(sys.argv) > 1 else Path(temporary)
        scenes = all_scenes()
        with trying(scenes, folder) as wait:
            outcomes = wait()
        runs = {key: run for key, run in outcomes.items() if isinstance(run, sim.Run)}
        seconds = sum(run.data.attrs["wall_time_s"] for run in runs.values())
        print(f"{len(runs)} of {len(scenes)} runs, {seconds:.0f} s in all")
        rows = [
            (kind, name, quantity, held)
            for name in SCENES
            for group in range(GROUPS)
            for kind, units in (("spread", spread_units), ("mesh", mesh_units))
            for quantity, held in units(runs, name, group)
        ]
    report(pd.DataFrame(rows, columns=["kind", "scene", "quantity", "inside"]))


if __name__ == "__main__":
    main()
