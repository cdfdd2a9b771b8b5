"""Write a force log the way Bluehill 3 exports raw data."""

import os
import tempfile
from collections.abc import Mapping
from pathlib import Path

import pandas as pd

TITLES = {"time": "Time", "displacement": "Extension", "force": "Load"}
PER_SI = {"s": 1.0, "mm": 1e3, "N": 1.0, "mN": 1e3, "kN": 1e-3}


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
        Digits after the decimal point of every number.
    """
    path = Path(path)
    units = {"time": "s", "displacement": "mm", "force": force_unit}
    table = pd.DataFrame({q: log[q] * PER_SI[unit] for q, unit in units.items()})
    lines = [f"{key},{_quoted(value)}" for key, value in (metadata or {}).items()]
    lines += [""] if lines else []
    lines += [",".join(TITLES.values()), ",".join(f"({unit})" for unit in units.values())]
    rows = table.to_csv(
        header=False, index=False, float_format=f"%.{decimals}f", lineterminator="\r\n"
    )
    _replace(path, "".join(line + "\r\n" for line in lines) + rows)
    return path


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
