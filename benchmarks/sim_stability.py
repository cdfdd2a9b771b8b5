"""How far the stated time-step bound is from where position Verlet really becomes unstable.

python benchmarks/sim_stability.py
"""

import itertools

import numpy as np

from sim.errors import Unstable
from sim.explicit import Explicit
from sim.scene import End, Material, Rod, Scene, Straight

STEPS = 4000


def is_stable(scene, factor):
    """March from small random velocities at `factor` times the bound; watch them grow or not."""
    march = Explicit(scene, dt=1.0)
    march = Explicit(scene, dt=factor * march.limit)
    rng = np.random.default_rng(0)
    for name in ("V0", "V1", "V2"):
        march.state.row(name)[:] = 1e-9 * rng.standard_normal(march.state.n)
    try:
        march.advance(STEPS)
    except Unstable:
        return False
    return bool(np.abs(march.state.rows("V0 V1 V2")).max() < 1e-6)


def true_limit(scene):
    """Bisect the largest stable multiple of the bound to 1 %."""
    low, high = 0.3, 3.0
    while high / low > 1.01:
        middle = (low * high) ** 0.5
        low, high = (middle, high) if is_stable(scene, middle) else (low, middle)
    return low


def bare_rod(elements, slenderness, rotary_inertia, hold):
    rod = Rod(shape=Straight(length=1.0), radius=1 / slenderness, elements=elements,
              material=Material(E=1e7, density=1000), root=End(hold=hold))  # fmt: skip
    return Scene(rods=[rod], duration=1, rotary_inertia=rotary_inertia)


if __name__ == "__main__":
    print("real limit / stated bound, bare rods")
    print("elements  L/r  inertia  root      ratio")
    for n, slender, inertia, hold in itertools.product(
        (10, 40, 160), (20, 100, 1000), ("section", "element"), ("free", "clamped")
    ):
        ratio = true_limit(bare_rod(n, slender, inertia, hold))
        print(f"{n:8d} {slender:4d}  {inertia:8s} {hold:7s} {ratio:6.2f}")
