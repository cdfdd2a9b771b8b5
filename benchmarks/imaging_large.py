"""Time and memory on photographs of twelve megapixels: rendered curls of twelve strands.

Run from the checkout:

    OMP_NUM_THREADS=1 PYTHONPATH=. python benchmarks/imaging_large.py [--first SEED]

`wide` is a curl of `imaging_curls.py` as a camera of twelve megapixels sees it, with strands 13 to
18 px wide; `thin` is one of strands as thin as there, three times as long. Each is drawn by one
process and measured by another, which reports its peak memory.
"""

import argparse
import resource
import subprocess
import sys
import time
from pathlib import Path
from tempfile import TemporaryDirectory

import cv2
import numpy as np
from drawn.strands import random_curl, render
from imaging_curls import PALETTE, SHAPE, STRANDS, line, varied_look

from imaging import crossings, interactions, read_photo, segment, trace

LARGER = np.sqrt(12e6 / (SHAPE[0] * SHAPE[1]))


def draw(seed: int, wide: bool) -> np.ndarray:
    """Draw a curl over twelve megapixels; its strands' width grows with it or not."""
    rng = np.random.default_rng(seed)
    size = {"length": 1200 * LARGER, "width": 400 * LARGER, "correlation": 90 * LARGER}
    lines, heights = random_curl(STRANDS, **size, slope=rng.uniform(0.2, 0.3), rng=rng)
    shape = int(SHAPE[0] * LARGER), int(SHAPE[1] * LARGER)
    lines = [points + [shape[1] / 2, 30 * LARGER] for points in lines]
    thick = LARGER if wide else 1.0
    heights = [thick * level for level in heights]
    colours, radius = rng.permutation(PALETTE), thick * rng.uniform(2.3, 3.2)
    return render(lines, heights, colours, radius, shape, look=varied_look(rng), rng=rng).pixels


def measure(path: Path) -> None:
    """Print what one photograph costs, stage by stage."""
    cv2.setNumThreads(1)
    clock = [time.process_time()]
    photo = read_photo(path)
    clock.append(time.process_time())
    segmentation = segment(photo)
    clock.append(time.process_time())
    strands = trace(segmentation, photo)
    clock.append(time.process_time())
    interactions(strands, table=crossings(strands, segmentation))
    clock.append(time.process_time())
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e6
    print(f"{path.stem}: {photo.shape[0]} x {photo.shape[1]}, strands", end=" ")
    print(f"{segmentation.width:.1f} px wide, {len(strands)} found of {STRANDS}")
    for name, spent in zip(("read", "segment", "trace", "cross"), np.diff(clock), strict=True):
        line(f"CPU s, {name}", spent, "-", 2)
    line("CPU s, all", clock[-1] - clock[0], "<= 4", 2)
    line("peak memory, GB (Python and libraries 0.2)", peak, "<= 1.5", 2)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--first", type=int, default=1012, help="seed")
    parser.add_argument("--draw", type=Path, help=argparse.SUPPRESS)
    parser.add_argument("--measure", type=Path, help=argparse.SUPPRESS)
    asked = parser.parse_args()
    if asked.draw is not None:
        pixels = draw(asked.first, asked.draw.stem == "wide")
        cv2.imwrite(str(asked.draw), pixels[..., ::-1])
    elif asked.measure is not None:
        measure(asked.measure)
    else:
        with TemporaryDirectory() as folder:
            for name in ("wide.png", "thin.png"):
                for step in ("--draw", "--measure"):
                    again = [sys.executable, __file__, "--first", str(asked.first)]
                    subprocess.run([*again, step, str(Path(folder) / name)], check=True)


if __name__ == "__main__":
    main()
