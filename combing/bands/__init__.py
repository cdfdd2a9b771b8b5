"""Error bars of a simulation: what its mesh and another specimen would change, as 95 % bands."""

from combing.bands.bands import Bands
from combing.bands.simulate import MEMBERS, simulate_with_bands, simulating_with_bands
from combing.bands.store import read_bands

__all__ = ["MEMBERS", "Bands", "read_bands", "simulate_with_bands", "simulating_with_bands"]
