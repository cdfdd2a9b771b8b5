"""Random tangles: curved rods thrown at each other, drawn from a seed."""

import math

import numpy as np
import pytest

from sim.scene import Friction

from .hard import SOFT, energies, march_of, rod, segment_distances, show, watch

R = 5e-3


def arc(rng, elements=8):
    """Return a rod's nodes: 20 radii long, bent by up to 200 degrees, somewhere within 15 radii."""
    turn = rng.uniform(0.01, math.radians(200))
    angle = np.linspace(-0.5, 0.5, elements + 1) * turn
    flat = np.column_stack([np.sin(angle), np.cos(angle) - np.cos(0.5 * turn), 0 * angle])
    axes, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    return flat * (20 * R / turn) @ axes + rng.uniform(-15 * R, 15 * R, 3)


def tangle(rng, rods):
    """Return the nodes of rods that do not touch."""
    found = []
    while len(found) < rods:
        new = arc(rng)
        if all(segment_distances(new, old).min() > 2 * R for old in found):
            found.append(new)
    return found


@pytest.mark.parametrize(
    "seed", [pytest.param(k, marks=() if k < 25 else pytest.mark.slow) for k in range(500)]
)
def test_random_tangle_of_2_to_6_rods_with_and_without_friction(seed):
    """Thrown at their common middle at 0.5 to 2 m/s, undamped: `watch` sees them all the way.

    Even seeds are without friction: what was kinetic at the start is kinetic or elastic at the end.
    """
    rng = np.random.default_rng([20070910, seed])
    curves = tangle(rng, int(rng.integers(2, 7)))
    friction = Friction(forward=0.3, backward=0.3) if seed % 2 else None
    march = march_of(*(rod(nodes, R, SOFT) for nodes in curves), friction=friction)
    for number, nodes in enumerate(curves):
        aim = -nodes.mean(axis=0) + rng.normal(0, 2 * R, 3)
        velocity = aim / np.linalg.norm(aim) * rng.uniform(0.5, 2.0)
        for k in range(3):
            march.state.row(f"V{k}")[march.state.nodes(number)] = velocity[k]
    start = energies(march).sum()
    # Against what moves: where round tips meet, contact makes up to its own energy, 0.5 % of that.
    seen = watch(march, 0.06, looks=20, rise=0.03, scale=start)
    if friction is None:
        assert energies(march).sum() == pytest.approx(start, rel=0.04)
    else:
        assert energies(march).sum() < 1.02 * start
    show(f"tangle {seed} of {len(curves)} rods", seen)
