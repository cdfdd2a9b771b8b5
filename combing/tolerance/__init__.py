"""How accurate a combing shall be: the cheapest setting that is predicted to hold it, verified."""

from combing.tolerance.front import PRESETS, load_front, pareto
from combing.tolerance.setting import Setting
from combing.tolerance.simulate import (
    as_tolerance,
    in_words,
    often,
    read_tolerance,
    settle,
    simulate_to_tolerance,
    with_record,
)

__all__ = [
    "PRESETS",
    "Setting",
    "as_tolerance",
    "in_words",
    "load_front",
    "often",
    "pareto",
    "read_tolerance",
    "settle",
    "simulate_to_tolerance",
    "with_record",
]
