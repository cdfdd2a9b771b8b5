"""Time of the entanglement of many strands, over the error that far pairs may have.

python benchmarks/tangle_speed.py [STRANDS] [SEGMENTS]
"""

import sys
import time

import numpy as np

import sim


def hairs(strands: int, segments: int) -> list[np.ndarray]:
    """Return hairs of segments of 2 mm that wander as they hang, roots within some 4 mm."""
    rng = np.random.default_rng(1)
    found = []
    for _ in range(strands):
        steps = np.column_stack([0.6 * rng.normal(size=(segments, 2)), -np.ones(segments)])
        steps *= 2e-3 / np.linalg.norm(steps, axis=1, keepdims=True)
        root = [*(4e-3 * rng.normal(size=2)), 0.0]
        found.append(np.vstack([root, root + np.cumsum(steps, axis=0)]))
    return found


def main() -> None:
    """Print a row an error: processor time, and how far the crossings of pairs are off."""
    strands, segments = (int(text) for text in (sys.argv[1:] + ["100", "60"][len(sys.argv) - 1 :]))
    tangle = hairs(strands, segments)
    sim.entanglement(tangle[:2])  # compiles
    exact = sim.entanglement(tangle, error=0)
    print(f"{strands} strands of {segments} segments; processor time, one core")
    for error in (1e-2, 1e-3, 1e-4, 0.0):
        times = []
        for _ in range(5):
            began = time.process_time()
            found = sim.entanglement(tangle, error=error)
            times.append(time.process_time() - began)
        off = np.abs(found.crossings / exact.crossings - 1).max()
        print(f"error {error:g}: {np.median(times):.2f} s, crossings of a pair off by {off:.1e}")


if __name__ == "__main__":
    main()
