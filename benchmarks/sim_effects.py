"""What a step costs: the bare rods of a double helix, and each effect added.

    python benchmarks/sim_effects.py

Processor time of one core; the rows take turns, the median of the turns is printed.
"""

import platform
import statistics
import time
from importlib import metadata

import sim
from sim.explicit import Explicit
from sim.scene import Contact, Damping, Friction, Scene

STEPS, TURNS = 2000, 15


def scenes() -> dict[str, Scene]:
    full = sim.double_helix(pi1=18)
    bare = full.model_copy(update={"contact": None, "tines": [], "damping": None})
    half = Friction(forward=0.2, backward=0.2)
    changes = {
        "bare rods": {},
        "+ gravity": {"gravity": (0.0, 0.0, -9.81)},
        "+ drag": {"damping": Damping(drag=50.0)},
        "+ material damping": {"damping": Damping(material=1e-7)},
        "+ tine": {"tines": full.tines},
        "+ contact": {"contact": Contact()},
        "+ contact, self-contact": {"contact": Contact(self_contact=True)},
        "+ contact, friction": {"contact": Contact(), "friction": half},
    }
    table = {name: bare.model_copy(update=change) for name, change in changes.items()}
    table["all of the preset"] = full
    return table


def main() -> None:
    marches = {name: Explicit(scene) for name, scene in scenes().items()}
    times: dict[str, list[float]] = {name: [] for name in marches}
    for march in marches.values():
        march.advance(10)  # compiles
    for _ in range(TURNS):
        for name, march in marches.items():
            began = time.process_time()
            march.advance(STEPS)
            times[name].append((time.process_time() - began) / STEPS)
    elements = sum(marches["bare rods"].state.elements)
    base = statistics.median(times["bare rods"])
    versions = ", ".join(f"{name} {metadata.version(name)}" for name in ("numba", "numpy"))
    print(f"{platform.machine()}, Python {platform.python_version()}, {versions}")
    print(f"2 strands, {elements} elements in all\n")
    print("effect                     us/step  ns/element  x bare")
    for name, found in times.items():
        middle = statistics.median(found)
        print(
            f"{name:26s} {middle * 1e6:7.2f} {middle / elements * 1e9:11.1f} {middle / base:7.2f}"
        )


if __name__ == "__main__":
    main()
