"""Workbooks (.xlsx, .xlsm, .xls, .ods): each sheet as text, read like any other export."""

import re
import zipfile
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from instron.errors import Unreadable
from instron.source.sheet import Sheet, as_text

ZIP, COMPOUND = b"PK\x03\x04", b"\xd0\xcf\x11\xe0"
_CELL = re.compile(rb"<c\b([^>]*?\br=\"([A-Z]+)(\d+)\"[^>]*)(?<!/)>(.*?)</c>", re.DOTALL)


def is_workbook(path: Path) -> bool:
    """Tell whether a file is a spreadsheet's, by its first bytes."""
    try:
        with path.open("rb") as file:
            start = file.read(4)
    except (PermissionError, IsADirectoryError):
        return False
    return start in (ZIP, COMPOUND)


def sheets(path: Path) -> list[Sheet]:
    """Return the sheets of a workbook that hold anything.

    Raises
    ------
    Unreadable
        For a damaged or protected workbook.
    """
    import python_calamine as calamine

    try:
        book = calamine.load_workbook(str(path))
        tables = {name: book.get_sheet_by_name(name).to_python(skip_empty_area=False)
                  for name in _worksheets(book, calamine)}  # fmt: skip
    except Exception as error:  # the library raises what its parsers do
        reason = " ".join(str(error).split()) or type(error).__name__
        raise Unreadable(f"{path}: a workbook that cannot be opened: {reason}") from None
    formulas = _formulas(path)
    found = []
    for name, rows in tables.items():
        if any(cell != "" for row in rows for cell in row):
            found.append(_sheet(path, name, rows, formulas.get(name, [])))
    return found


def _sheet(
    path: Path, name: str, rows: list[list[Any]], formulas: list[tuple[int, int, bool]]
) -> Sheet:
    columns = Counter(column for column, _, _ in formulas)
    hollow = next((row for _, row, kept in formulas if not kept), None)
    return Sheet(name, as_text(path, name, rows, "workbook"), dict(columns), hollow)


def _worksheets(book: Any, calamine: Any) -> list[str]:
    return [m.name for m in book.sheets_metadata if m.typ == calamine.SheetTypeEnum.WorkSheet]


def _formulas(path: Path) -> dict[str, list[tuple[int, int, bool]]]:
    """Return column, row and whether a value is kept, of each formula, by sheet; of .xlsx only."""
    if not zipfile.is_zipfile(path):
        return {}
    with zipfile.ZipFile(path) as archive:
        return {name: list(_formulas_of(archive.read(member)))
                for name, member in _members(archive).items()}  # fmt: skip


def _members(archive: zipfile.ZipFile) -> dict[str, str]:
    """Return where in the archive each sheet is."""
    names = set(archive.namelist())
    if not {"xl/workbook.xml", "xl/_rels/workbook.xml.rels"} <= names:
        return {}
    from xml.etree import ElementTree

    relations = ElementTree.fromstring(archive.read("xl/_rels/workbook.xml.rels"))
    links = {link.get("Id"): link.get("Target", "") for link in relations}
    found = {}
    for element in ElementTree.fromstring(archive.read("xl/workbook.xml")).iter():
        target = next((links.get(v) for k, v in element.items() if k.endswith("}id")), None)
        if element.tag.endswith("}sheet") and target:
            member = target.lstrip("/") if target.startswith("/") else f"xl/{target}"
            if member in names:
                found[str(element.get("name"))] = member
    return found


def _formulas_of(xml: bytes) -> Iterator[tuple[int, int, bool]]:
    if b"<f" not in xml:
        return
    for tag, letters, row, inside in _CELL.findall(xml):
        if b"<f" in inside:
            kept = re.search(rb"<v>[^<]|<is>", inside) is not None or b't="str"' in tag
            yield _column(letters), int(row), kept


def _column(letters: bytes) -> int:
    number = 0
    for letter in letters:
        number = 26 * number + letter - ord("A") + 1
    return number - 1
