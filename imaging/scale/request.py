"""A scale as it is asked for in words."""

import re
from dataclasses import dataclass

import numpy as np

from imaging.errors import Unmeasurable

METRES = {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "um": 1e-6, "in": 0.0254}
FORMS = (
    "40px/mm, marker:20mm, plane:20mm, charuco:7x5,15mm,11mm, grid:5x7,20mm,5mm, filament:0.85mm "
    "or ruler:x0,y0,x1,y1=50mm, with +-1% behind it where the length is not exact, and "
    "@board.jpg at the end where marker or board stand in a photograph of their own"
)
NUMBER, UNIT = r"([-+]?[\d.]+(?:[eE][-+]?\d+)?)", "(" + "|".join(METRES) + ")"
PATTERNS = {
    "stated": rf"{NUMBER}\s*px/{UNIT}",
    "marker": rf"marker:{NUMBER}\s*{UNIT}",
    "plane": rf"plane:{NUMBER}\s*{UNIT}",
    "filament": rf"filament:{NUMBER}\s*{UNIT}",
    "charuco": rf"charuco:(\d+)x(\d+),{NUMBER}\s*{UNIT},{NUMBER}\s*{UNIT}",
    "grid": rf"grid:(\d+)x(\d+),{NUMBER}\s*{UNIT},{NUMBER}\s*{UNIT}",
    "ruler": rf"ruler:{NUMBER},{NUMBER},{NUMBER},{NUMBER}={NUMBER}\s*{UNIT}",
}
ON_A_BOARD = ("marker", "plane", "charuco", "grid")


@dataclass(frozen=True)
class Request:
    """A scale as asked for on the command line.

    Attributes
    ----------
    kind : str
        One of PATTERNS.
    numbers : tuple of float
        Metres, pixels, counts, in the order they were written.
    length_sd : float
        Relative sd of the stated length.
    board : str or None
        Photograph of the marker or board, where it is not the one that is measured.
    """

    kind: str
    numbers: tuple[float, ...]
    length_sd: float = 0.0
    board: str | None = None


def parse_scale(text: str) -> Request:
    """Read a scale in one of the forms FORMS.

    Raises
    ------
    Unmeasurable
        When the text has none of these forms, or a length in it is not positive.
    """
    form, _, board = text.partition("@")
    form, _, doubt = form.partition("+-")
    kind, values = _match(form.strip())
    try:
        length_sd = float(doubt.strip().removesuffix("%")) / 100 if doubt else 0.0
    except ValueError:
        kind = None
    if kind is None or (doubt and "%" not in doubt) or (board and kind not in ON_A_BOARD):
        raise Unmeasurable(f"scale '{text}' is not understood; write it as {FORMS}")
    lengths = values[4:] if kind == "ruler" else values
    if not (np.isfinite(values).all() and min(lengths) > 0 and 0 <= length_sd < 1):
        raise Unmeasurable(f"scale '{text}': its lengths must be positive, its +- below 100 %")
    return Request(kind, values, length_sd, board or None)


def _match(form: str) -> tuple[str | None, tuple[float, ...]]:
    """Find the kind of a scale, and its numbers with lengths in metres."""
    for kind, pattern in PATTERNS.items():
        match = re.fullmatch(pattern, form)
        if match is None:
            continue
        numbers: list[float] = []
        try:
            for part in match.groups():
                if part in METRES:
                    numbers[-1] *= METRES[part] if kind != "stated" else 1 / METRES[part]
                else:
                    numbers.append(float(part))
        except ValueError:  # more than one point in a number
            break
        return kind, tuple(numbers)
    return None, ()
