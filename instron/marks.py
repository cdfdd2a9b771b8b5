"""Decimal and thousands marks of a whole body, read off its bytes.

Most files need no cell looked at one by one: where the bytes leave no doubt, pandas' C reader can
be told the marks. Where they do, the answer here is None and every cell is judged (``numerals``).
"""

import re
from collections.abc import Iterator
from mmap import mmap

import numpy as np

CHUNK = 1 << 18  # fits a core's cache
QUOTE, COMMA, POINT, NEWLINE = b'",.\n'
ZERO, TEN = np.uint8(ord("0")), np.uint8(10)
LONGEST_NUMBER = 24  # characters
LONG_LINE = 1 << 12
# What may stand before the first digit of a number.
EDGE = np.zeros(256, dtype=bool)
EDGE[list(b'"+-;\t| \n')] = True
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


def marks_of(data: mmap | bytes, start: int, delimiter: str) -> tuple[str, str | None] | None:
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
    """
    comma, point, quote = (data.find(mark, start) >= 0 for mark in (b",", b".", b'"'))
    if delimiter == "," and quote:
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
        if _grouped(text, _places(text, start, group), decimal):
            return None if _some_ungrouped(text, start, decimal) else (chr(decimal), chr(group))
    return None


def _between_commas(data: mmap | bytes, start: int, point: bool) -> tuple[str, str | None] | None:
    """Return the marks where commas divide the cells and may stand in quotes as well."""
    text = np.frombuffer(data, dtype=np.uint8)
    for inner in (_not_after_quotes, _within_quotes):
        grouped = _grouped(text, inner(text, start), POINT)
        if grouped:
            return None if _some_ungrouped(text, start, POINT) else (".", ",")
        if grouped is not None:
            proven = not point or _proven(POINT_BETWEEN_COMMAS, data, start)
            return (".", None) if proven else None
    if not point:
        return (",", None) if _proven(COMMA_IN_QUOTES, data, start) else None
    if not _grouped(text, _places(text, start, POINT), COMMA):
        return None
    return None if _some_ungrouped(text, start, COMMA) else (",", ".")


def _grouped(text: np.ndarray, places: Iterator[np.ndarray], decimal: int) -> bool | None:
    """Tell whether there are any marks at these places, or None if one is not regular."""
    found = False
    for some in places:
        if not _regular(text, some, decimal):
            return None
        found |= len(some) > 0
    return found


def _some_ungrouped(text: np.ndarray, start: int, decimal: int) -> bool:
    """Tell whether some number has four digits in a row before its decimal mark."""
    for first in range(max(start - 1, 0), len(text), CHUNK):
        piece = text[first : first + CHUNK + 4]
        digit = piece - ZERO < TEN  # unsigned: what is below 0 wraps round
        four = digit[1:-3] & digit[2:-2] & digit[3:-1] & digit[4:]
        if (four & ~digit[:-4] & (piece[:-4] != decimal)).any():
            return True
    return False


def _places(text: np.ndarray, start: int, mark: int) -> Iterator[np.ndarray]:
    for first in range(start, len(text), CHUNK):
        yield np.flatnonzero(text[first : first + CHUNK] == mark) + first


def _not_after_quotes(text: np.ndarray, start: int) -> Iterator[np.ndarray]:
    """Yield the commas that no quote precedes: where all cells are quoted, those inside."""
    for first in range(max(start - 1, 0), len(text), CHUNK):
        piece = text[first : first + CHUNK + 1]
        yield np.flatnonzero((piece[1:] == COMMA) & (piece[:-1] != QUOTE)) + first + 1


def _within_quotes(text: np.ndarray, start: int) -> Iterator[np.ndarray]:
    """Yield the commas inside quotes where only some cells are quoted.

    Quotes that are not about a short cell of their own yield place 0, which is never regular.
    """
    while start < len(text):
        stop = _after_newline(text, start + CHUNK)
        quotes = np.flatnonzero(text[start:stop] == QUOTE) + start
        opens, closes = quotes[::2], quotes[1::2]
        if len(opens) != len(closes) or (len(opens) and (closes - opens).max() > LONGEST_NUMBER):
            yield np.array([0])
            return
        yield _commas_between(text, opens, closes)
        start = stop


def _after_newline(text: np.ndarray, position: int) -> int:
    """Return where the line after ``position`` starts, or the end of the text."""
    for first in range(position, len(text), LONG_LINE):
        ends = np.flatnonzero(text[first : first + LONG_LINE] == NEWLINE)
        if len(ends):
            return first + int(ends[0]) + 1
    return len(text)


def _commas_between(text: np.ndarray, opens: np.ndarray, closes: np.ndarray) -> np.ndarray:
    found = [np.empty(0, dtype=opens.dtype)]
    for offset in range(1, int((closes - opens).max(initial=0))):
        at = np.minimum(opens + offset, closes)
        found.append(at[text[at] == COMMA])
    return np.sort(np.concatenate(found))


def _regular(text: np.ndarray, places: np.ndarray, decimal: int) -> bool:
    """Tell whether every mark groups three digits of a number that has a decimal mark.

    One to three digits before it, the first not 0, then exactly three; groups may follow each
    other, the decimal mark closes the last.
    """
    if not len(places):
        return True
    if places[0] < 4 or places[-1] + 4 >= len(text):
        return False

    def digit(offset: int) -> np.ndarray:
        return text[places + offset] - ZERO < TEN  # unsigned: what is below 0 wraps round

    mark = text[places[0]]
    two = digit(-2)
    first = places - 1 - two - (two & digit(-3))
    before, after = text[first - 1], text[places + 4]
    opened = (EDGE[before] & (text[first] != ZERO)) | ((before == mark) & (first == places - 3))
    closed = (after == decimal) | (after == mark)
    return bool((digit(-1) & opened & closed & digit(1) & digit(2) & digit(3)).all())
