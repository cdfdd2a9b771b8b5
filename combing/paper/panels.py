"""Which parameters the paper's figures vary, how far, and at what size."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

REPEATS = 5


@dataclass(frozen=True)
class Panel:
    """One figure: combings that differ in one parameter.

    Attributes
    ----------
    name : str
        Title, with the figures of the paper that it stands for.
    stem : str
        Name of its files.
    over : str
        Parameter that changes.
    values : tuple of float
        What it takes.
    fixed : mapping
        The other parameters of the double helix.
    measured : bool
        Whether the virtual lab combs specimens for it; else simulations stand alone.
    """

    name: str
    stem: str
    over: str
    values: tuple[float, ...]
    fixed: Mapping[str, Any]
    measured: bool = True


def panels(quick: bool) -> list[Panel]:
    """Return all panels; quick ones have shorter helices and shorter strokes."""
    size = {"height": 0.06 if quick else 0.15}
    strokes = (2, 4, 6) if quick else (2, 4, 8, 12, 16, 20, 25)
    below = {"pi1": 24, "turns": max(strokes) + 1}
    at_24 = {"pi1": 24} | size
    return [
        Panel("Pitch (Figs. 2c, 3c)", "pitch", "pi1", (14, 18, 24, 36, 48), size),
        Panel("Helix radius (Figs. 2d, 3d)", "radius", "pi2", (1, 1.5, 2, 3), at_24),
        Panel("Tine radius (SI)", "tine", "pi3", (1, 2, 4), at_24),
        Panel("Pitches below the tine (Figs. 4a, 4b)", "strokes", "q", strokes, below),
        Panel("Friction (footnotes)", "friction", "friction", (0, 0.1, 0.2), at_24, False),
    ]
