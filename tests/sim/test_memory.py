"""What a run takes of memory: so much per element, and nothing per snapshot."""

import subprocess
import sys
from pathlib import Path

import pytest

import sim

PEAK = """
import sys
import sim
from sim.scene import Contact, Damping, Friction, Material, Output, Rod, Scene, Straight, Tine

R = 1e-3

def memory(kind):
    with open("/proc/self/status") as lines:
        return next(1024 * int(line.split()[1]) for line in lines if line.startswith(kind))

def scene(rods, elements):
    "A sheet of rods side by side, a tine across: contact everywhere, friction, material damping."
    stuff = Material(E=1e8, density=1000)
    sheet = [
        Rod(shape=Straight(root=(1.99 * R * k, 0, 0), length=2 * R * elements), radius=R,
            elements=elements, material=stuff)
        for k in range(rods)
    ]
    tine = Tine(position=(0, 0, -0.05), axis=(1, 0, 0), length=1, radius=R, insertion=1e-3)
    return Scene(
        rods=sheet, duration=4e-3, contact=Contact(self_contact=True), tines=[tine],
        friction=Friction(forward=0.2, backward=0.2), gravity=(0, 0, -9.81),
        damping=Damping(material=1e-7), output=Output(sample_rate=1e4, snapshots=41),
    )

peak = []
sim.simulate(scene(2, 50), "first.nc", checkpoint_every=0.0)
with open("/proc/self/clear_refs", "w") as reset:
    reset.write("5")
before = memory("VmRSS")
sim.simulate(
    scene(20, 500), "run.nc", checkpoint_every=0.0,
    progress=lambda done: peak.append(memory("VmHWM")),
)
print((max(peak) - before) / 10_000)
"""


@pytest.mark.slow
@pytest.mark.skipif(not Path("/proc/self/clear_refs").exists(), reason="needs Linux' /proc")
def test_a_run_takes_at_most_2_kB_per_element_whatever_it_records(tmp_path):
    """10^4 elements, all effects with a memory, checkpoints; 41 snapshots are 1 kB per element."""
    environment = {"PYTHONPATH": str(Path(sim.__file__).parents[1]), "HOME": str(Path.home())}
    found = subprocess.run([sys.executable, "-c", PEAK], cwd=tmp_path, text=True,
                           env=environment,
                           stdout=subprocess.PIPE, check=True)  # fmt: skip
    assert 500 < float(found.stdout) < 2000
