"""The grammar of headings: what a header cell says of its column.

A heading is a quantity, a role (measured, setpoint, error), a sensor, labels, and a unit with a
factor: ``Kraft Ist [kN]``, ``Load(8800 (0,1):Load) (x10^3 N)``, ``A1_force_kN``. What would change
the numbers and cannot be read is kept in ``unread``, and whoever takes the column has to ask.
"""

import re
from dataclasses import dataclass

from instron.headings.units import Unit, read_unit
from instron.headings.words import (
    ABSOLUTE,
    ACROSS,
    ACTUAL,
    CROSSHEAD,
    ELONGATION,
    ENDINGS,
    ERROR,
    GAUGE,
    LENGTHENING,
    NEUTRAL,
    OTHER_PIECES,
    OTHER_THINGS,
    PARTS,
    PIECES,
    QUANTITIES,
    SECONDARY,
    SETPOINT,
    SETPOINT_PIECES,
    SPECIMEN,
    SYMBOLS,
    WORDS,
    plain,
    remembered,
)

LONGEST_NAME = 200
_BRACKET = re.compile(r"[(\[<{]\s*([^()\[\]<>{}]*?)\s*[)\]>}]")
_OPEN = re.compile(r"[(\[<{][^()\[\]<>{}]*$")
_APART = re.compile(r"\s+in\s+|[\s_/,|:;.\-\u2013=]+")
# Load/10, Load x10, 1000*Load: arithmetic that the numbers have been through.
_ARITHMETIC = re.compile(
    r"(?:[^\W\d][\s)\]]*(?:[/*\u00d7\u00f7\u00b7\u2219\u22c5]|\sx)|^\s*[x*/\u00d7])\s*\d"
    r"|\d\s*[*\u00d7\u00b7\u2219\u22c5]\s*[^\W\d]"
)
_PLACE = re.compile(
    r"\bat (?:the )?(?:cent|mid|tip\b|load(?:ing)? point|actuator|crosshead|grip|ram\b)"
)
_CAMEL = re.compile(r"[A-Z]?[a-z\u00df-\u00ff]+|[A-Z]+(?![a-z])|[A-Z]|[^\W\dA-Za-z]+")
_RATE = re.compile(r"(?i)(?:\bdefault )?\bsampl\w+ rate\b")  # catman: Time 1 - default sample rate
_CHANNEL = re.compile(r"(?i)^ext\w*[\s_.]*\d$")  # Extension 1: an extensometer's channel
_QUANTITY_OF = {word: q for q in QUANTITIES for word in WORDS[q]}
_CLASSES = (OTHER_THINGS, SETPOINT, ERROR, ACTUAL, CROSSHEAD, ABSOLUTE, GAUGE, LENGTHENING,
            SECONDARY, PARTS, NEUTRAL, SPECIMEN)  # fmt: skip
ROLES = SETPOINT | ERROR | ACTUAL
GLUED = ("sollwert", "istwert", "soll", "ist")  # German roles in front of their quantity
_KNOWN = set(_QUANTITY_OF).union(*_CLASSES)


@dataclass(frozen=True)
class Heading:
    """What a header cell says; ``quantity`` is None for what is no time, displacement or force."""

    text: str
    name: str  # without its unit
    quantity: str | None = None
    unit: Unit | None = None
    role: str = ""  # "setpoint", "error", or "" for what was measured
    rank: int = 0  # how far from the crosshead's own channel: the lowest is taken
    kind: tuple[str, ...] = ()  # its words without labels: alike in specimens side by side
    labels: tuple[str, ...] = ()  # what is left of it: numbers and unknown words
    lengthens: bool = False  # a length change, if nothing better is there
    other: bool = False  # a result or another quantity by name
    unread: str = ""  # why its numbers cannot be trusted without asking

    @property
    def fits(self) -> bool:
        """Tell whether a stated unit is of the quantity: ``Extension (%)`` is no length."""
        return self.unit is None or self.unit.quantity == self.quantity


@remembered
def read_heading(cell: str, below: str = "") -> Heading:
    """Return what a header cell and the cell of the units row below it say together."""
    text = " ".join(_RATE.sub("", cell).strip().strip("\"'").split())
    if not text or len(text) > LONGEST_NAME:
        return Heading(text, text)
    name, unit = _split_unit(text)
    under = read_unit(below) if below.strip(" ()[]<>{}") else None
    outer = _words(_BRACKET.sub(" ", name))
    inner = [word for part in _BRACKET.findall(name) for word in _words(part)]
    unread = _unread(name, unit, below, under)
    unit = unit or under
    if unit is None and below.strip(" ()[]<>{}-"):
        unread = unread or f"'{below}' is no unit that is known"
    quantity = _quantity(name, outer, inner, unit)
    every = {*outer, *inner}
    labels = tuple(word for word in outer if word not in _KNOWN and not _quantity_of(word))
    return Heading(
        text, name or text, quantity, unit,
        role=_role(text, every),
        rank=_rank(every, quantity, name),
        kind=tuple(filter(None, map(_without_digits, outer))),
        labels=(*labels, *re.findall(r"\d+", name)),
        lengthens=bool(every & LENGTHENING) and unit is not None
        and unit.quantity == "displacement",
        other=_is_other(name, outer),
        unread=unread,
    )  # fmt: skip


def _role(text: str, words: set[str]) -> str:
    """Return what a column is besides a measurement, or ""."""
    if words & SETPOINT or any(piece in text.casefold() for piece in SETPOINT_PIECES):
        return "setpoint"
    return "error" if words & ERROR else ""


def split_unit(cell: str) -> tuple[str, str | None]:
    """Split a header cell into name and written unit: ``Load [kN]`` gives (Load, kN)."""
    heading = read_heading(cell)
    return heading.name, heading.unit.text if heading.unit else None


def quantity_of(name: str) -> str | None:
    """Return which quantity a header name means, or None."""
    return read_heading(name).quantity


@remembered
def _split_unit(text: str) -> tuple[str, Unit | None]:
    """Return the name and the unit in brackets, at the end, in front, or glued to the name."""
    for bracket in reversed(list(_BRACKET.finditer(text))):
        unit = read_unit(bracket[1])
        if unit:
            return (text[: bracket.start()] + text[bracket.end() :]).strip(), unit
    core = text.rstrip(" _.-:")
    for gap in _APART.finditer(core):
        head, unit = core[: gap.start()], read_unit(core[gap.end() :])
        if head and unit and not _OPEN.search(head) and _belongs(unit, head):
            return head, unit
    alone = read_unit(text)
    if alone and alone.quantity in QUANTITIES and len(text) > 4:  # Newtons, Millimetres
        return text, alone
    first = re.match(r"([^\s_\-.]+)[\s_\-.]+(.+)", core)
    unit = read_unit(first[1]) if first else None
    if first and unit and unit.quantity in QUANTITIES and unit.quantity in _quantities(first[2]):
        return first[2], unit
    return _unglued(core) or (text, None)


def _belongs(unit: Unit, head: str) -> bool:
    """Tell whether what stands after a name is its unit: of the name's quantity, without factor."""
    if unit.factor != 1 or re.search(r"\d\d$|[5-9]$", head):
        return False
    if unit.quantity == "other":
        return (len(unit.text) > 1 or unit.text == "%") and bool(_quantities(head))
    symbol = _without_digits(plain(head)) in SYMBOLS[unit.quantity]
    lengthens = unit.quantity == "displacement" and not LENGTHENING.isdisjoint(_words(head))
    return symbol or lengthens or unit.quantity in _quantities(head)


def _unglued(text: str) -> tuple[str, Unit] | None:
    """Split ``LoadkN`` and ``\u529bN``, whose unit follows the last word without a gap."""
    for size in (2, 1, 3):
        head, unit = text[:-size], read_unit(text[-size:])
        whole = head and (not head[-1].isascii() or head[-1].islower() != text[-size].islower()
                          or size > 1)  # fmt: skip
        if unit and whole and unit.quantity in QUANTITIES and _known_end(head, unit.quantity):
            return head, unit
    return None


def _known_end(head: str, quantity: str) -> bool:
    """Tell whether the last word of a name is one of the quantity's own."""
    last = plain(head).split()[-1:]
    return bool(last) and _quantity_of(last[0]) == quantity


def _unread(name: str, unit: Unit | None, below: str, under: Unit | None) -> str:
    """Return what of a heading would change its numbers and is not understood, or ""."""
    if unit and under and not unit.agrees(under):
        return f"the heading says '{unit.text}', the row below it '{below.strip(' ()[]')}'"
    found = _ARITHMETIC.search(name)
    if found:
        return f"'{name}' seems to have been multiplied or divided"
    for part in _BRACKET.findall(name):
        words = part.split()
        units = [word for word in re.split(r"[\s\d*/^.,]+", part)
                 if (known := read_unit(word)) and known.quantity in QUANTITIES
                 and word.casefold() not in NEUTRAL]  # fmt: skip
        if units and not (unit or under):
            return f"'{part}' is no unit that is known"
        alone = len(words) == 1 and len(part) <= 12 and not re.search(r"\d", part)
        last = name.rstrip(" )]").endswith(part) and not (unit or under or below.strip())
        if alone and last and not _meaning(part):
            return f"'{part}' is no unit that is known"
    if unit or under:
        return ""
    end = re.search(r"(\d*)[\s_.]*([^\W\d_]+)[\s_.)\]]*$", name)
    if end and end[2].casefold() == "mn":
        return "'mn' may be mN or MN"
    capacity = read_unit(end[2]) if end and end[1] else None
    if end and capacity and capacity.quantity in _quantities(name[: end.start()]):
        return f"'{end[0].strip()}' may be its unit or its range"
    return ""


def _meaning(text: str) -> bool:
    """Tell whether the text says something else than a unit."""
    return any(w in _KNOWN or _quantity_of(w) for w in _words(text)) or len(text) < 2


@remembered
def _words(text: str) -> list[str]:
    """Return the words of a text as plain() writes them, glued ones taken apart."""
    found: list[str] = []
    for match in re.finditer(r"[^\s_\-/:,;#|*=@.()\[\]<>{}\u2013]+(\.?)", text):
        found += _parts(match[0].rstrip("."), bool(match[1]))
    return [word for word in found if word]


@remembered
def _parts(piece: str, dotted: bool) -> list[str]:
    word = plain(piece)
    bare = _without_digits(word)
    if bare not in _KNOWN:  # Sollweg ends as a displacement does
        for role in (role for role in GLUED if bare.startswith(role)):
            if _quantity_of(bare.removeprefix(role)):
                return [role, word.removeprefix(role)]
    if not bare or bare in _KNOWN or _quantity_of(bare):
        return [bare if bare in _KNOWN else word]
    whole = _abbreviated(bare, dotted)
    if whole:
        return [whole]
    camel = [plain(part) for part in _CAMEL.findall(piece)]
    if len(camel) > 1 and any(part in _KNOWN or _quantity_of(part) for part in camel):
        return camel
    for cut in range(2, len(bare) - 2):
        head, tail = bare[:cut], bare[cut:]
        if tail in _KNOWN and (head in _KNOWN or (len(tail) > 4 and tail in _QUANTITY_OF)):
            return [head, tail]
    return [word]


@remembered
def _abbreviated(word: str, dotted: bool) -> str | None:
    """Return a full word for ``Desplaz.`` if all that begin so are of one quantity."""
    if len(word) < (3 if dotted else 5):
        return None
    meant = [known for known in _KNOWN if known.startswith(word) and known != word]
    quantities = {_QUANTITY_OF.get(known) for known in meant}
    return min(meant) if len(quantities) == 1 and None not in quantities else None


def _without_digits(word: str) -> str:
    return re.sub(r"\d+$", "", word)


@remembered
def _quantity_of(word: str) -> str | None:
    """Return the quantity that a single word names."""
    bare = _without_digits(word)
    for known in (bare, bare.removesuffix("s")):
        if known in _QUANTITY_OF:
            return _QUANTITY_OF[known]
    if bare in OTHER_THINGS:
        return None
    for quantity in ("time", "force", "displacement"):
        if any(plain(piece) in bare for piece in PIECES[quantity]):
            return quantity
        if any(bare.endswith(end) for end in ENDINGS[quantity]):
            return quantity
    return None


def _quantities(text: str) -> list[str]:
    """Return the quantities that words of the text name, in their order."""
    return [q for q in map(_quantity_of, _words(text)) if q]


def _is_other(name: str, outer: list[str]) -> bool:
    bare = plain(_BRACKET.sub(" ", name))
    if _PLACE.search(bare):  # deflection at the centre, not load at break
        outer = [word for word in outer if word != "at"]
    return bool(set(outer) & OTHER_THINGS) or any(plain(piece) in bare for piece in OTHER_PIECES)


def _quantity(name: str, outer: list[str], inner: list[str], unit: Unit | None) -> str | None:
    """Return the quantity of a heading.

    Another quantity's word decides against it. Of two (``Crosshead load``) the unit tells; else
    the word that is no sensor's, else the last.
    """
    bare = plain(_BRACKET.sub(" ", name))
    if _is_other(name, outer):
        return None
    words = outer if any(map(_quantity_of, outer)) else [*outer, *inner]
    found = [(word, q) for word in words if (q := _quantity_of(word))]
    if unit and unit.quantity in {q for _, q in found}:
        return unit.quantity
    if not found:
        bare = " ".join(word for word in bare.split() if word not in ROLES)  # F_ist, s_soll
        symbol = bare.replace(" ", "") if len(bare) < 4 else bare
        known = unit.quantity if unit else ""
        alone = unit is not None and name == unit.text and known in QUANTITIES
        return known if alone or _without_digits(symbol) in SYMBOLS.get(known, ()) else None
    nouns = [q for word, q in found if word not in CROSSHEAD]
    return nouns[-1] if nouns else found[-1][1]


def _rank(words: set[str], quantity: str | None, name: str) -> int:
    """Return how far a channel is from the crosshead's own: the lowest is taken.

    The crosshead moves the tine, so its travel comes before an extensometer's, a travel that
    starts at zero before an absolute position, and a first channel before a corrected one. Of a
    force along and one across nobody knows which was the machine's, nor of a raw and a filtered.
    """
    if quantity == "force":
        words = (words | {"filtered"} if "raw" in words else words) - ABSOLUTE - ACROSS
    channel = quantity == "displacement" and _CHANNEL.search(name)
    return (
        8 * bool(channel)
        + 8 * bool(words & GAUGE)
        + 4 * bool(words & ABSOLUTE)
        + 2 * bool(words & SECONDARY)
        + 2 * bool(words & ACROSS)
        + bool(words & ELONGATION)
        - 2 * bool(words & CROSSHEAD)
        - bool(words & ACTUAL)
    )
