"""Error against processor time beside PyElastica, where there is a closed form: a cantilever.

    pip install "combing[bench]" && python benchmarks/work_precision.py

The rod, load, drag, step and duration are those of `combing.accuracy.cantilever`, on both sides;
the error is of the deflection of the tip, against Timoshenko. Processor time of one core, medians
of the rounds, in turns. The last column is how much longer the peer takes to the same error,
on the straight line between its points of log error over log time.
"""

import math
import os
import platform
import statistics
import time
from importlib import metadata

import elastica
import numpy as np

from combing.accuracy.cantilever import LENGTH, RADIUS, RUBBER, SLOPE, Cantilever, compliance
from sim.explicit import Explicit

ROUNDS = 3
ELEMENTS = (4, 8, 16, 32, 64)
FORCE = SLOPE * LENGTH / compliance(shear=True)


class System(
    elastica.BaseSystemCollection, elastica.Constraints, elastica.Forcing, elastica.Damping
):
    """What PyElastica calls a simulator."""


def peer(elements):
    """Return deflection [m] and processor time [s] of the same cantilever in PyElastica."""
    scene = Cantilever(elements=elements).scene()
    dt, system = Explicit(scene).dt, System()
    rod = elastica.CosseratRod.straight_rod(
        elements, np.zeros(3), np.array([1.0, 0, 0]), np.array([0, 1.0, 0]), LENGTH, RADIUS,
        RUBBER.density, youngs_modulus=RUBBER.E, shear_modulus=RUBBER.shear_modulus,
    )  # fmt: skip
    system.append(rod)
    system.constrain(rod).using(
        elastica.OneEndFixedBC, constrained_position_idx=(0,), constrained_director_idx=(0,)
    )
    system.add_forcing_to(rod).using(
        elastica.EndpointForces, np.zeros(3), np.array([0, 0, -FORCE]), ramp_up_time=dt
    )
    system.dampen(rod).using(
        elastica.AnalyticalLinearDamper,
        uniform_damping_constant=scene.damping.drag,
        time_step=dt,
    )
    system.finalize()
    stepper, now = elastica.PositionVerlet(), np.float64(0.0)
    began = time.process_time()
    for _ in range(math.ceil(scene.duration / dt)):
        now = stepper.step(system, now, np.float64(dt))
    return -float(rod.position_collection[2, -1]), time.process_time() - began


def ours(elements):
    found = Cantilever(elements=elements).measure()
    return found.quantity, found.seconds


def measured(side):
    """Return |error| and median time of every mesh."""
    truth = FORCE * compliance(shear=True)
    side(ELEMENTS[0])  # compiles
    rows = [[side(n) for n in ELEMENTS] for _ in range(ROUNDS)]
    errors = [abs(rows[0][k][0] / truth - 1) for k in range(len(ELEMENTS))]
    times = [statistics.median(row[k][1] for row in rows) for k in range(len(ELEMENTS))]
    return np.array(errors), np.array(times)


def main():
    os.sched_setaffinity(0, {max(os.sched_getaffinity(0))})
    versions = ", ".join(f"{p} {metadata.version(p)}" for p in ("pyelastica", "numba", "numpy"))
    print(f"{platform.machine()}, Python {platform.python_version()}, {versions}\n")
    (error, seconds), (theirs, needed) = measured(ours), measured(peer)
    same = np.exp(np.interp(np.log(error), np.log(theirs[::-1]), np.log(needed[::-1])))
    print("elements    error      s     peer: error      s     peer / ours at equal error")
    for k, n in enumerate(ELEMENTS):
        inside = theirs.min() <= error[k] <= theirs.max()
        ratio = f"{same[k] / seconds[k]:.0f}" if inside else "-"
        print(f"{n:8d} {error[k]:8.3%} {seconds[k]:6.4f} {theirs[k]:14.3%} {needed[k]:8.3f} "
              f"{ratio:>16s}")  # fmt: skip


if __name__ == "__main__":
    main()
