"""Two bent rods slid across each other: does their contact feel the mesh, and is it a potential?

    PYTHONPATH=. python benchmarks/sim_sliding.py

Arcs of radius 20 r that bend away from each other overlap by 3 % of the contact distance; one is
slid along by 1.2 elements. Energy: of contact at the start. Jump: most that the energy changes in a
thousandth of that beyond the work of the force, over the energy.
"""

import numpy as np

from sim.explicit import Explicit
from sim.kernels.contact import contact_forces
from sim.kernels.ledger import contact_energy
from sim.march.neighbours import rebuild
from sim.scene import Contact, End, Material, Points, Rod, Scene

R, LENGTH, BEND = 0.005, 0.2, 0.1  # m
RUBBER = Material(E=1e6, nu=0.5, density=1000)
ALONG = np.array([0.8, 0.6, 0.0])


def arc(height, angle, side, elements):
    """Return a rod bent in the plane of `angle` whose middle lies at a height."""
    turn = np.linspace(-0.5, 0.5, elements + 1)[:, None] * LENGTH / BEND
    direction = np.array([np.cos(angle), np.sin(angle), 0.0])
    up = np.array([0.0, 0.0, side])
    nodes = [0, 0, height] + BEND * (np.sin(turn) * direction + (np.cos(turn) - 1) * up)
    return Rod(shape=Points(nodes=[tuple(map(float, p)) for p in nodes]), radius=R, elements=2,
               material=RUBBER, root=End(hold="free"))  # fmt: skip


def pressed(march):
    """Return the energy of contact [J] and the force on the upper rod, (3,) [N]."""
    state = march.state
    rebuild(march)
    for name in ("F0", "F1", "F2"):
        state.row(name)[:] = 0
    contact_forces(state.buf, state.n, 0.0, march.contact, None)
    force = state.rows("F0 F1 F2")[:, state.nodes(1)].sum(axis=1)
    return contact_energy(state.buf, state.n, march.contact), force


def slide(elements, degrees):
    """Return the energies [J] on the way and the work of the force between two of them [J]."""
    rods = [arc(0.0, 0.0, 1, elements), arc(1.94 * R, np.radians(degrees), -1, elements)]
    march = Explicit(Scene(rods=rods, duration=1, contact=Contact(overlap="push apart")))
    state, at = march.state, march.state.nodes(1)
    start = state.rows("X0 X1 X2")[:, at].copy()
    place = np.linspace(0, 1.2 * LENGTH / elements, 1201)
    energies, forces = [], []
    for s in place:
        for axis in range(3):
            state.row(f"X{axis}")[at] = start[axis] + s * ALONG[axis]
        energy, force = pressed(march)
        energies.append(energy)
        forces.append(force @ ALONG)
    forces = np.array(forces)
    return np.array(energies), 0.5 * (forces[1:] + forces[:-1]) * np.diff(place)


def main():
    print("| elements | l/r | angle | energy (1e-5 J) | jump |")
    for elements in (10, 20, 40):
        for degrees in (90, 30, 5):
            energy, work = slide(elements, degrees)
            jump = np.abs(np.diff(energy) + work).max() / energy.max()
            print(f"| {elements} | {LENGTH / elements / R:g} | {degrees} | {1e5 * energy[0]:.3f} |"
                  f" {jump:.1e} |")  # fmt: skip


if __name__ == "__main__":
    main()
