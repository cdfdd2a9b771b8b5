"""Coverage of the mean band, and recall and precision of events, on synthetic repeats.

python benchmarks/instron_accuracy.py
"""

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


def coverage(n: int, trials: int = 1000) -> float:
    """Return how often the 95 % band of n repeats holds the whole true mean curve."""
    rng = np.random.default_rng(n)
    bands = (simultaneous_band(smooth(n, rng), 0.95, 500, rng) for _ in range(trials))
    return sum(bool(np.all((low <= 0) & (high >= 0))) for low, high in bands) / trials


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
    for n in (4, 5, 8, 12, 20):
        print(f"band of {n} repeats, 95 %: covers {coverage(n):.1%} of 1000 true mean curves")
    for prominence in (2.0, 3.0, 5.0, 8.0):
        recall, precision = detection(prominence)
        print(f"peaks of {prominence:g} x noise: recall {recall:.3f}, precision {precision:.3f}")


if __name__ == "__main__":
    main()
