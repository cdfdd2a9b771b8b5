"""A headless browser for the tests of pages."""

import subprocess

import pytest
from browser import NAMES, installed, page

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


@pytest.fixture(scope="session")
def browser():
    """Path of a browser; tests that need one skip where there is none."""
    found = installed()
    if found is None:
        pytest.skip(f"no browser: none of {', '.join(NAMES)} is installed")
    return found


@pytest.fixture(scope="module")
def chromium(browser, tmp_path_factory):
    """Yield a page of a browser with a hand: real clicks and keys."""
    with page(tmp_path_factory.mktemp("browser")) as opened:
        yield opened


@pytest.fixture
def open_page(browser, tmp_path):
    """Open a page; return its DOM and what the browser logged."""

    def open_page(page):
        profile = f"--user-data-dir={tmp_path / 'profile'}"
        command = [browser, *FLAGS, profile, "--dump-dom", page.as_uri()]
        done = subprocess.run(command, capture_output=True, text=True, timeout=120, check=True)
        return done.stdout, done.stderr

    return open_page
