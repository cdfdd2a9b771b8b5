"""Processor time of the demo's photographs, in turns with that of another checkout.

Run from the checkout:

    OMP_NUM_THREADS=1 python benchmarks/imaging_demo.py [PHOTOGRAPHS] [--beside CHECKOUT]

The least of three measurements in one process, on one thread, from the file to all that is measured
on it: scale, strands, crossings and interactions of a curl; scale and link density of a helix.
"""

import argparse
import os
import resource
import subprocess
import sys
import time
from pathlib import Path

import cv2

HERE = Path(__file__).parents[1]
SIDE = 0.008  # m, of the marker
ASKED = {"curl": 1.5, "helix": 2.0}  # s


def measure(path: Path) -> None:
    """Print the least processor time [s] and the peak memory [GB] of one photograph."""
    from imaging import helix, read_photo
    from imaging.measure.measured import measure as measured
    from imaging.scale import from_marker, parse_scale

    cv2.setNumThreads(1)
    spent = []
    for _ in range(3):
        start = time.process_time()
        if "helix" in path.name:
            scale, photo = from_marker(read_photo(path), SIDE)
            helix(photo, scale=scale)
        else:
            measured(read_photo(path), parse_scale(f"marker:{1e3 * SIDE:g}mm"))
        spent.append(time.process_time() - start)
    print(min(spent), resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e6)


def cost(path: Path, checkout: Path) -> tuple[float, float]:
    """Time [s] and memory [GB] of a photograph, measured by a checkout in a process of its own."""
    call = [sys.executable, __file__, "--measure", str(path)]
    environment = os.environ | {"PYTHONPATH": str(checkout)}
    said = subprocess.run(call, check=True, capture_output=True, text=True, env=environment)
    seconds, memory = map(float, said.stdout.split()[-2:])
    return seconds, memory


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("photographs", type=Path, nargs="*")
    parser.add_argument("--beside", type=Path, help="another checkout")
    parser.add_argument("--measure", type=Path, help=argparse.SUPPRESS)
    asked = parser.parse_args()
    if asked.measure is not None:
        measure(asked.measure)
        return
    checkouts = [HERE, *([asked.beside.resolve()] if asked.beside else [])]
    for path in asked.photographs or sorted((HERE / "data" / "photos").glob("*.jpg")):
        costs = [cost(path.resolve(), checkout) for checkout in checkouts]
        said = "   beside ".join(f"{seconds:6.2f} s {memory:5.2f} GB" for seconds, memory in costs)
        goal = ASKED["helix" if "helix" in path.name else "curl"]
        print(f"{path.stem:<24} {said}   asked {goal} s", flush=True)


if __name__ == "__main__":
    main()
