"""A text on disk, whole or not at all."""

from pathlib import Path


def write_text(path: Path, text: str) -> None:
    """Write a text to a temporary name, then move it into place."""
    partial = path.with_name(f".{path.name}.partial")
    try:
        partial.write_text(text, encoding="utf-8")
        partial.replace(path)
    except OSError:
        partial.unlink(missing_ok=True)
        raise
