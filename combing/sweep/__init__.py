"""Many simulations from one file: grids, lists, Latin hypercubes; kept on disk, point by point."""

from combing.sweep.run import run_sweep, simulate_points
from combing.sweep.store import Store, part_of_points

__all__ = ["Store", "part_of_points", "run_sweep", "simulate_points"]
