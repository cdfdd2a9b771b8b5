"""An effect that a scene does not name is not compiled; one of zero strength changes nothing."""

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from sim.explicit import Explicit
from sim.kernels.march import Gravity
from sim.scene import Helix, Material, Rod, Scene

# Takes a step in a process with an empty cache and prints every kernel that numba has compiled.
COMPILED = """
import sys
from sim.explicit import Explicit
from tests.sim.test_effects_pruned import hanging_strand

scene = hanging_strand()
Explicit(scene.model_copy(update={update})).advance(1)
for name, module in sorted(sys.modules.items()):
    if name.startswith("sim.kernels."):
        for kernel in vars(module).values():
            if getattr(kernel, "nopython_signatures", None) and kernel.__module__ == name:
                print(kernel.__name__)
"""
EFFECTS = {  # a kernel of each effect
    "weigh", "contact_forces", "wedges", "press_run", "rub_run", "tine_forces", "place", "drive",
    "react", "credit", "weigh_holders", "plane_forces", "pull", "kick_and_book", "strain_rate",
    "turning_rate", "moved_far",
}  # fmt: skip


def hanging_strand():
    shape = Helix(radius=4e-4, pitch=8e-3, height=16e-3)
    rod = Rod(shape=shape, radius=4e-4, elements=20, material=Material(E=2e8, density=1140))
    return Scene(rods=[rod], duration=1.0)


def compiled(tmp_path, update):
    root = Path(__file__).parents[2]
    environment = os.environ | {"NUMBA_CACHE_DIR": str(tmp_path), "PYTHONPATH": str(root)}
    code = COMPILED.replace("{update}", update)
    found = subprocess.run([sys.executable, "-c", code], env=environment, check=True,
                           capture_output=True, text=True, cwd=root)  # fmt: skip
    return set(found.stdout.split())


@pytest.mark.slow
def test_bare_rods_compile_no_kernel_of_any_effect(tmp_path):
    kernels = compiled(tmp_path, "{}")
    assert {"march", "drift", "stretch_and_shear", "kick_nodes"} <= kernels
    assert not kernels & EFFECTS


@pytest.mark.slow
@pytest.mark.parametrize(
    ("update", "its_own"),
    [
        ("dict(gravity=(0, 0, -9.81))", {"weigh"}),
        (
            "dict(contact=__import__('sim.scene').scene.Contact())",
            {"contact_forces", "wedges", "press_run", "moved_far"},
        ),
        ("dict(planes=[__import__('sim.scene').scene.Plane(point=(0, 0, -1))])", {"plane_forces"}),
        (
            "dict(damping=__import__('sim.scene').scene.Damping(material=1e-7))",
            {"strain_rate", "turning_rate"},
        ),
    ],
)
def test_an_effect_compiles_its_own_kernels_and_none_of_the_others(tmp_path, update, its_own):
    kernels = compiled(tmp_path, update)
    assert its_own <= kernels
    assert not kernels & (EFFECTS - its_own)


def test_drag_material_and_gravity_of_zero_strength_are_as_good_as_absent():
    """Present for the compiler, with coefficients that do nothing."""
    absent, zero = Explicit(hanging_strand()), Explicit(hanging_strand())
    zero.effects = zero.effects._replace(keep=1.0, viscous=0.0, gravity=Gravity(0.0, 0.0, 0.0))
    for march in (absent, zero):
        march.state.row("V0")[march.state.nodes(0)] = np.linspace(0, 0.5, 21)
        march.advance(500)
    moved, there = absent.state.strands()[0], zero.state.strands()[0]
    assert np.abs(moved - Explicit(hanging_strand()).state.strands()[0]).max() > 1e-5
    np.testing.assert_allclose(there, moved, rtol=0, atol=1e-13)
