"""Strands -> crossings, contacts that stay unresolved, N-body interactions."""

from imaging.count.crossings import crossings
from imaging.count.interactions import densities, events, interactions
from imaging.count.unresolved import unresolved

__all__ = ["crossings", "densities", "events", "interactions", "unresolved"]
