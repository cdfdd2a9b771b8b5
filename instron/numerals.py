"""How numbers are written: which mark is the decimal one, which groups thousands.

The decimal mark is decided from every number of the used columns, before thousands are thought
of, and grouping is then checked cell by cell: a wrong guess here scales a force by a thousand.
"""

import re
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
import pandas as pd

SPACES = " \u00a0\u202f\u2009\u2007"
_EXPONENT = r"(?:[eE][-+]?\d+)?"
_LOOKS = re.compile(rf"\s*[-+\u2212]?(?:\d[\d.,'\u2019{SPACES}]*|[.,]\d+){_EXPONENT}\s*")
_PLAIN = {
    mark: re.compile(rf"[-+]?(?:\d+(?:[{mark}]\d*)?|[{mark}]\d+){_EXPONENT}") for mark in ".,"
}
_GROUPED = {
    mark: re.compile(rf"[-+]?[1-9]\d{{0,2}}(?P<sep>[,.'\u2019{SPACES}])\d{{3}}(?:(?P=sep)\d{{3}})*"
                     rf"(?:[{mark}]\d*)?")
    for mark in ".,"
}  # fmt: skip
_MARK_NAMES = {".": "a decimal point", ",": "a decimal comma"}
_MARKS = re.compile(r"[.,].*[.,]")
_WHOLE_MILLIONS = re.compile(r"[-+]?\d{1,3}([,.])\d{3}(?:\1\d{3})+")


class Unclear(ValueError):
    """The numbers contradict each other or allow two readings; ``position`` is the first's row."""

    def __init__(self, message: str, position: int = 0) -> None:
        super().__init__(message)
        self.position = position


def looks_numeric(cell: str) -> bool:
    """Tell whether the cell could be a number in some notation."""
    return _LOOKS.fullmatch(cell.strip().strip("\"'")) is not None


def decimal_mark(cells: Sequence[str]) -> str:
    """Return the decimal mark that every cell agrees with.

    Raises
    ------
    Unclear
        When cells contradict each other, or ``1,424`` could be either of two numbers.
    """
    proofs = {
        mark: [i for i, c in enumerate(cells) if _may_prove(c, mark) and _proves(c, mark)]
        for mark in ".,"
    }
    if proofs["."] and proofs[","]:
        rare, usual = sorted(proofs, key=lambda mark: len(proofs[mark]))
        odd, common = cells[proofs[rare][0]], cells[proofs[usual][0]]
        twice = " (several marks: has a spreadsheet changed it?)" if _MARKS.search(odd) else ""
        raise Unclear(
            f"'{odd}'{twice} has {_MARK_NAMES[rare]}, but '{common}' {_MARK_NAMES[usual]}",
            proofs[rare][0],
        )
    if proofs["."] or proofs[","]:
        return "." if proofs["."] else ","
    unsure = next((i for i, c in enumerate(cells) if "," in c), None)
    if unsure is None:
        return "."
    raise Unclear(f"'{cells[unsure]}' could be a decimal or a thousand: no number tells", unsure)


def _may_prove(cell: str, mark: str) -> bool:
    """Rule most cells out quickly: a proof holds the mark itself, or the other one twice."""
    return mark in cell or cell.count("," if mark == "." else ".") > 1


def _proves(cell: str, mark: str) -> bool:
    """Return True when the cell is a number only if ``mark`` is the decimal mark."""
    other = "," if mark == "." else "."
    return _valid(cell, mark) and not _valid(cell, other)


def _valid(cell: str, mark: str) -> bool:
    if _PLAIN[mark].fullmatch(cell):
        return True
    grouped = _GROUPED[mark].fullmatch(cell)
    return grouped is not None and grouped["sep"] != mark


def to_numbers(cells: pd.Series, mark: str) -> tuple[np.ndarray, bool]:
    """Convert written numbers to floats and tell whether any was grouped; empty gives NaN.

    Raises
    ------
    Unclear
        With the position of the first cell that is not a number, or whose grouping is broken.
    """
    bare = cells.fillna("").str.strip().str.replace("\u2212", "-")
    empty = (bare == "").to_numpy()
    simple = bare.str.fullmatch(_PLAIN[mark]).to_numpy(dtype=bool)
    odd = np.flatnonzero(~simple & ~empty)
    values = np.full(len(bare), np.nan)
    texts = bare.to_numpy(dtype=object)
    values[simple] = [float(text.replace(mark, ".")) for text in texts[simple]]
    for position in odd:
        values[position] = _grouped_number(texts[position], mark, int(position))
    _refuse_lost_decimals(values, texts, odd)
    _refuse_unproven_groups(texts, odd, simple, mark)
    return values, bool(len(odd))


def _grouped_number(text: str, mark: str, position: int) -> float:
    match = _GROUPED[mark].fullmatch(text)
    if match is None or match["sep"] == mark:
        twice = " (several marks: has a spreadsheet changed it?)" if _MARKS.search(text) else ""
        raise Unclear(f"'{text}' is not a number{twice}", position)
    return float(text.replace(match["sep"], "").replace(mark, "."))


def _refuse_lost_decimals(values: np.ndarray, texts: np.ndarray, odd: np.ndarray) -> None:
    """Refuse ``2,110,849`` among numbers with decimals: a spreadsheet ate the decimal point."""
    whole = [i for i in odd if _WHOLE_MILLIONS.fullmatch(texts[i])]
    if not whole or len(whole) == len(values):
        return
    others = np.delete(np.abs(values), whole)
    if abs(values[whole[0]]) > 100 * np.nanmax(others, initial=0.0):
        raise Unclear(
            f"'{texts[whole[0]]}' is over 100 times every other value: a spreadsheet has probably"
            " lost its decimal point",
            int(whole[0]),
        )


def _refuse_unproven_groups(
    texts: np.ndarray, odd: np.ndarray, simple: np.ndarray, mark: str
) -> None:
    """Refuse ``1,490`` in a column of decimals, and ``2,110,849`` in any, unless another number
    such as ``1,490.5`` shows that commas group there.
    """
    decimals = any(mark in text for text in texts[simple])
    for separator in ",.'\u2019" + SPACES:
        grouped = [i for i in odd if separator != mark and separator in texts[i]]
        if not grouped or any(mark in texts[i] for i in grouped):
            continue
        if decimals or any(_WHOLE_MILLIONS.fullmatch(texts[i]) for i in grouped):
            raise Unclear(
                f"'{texts[grouped[0]]}' could be a decimal or a thousand: no number with both"
                " marks tells",
                int(grouped[0]),
            )


CHUNK = 1 << 18  # fits a core's cache
QUOTE, COMMA, POINT, ZERO, NINE, NEWLINE = b'",.09\n'
SIGNS = list(b"+-")


def grouping(data: Any, start: int) -> str:
    """Return how commas inside quotes group: ``"none"``, ``"regular"`` or ``"unclear"``.

    Regular means one group of exactly three digits with a decimal point after it, as in
    ``"1,424.96"``; what else there may be is for the exact way to judge.

    Strategy: where every cell is quoted, separators stand between two quotes and every other
    comma is inside. If those others are not all regular, some cells are bare, and quotes must be
    counted line by line, which takes several times as long.

    Parameters
    ----------
    data
        Bytes of a comma-delimited file, mapped or not.
    start
        Where its body starts.
    """
    text = np.frombuffer(data, dtype=np.uint8)
    for inside in (_commas_not_between_quotes, _commas_after_odd_quotes):
        found = "none"
        for places in inside(text, start):
            if not _regular(text, places):
                break
            found = "regular" if len(places) else found
        else:
            return found
    return "unclear"


def _commas_not_between_quotes(text: np.ndarray, start: int) -> Iterator[np.ndarray]:
    for first in range(start, len(text), CHUNK):
        piece = text[first : first + CHUNK + 2]
        quote = piece == QUOTE
        other = (piece[1:-1] == COMMA) & ~(quote[:-2] & quote[2:])
        yield np.flatnonzero(other) + first + 1


def _commas_after_odd_quotes(text: np.ndarray, start: int) -> Iterator[np.ndarray]:
    while start < len(text):
        stop = min(start + CHUNK, len(text))
        ends = np.flatnonzero(text[stop - 1 : stop + CHUNK] == NEWLINE)
        stop = stop + int(ends[0]) if len(ends) else len(text)
        piece = text[start:stop]
        odd = np.cumsum(piece == QUOTE, dtype=np.uint8) & 1
        yield np.flatnonzero((piece == COMMA) & odd.astype(bool)) + start
        start = stop


def _regular(text: np.ndarray, comma: np.ndarray) -> bool:
    """Check the neighbours of the bytes at ``comma``: one to three digits before, three after."""
    if not len(comma):
        return True
    if comma[0] < 4 or comma[-1] + 4 >= len(text):
        return False

    def digit(offset: int) -> np.ndarray:
        return (text[comma + offset] >= ZERO) & (text[comma + offset] <= NINE)

    two = digit(-2)
    first = comma - 1 - two - (two & digit(-3))
    opened = (text[first - 1] == QUOTE) | np.isin(text[first - 1], SIGNS)
    three = digit(1) & digit(2) & digit(3) & (text[comma + 4] == POINT)
    return bool((digit(-1) & (text[first] != ZERO) & opened & three).all())
