"""Where the numbers of a report come from: command, study file, inputs, versions, solver."""

import hashlib
import platform
import shlex
import subprocess
import sys
from importlib import metadata
from pathlib import Path
from typing import Any

import pandas as pd

import combing
from combing.runs import model_version
from combing.study import Study

PACKAGES = ("combing", "numpy", "scipy", "pandas", "numba", "opencv-python-headless", "matplotlib")


def provenance(study: Study) -> dict[str, Any]:
    """Return command, study file, commit, solver, versions, and the files that the study names.

    Returns
    -------
    dict
        ``command``; ``study``, the file; ``commit`` of the checkout that combing runs from, None
        where it is none, with ``+`` behind it where something is not committed; ``solver``, a hash;
        ``versions`` by package; ``inputs``, a list of ``file``, ``bytes`` and ``sha256``.
    """
    path = study.path
    named = [path] if path else []
    named += [one for chosen in study.sets for one in chosen.named]
    folder = path.parent.resolve() if path else Path()
    return {
        "command": command(sys.argv),
        "study": str(path) if path else None,
        "commit": commit(Path(combing.__file__).parent),
        "solver": model_version(),
        "versions": {"python": platform.python_version()} | versions(),
        "inputs": [_input(one, folder) for one in dict.fromkeys(one.resolve() for one in named)],
    }


def tables(found: dict[str, Any]) -> list[tuple[str, pd.DataFrame]]:
    """Return the tables of a report: what ran, and on what."""
    facts = {key: found[key] for key in ("command", "study", "commit", "solver") if found[key]}
    facts |= found["versions"]
    ran = pd.DataFrame({"what": list(facts), "is": list(facts.values())})
    inputs = pd.DataFrame(found["inputs"], columns=["file", "bytes", "sha256"])
    return [("What ran", ran), ("Inputs", inputs.assign(sha256=inputs["sha256"].str[:16]))]


def command(arguments: list[str]) -> str | None:
    """Return the command line as it was typed; None where combing was called from Python."""
    program = Path(arguments[0]).stem if arguments else ""
    return shlex.join([program, *arguments[1:]]) if program == "combing" else None


def versions() -> dict[str, str]:
    """Return the versions of the packages that the numbers hang on, as far as known."""
    found = {}
    for name in PACKAGES:
        try:
            found[name] = metadata.version(name)
        except metadata.PackageNotFoundError:
            continue
    return found


def commit(folder: Path) -> str | None:
    """Return the commit of the checkout that holds `folder` itself, None where there is none."""

    def git(*asked: str) -> str:
        done = subprocess.run(  # noqa: S603 (no word of it comes from a user)
            ["git", "-C", str(folder), *asked],  # noqa: S607
            capture_output=True, text=True, timeout=10, check=True,
        )  # fmt: skip
        return done.stdout.strip()

    try:
        if not git("ls-files", "__init__.py"):
            return None
        return git("rev-parse", "--short=12", "HEAD") + ("+" if git("status", "-s", ".") else "")
    except (OSError, subprocess.SubprocessError):
        return None


def _input(path: Path, folder: Path) -> dict[str, Any]:
    content = path.read_bytes()
    inside = path.is_relative_to(folder)
    return {
        "file": str(path.relative_to(folder) if inside else path),
        "bytes": len(content),
        "sha256": hashlib.sha256(content).hexdigest(),
    }
