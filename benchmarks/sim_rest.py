"""What rest costs and what is counted there: curls of 12 hairs, without contact and with it.

    python benchmarks/sim_rest.py                        without contact, 60 and 200 elements
    python benchmarks/sim_rest.py --shapes               of single hairs over meshes, against 240
    python benchmarks/sim_rest.py 30 60 120 --seeds 3    with contact, on these meshes: minutes each

Processor time of one core, kernels compiled before. Interactions are counted in 20 sections.
"""

import argparse
import time

import numpy as np

import sim
from combing.compare.curl import count_interactions, project_curl
from sim.explicit import explicit
from sim.statics.newton import settle

MESHES = (15, 30, 60, 120)


def free(elements: int) -> None:
    scene = sim.curl(elements=elements).model_copy(update={"contact": None})
    settle(explicit(scene), 1e-6)  # compiles
    march = explicit(scene)
    began = time.process_time()
    found = settle(march, 1e-6)
    print(f"12 x {elements}, no contact: {time.process_time() - began:.2f} s, {found}")


def shapes(seed: int) -> None:
    """Print how far nodes of one hair lie from those on 240 elements, over its length, 0.1 m."""

    def hair(elements: int) -> np.ndarray:
        parameters = {"length": 0.1, "curvature": 60, "correlation": 0.01, "seed": seed}
        scene = sim.curl(n=2, elements=elements, **parameters).model_copy(update={"contact": None})
        march = explicit(scene)
        assert settle(march, 1e-5).converged  # noqa: S101
        return march.state.strands()[0][:: elements // MESHES[0]]

    *coarse, finest = map(hair, (*MESHES, 240))
    off = [f"{np.abs(shape - finest).max() / 0.1:.1e}" for shape in coarse]
    print(f"seed {seed}:", ", ".join(f"{n}: {far}" for n, far in zip(MESHES, off, strict=True)))


def touching(elements: int, seed: int) -> None:
    began = time.process_time()
    run = sim.equilibrium(sim.curl(elements=elements, seed=seed, snapshots=2, until="rest"))
    found = count_interactions(project_curl(run), 1.0, 20)
    counts = found.groupby("N")["count"].sum()
    print(
        f"12 x {elements}, seed {seed}: {time.process_time() - began:.1f} s, "
        f"{run.data.attrs['rest']}, N: count {counts[counts > 0].to_dict()}, "
        f"length {found.attrs['length']:.4f} m",
        flush=True,
    )


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("meshes", nargs="*", type=int)
    parser.add_argument("--seeds", type=int, default=1)
    parser.add_argument("--shapes", action="store_true")
    asked = parser.parse_args()
    if asked.shapes:
        for seed in range(max(3, asked.seeds)):
            shapes(seed)
        return
    for elements in () if asked.meshes else (60, 200):
        free(elements)
    for seed in range(asked.seeds):
        for elements in asked.meshes:
            touching(elements, seed)


if __name__ == "__main__":
    main()
