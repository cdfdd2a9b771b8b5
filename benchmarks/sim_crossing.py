"""Two ropes across each other against the elastica: the experiment `crossing` of cosseratbench.

    pip install cosseratbench && PYTHONPATH=. python benchmarks/sim_crossing.py [stiffness/E]

Frictionless ropes touch at a node where the number of elements is even, in the middle of an element
where it is odd. Half way through they are pushed out of their planes by 0.01 mm.
"""

import sys

import numpy as np
from cosseratbench.experiments import crossing
from cosseratbench.metrics import max_distance_to_curve

from sim.explicit import Explicit
from sim.kernels.curve import bend_centreline
from sim.march.neighbours import rebuild
from sim.scene import Contact, Damping, End, Material, Rod, Scene, Straight, shapes

E, DROP = 1e6, 0.1  # Pa, m: the experiment's own
PUSH = 1e-5  # m


def march_of(elements, stiffness):
    """Return the march of the experiment, its ropes as stretched as they are drawn."""
    scenario = crossing.build(E, DROP)
    rods, drawn = [], []
    for rope in scenario.rods:
        arc, line = np.array(rope.rest_arc_length), np.array(rope.centerline)
        s = np.linspace(0, arc[-1], elements + 1)
        nodes = np.column_stack([np.interp(s, arc, line[:, k]) for k in range(3)])
        material = Material(E=E, G=rope.material.shear_modulus, density=rope.material.density)
        shape = Straight(root=tuple(nodes[0]), direction=tuple(nodes[-1] - nodes[0]),
                         length=float(arc[-1]))  # fmt: skip
        rods.append(Rod(shape=shape, radius=rope.radius, elements=elements, material=material,
                        root=End(hold="pinned"), tip=End(hold="pinned")))  # fmt: skip
        drawn.append(nodes)
    scene = Scene(rods=rods, duration=scenario.duration, gravity=scenario.gravity,
                  contact=Contact(stiffness=stiffness * E),
                  damping=Damping(drag=6.0, material=1e-5), rotary_inertia="element")  # fmt: skip
    march = Explicit(scene)
    for number, nodes in enumerate(drawn):
        put(march.state, number, nodes)
    rebuild(march)
    return march, scenario


def put(state, number, nodes):
    """Put a rod's nodes and frames where they are drawn."""
    at, frames = state.nodes(number), shapes.frames(nodes)
    for axis in range(3):
        state.row(f"X{axis}")[at] = nodes[:, axis]
        for k in range(3):
            state.row(f"Q{axis}{k}")[at.start : at.stop - 1] = frames[:, axis, k]


def middle_height(march):
    """Return the height of the middle of the upper rope's smooth centreline [m]."""
    state = march.state
    bend_centreline(state.buf, state.n)
    count, first = state.elements[1], state.first[1]
    height, bulge = state.row("X2"), state.row("H2")
    at = first + count // 2
    return height[at] if count % 2 == 0 else (height[at] + height[at + 1]) / 2 + bulge[at] / 4


def measure(elements, stiffness):
    march, scenario = march_of(elements, stiffness)
    half = round(scenario.duration / 2 / march.dt)
    march.advance(half)
    push = PUSH * np.sin(np.pi * np.linspace(0, 1, elements + 1))
    march.state.row("X1")[march.state.nodes(0)] += push
    march.state.row("X0")[march.state.nodes(1)] += push
    march.advance(half)
    lower, upper = march.state.strands()
    curves = crossing.reference_curves(scenario)
    shape = max(max_distance_to_curve(a, b) for a, b in zip((lower, upper), curves, strict=True))
    reference = curves[1][len(curves[1]) // 2][2]
    free = crossing._mid_height(E, 0.0) - DROP
    lift = (middle_height(march) - reference) / abs(reference - free)
    drift = max(np.abs(lower[:, 1]).max(), np.abs(upper[:, 0]).max())
    print(f"| {elements} | {1e3 * drift:.5f} | {shape:.1e} | {100 * lift:+.2f} % |", flush=True)


def main():
    stiffness = float(sys.argv[1]) if len(sys.argv) > 1 else 0.3
    print(f"contact of {stiffness:g} E\n| n | out of plane (mm) | shape error | lift error |")
    for elements in map(int, sys.argv[2:] or (50, 51, 100, 101, 200, 201)):
        measure(elements, stiffness)


if __name__ == "__main__":
    main()
