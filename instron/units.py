"""Conversion to SI, once, at the door."""

from functools import cache
from typing import Any

SI = {"time": "s", "displacement": "m", "force": "N"}
PINT_NAMES = {"gf": "gram_force", "kgf": "kilogram_force", "lbf": "pound_force",
              "ozf": "ounce_force"}  # fmt: skip


@cache
def _registry() -> Any:
    """Make pint's registry when first needed: it takes longer than reading a file."""
    import pint

    return pint.UnitRegistry()


@cache
def factor(unit: str, quantity: str) -> float:
    """Return how many SI units of ``quantity`` one ``unit`` (a pint name) is."""
    return float(_registry().Quantity(1.0, PINT_NAMES.get(unit, unit)).to(SI[quantity]).magnitude)
