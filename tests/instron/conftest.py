import numpy as np
import pytest

import instron


@pytest.fixture
def is_read_exactly(tmp_path):
    """Check a look-alike: a function that returns text, values by log, and maybe an encoding."""

    def check(family):
        text, expected, *encoding = family()
        path = tmp_path / "export.csv"
        path.write_bytes(text.encode(*encoding or ["utf-8"]))
        logs = instron.read(path)
        assert len(logs) == len(expected)
        for log, columns in zip(logs, expected, strict=True):
            assert len(log) == len(columns[0])
            for name, values in zip(("time", "displacement", "force"), columns, strict=True):
                np.testing.assert_allclose(log[name], values, rtol=1e-12, atol=1e-15, err_msg=name)
            assert log.attrs["warnings"] == []

    return check
