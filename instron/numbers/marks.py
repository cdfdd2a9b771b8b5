"""Decimal and thousands marks of a whole body, read off its bytes.

Most files need no cell looked at one by one: where the bytes leave no doubt, pandas' C reader can
be told the marks. Where they do, the answer here is None and every cell is judged (``numerals``).
"""

import re
from collections.abc import Sequence
from mmap import mmap

import numpy as np

from instron.numbers.bits import at, bits, pieces

COMMA, POINT = b",."
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
    data: mmap | bytes, start: int, delimiter: str, enclosed: Sequence[np.ndarray] | None = None
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
    enclosed
        Commas within quotes (``quotes``), if there are any quotes.
    """
    comma, point = (data.find(mark, start) >= 0 for mark in (b",", b"."))
    if delimiter == "," and enclosed is not None:
        return _between_commas(data, start, point, enclosed)
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


def _between_commas(
    data: mmap | bytes, start: int, point: bool, enclosed: Sequence[np.ndarray]
) -> tuple[str, str | None] | None:
    """Return the marks where commas divide the cells and may stand in quotes as well."""
    text = np.frombuffer(data, dtype=np.uint8)
    if not any(commas.any() for commas in enclosed):
        proven = not point or _proven(POINT_BETWEEN_COMMAS, data, start)
        return (".", None) if proven else None
    if _grouped(text, start, COMMA, POINT, enclosed):
        return ".", ","
    if not point:
        return (",", None) if _proven(COMMA_IN_QUOTES, data, start) else None
    return (",", ".") if _grouped(text, start, POINT, COMMA) else None


def _grouped(
    text: np.ndarray,
    start: int,
    group: int,
    decimal: int,
    counted: Sequence[np.ndarray] | None = None,
) -> bool:
    """Tell whether ``group`` groups thousands in every large number, and in one at least.

    One to three digits before it, the first not 0, then exactly three; groups may follow each
    other, the decimal mark closes the last. All in bits, see ``bits``.

    Parameters
    ----------
    counted
        Which of the characters are marks, as bits by piece; all if None.
    """
    found, letters = False, False
    for number, piece in enumerate(pieces(text, start)):
        digit, point = _digits(piece), bits(piece == decimal)
        mark = bits(piece == group) if counted is None else counted[number]
        starts = ~at(digit | mark | point, -1)
        three = digit & at(digit, 1) & at(digit, 2)
        if (three & at(digit, 3) & starts)[1:-1].any():
            return False  # four digits without a mark
        if not mark[1:-1].any():
            continue
        first = digit & starts & ~bits(piece == ZERO)
        regular = _leads(first, digit, mark) & at(three & at(mark | point, 3), 1)
        if (mark & ~regular)[1:-1].any():
            return False
        found, letters = True, letters or _has_e(piece)
    return found and not (letters and _grouped_exponent(group, decimal).search(text.data, start))


def _has_e(piece: np.ndarray) -> bool:
    """Tell whether a piece has an e; mostly no character of it comes as late as that."""
    return bool(piece.max() >= ord("E")) and b"e" in piece.tobytes().lower()


def _grouped_exponent(group: int, decimal: int) -> re.Pattern[bytes]:
    """Return what finds a grouped number with an exponent, which nobody writes: 191,926.e3."""
    return re.compile(rb"\d[%c]\d{3}(?:[%c]\d*)?[eE]" % (group, decimal))


def _digits(piece: np.ndarray) -> np.ndarray:
    return bits(piece - ZERO < TEN)  # unsigned: what is below 0 wraps round


def _leads(first: np.ndarray, digit: np.ndarray, mark: np.ndarray) -> np.ndarray:
    """Return the places after one to three first digits of a number, or after a group of three.

    The three digits of a group are another mark's to ask for.
    """
    second = at(first, -1) & digit
    third = at(second, -1) & digit
    return at(first | second | third, -1) | at(mark, -4)
