"""Exports of testing machines to force logs, scaled curves, events, repeats; Love's helix."""

from instron.bluehill import write_bluehill
from instron.errors import RigError, Unreadable, Unscalable
from instron.events import events
from instron.love import love_force, theory_curve, wrench
from instron.read import read
from instron.repeats import Repeats, on_grid, repeats
from instron.scaling.average import averaged
from instron.scaling.noise import noise_of
from instron.scaling.rig import Rig, load_rig
from instron.scaling.scale import scale, work
from instron.scaling.strokes import strokes
from instron.source.kinds import exports
from instron.summary import summary

__all__ = [
    "Repeats",
    "Rig",
    "RigError",
    "Unreadable",
    "Unscalable",
    "averaged",
    "events",
    "exports",
    "load_rig",
    "love_force",
    "noise_of",
    "on_grid",
    "read",
    "repeats",
    "scale",
    "strokes",
    "summary",
    "theory_curve",
    "work",
    "wrench",
    "write_bluehill",
]
