"""Exports of testing machines to force logs, scaled curves, events, repeats; Love's helix."""

from instron.errors import RigError, Unreadable, Unscalable
from instron.read import read

__all__ = ["RigError", "Unreadable", "Unscalable", "read"]
