"""Write a force log the way Bluehill 3 exports raw data."""

import math
import os
import tempfile
from collections.abc import Mapping
from pathlib import Path

import pandas as pd

TITLES = {"time": "Time", "displacement": "Extension", "force": "Load"}
PER_SI = {"s": 1.0, "mm": 1e3, "N": 1.0, "mN": 1e3, "kN": 1e-3}
SIGNIFICANT = 6


def write_bluehill(
    path: str | Path,
    log: pd.DataFrame,
    metadata: Mapping[str, object] | None = None,
    *,
    force_unit: str = "N",
    decimals: int = 5,
) -> Path:
    """Write a force log as a Bluehill 3 raw-data CSV and return its path.

    Parameters
    ----------
    path
        Where to write; the file appears complete or not at all.
    log
        Columns ``time`` [s], ``displacement`` [m], ``force`` [N].
    metadata
        Lines above the header, e.g. ``{"Text Inputs : Specimen label": "helix 1",
        "General : Origin": "synthetic"}``.
    force_unit
        ``"N"``, ``"mN"`` or ``"kN"``.
    decimals
        Digits after the decimal point, at least; a column gets more where its largest number
        would have fewer than SIGNIFICANT digits (a log of 2 uN in N).
    """
    path = Path(path)
    units = {"time": "s", "displacement": "mm", "force": force_unit}
    table = pd.DataFrame({q: log[q] * PER_SI[unit] for q, unit in units.items()})
    lines = [f"{key},{_quoted(value)}" for key, value in (metadata or {}).items()]
    lines += [""] if lines else []
    lines += [",".join(TITLES.values()), ",".join(f"({unit})" for unit in units.values())]
    for column in table:
        table[column] = table[column].map(f"{{:.{_decimals(table[column], decimals)}f}}".format)
    rows = table.to_csv(header=False, index=False, lineterminator="\r\n")
    _replace(path, "".join(line + "\r\n" for line in lines) + rows)
    return path


def _decimals(column: pd.Series, least: int) -> int:
    """Return how many decimals leave the largest number of a column enough digits."""
    largest = float(column.abs().max())
    if not 0 < largest < math.inf:
        return least
    return max(least, SIGNIFICANT - 1 - math.floor(math.log10(largest)))


def _quoted(value: object) -> str:
    text = " ".join(str(value).split())
    return text if text.replace(".", "", 1).isdigit() else '"' + text.replace('"', '""') + '"'


def _replace(path: Path, text: str) -> None:
    """Write under a temporary name and move into place."""
    handle, name = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name}.")
    try:
        with os.fdopen(handle, "w", encoding="utf-8", newline="") as file:
            file.write(text)
        Path(name).chmod(0o644)
        Path(name).replace(path)
    except BaseException:
        Path(name).unlink(missing_ok=True)
        raise
