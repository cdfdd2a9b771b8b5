"""A table that is no text, cell by cell, as tab-separated text that is read like an export."""

import datetime
import re
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from instron.source.files import Source

_UNUSABLE = re.compile(r"[\t\r\n]+")


@dataclass(frozen=True)
class Sheet:
    """One sheet as tab-separated text, and where its formulas are."""

    name: str
    source: Source
    formulas: dict[int, int] = field(default_factory=dict)  # how many, by column
    hollow: int | None = None  # row of the first formula without a value


def as_text(path: Path, name: str, rows: list[list[Any]], written: str) -> Source:
    """Return rows of cells as a source; ``written`` says in its dialect what wrote them."""
    text = "".join("\t".join(map(_written, row)).rstrip("\t") + "\n" for row in rows)
    place = path.with_name(f"{path.name} [{_UNUSABLE.sub(' ', name).replace('/', ' ')}]")
    return Source(place, text.encode(), "utf-8", written, "LF", on_disk=False)


def _written(cell: Any) -> str:
    """Return a cell as text; a number so that no mark in it can be taken for another."""
    if isinstance(cell, bool):
        return str(cell)
    if isinstance(cell, int | float):
        text = repr(float(cell))
        return text + "0" if re.fullmatch(r"-?\d+\.\d{3}", text) else text
    if isinstance(cell, datetime.date):  # and datetime
        return f"{cell.isoformat()} (a date)"
    return _UNUSABLE.sub(" ", str(cell)).replace('"', "'")
