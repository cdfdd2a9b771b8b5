"""Time and memory of ``instron.read`` against the bare pandas call on the same file.

python benchmarks/instron_speed.py                  # 1 M rows, three notations
python benchmarks/instron_speed.py --rows 10000000  # adds the peak memory of a fresh process
"""

import argparse
import platform
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path

import numpy as np
import pandas as pd

import instron

NOTATIONS = {
    "plain": ("{:.5f}", ",", {}),
    "quoted, thousands": ('"{:,.5f}"', ",", {"thousands": ","}),
    "decimal comma": ("{:.5f}", ";", {"sep": ";", "decimal": ","}),
}


def write(path: Path, rows: int, cell: str, delimiter: str) -> None:
    """Write an export of a slow pull with forces up to 1500 N."""
    time_ = np.arange(rows) * 0.01
    columns = time_, time_ * 0.001, 1500 * np.sin(time_ / 3000) ** 2
    with path.open("w") as file:
        file.write(delimiter.join(["Time", "Extension", "Load"]) + "\n")
        file.write(delimiter.join(["(s)", "(mm)", "(N)"]) + "\n")
        for start in range(0, rows, 100_000):
            part = zip(*(c[start : start + 100_000] for c in columns), strict=True)
            text = "".join(delimiter.join(map(cell.format, row)) + "\n" for row in part)
            file.write(text.replace(".", ",") if delimiter == ";" else text)


def seconds(calls: list[Callable[[], object]], repeats: int) -> list[float]:
    """Return each call's shortest duration, taken in turns so that other load hits all alike."""
    best = [float("inf")] * len(calls)
    for _ in range(repeats + 1):
        for number, call in enumerate(calls):
            start = time.perf_counter()
            call()
            best[number] = min(best[number], time.perf_counter() - start)
    return best


def peak_memory(path: Path) -> float:
    """Return the peak resident memory [GB] of a fresh process that reads the file."""
    code = f"import instron; instron.read({str(path)!r})"
    subprocess.run([sys.executable, "-c", code], check=True)
    return resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss / 1e6


def main() -> None:
    """Print one line per notation."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--rows", type=int, default=1_000_000)
    parser.add_argument("--repeats", type=int, default=15)
    options = parser.parse_args()
    print(f"python {platform.python_version()}, pandas {pd.__version__}, numpy {np.__version__}")
    with tempfile.TemporaryDirectory() as folder:
        for name, (cell, delimiter, keywords) in NOTATIONS.items():
            path = Path(folder) / "export.csv"
            write(path, options.rows, cell, delimiter)
            memory = f", peak {peak_memory(path):.2f} GB" if options.rows >= 5_000_000 else ""
            calls = [partial(pd.read_csv, path, skiprows=2, header=None, **keywords),
                     partial(instron.read, path)]  # fmt: skip
            bare, ours = seconds(calls, options.repeats)
            size = path.stat().st_size / 1e6
            print(f"{name}: {options.rows} rows, {size:.0f} MB, pandas {bare:.3f} s, "
                  f"instron {ours:.3f} s, ratio {ours / bare:.2f}{memory}")  # fmt: skip


if __name__ == "__main__":
    main()
