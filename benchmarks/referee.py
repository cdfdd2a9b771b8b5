"""The public benchmark `cosseratbench`: this solver beside whatever others are installed.

    pip install -e ".[referee]" && python benchmarks/referee.py [EXPERIMENT ...]

A line an experiment and solver: how it ended, wall time, its time over this solver's, metrics.
Default numbers of elements; MuJoCo and DisMech take part where they are installed.
"""

import sys

from cosseratbench import registry, run
from cosseratbench.experiment import Experiment, Result

LINE = "| {:10s} | {:4d} | {:10s} | {:11s} | {:>9s} | {:>7s} | {} |"


def main(names: list[str]) -> None:
    print("| experiment | n | solver | outcome | time [s] | of ours | metrics |")
    print("|---|---|---|---|---|---|---|")
    for name in names or sorted(registry.names(registry.EXPERIMENTS)):
        compare(registry.load_experiment(name))


def compare(experiment: Experiment) -> None:
    """Run an experiment with every solver, this one first."""
    own = None
    for name in sorted(registry.names(registry.SOLVERS), key=lambda name: name != "combing"):
        try:
            solver = registry.load_solver(name)
        except ImportError:
            continue
        result = run(experiment, solver)
        own = own or result.wall_time
        print(described(result, own), flush=True)


def described(result: Result, own: float | None) -> str:
    taken = "" if result.wall_time is None else f"{result.wall_time:.2f}"
    ratio = "" if not (result.wall_time and own) else f"{result.wall_time / own:.1f}"
    numbers = ", ".join(f"{key} {value:.2g}" for key, value in result.metrics.items())
    return LINE.format(
        result.experiment, result.n_elements, result.solver, result.outcome, taken, ratio, numbers
    )


if __name__ == "__main__":
    main(sys.argv[1:])
