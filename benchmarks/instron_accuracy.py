"""Coverage of the mean band, and recall and precision of events, on synthetic repeats.

python benchmarks/instron_accuracy.py
"""

from collections.abc import Callable

import numpy as np
import pandas as pd

import instron
from instron.repeats import simultaneous_band

X = np.linspace(0, 1, 101)
FINE = np.linspace(0, 1, 5000)


def smooth(n: int, rng: np.random.Generator) -> np.ndarray:
    """Return n curves of five random modes, of true mean 0."""
    modes = np.sin(np.pi * np.outer(np.arange(1, 6), X))
    return (rng.normal(size=(n, 5)) / np.arange(1, 6)) @ modes + rng.normal(size=(n, 1)) * 0.3


def jams(n: int, rng: np.random.Generator) -> np.ndarray:
    """Return n curves with one jam, whose place scatters by half its width."""
    places = 0.5 + 0.025 * rng.standard_normal((n, 1))
    return np.exp(-(((X - places) / 0.05) ** 2)) + 0.3 * smooth(n, rng)


def coverage(n: int, draw: Callable[..., np.ndarray], trials: int = 1000) -> float:
    """Return how often the 95 % band of n repeats holds the whole true mean curve."""
    truth = draw(40_000, np.random.default_rng(0)).mean(axis=0)
    rng = np.random.default_rng(n)
    bands = (simultaneous_band(draw(n, rng), 0.95, 500, rng) for _ in range(trials))
    return sum(bool(np.all((low <= truth) & (high >= truth))) for low, high in bands) / trials


def detection(prominence: float, curves: int = 200) -> tuple[float, float]:
    """Return recall and precision for nine peaks a curve, of ``prominence`` times the noise."""
    rng = np.random.default_rng(0)
    hits = missed = false = 0
    for _ in range(curves):
        places = np.arange(0.1, 0.95, 0.1) + rng.uniform(-0.02, 0.02, 9)
        f = sum(prominence * np.exp(-(((FINE - p) / 0.012) ** 2) / 2) for p in places)
        table = pd.DataFrame({"x": FINE, "f": f + rng.standard_normal(len(FINE))})
        table.attrs["f_noise"] = 1.0
        found = instron.events(table)
        found = found.loc[found["kind"] != "plateau", "x"].to_numpy()
        near = np.abs(found[:, None] - places[None]) < 0.02
        hits += int(near.any(axis=0).sum())
        missed += int((~near.any(axis=0)).sum())
        false += int((~near.any(axis=1)).sum())
    return hits / (hits + missed), hits / max(1, hits + false)


def main() -> None:
    """Print both tables."""
    for n in (3, 4, 5, 8, 12, 20):
        print(f"95 % band of {n} repeats, true mean covered in 1000 trials: "
              f"smooth {coverage(n, smooth):.1%}, jams {coverage(n, jams):.1%}")  # fmt: skip
    for prominence in (2.0, 3.0, 5.0, 8.0):
        recall, precision = detection(prominence)
        print(f"peaks of {prominence:g} x noise: recall {recall:.3f}, precision {precision:.3f}")


if __name__ == "__main__":
    main()
