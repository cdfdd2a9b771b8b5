"""How much of what the core can do a step of the bare rods uses.

    python benchmarks/sim_peak.py

The core's peaks are measured in the same process: fused multiply-adds on sixteen registers' worth
of data, and a triad a = b + s c on rows that lie as the solver's do, within the cache and beyond
it. Operations and bytes of an element's step are counted from the source of `sim.kernels.rod` and
`march` (an addition, a multiplication, a quotient or a root is one).
"""

import os
import platform
import statistics
import time
from importlib import metadata

import numba
import numpy as np

from sim.explicit import Explicit
from sim.kernels.compiled import kernel
from sim.kernels.contact import press_run
from sim.kernels.runs import LENGTH_OF, whole
from sim.scene import Contact, Helix, Material, Rod, Scene, Straight

LANES = 128
# Per element and step, in the order of `march`: additions, multiplications, quotients and roots.
OPERATIONS = {
    "drift": 6 + 3 * (3 + 6 + 2 + 2 + 2 + 18 + 12),
    "stretch and shear": 6 + 15 + 1 + 3 + 15 + 12,
    "turn between elements": 36 + 9 + 4,
    "rotation vectors": 24 + 24 + 3,
    "couples": 9 + 3 + 9 + 15 + 9,
    "kick of nodes": 3 * 5 + 1,
    "kick of elements": 3 * 5 + 30,
    "speed": 6,
}
# Reads and writes of 8 bytes, every loop taken on its own.
WORDS = {
    "drift": 9 + 3 * (3 + 6),
    "stretch and shear": 3 + 9 + 4 + 6,
    "turn between elements": 9 + 1 + 4,
    "rotation vectors": 4 + 4,
    "couples": 4 + 6 + 6,
    "kick of nodes": 1 + 3 + 3 + 3 + 3,
    "kick of elements": 3 + 3 + 3 + 6 + 3 + 3,
    "clearing of loads": 6,
    "speed": 3,
}
PRESS = 272  # operations of a pair in `press_run`: its vector loop, counted in machine code


@numba.njit(fastmath={"contract"})  # with more freedom the compiler sums the series in advance
def multiply_add(x, rounds):
    """Replace LANES independent numbers by a x + b, over and over."""
    for _ in range(rounds):
        for j in range(LANES):
            y = x[j]
            for _ in range(32):
                y = 0.999 * y + 0.001
            x[j] = y


@kernel
def triad(buf, n, rounds):
    """Compute a = b + s c on three rows of one buffer."""
    for _ in range(rounds):
        for i in range(n):
            buf[i] = buf[2_000_000 + i] + 0.5 * buf[4_000_000 + i]


def fastest(call, work):
    """Return the highest rate out of many short calls [1/s]."""
    call()
    times = []
    for _ in range(40):
        began = time.perf_counter()
        call()
        times.append(time.perf_counter() - began)
    return work / min(times), work / statistics.median(times)


def bare_rods():
    rods = [
        Rod(shape=Helix(radius=4e-4, pitch=7e-3, height=0.15, phase=phase), radius=4e-4,
            elements=250, material=Material(E=2e8, density=1140)) for phase in (0.0, np.pi)
    ]  # fmt: skip
    return Explicit(Scene(rods=rods, duration=1.0))


def side_by_side():
    """Return two strands of 65 elements that press on each other: one run of 64 pairs, and one."""
    rods = [
        Rod(shape=Straight(root=(x, 0.0, 0.0), length=65e-3), radius=1e-3, elements=65,
            material=Material(E=2e8, density=1140)) for x in (0.0, 1.9e-3)
    ]  # fmt: skip
    march = Explicit(Scene(rods=rods, duration=1.0, contact=Contact()))
    march.advance(1)
    return march


@kernel
def press_often(buf, contact, rounds):
    """Press the first run over and over."""
    for _ in range(rounds):
        press_run(buf, contact, 0)


def main():
    versions = ", ".join(f"{name} {metadata.version(name)}" for name in ("numba", "numpy"))
    print(f"{platform.machine()}, Python {platform.python_version()}, {versions}; best (median)\n")
    os.sched_setaffinity(0, {max(os.sched_getaffinity(0))})
    x = np.linspace(0, 1, LANES)
    flops = fastest(lambda: multiply_add(x, 2000), 2000 * LANES * 32 * 2)
    print(f"multiply-add: {flops[0] / 1e9:.1f} ({flops[1] / 1e9:.1f}) GFLOP/s")
    buf = np.ones(6_000_000)
    cache = fastest(lambda: triad(buf, 500, 2000), 2000 * 500 * 24)
    memory = fastest(lambda: triad(buf, 2_000_000, 1), 2_000_000 * 24)
    print(f"triad, rows of 500: {cache[0] / 1e9:.1f} ({cache[1] / 1e9:.1f}) GB/s")
    print(f"triad, rows of 2 000 000: {memory[0] / 1e9:.1f} ({memory[1] / 1e9:.1f}) GB/s\n")
    march = bare_rods()
    rate = fastest(lambda: march.advance(200), 200 * 500)
    operations, size = sum(OPERATIONS.values()), 8 * sum(WORDS.values())
    report("bare rods, 2 x 250, an element", rate[0], operations, size, flops[0], cache[0])
    march = side_by_side()
    length = march.contact.runs[LENGTH_OF, 0]
    pairs = fastest(lambda: press_often(march.state.buf, march.contact, 1000), 1000 * whole(length))
    report("contact integral, a pair", pairs[0], PRESS, 8 * 39, flops[0], cache[0])


def report(name, rate, operations, size, flops, cache):
    print(f"{name}: {1e9 / rate:.2f} ns, {operations} operations, {size} bytes: "
          f"{operations * rate / 1e9:.1f} GFLOP/s, {operations * rate / flops:.0%} of the peak; "
          f"{size * rate / 1e9:.1f} GB/s, {size * rate / cache:.0%} of the cache's")  # fmt: skip


if __name__ == "__main__":
    main()
