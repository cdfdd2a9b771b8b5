"""Cost of a step beside PyElastica, on the same scenes, the same core and in turns.

    pip install "combing[bench]" && python benchmarks/sim_peer.py

Processor time of one core, medians of the rounds. The strands of the double helix lie against each
other along their whole length, those of the rope (three, and nine around them) along much of it:
each is made to wind on a smaller helix than it has room for, and both sides start from a state in
which contact bears that and go on under the same drag. The number of element pairs that touch is
printed, before and after.
"""

import os
import platform
import statistics
import time
from importlib import metadata

import elastica
import numpy as np

import sim
from sim.energy import directors
from sim.explicit import Explicit
from sim.kernels.contact import contact_interval
from sim.march.effects import SOFTNESS
from sim.march.neighbours import rebuild
from sim.march.state import centreline
from sim.scene import Contact, Damping, End, Helix, Material, Rod, Scene, shapes

ROUNDS = 7
NYLON = Material(E=2.18e8, nu=0.4, density=1140)
RADIUS, ELEMENT = 4.25e-4, 1.5 * 4.25e-4  # m
DRAG = 500.0  # 1/s
TIGHT = 0.9  # of the radius at which strands just touch


def helix(radius, phase, elements, per_turn):
    pitch = per_turn * ELEMENT
    shape = Helix(radius=radius, pitch=pitch, height=elements / per_turn * pitch, phase=phase)
    return Rod(shape=shape, radius=RADIUS, elements=elements, material=NYLON,
               root=End(hold="free"), tip=End(hold="free"))  # fmt: skip


def double_helix():
    return [helix(TIGHT * RADIUS, phase, 250, 12) for phase in (0.0, np.pi)]


def rope():
    """Three strands that touch, and nine around them, all of one pitch."""
    inner = TIGHT * 2 / np.sqrt(3) * RADIUS
    outer = inner + TIGHT * 2 * RADIUS
    thirds, ninths = 2 * np.pi / 3 * np.arange(3), 2 * np.pi / 9 * np.arange(9)
    return [helix(inner, a, 100, 48) for a in thirds] + [helix(outer, a, 100, 48) for a in ninths]


def march(rods, contact, damping=None):
    return Explicit(Scene(rods=rods, duration=1.0, contact=contact, damping=damping))


def come_to_rest(rods):
    """Return nodes and frames of all rods, side by side as in the buffer, when contact bears."""
    resting = march(rods, Contact(), Damping(drag=2000.0, material=1e-6))
    resting.advance(round(0.02 / resting.dt))
    return resting.state


def take_positions(state, source):
    for name in FRAME:
        state.row(name)[:] = source.row(name)


FRAME = ["X0", "X1", "X2", "Q00", "Q01", "Q02", "Q10", "Q11", "Q12", "Q20", "Q21", "Q22"]


def peer_rod(rod, state, number):
    """Return the same rod in PyElastica: where it is now, stress-free as drawn."""
    drawn = centreline(rod)
    lengths = np.linalg.norm(np.diff(drawn, axis=0), axis=1)
    frames = shapes.frames(drawn)
    at = state.nodes(number)
    nodes = np.ascontiguousarray(state.rows("X0 X1 X2")[:, at])
    made = elastica.CosseratRod.straight_rod(
        rod.elements, drawn[0], frames[0, 2], frames[0, 0], lengths.sum(), rod.radius,
        rod.material.density, youngs_modulus=rod.material.E,
        shear_modulus=rod.material.E / (2 * (1 + rod.material.nu)),
        position=np.ascontiguousarray(drawn.T), directors=frames.transpose(1, 2, 0).copy(),
    )  # fmt: skip
    made.rest_kappa[:] = -shapes.curvature(frames, lengths[1:]).T
    made.position_collection[:] = nodes
    within = slice(at.start, at.stop - 1)
    made.director_collection[:] = directors(state, within).transpose(1, 2, 0)
    return made


class PeerSystem(elastica.BaseSystemCollection, elastica.Contact, elastica.Damping):
    """What PyElastica calls a simulator."""


class Peer:
    """A scene of PyElastica that takes steps."""

    def __init__(self, rods, state, dt, *, between, within):
        self.system, self.dt = PeerSystem(), np.float64(dt)
        self.rods = [peer_rod(rod, state, number) for number, rod in enumerate(rods)]
        for rod in self.rods:
            self.system.append(rod)
            if between:
                self.system.dampen(rod).using(
                    elastica.AnalyticalLinearDamper, uniform_damping_constant=DRAG, time_step=dt
                )
        pairs = [(a, b) for i, a in enumerate(self.rods) for b in self.rods[i + 1 :]]
        spring = SOFTNESS * NYLON.E * ELEMENT  # our line stiffness times an element's length
        for a, b in pairs if between else []:
            self.system.detect_contact_between(a, b).using(elastica.RodRodContact, k=spring, nu=0.0)
        for rod in self.rods if within else []:
            self.system.detect_contact_between(rod, rod).using(
                elastica.RodSelfContact, k=spring, nu=0.0
            )
        self.system.finalize()
        self.stepper, self.time = elastica.PositionVerlet(), np.float64(0.0)

    def advance(self, steps):
        for _ in range(steps):
            self.time = self.stepper.step(self.system, self.time, self.dt)


def touching(march):
    """Count the pairs of elements whose contact integral is not empty now."""
    if march.contact is None:
        return 0
    ends = (
        contact_interval.py_func(march.state.buf, a, b, 2 * RADIUS)
        for a, b in march.contact.pairs.T
    )
    return sum(low < high for low, high in ends)


def process_time(call, *arguments):
    began = time.process_time()
    call(*arguments)
    return time.process_time() - began


def compare(name, rods, state, contact, goal, peer_steps, our_steps):
    """Time both sides in turns and print one row."""
    ours_now = march(rods, contact, Damping(drag=DRAG) if contact is not None else None)
    take_positions(ours_now.state, state)
    if contact is not None:
        rebuild(ours_now)
    peer = Peer(rods, state, ours_now.dt, between=contact is not None,
                within=contact is not None and contact.self_contact)  # fmt: skip
    ours_now.advance(1), peer.advance(1)  # compiles
    before = touching(ours_now)
    ours, theirs = [], []
    for _ in range(ROUNDS):
        theirs.append(process_time(peer.advance, peer_steps) / peer_steps)
        ours.append(process_time(ours_now.advance, our_steps) / our_steps)
    mine, other = statistics.median(ours), statistics.median(theirs)
    ratio = statistics.median(b / a for a, b in zip(ours, theirs, strict=True))
    print(f"{name:34s} {other * 1e6:9.1f} {mine * 1e6:9.2f} {ratio:7.0f} {goal:>6s}   "
          f"{mine / sum(ours_now.state.elements) * 1e9:6.1f}   {before} .. {touching(ours_now)}",
          flush=True)  # fmt: skip


def compare_link():
    """Link of two 250-element strands: PyElastica's total, our density."""
    first, second = (centreline(rod) for rod in double_helix())
    apart = second - first
    normals = 0.5 * (apart[1:] + apart[:-1])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    distance = np.full((1, len(normals)), 2 * RADIUS)
    arguments = first.T[None], normals.T[None].copy(), distance, np.float64(1.0), "net_tangent"
    elastica.compute_link(*arguments), sim.link_density(first, second)
    ours, theirs = [], []
    for _ in range(ROUNDS):
        theirs.append(process_time(elastica.compute_link, *arguments))
        ours.append(process_time(lambda: [sim.link_density(first, second) for _ in range(20)]) / 20)
    mine, other = statistics.median(ours), statistics.median(theirs)
    print(f"\nlink of 2 x 250: PyElastica {other * 1e3:.1f} ms, ours (its density along the pair) "
          f"{mine * 1e3:.2f} ms (goal 2), ratio {other / mine:.0f} (goal 30)")  # fmt: skip


def main():
    os.sched_setaffinity(0, {max(os.sched_getaffinity(0))})
    versions = ", ".join(f"{p} {metadata.version(p)}" for p in ("pyelastica", "numba", "numpy"))
    print(f"{platform.machine()}, Python {platform.python_version()}, {versions}\n")
    print(f"{'scene':34s} {'peer us':>9s} {'ours us':>9s} {'ratio':>7s} {'goal':>6s}   ns/element"
          "   pairs that touch")  # fmt: skip
    pair, pair_state = double_helix(), come_to_rest(double_helix())
    both = Contact(self_contact=True)
    compare("2 x 250 bare", pair, pair_state, None, "8", 300, 2000)
    compare("2 x 250 rod-rod contact", pair, pair_state, Contact(), "150", 20, 2000)
    compare("2 x 250 rod-rod and self", pair, pair_state, both, "200", 10, 2000)
    compare("12 x 100 rope, all pairs", rope(), come_to_rest(rope()), Contact(), "400", 3, 500)
    compare_link()


if __name__ == "__main__":
    main()
