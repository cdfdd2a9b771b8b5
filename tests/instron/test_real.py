"""Real exports of six machines against numbers read off by hand."""

import json
from pathlib import Path

import numpy as np
import pytest

import instron

REAL = Path(__file__).parents[3] / "shared" / "real" / "instron"
PER_SI = {"s": 1, "sec": 1, "mm": 1e3, "N": 1, "kN": 1e-3}
FILES = ["bluehill_trailing_commas.csv", "bluehill_cyclic.csv", "zwick.TRA", "mts_tab.dat",
         "units_in_parentheses_kN.csv", "metadata_tab_utf8.csv"]  # fmt: skip


@pytest.fixture(scope="module")
def truth():
    if not REAL.exists():
        pytest.skip(f"real exports are not at {REAL}")
    return {row["file"]: row for row in json.loads((REAL / "truth.json").read_text())}


@pytest.mark.parametrize("name", FILES)
def test_a_real_export_is_read_exactly(name, truth):
    expected = truth[name]
    logs = instron.read(REAL / name)
    assert len(logs) == 1
    log, (_, length, force) = logs[0], expected["units"]
    x, F = log["displacement"] * PER_SI[length], log["force"] * PER_SI[force]
    assert len(log) == expected["rows"]
    got = [F.max(), F.min(), x[F.idxmax()], x.iloc[0], x.iloc[-1], log["time"].iloc[-1]]
    keys = ["Fmax", "Fmin", "x_at_Fmax", "x_first", "x_last", "t_last"]
    np.testing.assert_allclose(got, [expected[key] for key in keys], rtol=1e-12, atol=1e-12)
    assert log.attrs["warnings"] == []


def test_what_is_known_of_a_file_comes_along(truth):
    attrs = instron.read(REAL / "bluehill_cyclic.csv")[0].attrs
    assert attrs["specimen"] == "22L.3"
    assert attrs["metadata"]["General : Start Date"] == "13/11/2018 5:14 PM"
    assert attrs["columns"]["time"] == {"name": "Time", "unit": "sec", "index": 0}
    assert attrs["dialect"]["newline"] == "CRLF"
    machine = instron.read(REAL / "metadata_tab_utf8.csv")[0].attrs
    assert machine["metadata"]["Machine type"] == "INSTRON 8852TT"
    assert "not taken: 'Displacement'" in machine["choices"][0]
