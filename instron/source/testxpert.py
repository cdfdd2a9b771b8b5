"""Series of testXpert (.zs2): the channels of each specimen as text, through zs2decode.

The file names its channels and holds their numbers; in which units they are is not part of what is
known of the format, so they have to be told.
"""

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from instron.errors import Unreadable
from instron.source.kinds import TESTXPERT
from instron.source.sheet import Sheet, as_text

Chunk = tuple[tuple[str, ...], Any]  # path of names from the root, and what is there
GZIP = b"\x1f\x8b"


def is_series(path: Path) -> bool:
    """Tell whether a file is a testXpert II series, by its name and first bytes."""
    if path.suffix.lower() != ".zs2" or not path.is_file():
        return False
    with path.open("rb") as file:
        return file.read(2) == GZIP


def specimens(path: Path, units: Mapping[str, str]) -> list[Sheet]:
    """Return a sheet for each specimen that was recorded, its channels as columns.

    Parameters
    ----------
    path
        The file.
    units
        What the user said, by quantity.

    Raises
    ------
    Unreadable
        Without zs2decode, without units of displacement and force, or for a file that it does not
        decode.
    """
    chunks = list(_chunks(path))
    missing = [q for q in ("displacement", "force") if q not in units]
    if missing:
        raise Unreadable(
            f"{path}: the units of a .zs2 file's numbers cannot be read: say --units"
            f" {','.join(f'{q}=...' for q in missing)} (compare one value with testXpert; m and N"
            " are usual)"
        )
    names = _names(chunks)
    found = [_sheet(path, number, block, names) for number, block in enumerate(_blocks(chunks), 1)]
    if not found:
        raise Unreadable(f"{path}: the series holds no recorded specimen")
    return found


def _chunks(path: Path) -> Iterator[Chunk]:
    """Yield what a file holds, each with the names of the sections it is in."""
    try:
        from zs2decode import parser
    except ImportError:
        raise Unreadable(
            f"{path}: a testXpert series; {TESTXPERT}, or install combing[testxpert] to read it so"
        ) from None
    try:
        stream = parser.load(str(path))
        decoded = parser.parse_chunks(parser.data_stream_to_chunks(stream))
    except Exception as error:  # the library raises what its parsers do
        reason = " ".join(str(error).split()) or type(error).__name__
        raise Unreadable(
            f"{path}: a testXpert series that cannot be decoded ({reason}); {TESTXPERT}"
        ) from None
    sections: list[str] = []
    for _, name, kind, value in decoded:
        if kind == "end":
            del sections[-1:]
            continue
        yield (*sections, name), value
        if kind == "DD":
            sections.append(name)


def _names(chunks: Sequence[Chunk]) -> dict[int, str]:
    """Return what each channel is called, by its number."""
    facts: dict[tuple[str, ...], dict[str, Any]] = {}
    for place, value in chunks:
        if "ChannelManager" in place:
            elements = [i for i, part in enumerate(place) if part.startswith("Elem")]
            if elements and place[elements[-1] + 1 :] in (("ID",), ("Name", "Text")):
                facts.setdefault(place[: elements[-1] + 1], {})[place[-1]] = value
    return {fact["ID"]: fact["Text"] for fact in facts.values() if {"ID", "Text"} <= fact.keys()}


def _blocks(chunks: Sequence[Chunk]) -> list[dict[int, list[float]]]:
    """Return of each recording the numbers of its channels, by the channel's number."""
    blocks: dict[tuple[str, ...], dict[str, dict[str, Any]]] = {}
    for place, value in chunks:
        if (
            len(place) > 3
            and place[-3] == "DataChannels"
            and place[-1] in ("TrsChannelId", "DataArray")
        ):
            block = blocks.setdefault(place[:-3], {})
            block.setdefault(place[-2], {})[place[-1]] = value
    found = [
        {c["TrsChannelId"]: c["DataArray"] for c in block.values()
         if len(c) == 2 and isinstance(c["DataArray"], list)}
        for block in blocks.values()
    ]  # fmt: skip
    return [block for block in found if any(block.values())]  # others were planned, not recorded


def _sheet(path: Path, number: int, block: dict[int, list[float]], names: dict[int, str]) -> Sheet:
    lengths = {len(column) for column in block.values()} - {0}
    if len(lengths) != 1:
        raise Unreadable(
            f"{path}: specimen {number}: channels of {sorted(lengths)} numbers: damaged, or of"
            " different rates"
        )
    columns = {i: column for i, column in block.items() if column}
    heading = [names.get(i, f"channel {i}") for i in columns]
    rows = [heading, *map(list, zip(*columns.values(), strict=True))]
    name = f"specimen {number}"
    return Sheet(name, as_text(path, name, rows, "testXpert"))
