"""One place for compiler options, and a disk cache that cannot go stale.

numba's disk cache notices an edit of the file that holds a kernel, but not of a callee in another
file, and would then run old machine code. The cache folder is therefore named by a hash of every
source in this folder. Another copy of the same sources has a folder of its own: numba drops what is
older or younger than its file, so that two copies would drop each other's.
"""

import hashlib
import os
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numba
from numba.core import config

# "nnan" and "ninf" are left out: with them the compiler may delete the checks for NaN.
FASTMATH = {"contract", "arcp", "nsz", "reassoc", "afn"}


def source_digest(folder: Path) -> str:
    """Return a hash of every Python source in `folder` and of the numba version."""
    digest = hashlib.sha256(numba.__version__.encode())
    for source in sorted(folder.rglob("*.py")):
        digest.update(str(source.relative_to(folder)).encode() + b"\0" + source.read_bytes())
    return digest.hexdigest()[:16]


def source_age(folder: Path) -> str:
    """Return a hash of when every Python source in `folder` was written: one for each copy."""
    ages = sorted((str(each), each.stat().st_mtime_ns) for each in folder.rglob("*.py"))
    return hashlib.sha256(repr(ages).encode()).hexdigest()[:8]


def _user_cache() -> Path:
    if sys.platform == "win32":
        return Path(os.environ.get("LOCALAPPDATA", Path.home() / "AppData" / "Local"))
    if sys.platform == "darwin":
        return Path.home() / "Library" / "Caches"
    return Path(os.environ.get("XDG_CACHE_HOME", Path.home() / ".cache"))


def cache_folder() -> Path:
    """Return the folder for compiled kernels, the system's temporary one if home is read-only."""
    base = Path(os.environ["NUMBA_CACHE_DIR"]) if "NUMBA_CACHE_DIR" in os.environ else _user_cache()
    folder = base / "combing" / f"{SOURCES}-{source_age(Path(__file__).parent)}"
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError:
        folder = Path(tempfile.gettempdir()) / "combing" / folder.name
        folder.mkdir(parents=True, exist_ok=True)
    return folder


SOURCES = source_digest(Path(__file__).parent)
CACHE = cache_folder()


def kernel(function: Callable[..., Any]) -> Callable[..., Any]:
    """Compile `function` without the interpreter, with the project's options, cached on disk."""
    return _compile(function, forceinline=False)


def formula(function: Callable[..., Any]) -> Callable[..., Any]:
    """Compile a kernel that is always inlined: a loop with a call left in it is not vectorised."""
    return _compile(function, forceinline=True)


def _compile(function: Callable[..., Any], *, forceinline: bool) -> Callable[..., Any]:
    previous = config.CACHE_DIR  # type: ignore[attr-defined]
    config.CACHE_DIR = str(CACHE)  # type: ignore[attr-defined]
    try:
        compiler = numba.njit(
            cache=True, error_model="numpy", fastmath=FASTMATH, forceinline=forceinline
        )
        return compiler(function)
    finally:
        config.CACHE_DIR = previous  # type: ignore[attr-defined]
