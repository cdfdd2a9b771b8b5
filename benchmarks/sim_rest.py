"""What rest costs and what is counted there: curls of 12 hairs, without contact and with it.

    python benchmarks/sim_rest.py                        without contact, 60 and 200 elements
    python benchmarks/sim_rest.py 30 60 120 --seeds 3    with contact, on these meshes: minutes each

Processor time of one core, kernels compiled before. Interactions are counted in 20 sections.
"""

import argparse
import time

import sim
from combing.compare.curl import count_interactions, project_curl
from sim.explicit import explicit
from sim.statics import settle


def free(elements: int) -> None:
    scene = sim.curl(elements=elements).model_copy(update={"contact": None})
    settle(explicit(scene), 1e-6)  # compiles
    march = explicit(scene)
    began = time.process_time()
    found = settle(march, 1e-6)
    print(f"12 x {elements}, no contact: {time.process_time() - began:.2f} s, {found}")


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
    asked = parser.parse_args()
    for elements in () if asked.meshes else (60, 200):
        free(elements)
    for seed in range(asked.seeds):
        for elements in asked.meshes:
            touching(elements, seed)


if __name__ == "__main__":
    main()
