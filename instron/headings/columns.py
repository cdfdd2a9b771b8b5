"""Which columns of a table are a specimen's time, displacement and force, or what has to be asked.

The crosshead's own, measured, filled column of each quantity is taken. Where names and contents
leave two columns that could be it, or a number that a heading does not explain, the answer is a
question: nobody's first column is taken for want of a better reason.
"""

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from instron.headings.grammar import Heading, read_heading
from instron.headings.units import MASSES, Unit, read_unit
from instron.headings.words import CHANNELS, QUANTITIES, SPECIMEN, plain
from instron.numbers.numerals import Unclear, decimal_mark, looks_numeric, to_numbers

FIRST = 100  # rows by which a column is filled or not
SPARSE = 0.5  # a column filled less than this, up to its last number, belongs to another logger
# A1, S12: a specimen's label; X1, F2, C3, V4, I5, L6, U7 may be an axis, a symbol or a channel.
_LABEL = re.compile(r"(?:^|[\s_.:/-])[ABDEGHKMNOPQRSTW]\d+(?=$|[\s_.:/-])", re.IGNORECASE)


@dataclass(frozen=True)
class Channel:
    """One column that is used: where it is, and how the file names it and its unit."""

    index: int
    name: str
    unit: Unit | None


Specimen = dict[str, Channel]


@dataclass(frozen=True)
class Told:
    """What the user said of a file: headings by quantity, and units."""

    columns: Mapping[str, str] = field(default_factory=dict)
    units: Mapping[str, str] = field(default_factory=dict)


@dataclass(frozen=True)
class Choice:
    """The columns of each specimen, what was passed over, and what has to be asked first."""

    specimens: list[Specimen]
    notes: list[str] = field(default_factory=list)
    question: str = ""
    doubts: list[str] = field(default_factory=list)  # what a log has to be warned of


class Sample:
    """The rows below a header, as far as they are at hand."""

    def __init__(self, lines: Sequence[str], split: Callable[[str], list[str]]) -> None:
        rows = [split(line) for line in lines[:FIRST]]
        numbers = [sum(map(looks_numeric, row)) for row in rows]
        # Words end the rows: the head of the next block says nothing of this one's columns.
        stop = next((i for i, n in enumerate(numbers) if any(rows[i]) and 2 * n < numbers[0]), None)
        self._lines, self._split = lines[:stop], split
        self.rows = rows[:stop]

    def _column(self, index: int, rows: Sequence[Sequence[str]]) -> list[str]:
        return [row[index].strip() if index < len(row) else "" for row in rows]

    def fill(self, index: int) -> float:
        """Return how much of a column holds numbers, up to the last one that it holds."""
        numeric = [looks_numeric(cell) for cell in self._column(index, self.rows)]
        last = max((i for i, found in enumerate(numeric) if found), default=-1)
        return sum(numeric) / (last + 1) if last >= 0 else 0.0

    def reaches(self, index: int) -> bool:
        """Tell whether any row is long enough to hold a column, be the cell empty."""
        return any(index < len(row) for row in self.rows)

    def words(self, index: int) -> bool:
        """Tell whether most filled cells hold something else than a number."""
        filled = [cell for cell in self._column(index, self.rows) if cell]
        return bool(filled) and sum(map(looks_numeric, filled)) < len(filled) / 2

    @cached_property
    def _more(self) -> list[list[str]]:
        return [self._split(line) for line in self._lines]

    @cached_property
    def _mark(self) -> str:
        try:
            return decimal_mark([cell for row in self.rows for cell in row if looks_numeric(cell)])
        except Unclear:
            return "."

    def same(self, one: Heading, i: int, other: Heading, j: int) -> bool:
        """Tell whether two columns hold the same lengths or forces, in whatever units."""
        try:
            a, b = (to_numbers(self._column(k, self._more), self._mark)[0] for k in (i, j))
        except Unclear:
            return False
        for values, heading in ((a, one), (b, other)):
            values *= heading.unit.to_si() if heading.unit and heading.fits else 1.0
        both = np.isfinite(a) & np.isfinite(b)
        if np.count_nonzero(both) < 3 or np.ptp(a[both]) == 0:
            return False
        return bool(np.abs(a - b)[both].max() <= 2e-3 * np.abs(a[both]).max())


Found = tuple[int, Heading]


def choose(names: Sequence[str], units: Sequence[str] | None, sample: Sample, told: Told) -> Choice:
    """Return the columns of every specimen under a header; none if it names no force log."""
    below = units or []
    headings = [
        read_heading(name, below[i] if i < len(below) else "") for i, name in enumerate(names)
    ]
    found = {q: _candidates(headings, q, sample, told) for q in QUANTITIES}
    doubts = _by_unit(headings, found, told)
    if not found["force"] or not found["displacement"]:
        return Choice([])
    best, rivals = {}, {}
    for quantity in QUANTITIES:
        best[quantity], rivals[quantity] = _plainest(found[quantity], sample)
    specimens, question = _group(best, rivals, sample)
    chosen = [specimen.get(q) for q in QUANTITIES for specimen in specimens]
    asked = (_doubt(q, *specimen[q], told) for specimen in specimens for q in specimen)
    question = question or next(filter(None, asked), "")
    channels = [{q: _channel(q, *s[q]) for q in s} for s in specimens]
    doubts += _out_of_reach(headings, chosen, sample, told)
    return Choice(channels, _passed_over(headings, found, chosen), question, doubts)


def _channel(quantity: str, index: int, heading: Heading) -> Channel:
    unit = heading.unit if heading.unit and heading.unit.quantity == quantity else None
    return Channel(index, heading.name, unit)


def named(names: Sequence[str], wanted: str) -> list[int]:
    """Return the columns whose heading, with or without its unit, is the one that was told."""
    for key in (lambda h: h.text, lambda h: h.name):
        same = [i for i, name in enumerate(names)
                if plain(key(read_heading(name))) == plain(wanted)]  # fmt: skip
        if same:
            return same
    number = re.fullmatch(r"#?(\d+)", wanted.strip())
    return [int(number[1]) - 1] if number and 0 < int(number[1]) <= len(names) else []


def _candidates(headings: list[Heading], quantity: str, sample: Sample, told: Told) -> list[Found]:
    """Return the columns that could be a quantity, those with numbers in them."""
    if quantity in told.columns:
        return [(i, headings[i])
                for i in named([h.text for h in headings], told.columns[quantity])]  # fmt: skip
    taken = {i for q in told.columns for i in named([h.text for h in headings], told.columns[q])}
    free = [(i, h) for i, h in enumerate(headings) if i not in taken and not h.role]
    found = [(i, h) for i, h in free if h.quantity == quantity and h.fits]
    if quantity == "displacement" and not found:
        found = [(i, h) for i, h in free if h.lengthens and h.unit]
    filled = [(i, h) for i, h in found if sample.fill(i) >= SPARSE and not sample.words(i)]
    return filled if filled or quantity == "time" else found


def _by_unit(headings: list[Heading], found: dict[str, list[Found]], told: Told) -> list[str]:
    """Add the only column in a unit of force, or of length, where no name tells, and say so."""
    alike = {q: [(i, h) for i, h in enumerate(headings) if might_be(h, q)]
             for q in ("force", "displacement")}  # fmt: skip
    if not (found["force"] or found["displacement"] or told.columns) and sure(alike):
        found |= alike
        names = " and ".join(f"'{alike[q][0][1].name}'" for q in ("displacement", "force"))
        return [f"no heading names displacement or force: {names} are taken by their units"]
    for quantity, other in (("force", "displacement"), ("displacement", "force")):
        alone = alike[quantity]
        if (
            len(alone) == 1
            and found[other]
            and not found[quantity]
            and quantity not in told.columns
        ):
            found[quantity] = alone
            unit = alone[0][1].unit
            return [f"no heading names a {quantity}: '{alone[0][1].name}' is the only column in"
                    f" {unit.text if unit else ''}"]  # fmt: skip
    return []


def sure(alike: Mapping[str, Sequence[Found]]) -> bool:
    """Tell whether one column has a unit of length and one of force, which no mass has."""
    if [len(columns) for columns in alike.values()] != [1, 1]:
        return False
    force = alike["force"][0][1]
    unit = None if read_unit(force.text) else force.unit  # a unit alone is no name
    return unit is not None and unit.text.strip("()[]<>{} .").casefold() not in MASSES


def might_be(heading: Heading, quantity: str) -> bool:
    """Tell whether a heading of unknown words has a unit of the quantity."""
    unknown = heading.quantity is None and not heading.other and not heading.role
    return unknown and heading.unit is not None and heading.unit.quantity == quantity


def _plainest(found: list[Found], sample: Sample) -> tuple[list[Found], list[Found]]:
    """Return the columns alike that stand nearest to the crosshead, and those as near as they."""
    if not found:
        return [], []
    index, first = min(found, key=lambda c: (c[1].rank, len(c[1].kind)))
    near = [(i, h) for i, h in found if (h.rank, len(h.kind)) == (first.rank, len(first.kind))]
    alike = [(i, h) for i, h in near if h.kind == first.kind]
    other = [(i, h) for i, h in near if h.kind != first.kind]
    once: list[Found] = []
    for i, heading in alike:  # the same column in mm and in inches
        if not any(_other_unit(h, heading) and sample.same(h, j, heading, i) for j, h in once):
            once.append((i, heading))
    return once, [(i, h) for i, h in other if not sample.same(first, index, h, i)]


def _other_unit(one: Heading, other: Heading) -> bool:
    return bool(one.unit and other.unit and not one.unit.agrees(other.unit))


def _group(
    best: dict[str, list[Found]], rivals: dict[str, list[Found]], sample: Sample
) -> tuple[list[dict[str, Found]], str]:
    """Return each specimen's columns, and what has to be asked."""
    forces, lengths, times = (best[q] for q in ("force", "displacement", "time"))
    first = [{q: columns[0] for q, columns in best.items() if columns}]
    for quantity in ("force", "displacement"):
        if rivals[quantity]:
            return first, _which(quantity, [*best[quantity], *rivals[quantity]])
    count = max(len(forces), len(lengths))
    if len(forces) == len(lengths):
        if count > 1 and len(times) < count and _of_one_test(forces, lengths):
            return first, _which("force", forces)
    elif len(lengths) == 1 and _are_specimens(forces):
        lengths = lengths * count
    else:
        for quantity, columns in (("force", forces), ("displacement", lengths)):
            (i, one), *others = columns
            if not all(sample.same(one, i, h, j) for j, h in others):
                return first, _which(quantity, columns)
        return first, ""
    times = times if len(times) == count else times[:1] * count
    parts = {"time": times, "displacement": lengths, "force": forces}
    return [{q: c[k] for q, c in parts.items() if c} for k in range(count)], ""


def _of_one_test(forces: list[Found], lengths: list[Found]) -> bool:
    """Tell whether forces are sensors of one test: numbered channels, or apart from the lengths."""
    (f, x) = ([i for i, _ in forces], [i for i, _ in lengths])
    apart = max(f) < min(x) or max(x) < min(f)
    channels = all(CHANNELS & set(h.kind) for _, h in [*forces, *lengths])
    return channels or (apart and not _are_specimens(forces))


def _are_specimens(columns: list[Found]) -> bool:
    """Tell whether every name holds a specimen's label, each another one."""
    labels = []
    for _, heading in columns:
        words = plain(heading.name).split()
        said = bool(set(words) & (SPECIMEN - {"test", "run"})) or set(words[:1]) & {"test", "run"}
        label = _LABEL.search(heading.name)
        labels.append(heading.name if said and heading.labels else label[0] if label else "")
    return all(labels) and len(set(labels)) == len(labels)


def _which(quantity: str, columns: list[Found]) -> str:
    names = ", ".join(f"'{h.text}'" for _, h in columns[:6])
    more = f" and {len(columns) - 6} more" if len(columns) > 6 else ""
    index, heading = columns[0]
    twice = len({h.text for _, h in columns}) < len(columns)
    example = f"#{index + 1}" if twice else heading.text
    return f'which column is {quantity}: {names}{more}? Say --column {quantity}="{example}"'


def _doubt(quantity: str, index: int, heading: Heading, told: Told) -> str:
    """Return what has to be asked of a column's unit, unless the user has answered."""
    if quantity in told.columns and quantity in told.units:
        return ""
    usual = {"time": "s", "displacement": "mm", "force": "N"}[quantity]
    if heading.unread:
        return (
            f"{quantity} is '{heading.text}', but {heading.unread}. Say --column"
            f' {quantity}="{heading.text}" --units {quantity}={usual} if that is what it holds'
        )
    if heading.unit and heading.unit.quantity != quantity:
        return f"told that {quantity} is '{heading.text}', which is in {heading.unit.text}"
    return ""


def _passed_over(
    headings: list[Heading], found: dict[str, list[Found]], chosen: list[Found | None]
) -> list[str]:
    """Say of each quantity which columns were not taken."""
    taken, notes = {c[0] for c in chosen if c}, []
    for quantity in QUANTITIES:
        named_so = [(i, h) for i, h in enumerate(headings) if h.quantity == quantity and h.fits]
        left = [h.name for i, h in named_so if i not in taken]
        first = next((h.name for i, h in found[quantity] if i in taken), "absent")
        if left:
            notes.append(f"{quantity} is '{first}'; not taken: {', '.join(map(repr, left))}")
    return notes


def _out_of_reach(
    headings: list[Heading], chosen: list[Found | None], sample: Sample, told: Told
) -> list[str]:
    """Name the columns, as near to the crosshead as those found, that every row ends before."""
    rank = {h.quantity: h.rank for _, h in filter(None, chosen) if h.quantity not in told.columns}
    named_so = [(i, h) for i, h in enumerate(headings) if h.quantity in rank and h.fits]
    lost = [h.name for i, h in named_so
            if not h.role and h.rank <= rank[h.quantity] and not sample.reaches(i)]  # fmt: skip
    return [f"every row ends before {', '.join(map(repr, lost))}"] if lost else []


def from_units_alone(names: Sequence[str]) -> Choice:
    """Return the columns of a header that holds nothing but one unit of each quantity."""
    specimen: Specimen = {}
    for index, name in enumerate(names):
        unit = read_unit(name)
        if (unit is None and name) or (unit and unit.quantity in specimen):
            return Choice([])
        if unit and unit.quantity != "other":
            bare = name.strip("()[]")
            specimen[unit.quantity] = Channel(index, bare, unit)
    if {"force", "displacement"} <= specimen.keys():
        return Choice([specimen], ["no column names: columns taken by their units"])
    return Choice([])
