"""What is simulated: rods, what holds, touches and combs them, their presets and their files."""

from sim.scene.model import (
    Contact,
    Damping,
    End,
    Friction,
    Helix,
    Load,
    Material,
    Motion,
    Output,
    Plane,
    Points,
    RandomCurvature,
    Rod,
    Scene,
    Straight,
    Tine,
)

__all__ = [
    "Contact",
    "Damping",
    "End",
    "Friction",
    "Helix",
    "Load",
    "Material",
    "Motion",
    "Output",
    "Plane",
    "Points",
    "RandomCurvature",
    "Rod",
    "Scene",
    "Straight",
    "Tine",
]
