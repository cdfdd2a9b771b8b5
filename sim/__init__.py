"""Cosserat rods in contact, a tine that combs them, and their exact topology."""

import sys
from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from sim.equilibrium import equilibrium
    from sim.errors import NotAtRest, SceneError, Unstable
    from sim.records.run import Run, open_run
    from sim.scene import Scene
    from sim.scene.file import load_scene
    from sim.scene.presets import curl, double_helix
    from sim.simulate import simulate
    from sim.topology import average_crossing_number, gauss_link, link_density, twist, writhe
    from sim.topology.network import ContactNetwork, contact_network, nearest_strand
    from sim.topology.tangle import Entanglement, entanglement

# Imported on first use: numba and its kernels take a second that `import sim` need not.
_ROOMS = {
    "ContactNetwork": "topology.network",
    "contact_network": "topology.network",
    "nearest_strand": "topology.network",
    "Entanglement": "topology.tangle",
    "entanglement": "topology.tangle",
    "equilibrium": "equilibrium",
    "NotAtRest": "errors",
    "SceneError": "errors",
    "Unstable": "errors",
    "curl": "scene.presets",
    "double_helix": "scene.presets",
    "Run": "records.run",
    "open_run": "records.run",
    "Scene": "scene",
    "load_scene": "scene.file",
    "simulate": "simulate",
    "average_crossing_number": "topology",
    "gauss_link": "topology",
    "link_density": "topology",
    "twist": "topology",
    "writhe": "topology",
}
__all__ = [
    "ContactNetwork",
    "Entanglement",
    "NotAtRest",
    "Run",
    "Scene",
    "SceneError",
    "Unstable",
    "average_crossing_number",
    "contact_network",
    "curl",
    "double_helix",
    "entanglement",
    "equilibrium",
    "gauss_link",
    "link_density",
    "load_scene",
    "nearest_strand",
    "open_run",
    "simulate",
    "twist",
    "writhe",
]


def __getattr__(name: str) -> Any:
    if name not in _ROOMS:
        raise AttributeError(f"module 'sim' has no attribute {name!r}")
    value = getattr(import_module(f"sim.{_ROOMS[name]}"), name)
    # Over the submodules of the same name, which an import has just bound.
    for twin in ("equilibrium", "simulate"):
        if (room := sys.modules.get(f"sim.{twin}")) is not None:
            globals()[twin] = getattr(room, twin)
    globals()[name] = value
    return value
