"""How numbers are written: which mark is the decimal one, which groups thousands.

The decimal mark is decided from every number of the used columns, before thousands are thought
of, and grouping is then checked cell by cell: a wrong guess here scales a force by a thousand.
"""

import re
from collections.abc import Sequence

import numpy as np

SPACES = " \u00a0\u202f\u2009\u2007"
# Fortran writes 1.0D-03; 12D3 may be a specimen's name.
_EXPONENT = r"(?:[eE][-+]?\d+|[dD](?:[-+]\d+|\d{2,3}))?"
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
LONGEST_COUNT = 19  # digits
_E = str.maketrans("dD", "ee")
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


def is_count(cell: str) -> bool:
    """Tell whether the cell could count something: digits, few enough to calculate with."""
    return cell.isdecimal() and len(cell) < LONGEST_COUNT


def decimal_mark(cells: Sequence[str]) -> str:
    """Return the decimal mark that every cell agrees with.

    Raises
    ------
    Unclear
        When cells contradict each other, or ``1,424`` or ``1.424`` could be either of two numbers.
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
    proven = proofs["."] or proofs[","]
    marked = [i for i, c in enumerate(cells) if "," in c or "." in c]
    if len(proven) > 1 or (proven and (len(cells) == 1 or _MARKS.search(cells[proven[0]]))):
        return "." if proofs["."] else ","
    if not marked:
        return "."
    # A single cell may be damaged: 96.80 that was 96.800 would turn its whole file around.
    unsure = next((i for i in marked if i not in proven), marked[0])
    tells = f"only '{cells[proven[0]]}' tells" if proven else "no number tells"
    raise Unclear(f"'{cells[unsure]}' could be a decimal or a thousand: {tells}", unsure)


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


def to_numbers(cells: Sequence[str], mark: str) -> tuple[np.ndarray, bool]:
    """Convert written numbers to floats and tell whether any was grouped; empty gives NaN.

    Raises
    ------
    Unclear
        With the position of the first cell that is not a number, or whose grouping is broken.
    """
    texts = [cell.strip().replace("\u2212", "-") for cell in cells]
    plain = _PLAIN[mark].fullmatch
    odd = [i for i, text in enumerate(texts) if text and not plain(text)]
    values = np.empty(len(texts))
    special = set(odd)
    for i, text in enumerate(texts):
        if i in special:
            values[i] = _grouped_number(text, mark, i)
        else:
            values[i] = float(text.replace(mark, ".").translate(_E)) if text else np.nan
    if odd:
        _refuse_lost_decimals(values, texts, odd, mark)
        _refuse_unproven_groups(texts, odd, mark)
        _refuse_groups_in_some(texts, odd, mark)
    return values, bool(odd)


def _grouped_number(text: str, mark: str, position: int) -> float:
    match = _GROUPED[mark].fullmatch(text)
    if match is None or match["sep"] == mark:
        twice = " (several marks: has a spreadsheet changed it?)" if _MARKS.search(text) else ""
        raise Unclear(f"'{text}' is not a number{twice}", position)
    return float(text.replace(match["sep"], "").replace(mark, "."))


def _refuse_lost_decimals(
    values: np.ndarray, texts: Sequence[str], odd: Sequence[int], mark: str
) -> None:
    """Refuse ``2,110,849`` among numbers with decimals: a spreadsheet ate the decimal point."""
    whole = [i for i in odd if _WHOLE_MILLIONS.fullmatch(texts[i])]
    if not whole or len(whole) == len(values):
        return
    times = abs(values[whole[0]]) / np.nanmax(np.delete(np.abs(values), whole), initial=1e-9)
    if times > 100:
        reason = "is over 100 times every other value"
    elif times > 10 and len(_decimals(texts, whole, mark)) == 1:
        reason = "alone has no decimals and is over 10 times every other value"
    else:
        return
    raise Unclear(
        f"'{texts[whole[0]]}' {reason}: a spreadsheet has probably lost its decimal point",
        whole[0],
    )


def _decimals(texts: Sequence[str], without: Sequence[int], mark: str) -> set[int]:
    """Return how many decimals the other numbers have, if they all have some."""
    skipped = set(without)
    found = {len(t.partition(mark)[2]) for i, t in enumerate(texts) if t and i not in skipped}
    return found if 0 not in found else set()


def _refuse_unproven_groups(texts: Sequence[str], odd: Sequence[int], mark: str) -> None:
    """Refuse ``1,490`` in a column of decimals, and ``2,110,849`` in any, unless another number
    such as ``1,490.5`` shows that commas group there.
    """
    special = set(odd)
    decimals = any(mark in text for i, text in enumerate(texts) if i not in special)
    for separator in ",.'\u2019" + SPACES:
        grouped = [i for i in odd if separator != mark and separator in texts[i]]
        if not grouped or any(mark in texts[i] for i in grouped):
            continue
        if decimals or any(_WHOLE_MILLIONS.fullmatch(texts[i]) for i in grouped):
            raise Unclear(
                f"'{texts[grouped[0]]}' could be a decimal or a thousand: no number with both"
                " marks tells",
                grouped[0],
            )


def _refuse_groups_in_some(texts: Sequence[str], odd: Sequence[int], mark: str) -> None:
    """Refuse ``76.061,7`` beside ``168896,3``: a column that groups does so from some size on."""
    special = set(odd)
    least = min(odd, key=lambda i: _whole_digits(texts[i], mark))
    most = max(
        (i for i, text in enumerate(texts) if text and i not in special),
        key=lambda i: _whole_digits(texts[i], mark),
        default=least,
    )
    if most != least and _whole_digits(texts[least], mark) <= _whole_digits(texts[most], mark):
        raise Unclear(
            f"'{texts[least]}' groups its thousands, '{texts[most]}' in the same column does not"
            " (a damaged digit?)",
            least,
        )


def _whole_digits(text: str, mark: str) -> int:
    """Count the digits before the decimal mark, leading zeros left out."""
    return len(re.sub(r"\D", "", text.partition(mark)[0]).lstrip("0"))
