import numpy as np
import pandas as pd
import pytest

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
