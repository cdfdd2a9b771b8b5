"""Rows of statistics below the data, which look like rows of it."""

import re
from collections.abc import Sequence

from instron.headings.words import plain, word_set
from instron.numbers.numerals import looks_numeric
from instron.source.files import Source
from instron.tables.layout import is_row, split_cells

STATISTIC = word_set(
    "mean average avg median max maximum min minimum std stdev stddev sd cv rsd variance range"
    " total mittelwert mittel durchschnitt standardabweichung standardabw variationskoeffizient"
    " spannweite streuung moyenne mediane ecart type etendue media promedio mediana desviacion"
    " desvio padrao deviazione maximo minimo massimo gemiddelde srednia odchylenie medelvarde"
    " prumer atlag ortalama среднее 平均 平均值 最大 最大值 最小 最小值 标准差 標準偏差"
    " 평균 최대 최소"
)
BESIDE = word_set("dev deviation standard std value values of s % wert werte estandar (%)")
LONGEST = 12  # lines of statistics
WORD = re.compile(r"[\[<(*#]*[^\W\d_]{4,}[^\d,.;]*")  # at least, so that no damaged number is one
OUT_OF_RANGE = word_set("over under overload overflow overrange underflow error nan null none inf")


def is_statistic(cells: Sequence[str]) -> bool:
    """Tell whether a cell names a statistic of the rows and nothing else: ``Mean``, ``CV %``."""
    for cell in cells:
        if cell and not looks_numeric(cell):
            words = set(plain(cell).replace("(", " ").replace(")", " ").split())
            if words & STATISTIC and words <= STATISTIC | BESIDE:
                return True
    return False


def ends_rows(
    source: Source, number: int, delimiter: str, used: Sequence[int], reach: int = LONGEST
) -> bool:
    """Tell whether no row follows a statistic, which else is a remark: ``max`` at a jam."""
    following = source.lines[number + 1 : number + reach]
    rows = (split_cells(line, delimiter) for line in following)
    return not any(is_row(row, list(used)) and not is_statistic(row) for row in rows)


def is_trailer(
    source: Source, number: int, delimiter: str, used: Sequence[int], rows: Sequence[int]
) -> bool:
    """Tell whether a line ends a file as ``CHECKSUM 1234`` does: a word, fewer cells, no row after.

    What a load cell shows out of its range is no such word, nor are letters beside digits.
    """
    cells = split_cells(source.lines[number], delimiter)
    if not rows or WORD.fullmatch(cells[0]) is None or plain(cells[0]) in OUT_OF_RANGE:
        return False
    whole = split_cells(source.lines[rows[-1]], delimiter)
    shorter = sum(map(bool, cells)) < sum(map(bool, whole))
    return shorter and ends_rows(source, number, delimiter, used, len(source.lines))


def ends_oddly(source: Source, first_row: str, delimiter: str) -> bool:
    """Tell whether a last line names a statistic, begins with no number, or lacks a cell."""
    tail = source.data[-5000:].decode(source.encoding, errors="replace").split("\n")[-LONGEST:]
    first = split_cells(first_row, delimiter)
    rows = [split_cells(line.rstrip("\r"), delimiter) for line in tail[1:]]
    if is_short([row for row in rows if any(row)]):
        return True
    return any(is_statistic(row) or begins_otherwise(row, first) for row in rows)


def is_short(rows: Sequence[Sequence[str]], used: Sequence[int] = ()) -> bool:
    """Tell whether the last row lacks a cell that every row before it has.

    A statistic that lost its name lacks the number of the row. Empty cells of columns in use are
    told otherwise.
    """
    if len(rows) < 3:
        return False
    last, before = rows[-1], rows[:-1]
    least = min(map(len, before))
    beside = [k for k in range(min(least, len(last))) if k not in used]
    return len(last) < least or any(not last[k] and all(row[k] for row in before) for k in beside)


def starts_short(source: Source, first: int, delimiter: str, used: Sequence[int]) -> bool:
    """Tell whether the first row lacks a cell that every row below it has."""
    lines = source.head[first : first + LONGEST]
    return is_short([split_cells(line, delimiter) for line in reversed(lines) if line], used)


def begins_otherwise(cells: Sequence[str], first: Sequence[str]) -> bool:
    """Tell whether a line begins with no number where the first row does."""
    return bool(cells[0]) and looks_numeric(first[0]) and not looks_numeric(cells[0])
