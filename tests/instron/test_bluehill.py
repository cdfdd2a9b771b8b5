import numpy as np
import pandas as pd
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from instron import read, write_bluehill


def log(n=200):
    t = np.round(np.arange(n) * 0.02, 5)
    return pd.DataFrame({"time": t, "displacement": t * 1e-3, "force": 1.5 * np.sin(t)})


@pytest.mark.parametrize("unit", ["N", "mN", "kN"])
def test_what_is_written_is_read(unit, tmp_path):
    path = write_bluehill(tmp_path / "a.csv", log(), force_unit=unit, decimals=9)
    back = read(path)[0]
    for name, within in (("time", 1e-9), ("displacement", 1e-12), ("force", 1e-6)):
        np.testing.assert_allclose(back[name], log()[name], rtol=0, atol=within)
    assert back.attrs["warnings"] == []


@settings(max_examples=60, deadline=None, derandomize=True,
          suppress_health_check=[HealthCheck.function_scoped_fixture])  # fmt: skip
@given(force=st.floats(-12, 6), length=st.floats(-9, 1), seed=st.integers(0, 99),
       unit=st.sampled_from(["N", "mN", "kN"]))  # fmt: skip
def test_a_log_of_any_size_keeps_its_digits(force, length, seed, unit, tmp_path):
    rng = np.random.default_rng(seed)
    table = log(60)
    table["force"] = 10**force * (np.sin(table["time"]) + 0.05 * rng.standard_normal(60))
    table["displacement"] = 10**length * np.cumsum(rng.uniform(0.1, 1, 60))
    back = read(write_bluehill(tmp_path / "a.csv", table, force_unit=unit))[0]
    for name in ("time", "displacement", "force"):
        within = 5.1e-6 * np.abs(table[name]).max()
        np.testing.assert_allclose(back[name], table[name], rtol=0, atol=within)


def test_two_micronewtons_are_not_written_as_zero(tmp_path):
    table = log()
    table["force"] *= 2e-6 / 1.5
    back = read(write_bluehill(tmp_path / "a.csv", table))[0]
    assert back["force"].max() == pytest.approx(2e-6, rel=1e-4)


def test_metadata_label_the_file(tmp_path):
    facts = {"Text Inputs : Specimen label": 'a "quoted", name', "General : Origin": "synthetic"}
    back = read(write_bluehill(tmp_path / "a.csv", log(), facts))[0]
    assert back.attrs["metadata"]["General : Origin"] == "synthetic"
    assert back.attrs["specimen"].replace('""', '"') == 'a "quoted", name'


def test_it_looks_like_bluehill_3(tmp_path):
    lines = write_bluehill(tmp_path / "a.csv", log(), {"Specimen properties : Length": 150})
    assert lines.read_bytes().startswith(
        b"Specimen properties : Length,150\r\n\r\nTime,Extension,Load\r\n(s),(mm),(N)\r\n0.00000,"
    )


def test_nothing_stays_behind_when_writing_fails(tmp_path):
    with pytest.raises(KeyError):
        write_bluehill(tmp_path / "a.csv", log().drop(columns="force"))
    assert list(tmp_path.iterdir()) == []
