import numpy as np
import pytest
from hypothesis import HealthCheck, settings

import instron

RELAXED = {"deadline": None, "suppress_health_check": list(HealthCheck), "database": None}
# The default run takes the same examples every time: what a search finds gets a test of its own.
settings.register_profile("steady", derandomize=True, **RELAXED)
settings.register_profile("search", **RELAXED)


@pytest.fixture(scope="module")
def attempt(tmp_path_factory):
    """Read bytes: the logs, or None when they were refused with the file's name in one line."""
    path = tmp_path_factory.mktemp("fuzz") / "export.csv"

    def read(content):
        path.write_bytes(content)
        try:
            return instron.read(path)
        except instron.Unreadable as error:
            message = str(error)
        assert path.name in message
        assert "\n" not in message
        return None

    return read


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
