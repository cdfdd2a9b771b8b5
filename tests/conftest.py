"""What every test may use: independent reference numbers and real data beside the checkout."""

import json
import os
from pathlib import Path

import pytest

SHARED = Path(os.environ.get("COMBING_SHARED", Path(__file__).parents[2] / "shared"))


@pytest.fixture(scope="session")
def shared():
    """Folder of reference numbers and real data; tests that need it skip where it is absent."""
    if not SHARED.is_dir():
        pytest.skip(f"no folder {SHARED} with reference numbers and real data")
    return SHARED


@pytest.fixture(scope="session")
def reference(shared):
    """Return a table of independent numbers by its name."""
    return lambda name: json.loads((shared / "reference" / f"{name}.json").read_text())
