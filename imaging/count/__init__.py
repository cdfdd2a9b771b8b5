"""Strands -> crossings, contacts that stay unresolved, N-body interactions."""

from imaging.count.crossings import crossing_matrix, crossings
from imaging.count.interactions import densities, events, interactions
from imaging.count.unresolved import unresolved

__all__ = ["crossing_matrix", "crossings", "densities", "events", "interactions", "unresolved"]
