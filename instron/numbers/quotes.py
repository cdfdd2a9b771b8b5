"""Quotes of a whole body: whether they are in order, and which commas they enclose."""

from itertools import pairwise
from mmap import mmap

import numpy as np

from instron.numbers.bits import at, bits, pieces, within

QUOTE, COMMA, NEWLINE = b'",\n'


def enclosed_commas(data: mmap | bytes, start: int, delimiter: str) -> list[np.ndarray] | None:
    """Return the commas within quotes, as bits of ``bits.pieces``, or None in any doubt.

    Every quote has to stand at the edge of a cell and to close in its line, around no delimiter
    but commas: of ``"773.98"5.00"`` a reader makes 773.985, and of two lines one. Of such a body
    nothing is lost with its quotes but what the enclosed commas mean.

    Parameters
    ----------
    data
        Bytes of the file, mapped or not.
    start
        Where its body starts.
    delimiter
        What divides its cells.
    """
    found: list[np.ndarray] = []
    opened = False
    apart = b" " if delimiter == "spaces" else delimiter.encode()
    for piece in pieces(np.frombuffer(data, dtype=np.uint8), start):
        quote, comma, feed = (bits(piece == mark) for mark in (QUOTE, COMMA, NEWLINE))
        # Comma, TAB and line ends come before "-"; other such characters make no number anyway.
        edge = bits(piece < ord("-")) & ~quote
        other = comma if apart == b"," else bits(piece == apart[0])
        inside, opened = within(quote, opened)
        torn = quote & ~(at(edge | other, -1) | at(edge | other, 1))
        torn |= inside & (feed if apart == b"," else feed | other)
        if torn[1:-1].any():
            return None
        found.append(inside & comma)
    _agree_beside(found)
    return None if opened else found


def _agree_beside(commas: list[np.ndarray]) -> None:
    """Put into the words on either side of a piece what its neighbours found there."""
    for left, right in pairwise(commas):
        left[-1], right[0] = right[1], left[-2]
    if commas:
        commas[0][0] = commas[-1][-1] = 0
