"""The rows under a header, as numbers."""

from dataclasses import dataclass, field

import numpy as np

from instron.tables.layout import Header


@dataclass
class Body:
    """The numbers of the used columns (keyed by column index), and how they were written."""

    header: Header
    values: dict[int, np.ndarray]
    lines: range | list[int] | np.ndarray  # of the file, from 0, of every row
    decimal: str = "."
    thousands: bool = False
    above: int = 0  # line at which the text above the header starts
    cut: int | None = None  # line that the file's end cuts
    label: str = ""  # of its specimen, where a column tells
    parts: list["Body"] = field(default_factory=list)  # blocks that make up one test
    warnings: list[str] = field(default_factory=list)
