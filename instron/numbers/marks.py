"""Decimal and thousands marks of a whole body, read off its bytes.

Most files need no cell looked at one by one: where the bytes leave no doubt, pandas' C reader can
be told the marks. Where they do, the answer here is None and every cell is judged (``numerals``).
"""

import re
from collections.abc import Callable
from mmap import mmap

import numpy as np

from instron.numbers.bits import at, bits, pieces, within

QUOTE, COMMA, POINT, NEWLINE = b'",.\n'
ZERO, TEN = np.uint8(ord("0")), np.uint8(10)
# What follows a decimal comma that divides cells by mistake: 0,05 or 1,007.
TORN = re.compile(rb",[-+]?0\d")


def _one_reading(mark: bytes, before: bytes, after: bytes) -> re.Pattern[bytes]:
    """Return what matches a number that only a decimal ``mark`` explains: 0.5, 1.25, 1.23456."""
    tail = rb"(?:[eE][-+]?\d+)?" + after
    return re.compile(
        before + rb"[-+]?(?:0?" + mark + rb"\d+|\d+" + mark + rb"(?:\d\d?|\d{4,}))" + tail
    )


POINT_BETWEEN_COMMAS = _one_reading(rb"\.", rb"(?<![\d.])", rb"(?![\d.])")
COMMA_IN_QUOTES = _one_reading(rb",", rb'"', rb'"')
POINT_ALONE, COMMA_ALONE = (
    _one_reading(mark, rb"(?<![\d.,])", rb"(?![\d.,])") for mark in (rb"\.", rb",")
)


def _proven(pattern: re.Pattern[bytes], data: mmap | bytes, start: int) -> bool:
    """Tell whether two numbers match; a single one may be damaged."""
    first = pattern.search(data, start)
    return first is not None and pattern.search(data, first.end()) is not None


def marks_of(
    data: mmap | bytes, start: int, delimiter: str, quoted: bool
) -> tuple[str, str | None] | None:
    """Return decimal and thousands mark (None if nothing is grouped), or None in any doubt.

    A mark groups thousands only where every single one of it stands in a regular number such as
    1,424.96 or 1.629.770,85, and no number as large goes without.

    Parameters
    ----------
    data
        Bytes of the file, mapped or not.
    start
        Where its body starts.
    delimiter
        What divides its cells.
    quoted
        Whether there is a quote in the body.
    """
    comma, point = (data.find(mark, start) >= 0 for mark in (b",", b"."))
    if delimiter == "," and quoted:
        return _between_commas(data, start, point)
    if delimiter == "," and not point and TORN.search(data, start):
        return None
    if delimiter == "," or not comma:
        proof = POINT_BETWEEN_COMMAS if delimiter == "," else POINT_ALONE
        return (".", None) if not point or _proven(proof, data, start) else None
    if not point:
        return (",", None) if _proven(COMMA_ALONE, data, start) else None
    text = np.frombuffer(data, dtype=np.uint8)
    for group, decimal in ((COMMA, POINT), (POINT, COMMA)):
        if _grouped(text, start, group, decimal):
            return chr(decimal), chr(group)
    return None


def _between_commas(data: mmap | bytes, start: int, point: bool) -> tuple[str, str | None] | None:
    """Return the marks where commas divide the cells and may stand in quotes as well."""
    text = np.frombuffer(data, dtype=np.uint8)
    for inner in (_not_after_quote, _InQuotes()):
        grouped = _grouped(text, start, COMMA, POINT, inner)
        if grouped:
            return ".", ","
        if grouped is not None:
            proven = not point or _proven(POINT_BETWEEN_COMMAS, data, start)
            return (".", None) if proven else None
    if not point:
        return (",", None) if _proven(COMMA_IN_QUOTES, data, start) else None
    return (",", ".") if _grouped(text, start, POINT, COMMA) else None


Which = Callable[[np.ndarray, np.ndarray], np.ndarray]


def _all(piece: np.ndarray, mark: np.ndarray) -> np.ndarray:
    return mark


def _not_after_quote(piece: np.ndarray, mark: np.ndarray) -> np.ndarray:
    """Return the marks that no quote precedes: where all cells are quoted, those inside."""
    return mark & ~at(bits(piece == QUOTE), -1)


class _InQuotes:
    """The marks inside quotes, where only some cells are quoted; a quote must close in its line."""

    def __init__(self) -> None:
        self.opened = False

    def __call__(self, piece: np.ndarray, mark: np.ndarray) -> np.ndarray:
        inside, self.opened = within(bits(piece == QUOTE), self.opened)
        broken = inside & bits(piece == NEWLINE)
        return mark & inside | broken  # a line break is no regular mark


def _grouped(
    text: np.ndarray, start: int, group: int, decimal: int, which: Which = _all
) -> bool | None:
    """Tell whether ``group`` groups thousands; None if it does so in some numbers only.

    Parameters
    ----------
    which
        Which of the marks count, by a piece of text and where it has any.
    """
    found, bare = False, []
    for piece in pieces(text, start):
        mark = bits(piece == group)
        counted = which(piece, mark)[1:-1]
        if not counted.any():
            bare.append(piece)
            continue
        digit, point = _digits(piece), bits(piece == decimal)
        regular = _regular(digit, mark, point, bits(piece == ZERO))
        if (counted & ~regular[1:-1]).any() or _four_first(digit, point):
            return None
        found = True
    if not found:
        return False
    exponent = _grouped_exponent(group, decimal)
    if (text[start:] | 32 == ord("e")).any() and exponent.search(text.data, start):
        return None
    return None if any(_four_first(_digits(p), bits(p == decimal)) for p in bare) else True


def _grouped_exponent(group: int, decimal: int) -> re.Pattern[bytes]:
    """Return what finds a grouped number with an exponent, which nobody writes: 191,926.e3."""
    return re.compile(rb"\d[%c]\d{3}(?:[%c]\d*)?[eE]" % (group, decimal))


def _digits(piece: np.ndarray) -> np.ndarray:
    return bits(piece - ZERO < TEN)  # unsigned: what is below 0 wraps round


def _regular(
    digit: np.ndarray, mark: np.ndarray, point: np.ndarray, zero: np.ndarray
) -> np.ndarray:
    """Return where a mark would group three digits of a number that has a decimal mark.

    One to three digits before it, the first not 0, then exactly three; groups may follow each
    other, the decimal mark closes the last. All in bits, see ``bits``.
    """
    first = at(~(digit | mark | point), -1) & digit & ~zero
    second = at(first, -1) & digit
    third = at(second, -1) & digit
    before = at(first | second | third, -1) | at(mark, -4)
    two = digit & at(digit, 1)
    three_closed = two & at(digit, 2) & at(mark | point, 3)
    return before & at(three_closed, 1)


def _four_first(digit: np.ndarray, point: np.ndarray) -> bool:
    """Tell whether a number starts with four digits in a row, decimals aside."""
    two = digit & at(digit, 1)
    return bool((two & at(two, 2) & ~at(digit | point, -1))[1:-1].any())
