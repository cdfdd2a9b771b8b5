"""A file as text: its encoding, line ends, and what is not a text export at all."""

import codecs
import io
import mmap
import re
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import BinaryIO

import numpy as np

from instron.errors import Unreadable
from instron.headings.words import PIECES, TELLING, plain
from instron.source.kinds import BLUEHILL, own_format

HEAD_BYTES = 1 << 16
CHUNK = 1 << 18  # fits a core's cache
FOREIGN = {"CR": b"\r", "CRCRLF": b"\r\r\n"}  # line ends that are rewritten
RETURN, NEWLINE = b"\r\n"
FORMATS = {b"TDAT": f"a Bluehill data file (.id_*): {BLUEHILL}"}
QUOTES = [
    (re.compile(mark, re.MULTILINE), re.compile(rb"%b(?:[,;\t]%b)+" % (cell, cell)))
    for mark, cell in [(rb'(?:^|(?<=[,;\t]))="', rb'="[^"]*"'),
                       (rb"(?:^|(?<=[,;\t]))'|'(?=[,;\t\r\n]|$)", rb"'[^']*'")]
]  # fmt: skip
ENCODINGS = ("gb18030", "shift_jis", "big5", "cp949", "cp1251", "cp1250", "cp850", "mac_roman")


@dataclass(frozen=True)
class Survey:
    """What is in a file, seen in one pass over its bytes.

    Attributes
    ----------
    zero
        Place of the first zero byte, -1 if there is none.
    quoted, lone
        Whether there is a quote, and a carriage return without a line feed.
    breaks
        How many line feeds there are.
    """

    zero: int
    quoted: bool
    lone: bool
    breaks: int


def _survey(data: mmap.mmap | bytes) -> Survey:
    zero, quoted, lone, breaks = -1, False, False, 0
    for first in range(0, len(data), CHUNK):
        text = data[first : first + CHUNK + 1]  # of the next piece one byte more
        if zero < 0 <= (place := text.find(b"\0")):
            zero = first + place
        quoted = quoted or b'"' in text
        codes = np.frombuffer(text, dtype=np.uint8)
        feeds = codes == NEWLINE
        breaks += int(np.count_nonzero(feeds[:CHUNK]))
        if not lone and b"\r" in text:
            lone = bool(((codes[:-1] == RETURN) & ~feeds[1:]).any())
    return Survey(zero, quoted, lone, breaks)


@dataclass(frozen=True)
class Source:
    """Bytes of a file in an encoding whose delimiters and digits are plain ASCII."""

    path: Path
    data: mmap.mmap | bytes
    encoding: str
    written: str  # the encoding of the file itself
    newline: str
    on_disk: bool  # data are the file's own bytes, so pandas may read the file itself

    @cached_property
    def lines(self) -> list[str]:
        """All lines, decoded; only asked for when the quick path does not suffice."""
        return split_lines(self._decoded())

    def _decoded(self) -> str:
        """Return the whole text; letters may come after a head that is plain ASCII."""
        data = self.data[:]
        if self.encoding != "ascii":
            return data.decode(self.encoding, errors="replace")
        try:
            return data.decode("utf-8")
        except UnicodeDecodeError:
            return data.decode("cp1252", errors="replace")

    @cached_property
    def survey(self) -> "Survey":
        """What one pass over all bytes tells."""
        return _survey(self.data)

    @property
    def count(self) -> int:
        """Return the number of lines."""
        return self.survey.breaks + (not self.ends_in_newline())

    @cached_property
    def _ends(self) -> np.ndarray:
        return np.flatnonzero(np.frombuffer(self.data, dtype=np.uint8) == NEWLINE)

    def line(self, number: int) -> str:
        """Return one line."""
        if number < len(self.head):
            return self.head[number]
        stop = self._ends[number] if number < len(self._ends) else len(self.data)
        return (
            self.data[self._ends[number - 1] + 1 : stop]
            .decode(self.encoding, errors="replace")
            .rstrip("\r")
        )

    @cached_property
    def head(self) -> list[str]:
        """The first lines, decoded, up to 64 kB."""
        piece = self.data[:HEAD_BYTES]
        if len(piece) == HEAD_BYTES:
            piece = piece[: piece.rfind(b"\n") + 1] or piece
        return split_lines(piece.decode(self.encoding, errors="replace"))

    def opened(self, start: int) -> BinaryIO:
        """Return the bytes from ``start`` on as a file; of a mapped file, the file itself."""
        if not self.on_disk:
            return io.BytesIO(self.data[start:])
        file = self.path.open("rb")
        file.seek(start)
        return file

    def release(self) -> None:
        """Give mapped pages back, so that a large file is not in memory twice while parsed."""
        if isinstance(self.data, mmap.mmap) and hasattr(mmap, "MADV_DONTNEED"):
            self.data.madvise(mmap.MADV_DONTNEED)

    def ends_in_newline(self) -> bool:
        """Tell whether the last line is closed."""
        return self.data[-1:] == b"\n"

    def offset(self, line: int) -> int:
        """Return the byte at which line ``line``, counted from 0, starts."""
        position = 0
        for _ in range(line):
            position = self.data.find(b"\n", position) + 1
        return position

    def chunks(self, start: int, overlap: int = 0) -> Iterator[tuple[int, np.ndarray]]:
        """Yield the bytes from ``start`` on in pieces, each with its place in the file."""
        text = np.frombuffer(self.data, dtype=np.uint8)
        for first in range(start, len(text), CHUNK):
            yield first, text[first : first + CHUNK + overlap]


def refuse_lone_returns(source: Source, line: int) -> None:
    r"""Refuse a carriage return without ``\n`` from line ``line`` on.

    Some readers end a row at it and others do not: it may cut a number in two, ``4\r.8``.
    """
    if not source.survey.lone:
        return
    start = source.offset(line)
    for first, piece in source.chunks(start, overlap=1):
        lone = np.flatnonzero((piece[:-1] == RETURN) & (piece[1:] != NEWLINE))
        if len(lone):
            number = source.data[: first + int(lone[0])].count(b"\n") + 1
            raise Unreadable(
                f"{source.path}: line {number}: a carriage return within the line: mixed line"
                " ends, or a damaged number"
            )


def split_lines(text: str) -> list[str]:
    r"""Split at ``\n`` only (``str.splitlines`` also splits at form feeds and the like)."""
    lines = text.split("\n")
    if lines[-1] == "":
        lines.pop()
    return [line.rstrip("\r") for line in lines]


def open_source(path: Path) -> Source:
    """Open a file and find its encoding and line ends.

    Raises
    ------
    Unreadable
        For an empty file, XML, zero bytes, or a binary file.
    """
    data = _mapped(path)
    if data[-1:] == b"\x1a":  # DOS ends a text file so
        data = data[:].rstrip(b"\x1a")
    data = _without_terminator(data)
    start = data[:HEAD_BYTES]
    _refuse_binary(path, start)
    utf16 = _utf16(start)
    if utf16:
        return _without_zeros(_rewritten(path, _decode_utf16(path, data, utf16), "utf-16", "utf-8"))
    _refuse_foreign(path, start.decode("latin-1"))
    data = _in_quotes(data, start)
    encoding = _encoding(data, start)
    newline = _newline(start)
    if newline in FOREIGN:
        data = data[:].replace(FOREIGN[newline], b"\n")
    on_disk = isinstance(data, mmap.mmap)
    return _without_zeros(Source(path, data, encoding, encoding, newline, on_disk))


def _without_zeros(source: Source) -> Source:
    zero = source.survey.zero
    if zero >= 0:
        line = source.data[:zero].count(b"\n") + 1
        raise Unreadable(f"{source.path}: line {line}: zero bytes: the file is damaged or binary")
    return source


def _without_terminator(data: mmap.mmap | bytes) -> mmap.mmap | bytes:
    """Return the bytes without the zero byte that WinTest ends its first line of words by."""
    first = data[: data.find(b"\n") + 1].rstrip(b"\r\n")
    if not first.endswith(b"\0") or b"\0" in first[:-1] or not re.search(rb"[A-Za-z]{2}", first):
        return data
    return first[:-1] + data[len(first) :]


def _in_quotes(data: mmap.mmap | bytes, start: bytes) -> mmap.mmap | bytes:
    """Return the bytes with cells in common quotes: a spreadsheet is told text by ``="0.12"``."""
    whole = start[: start.rfind(b"\n")].rpartition(b"\n")[2].strip()
    for mark, row in QUOTES:
        if row.fullmatch(whole):
            return mark.sub(b'"', data[:])
    return data


def _newline(start: bytes) -> str:
    r"""Return how lines end; ``CRCRLF`` is what a program writes that ends text lines by CRLF."""
    if b"\n" not in start:
        return "CR" if b"\r" in start else "LF"
    if b"\r\r\n" in start and start.count(b"\r\r\n") == start.count(b"\n"):
        return "CRCRLF"
    return "CRLF" if b"\r\n" in start else "LF"


def _mapped(path: Path) -> mmap.mmap | bytes:
    try:
        with path.open("rb") as file:
            if path.stat().st_size == 0:
                raise Unreadable(f"{path}: the file is empty")
            return mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ)
    except (PermissionError, IsADirectoryError) as error:
        raise Unreadable(f"{path}: {error.strerror}") from None


def _utf16(start: bytes) -> str | None:
    if start.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        return "utf-16"
    sample = start[:1000]
    for encoding, high in (("utf-16-le", sample[1::2]), ("utf-16-be", sample[::2])):
        if len(sample) >= 20 and high.count(0) > 0.4 * len(sample):
            return encoding
    return None


def _decode_utf16(path: Path, data: mmap.mmap | bytes, encoding: str) -> str:
    try:
        text = data[: len(data) // 2 * 2].decode(encoding)
    except UnicodeDecodeError as error:
        raise Unreadable(f"{path}: not valid UTF-16 at byte {error.start}") from None
    text = text.lstrip("\ufeff")
    _refuse_foreign(path, text[:200])
    return text


def _rewritten(path: Path, text: str, written: str, encoding: str) -> Source:
    data = text.encode(encoding)
    data = bytes(_in_quotes(data, data[:HEAD_BYTES]))
    newline = _newline(data[:HEAD_BYTES])
    if newline in FOREIGN:
        data = data.replace(FOREIGN[newline], b"\n")
    return Source(path, data, encoding, written, newline, on_disk=False)


def _refuse_binary(path: Path, start: bytes) -> None:
    """Refuse what testing machines save for themselves, with how to export it."""
    why = next((why for mark, why in FORMATS.items() if start.startswith(mark)), None)
    why = why or own_format(path)
    if why:
        raise Unreadable(f"{path}: {why}")


def _refuse_foreign(path: Path, start: str) -> None:
    """Refuse what is no text table, by its first characters."""
    opening = start[:200].lstrip("\ufeff\u00ef\u00bb\u00bf \r\n\t")
    if re.match(r"<[?!]|<(\w+)", opening) and re.search(r"<\?xml|<!doctype|</\w", start, re.I):
        raise Unreadable(
            f"{path}: line 1: an XML or HTML file, not an export; of a Bluehill sample or method"
            f" (.is_*, .im_*) {BLUEHILL}"
        )
    if not opening:
        raise Unreadable(f"{path}: the file holds only blanks")


def _encoding(data: mmap.mmap | bytes, start: bytes) -> str:
    """Return the first encoding in which the head shows this trade's words.

    Single-byte code pages decode anything, so those are tried only where their own letters spell
    a word for time, displacement or force; cp1252 is what Windows writes otherwise.
    """
    if start.startswith(codecs.BOM_UTF8):
        return "utf-8-sig"
    if start.isascii():
        return "ascii"
    try:
        codecs.getincrementaldecoder("utf-8")().decode(start, final=len(start) == len(data))
        return "utf-8"
    except UnicodeDecodeError:
        pass
    return next((name for name in ENCODINGS if _spells(start, name)), "cp1252")


def _spells(start: bytes, encoding: str) -> bool:
    text = start.decode(encoding, errors="ignore")[:20000]
    if encoding in TELLING:
        return not TELLING[encoding].isdisjoint(re.findall(r"[^\W\d_]+", text.casefold()))
    # A lone 力 also comes about by chance; two quantities, or one without a wrong byte, do not.
    text = plain(text)
    found = [any(plain(p) in text for p in PIECES[q] if len(p) > 1) for q in PIECES]
    return sum(found) >= (1 if _decodes(start, encoding) else 2)


def _decodes(start: bytes, encoding: str) -> bool:
    """Tell whether all bytes are letters of an encoding, but for one that the end may cut."""
    try:
        codecs.getincrementaldecoder(encoding)().decode(start)
    except UnicodeDecodeError:
        return False
    return True
