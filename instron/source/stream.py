"""Bytes of a quoted body as pandas' C reader takes them fastest: without quotes."""

from collections.abc import Iterator, Sequence
from typing import BinaryIO

import numpy as np

from instron.numbers.bits import WORD


class Unquoted:
    """A file without its quotes and without the commas that they enclose.

    It has no mode: pandas would wrap a binary file, to decode and encode it once more.

    Parameters
    ----------
    file
        Bytes of a body whose quotes are in order (``quotes.enclosed_commas``).
    enclosed
        Its commas within quotes, as bits of ``bits.pieces``, which group thousands; none where
        commas divide no cells and can be left to the reader.
    """

    def __init__(self, file: BinaryIO, enclosed: Sequence[np.ndarray] = ()) -> None:
        self._file = file
        some = any(commas.any() for commas in enclosed)
        self._commas = np.concatenate([commas[1:-1] for commas in enclosed]) if some else None
        self._place = 0

    def read(self, size: int = -1) -> bytes:
        """Return what is left of the next ``size`` bytes, in whole words."""
        raw = self._file.read(size if size < 0 else max(size - size % WORD, WORD))
        if self._commas is None:
            return raw.translate(None, b'"')
        first = self._place // WORD
        words = self._commas[first : first + len(raw) // WORD + 1]
        self._place += len(raw)
        if words.any():  # put out what goes: no file has zero bytes (``files.Survey``)
            kept = np.unpackbits((~words).view(np.uint8), count=len(raw), bitorder="little")
            raw = (np.frombuffer(raw, dtype=np.uint8) * kept).tobytes()
        return raw.translate(None, b'"\0')

    def __iter__(self) -> Iterator[bytes]:
        """Iterate over lines; pandas asks for no more than that it could."""
        return iter(self.read().splitlines(keepends=True))
