"""What every test may use: independent reference numbers and real data beside the checkout."""

import json
import os
from collections.abc import Callable
from pathlib import Path

import pytest

from combing.cli import main

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


@pytest.fixture(scope="session")
def run() -> Callable[..., int]:
    """Run a command line in this process; return its exit code."""

    def run(*args: object) -> int:
        try:
            main([str(arg) for arg in args])
        except SystemExit as leaving:
            return int(leaving.code or 0)
        return 0

    return run
