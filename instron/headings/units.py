"""Written units, factors included, and their conversion to SI, once, at the door.

``(kN)``, ``[x10^3 N]``, ``1/100 mm`` and ``kilo N`` each are a quantity, a unit and a factor;
whatever of them cannot be read makes no unit at all, so that nobody takes a part for the whole.
"""

import re
import unicodedata
from dataclasses import dataclass
from functools import cache
from typing import Any

from instron.headings.words import remembered, word_set

SI = {"time": "s", "displacement": "m", "force": "N"}
PINT_NAMES = {"gf": "gram_force", "kgf": "kilogram_force", "lbf": "pound_force",
              "ozf": "ounce_force", "tf": "metric_ton * standard_gravity"}  # fmt: skip
UNITS = {
    "time": {
        "s": "s sec secs second seconds sek sekunde sekunden seg segundo segundos sekunda"
        " secondes seconde secondi sn saniye 秒 с сек 초",
        "ms": "ms msec msecs millisecond milliseconds millis millisekunden мс 毫秒",
        "us": "us µs μs microseconds",
        "min": "min mins minute minutes minuten minutos мин 分",
        "hour": "h hr hrs hour hours stunden",
    },
    "displacement": {
        "mm": "mm millimeter millimeters millimetre millimetres milimetros 毫米 мм",
        "cm": "cm centimeter centimeters centimetre centimetres 厘米 см",
        "m": "m meter meters metre metres м",
        "micrometer": "um µm μm mum micron microns micrometer micrometers micrometre micrometres"
        " 微米 мкм",
        "nm": "nm nanometer nanometers",
        "inch": "in inch inches zoll pouces pulgadas",
        "thou": "mil mils thou",
        "foot": "ft foot feet",
    },
    "force": {
        "N": "n newton newtons 牛 牛顿 н",
        "kN": "kn kilonewton kilonewtons 千牛 кн",
        "cN": "cn centinewton",
        "daN": "dan decanewton",
        "uN": "un µn μn micronewton micronewtons",
        "nN": "nanonewton nanonewtons",
        "mN": "millinewton millinewtons",
        "MN": "meganewton",
        "dyn": "dyn dyne dynes",
        "lbf": "lbf lb lbs pound pounds poundf",
        "kip": "kip kips klbf klb",
        "ozf": "ozf oz",
        "kgf": "kgf kg kp kilopond кгс 公斤 千克",
        "gf": "gf gmf g gr gram grams gramm gramme pond 克 гс",
        "tf": "tf tonf ton tons tonne tonnes",
    },
}
# Case tells: mN from MN, Nm from nm.
CASED = {"mN": ("force", "mN"), "MN": ("force", "MN"), "nN": ("force", "nN"),
         "Nm": ("other", "nm"), "NM": ("other", "nm")}  # fmt: skip
AMBIGUOUS = {"mn"}
MASSES = word_set("g gr gram grams gramm gramme kg lb lbs pound pounds oz 公斤 千克 克") | {
    "ton", "tons", "tonne", "tonnes"}  # fmt: skip
LOOSE = {"ton", "tons", "tonf"}  # metric in most of the world, 907 kg in some of it
SPELLED = {
    f"{word}{plural} force": unit
    for word, unit in {"gram": "gf", "pound": "lbf", "kilogram": "kgf", "tonne": "tf",
                       "ounce": "ozf"}.items()
    for plural in ("", "s")
}  # fmt: skip
_UNIT_OF = {
    word: (quantity, unit)
    for quantity, table in UNITS.items()
    for unit, words in table.items()
    for word in words.split()
}
OTHER_UNITS = word_set(
    "% mpa gpa kpa pa psi ksi msi mm/mm in/in n/mm n/mm² n/mm2 n/mm^2 kn/mm² kn/mm2 n/m n/tex"
    " cn/tex g/den gf/den cn/dtex j mj kj nm² nmm n·m n.m n-m n*m n·mm kn·m kn-m in·lbf in-lbf"
    " ft-lbf v mv mvolt volt volts deg degree degrees ° °c degc ℃ c °f k hz mm/min mm/s mm/sec"
    " in/min m/s mm² mm2 mm^2 cycles cycle segments count counts strain mm/mm% m/m cel s-1 1/s"
    " %/min %/s mv/v a ma bar kgf/mm2 kgf/mm² kgf/cm² kgf/cm2 kn/mm rad ustrain µε με µm/m um/m"
    " microstrain kn/s n/s mpa/s pixel px pixels steps - none"
)
VOLTS = {"v", "mv", "volt", "volts", "mv/v", "uv", "µv"}
PREFIXES = {"kilo": 1e3, "milli": 1e-3, "micro": 1e-6, "mega": 1e6, "deca": 10.0, "centi": 1e-2}
# 10e3 N may be 10^3 or 10^4 N, 10 kN a load cell: neither is read, nor a power beyond any unit.
_POWER = re.compile(r"(?:x|\*)?\s*10\s*(?:\^|\*\*)\s*\(?([-+]?\d{1,2})\)?", re.IGNORECASE)
_RATIO = re.compile(r"(\d{1,9})\s*/\s*(\d{1,9})")
_NUMBER = re.compile(r"(?:x|\*)\s*(\d{1,9}(?:\.\d+)?(?:e[-+]?\d{1,2})?)", re.IGNORECASE)
_SUPERSCRIPT = str.maketrans("⁰¹²³⁴⁵⁶⁷⁸⁹⁻×∙⋅", "0123456789-x··")
_RAISED = re.compile(r"10([⁻⁰¹²³⁴⁵⁶⁷⁸⁹]+)")


@dataclass(frozen=True)
class Unit:
    """A written unit: how it stands in the file, its quantity, pint's name, and a factor."""

    text: str
    quantity: str  # "other" for stress, strain, volts and the like
    name: str
    factor: float = 1.0

    @property
    def loose(self) -> bool:
        """Tell whether the word is used for more than one unit (``ton``)."""
        return self.text.casefold().strip("()[] .") in LOOSE

    def to_si(self) -> float:
        """Return how many SI units one of this unit is."""
        return self.factor * per_si(self.name, self.quantity)

    def agrees(self, other: "Unit") -> bool:
        """Tell whether both are the same unit, however they are written."""
        mine, theirs = (u.text if u.quantity == "other" else u.name for u in (self, other))
        return (self.quantity, mine, self.factor) == (other.quantity, theirs, other.factor)


@remembered
def read_unit(text: str) -> Unit | None:
    """Return the unit that all of this text is, or None."""
    bare = text.strip().strip("\"'").strip().strip("()[]<>{}").strip()
    plain = _simple(bare)
    if plain:
        return Unit(bare, *plain)
    scale, rest = _factor(bare)
    known = _simple(rest) if scale is not None else None
    if known is None or known[0] == "other":
        return None
    return Unit(bare, *known, factor=scale or 1.0)


def _simple(bare: str) -> tuple[str, str] | None:
    """Return (quantity, pint unit) of a unit without factor."""
    bare = bare.rstrip(".")
    if bare in CASED:
        return CASED[bare]
    if bare in AMBIGUOUS:
        return None
    folded = unicodedata.normalize("NFKC", bare).casefold()
    spelled = SPELLED.get(" ".join(re.split(r"[-\s]+", folded)))
    if spelled:
        return "force", spelled
    if bare.casefold() in OTHER_UNITS or folded in OTHER_UNITS:
        return "other", folded
    return _UNIT_OF.get(folded) or _UNIT_OF.get(bare.casefold())


def _factor(bare: str) -> tuple[float | None, str]:
    """Return a leading factor and what follows it: ``x10^3 N``, ``1/100 mm``, ``kilo N``."""
    word, _, rest = bare.partition(" ")
    if word.casefold() in PREFIXES:
        return PREFIXES[word.casefold()], rest.strip()
    bare = _RAISED.sub(r"10^\1", bare).translate(_SUPERSCRIPT)
    if match := _POWER.match(bare):
        return 10.0 ** int(match[1]), bare[match.end() :].strip(" *")
    if match := _RATIO.match(bare):
        return int(match[1]) / int(match[2]) if int(match[2]) else None, bare[match.end() :].strip()
    if match := _NUMBER.match(bare):
        return float(match[1]) or None, bare[match.end() :].strip(" *")
    return None, bare


def is_unit(text: str) -> bool:
    """Tell whether the text is a unit of any kind, those of stress and strain included."""
    return read_unit(text) is not None


@cache
def _registry() -> Any:
    """Make pint's registry when first needed: it takes longer than reading a file."""
    import pint

    return pint.UnitRegistry()


@cache
def per_si(unit: str, quantity: str) -> float:
    """Return how many SI units of ``quantity`` one ``unit`` (a pint name) is."""
    return float(_registry().Quantity(1.0, PINT_NAMES.get(unit, unit)).to(SI[quantity]).magnitude)
