"""Time and memory of ``instron.read`` against the bare pandas call on the same file.

python benchmarks/instron_speed.py                  # 1 M rows, ten notations
python benchmarks/instron_speed.py --rows 10000000  # plain only, and the peak memory
"""

import argparse
import io
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

GERMAN = str.maketrans(",.", ".,")
# Number format, swap of its marks, delimiter, from what size on a number is quoted, line end,
# and how pandas has to be told.
NOTATIONS = {
    "plain": ("{:.5f}", {}, ",", np.inf, "\n", {}),
    "CRLF": ("{:.5f}", {}, ",", np.inf, "\r\n", {}),
    "TAB": ("{:.5f}", {}, "\t", np.inf, "\n", {"sep": "\t"}),
    "all quoted": ("{:.5f}", {}, ",", 0, "\n", {}),
    "all quoted, thousands": ("{:,.5f}", {}, ",", 0, "\n", {"thousands": ","}),
    "thousands quoted only": ("{:,.5f}", {}, ",", 1000, "\n", {"thousands": ","}),
    "thousands, TAB": ("{:,.5f}", {}, "\t", np.inf, "\n", {"sep": "\t", "thousands": ","}),
    "decimal comma": ("{:.5f}", GERMAN, ";", np.inf, "\n", {"sep": ";", "decimal": ","}),
    "decimal comma, quoted": ("{:.5f}", GERMAN, ",", 0, "\n", {"decimal": ","}),
    "German thousands": ("{:,.5f}", GERMAN, ";", np.inf, "\n",
                         {"sep": ";", "decimal": ",", "thousands": "."}),
}  # fmt: skip


def write(path: Path, rows: int, notation: tuple) -> None:
    """Write an export of a slow pull with forces up to 1500 N."""
    form, swap, delimiter, quoted_from, end, _ = notation
    time_ = np.arange(rows) * 0.01
    columns = time_, time_ * 0.001, 1500 * np.sin(time_ / 3000) ** 2

    def cell(value: float) -> str:
        text = form.format(value).translate(swap)
        return f'"{text}"' if value >= quoted_from else text

    with path.open("w", newline="") as file:
        file.write(delimiter.join(["Time", "Extension", "Load"]) + end)
        file.write(delimiter.join(["(s)", "(mm)", "(N)"]) + end)
        for start in range(0, rows, 100_000):
            part = zip(*(c[start : start + 100_000] for c in columns), strict=True)
            file.write("".join(delimiter.join(map(cell, row)) + end for row in part))


def write_buffers(path: Path, buffers: int = 200, rows: int = 1024) -> None:
    """Write one test as a controller does, in buffers with a head each."""
    time_ = np.arange(buffers * rows) * 0.01
    lines = [f"{t * 1e-3:.6f}\t{1500 * np.sin(t / 300) ** 2:.5f}\t{t:.4f}\n" for t in time_]
    head = "Data Acquisition\t\t\tTime:\t{}\ts\n"
    head += "Axial Displacement\tAxial Force\tRunning Time\nmm\tN\ts\n"
    with path.open("w") as file:
        file.write("MTS793|MPT|ENU|1|2|.|/|:|1|0|0|A\n\n")
        for first in range(0, len(lines), rows):
            file.write(head.format(first) + "".join(lines[first : first + rows]) + "\n")


def pandas_by_buffer(path: Path) -> pd.DataFrame:
    """Read every buffer with a call of its own, for one who knows what stands above each."""
    parts = path.read_bytes().split(b"mm\tN\ts\n")[1:]
    return pd.concat([pd.read_csv(io.BytesIO(part.partition(b"\nData")[0]), sep="\t", header=None)
                      for part in parts])  # fmt: skip


def seconds(calls: list[Callable[[], object]], repeats: int) -> np.ndarray:
    """Return each call's processor time, (repeats, calls), taken in turns."""
    taken = []
    for _ in range(repeats + 1):
        taken.append([])
        for call in calls:
            start = time.process_time()
            call()
            taken[-1].append(time.process_time() - start)
    return np.array(taken[1:])


def compared(calls: list[Callable[[], object]], repeats: int) -> str:
    """Compare the last call with the best other, turn by turn: other load hits all alike."""
    taken = seconds(calls, repeats)
    best = taken[:, np.argmin(np.median(taken[:, :-1], axis=0))]
    low, middle, high = np.quantile(taken[:, -1] / best, [0.25, 0.5, 0.75])
    return (f"pandas {np.median(best):.3f} s, instron {np.median(taken[:, -1]):.3f} s,"
            f" ratio {middle:.2f} ({low:.2f} to {high:.2f})")  # fmt: skip


def peak_memory(path: Path) -> float:
    """Return the peak resident memory [GB] of a fresh process that reads the file."""
    code = f"import instron; instron.read({str(path)!r})"
    subprocess.run([sys.executable, "-c", code], check=True)
    return resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss / 1e6


def main() -> None:
    """Print one line per notation."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--rows", type=int, default=1_000_000)
    parser.add_argument("--repeats", type=int, default=11)
    options = parser.parse_args()
    print(f"python {platform.python_version()}, pandas {pd.__version__}, numpy {np.__version__}")
    with tempfile.TemporaryDirectory() as folder:
        for name, notation in NOTATIONS.items():
            path = Path(folder) / "export.csv"
            write(path, options.rows, notation)
            memory = f", peak {peak_memory(path):.2f} GB" if options.rows >= 5_000_000 else ""
            bare = partial(pd.read_csv, path, skiprows=2, header=None, **notation[-1])
            calls = [bare, partial(bare, memory_map=True), partial(instron.read, path)]
            size = path.stat().st_size / 1e6
            print(f"{name}: {options.rows} rows, {size:.0f} MB, "
                  f"{compared(calls, options.repeats)}{memory}", flush=True)  # fmt: skip
            if options.rows >= 5_000_000:
                return
        path = Path(folder) / "buffers.dat"
        write_buffers(path)
        calls = [partial(pandas_by_buffer, path), partial(instron.read, path)]
        print(f"200 buffers of 1024 rows: {compared(calls, options.repeats)}")


if __name__ == "__main__":
    main()
