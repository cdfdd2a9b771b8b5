"""Bands in the file of their run, beside everything else, and out of it again."""

import json
from typing import Any

import numpy as np
import pandas as pd

import sim
from combing.bands.bands import Bands
from combing.bands.intervals import LEVEL

TABLES = ("force", "link", "numbers")
KINDS = ("spread", "mesh")
UNITS = {
    "force": {"d": "m"},
    "link": {"displacement": "m", "s": "m"}
    | dict.fromkeys(("value", "low", "high", "mesh", "mean", "sd"), "1/m"),
}
LONG = {
    "low": f"lower end of the band at {LEVEL:g}",
    "high": f"upper end of the band at {LEVEL:g}",
    "mesh": "half-width by the mesh: a bias",
    "mean": "over the members",
    "sd": "over the members",
}


def with_bands(run: sim.Run, bands: Bands) -> sim.Run:
    """Return the run with variables band_TABLE_COLUMN and the attribute `bands`."""
    variables = {}
    for name in TABLES:
        table = getattr(bands, name)
        for column in table:
            variables[f"band_{name}_{column}"] = _variable(name, str(column), table[column])
    data = run.data.assign(variables)
    data.attrs = run.data.attrs | {"bands": json.dumps(bands.about)}
    return sim.Run(data)


def _variable(table: str, column: str, values: pd.Series) -> tuple:
    about: dict[str, Any] = {
        "units": UNITS.get(table, {}).get(column, "1"),
        "long_name": LONG.get(column, column),
    }
    content = values.to_numpy()
    if column == "kind":
        flags = {"flag_values": np.array([0, 1], np.int8), "flag_meanings": " ".join(KINDS)}
        content, about = (values == KINDS[1]).to_numpy(np.int8), about | flags
    if table == "numbers":
        del about["units"]  # each row has its own: D is in m, rho_N in 1/m
    return f"band_{table}", content, about


def read_bands(run: sim.Run) -> Bands | None:
    """Return the bands that a run was stored with, None where it has none."""
    if "bands" not in run.data.attrs:
        return None
    tables = {name: _table(run, f"band_{name}_") for name in TABLES}
    return Bands(**tables, about=json.loads(run.data.attrs["bands"]))


def _table(run: sim.Run, prefix: str) -> pd.DataFrame:
    table = pd.DataFrame(
        {
            str(name).removeprefix(prefix): np.asarray(run.data[name])
            for name in run.data.data_vars
            if str(name).startswith(prefix)
        }
    )
    if "kind" in table:
        table["kind"] = np.array(KINDS)[table["kind"]]
    return table
