"""How much of a tangle's entanglement one picture tells: curls at rest, exact and from six sides.

python benchmarks/tangle_views.py [SEEDS] [--n HAIRS] [--elements ELEMENTS] [--curvature 1/M ...]
"""

import argparse
import time

import numpy as np
import pandas as pd

import sim
from combing.compare.entanglement import tangle_of


def main() -> None:
    """Simulate the curls, measure them and print one row a curvature."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("seeds", nargs="?", type=int, default=6)
    parser.add_argument("--n", type=int, default=12)
    parser.add_argument("--elements", type=int, default=30)
    parser.add_argument("--curvature", type=float, nargs="+", default=[10.0, 40.0, 100.0])
    asked = parser.parse_args()
    print(f"{asked.n} hairs x {asked.elements} elements at rest, {asked.seeds} seeds; six pictures")
    print("                                              shown/exact            pair by pair: r of")
    print("curvature  crossings a strand  contacts each  (one picture, +- sd)  one picture, mean")
    for curvature in asked.curvature:
        began = time.process_time()
        print(row(curvature, asked.seeds, asked.n, asked.elements),
              f"  {time.process_time() - began:.0f} s", flush=True)  # fmt: skip


def row(curvature: float, seeds: int, n: int, elements: int) -> str:
    """Return the row of one intrinsic curvature [1/m]."""
    pairs, shown, density, contacts = [], [], [], []
    for seed in range(seeds):
        run = sim.simulate(sim.curl(n=n, elements=elements, curvature=curvature, seed=seed))
        radius = run.scene.rods[0].radius
        found = tangle_of(run.strands(-1), 1.05 * 2 * radius, 5e-3)
        exact = found.pairs["crossings"].sum()
        shown += list(found.views.groupby("degrees")["seen"].sum() / exact)
        density.append(2 * exact / n)
        contacts.append(found.strands["contacts"].mean())
        keys = ["strand_a", "strand_b"]
        joined = found.views.merge(found.pairs[[*keys, "crossings"]].assign(seed=seed), on=keys)
        pairs.append(joined)
    every = pd.concat(pairs)
    mean = every.groupby(["seed", "strand_a", "strand_b"])[["seen", "crossings"]].mean()
    return (
        f"{curvature:9.0f}  {np.mean(density):6.1f} +- {np.std(density, ddof=1):4.1f}     "
        f"{np.mean(contacts):6.1f}         {np.mean(shown):.2f} +- {np.std(shown, ddof=1):.2f}"
        f"          {every['seen'].corr(every['crossings']):.2f}, "
        f"{mean['seen'].corr(mean['crossings']):.2f}"
    )


if __name__ == "__main__":
    main()
