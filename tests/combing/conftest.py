"""A headless browser for the tests of pages."""

import subprocess

import pytest
from browser import NAMES, installed

FLAGS = [
    "--headless",
    "--disable-gpu",
    "--no-sandbox",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--enable-logging=stderr",
    "--virtual-time-budget=5000",
]


@pytest.fixture
def open_page(tmp_path):
    """Open a page; return its DOM and what the browser logged. Skip where there is no browser."""
    browser = installed()
    if browser is None:
        pytest.skip(f"no browser: none of {', '.join(NAMES)} is installed")

    def open_page(page):
        profile = f"--user-data-dir={tmp_path / 'profile'}"
        command = [browser, *FLAGS, profile, "--dump-dom", page.as_uri()]
        done = subprocess.run(command, capture_output=True, text=True, timeout=120, check=True)
        return done.stdout, done.stderr

    return open_page
