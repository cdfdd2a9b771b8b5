"""What rig, scene and photographs state of one specimen must agree: r, P, R, turns, strands.

A rig of P/r = 14 beside a scene of P/r = 36 makes two curves that have nothing to do with each
other, and nothing in the figure tells. A study that means it says so by ``allow_different``.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations
from pathlib import Path

import pandas as pd

import instron
import sim
from combing.errors import UserError

UNITS = {"r": "m", "P": "m", "R": "m", "turns": "", "strands": ""}
# Relative: what is written down is rounded, what is photographed is measured (docs/study.md).
WRITTEN = {"r": 0.02, "P": 0.02, "R": 0.02, "turns": 0.05, "strands": 0.0}
PHOTOGRAPHED = {"r": 0.2, "P": 0.1, "R": 0.3, "turns": 0.15, "strands": 0.0}


@dataclass(frozen=True)
class Statement:
    """What one source says of the specimen.

    Attributes
    ----------
    source : str
        File name, for messages.
    facts : mapping
        By name (r, P, R in metres, turns, strands); what it does not state is left out.
    tolerance : mapping
        Relative difference from another source that its rounding or its measurement explains.
    """

    source: str
    facts: Mapping[str, float]
    tolerance: Mapping[str, float]


def of_rig(path: Path) -> Statement:
    """Return what a rig states."""
    rig = instron.load_rig(path)
    stated = {"r": rig.r, "P": rig.pitch, "R": rig.helix_radius, "turns": rig.turns}
    facts = {key: value for key, value in stated.items() if value is not None}
    return Statement(path.name, facts, WRITTEN)


def of_scene(name: str, scene: sim.Scene) -> Statement:
    """Return what a scene states of its first rod, and how many rods it has."""
    rod = scene.rods[0]
    facts = {"r": rod.radius, "strands": float(len(scene.rods))}
    if rod.shape.kind == "helix":
        shape = rod.shape
        facts |= {"P": shape.pitch, "R": shape.radius, "turns": shape.height / shape.pitch}
    return Statement(name, facts, WRITTEN)


def of_photograph(found: pd.DataFrame) -> Statement:
    """Return what the photograph before the tine, measured by `measure_link`, says."""
    facts = {
        "r": found.attrs["r"],
        "R": found.attrs["R"],
        "P": 1 / abs(float(found["link"].mean())),
        "turns": abs(found.attrs["total_link"]),
    }
    return Statement(found.attrs["photo"], facts, PHOTOGRAPHED)


def disagreements(name: str, statements: Sequence[Statement], allowed: Sequence[str]) -> list[str]:
    """Hold statements against each other.

    Parameters
    ----------
    name : str
        Of the set.
    statements : sequence of Statement
    allowed : sequence of str
        Facts that may differ; that they do is returned as a note.

    Returns
    -------
    list of str
        Differences that the study allows.

    Raises
    ------
    UserError
        At the first difference that it does not allow.
    """
    notes = []
    for one, other in combinations(statements, 2):
        for fact in [fact for fact in UNITS if fact in one.facts and fact in other.facts]:
            if _agree(one, other, fact):
                continue
            text = f"{name}: {_said(one, fact)} but {_said(other, fact)}"
            if fact not in allowed:
                raise UserError(
                    f'{text}; make them agree, or write allow_different = ["{fact}"] into the set'
                )
            notes.append(f"{text} (the study allows it)")
    return notes


def _agree(one: Statement, other: Statement, fact: str) -> bool:
    a, b = one.facts[fact], other.facts[fact]
    reach = max(one.tolerance[fact], other.tolerance[fact]) * max(a, b)
    return abs(a - b) <= reach + (0.5 if fact == "turns" else 0.0)


def _said(one: Statement, fact: str) -> str:
    return f"{fact} = {one.facts[fact]:.4g} {UNITS[fact]}".rstrip() + f" in {one.source}"
