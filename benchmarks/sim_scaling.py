"""How the cost of a step and the memory grow with the number of elements, bare and in contact.

    python benchmarks/sim_scaling.py            # table, and docs/figures/sim_scaling.png

Straight strands of 50 elements lie two by two against each other, the couples on a square grid:
every element has the same neighbours however many there are. Processor time of one core, the best
of several marches. Memory is the resident size of a fresh process that has taken steps, less that
of one with a single couple.
"""

import argparse
import math
import platform
import resource
import subprocess
import sys
import time
from importlib import metadata
from pathlib import Path

import numpy as np

from sim.explicit import Explicit
from sim.scene import Contact, Material, Rod, Scene, Straight

SIZES = (100, 300, 1000, 3000, 10_000, 30_000, 100_000)
NYLON, RADIUS, PER_ROD = Material(E=2e8, density=1140), 4e-4, 50
FIGURE = Path(__file__).parents[1] / "docs" / "figures" / "sim_scaling.png"


def scene(elements, contact):
    """Return couples of strands that overlap by half a per cent, 6 radii apart."""
    couples = elements // (2 * PER_ROD)
    side = math.ceil(math.sqrt(couples))
    roots = [
        (6 * RADIUS * (k % side) + beside, 6 * RADIUS * (k // side), 0.4 * beside)
        for k in range(couples)
        for beside in (0.0, 1.99 * RADIUS)
    ]
    rods = [
        Rod(shape=Straight(root=root, length=1.5 * RADIUS * PER_ROD), radius=RADIUS,
            elements=PER_ROD, material=NYLON) for root in roots
    ]  # fmt: skip
    return Scene(rods=rods, duration=1.0, contact=Contact() if contact else None)


def step_time(elements, contact):
    """Return the processor time of a step [s], the best of several marches."""
    march = Explicit(scene(elements, contact))
    march.advance(2)
    steps = max(3, 200_000 // elements)
    times = []
    for _ in range(7):
        began = time.process_time()
        march.advance(steps)
        times.append((time.process_time() - began) / steps)
    return min(times)


def resident(elements, contact):
    """Return the resident size of a fresh process that has marched this scene [bytes]."""
    code = f"import sim_scaling; sim_scaling.take_steps_and_tell({elements}, {contact})"
    found = subprocess.run([sys.executable, "-c", code], cwd=Path(__file__).parent, check=True,
                           capture_output=True, text=True)  # fmt: skip
    return int(found.stdout)


def take_steps_and_tell(elements, contact):
    march = Explicit(scene(elements, contact))
    march.advance(2)
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    print(pages * resource.getpagesize())


def slope(sizes, times):
    """Return the exponent of a power law through the points."""
    return np.polyfit(np.log(sizes), np.log(times), 1)[0]


def draw(bare, touching):
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(figsize=(5, 3.6), layout="constrained")
    for times, name in ((bare, "bare"), (touching, "in contact")):
        label = f"{name}, slope {slope(SIZES, times):.2f}"
        axes.loglog(SIZES, np.array(times) * 1e6, "o-", label=label)
    axes.set(xlabel="elements", ylabel="time of a step [µs]")
    axes.legend(frameon=False)
    figure.savefig(FIGURE, dpi=150)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--no-memory", action="store_true", help="leave the fresh processes out")
    options = parser.parse_args()
    versions = ", ".join(f"{name} {metadata.version(name)}" for name in ("numba", "numpy"))
    print(f"{platform.machine()}, Python {platform.python_version()}, {versions}\n")
    print("elements   bare us  ns/element   in contact us  ns/element")
    bare, touching = [], []
    for n in SIZES:
        bare.append(step_time(n, False))
        touching.append(step_time(n, True))
        print(f"{n:8d} {bare[-1] * 1e6:9.1f} {bare[-1] / n * 1e9:11.1f} {touching[-1] * 1e6:15.1f}"
              f" {touching[-1] / n * 1e9:11.1f}", flush=True)  # fmt: skip
    print(f"slope    {slope(SIZES, bare):9.2f} {'':11s} {slope(SIZES, touching):15.2f}")
    draw(bare, touching)
    if not options.no_memory:
        for contact in (False, True):
            few, many = resident(100, contact), resident(50_000, contact)
            name = "in contact" if contact else "bare"
            print(f"memory, {name}: {(many - few) / 49_900:.0f} bytes an element")


if __name__ == "__main__":
    main()
