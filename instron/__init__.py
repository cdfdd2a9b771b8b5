"""Exports of testing machines to force logs, scaled curves, events, repeats; Love's helix."""

from instron.average import averaged
from instron.bluehill import write_bluehill
from instron.errors import RigError, Unreadable, Unscalable
from instron.events import events
from instron.love import love_force, theory_curve, wrench
from instron.noise import noise_of
from instron.read import read
from instron.repeats import Repeats, on_grid, repeats
from instron.rig import Rig, load_rig
from instron.scale import scale, work
from instron.strokes import strokes
from instron.summary import summary

__all__ = [
    "Repeats",
    "Rig",
    "RigError",
    "Unreadable",
    "Unscalable",
    "averaged",
    "events",
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
