"""Characters of a text as bits, 64 to a word: questions about neighbours cost next to nothing."""

from collections.abc import Iterator

import numpy as np

SIZE = 1 << 19  # characters to a piece: fits a core's cache
WORD = 64


def pieces(text: np.ndarray, start: int) -> Iterator[np.ndarray]:
    """Yield ``SIZE`` characters at a time from ``start`` on, with a word more on either side.

    Beyond the text there are zeros.
    """
    for first in range(start, len(text), SIZE):
        low, high = first - WORD, first + SIZE + WORD
        piece = text[max(low, 0) : high]
        if low < 0 or high > len(text):
            piece = np.pad(piece, (max(-low, 0), max(high - len(text), 0)))
        yield piece


def bits(flags: np.ndarray) -> np.ndarray:
    """Return flags as bits, the first in the lowest."""
    return np.packbits(flags, bitorder="little").view("<u8")


def at(words: np.ndarray, offset: int) -> np.ndarray:
    """Return at every place the bit that stands ``offset`` places further on."""
    near, far = np.uint64(abs(offset)), np.uint64(WORD - abs(offset))
    if offset > 0:
        moved = words >> near
        moved[:-1] |= words[1:] << far
    else:
        moved = words << near
        moved[1:] |= words[:-1] >> far
    return moved


def within(quotes: np.ndarray, opened: bool) -> tuple[np.ndarray, bool]:
    """Return the places from an opening quote to before its closing one, of a piece.

    And whether one is open at the end of its last word but one, where the next piece starts.

    Every bit becomes the parity of those up to it: within words by doubling steps, then across.

    Parameters
    ----------
    quotes
        Where quotes are.
    opened
        Whether one is open before the second word.
    """
    parity = quotes.copy()
    for by in (1, 2, 4, 8, 16, 32):
        parity ^= parity << np.uint64(by)
    odd = parity >> np.uint64(WORD - 1)
    odd[0] = opened
    before = np.bitwise_xor.accumulate(odd)
    parity[1:] ^= -before[:-1]
    return parity, bool(before[-2])
