"""How long a fresh process takes to its first step: with warm kernels, and when it must compile.

    python benchmarks/sim_start.py

Wall and processor time of `import sim`, building the preset's scene and one step. The cold process
has an empty kernel cache of its own, the warm ones use it afterwards; the median of five.
"""

import os
import platform
import resource
import statistics
import subprocess
import sys
import tempfile
import time
from importlib import metadata
from pathlib import Path

BARE = "scene = scene.model_copy(update={'contact': None, 'tines': [], 'damping': None}); "
STEP = "import sim; scene = sim.double_helix(pi1=18); {change}import sim.explicit; " \
    "sim.explicit.explicit(scene).advance(1)"  # fmt: skip


def run(code, cache):
    """Return wall and processor time of a fresh process [s]."""
    root = str(Path(__file__).parents[1])
    environment = os.environ | {"NUMBA_CACHE_DIR": cache, "PYTHONPATH": root}
    began, used = time.perf_counter(), resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run([sys.executable, "-c", code], env=environment, check=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    processor = after.ru_utime + after.ru_stime - used.ru_utime - used.ru_stime
    return time.perf_counter() - began, processor


def main():
    versions = ", ".join(f"{name} {metadata.version(name)}" for name in ("numba", "numpy"))
    print(f"{platform.machine()}, Python {platform.python_version()}, {versions}\n")
    print("                                   wall s   processor s")
    for name, change in (("bare rods", BARE), ("the double helix preset", "")):
        with tempfile.TemporaryDirectory() as cache:
            code = STEP.format(change=change)
            cold = run(code, cache)
            warm = [run(code, cache) for _ in range(5)]
        middle = [statistics.median(each) for each in zip(*warm, strict=True)]
        print(f"{name + ', cold':34s} {cold[0]:6.1f} {cold[1]:13.1f}")
        print(f"{name + ', warm':34s} {middle[0]:6.2f} {middle[1]:13.2f}", flush=True)
    alone = [run("import sim", tempfile.gettempdir())[0] for _ in range(5)]
    print(f"{'import sim alone':34s} {statistics.median(alone):6.2f}")


if __name__ == "__main__":
    main()
