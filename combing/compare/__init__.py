"""Experiment, simulation and theory side by side, all measured by the same operators."""

from combing.compare.bench import Result, compare

__all__ = ["Result", "compare"]
