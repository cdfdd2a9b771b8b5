"""The words and units by which testing machines name time, displacement and force.

A header cell becomes a quantity when it holds one of that quantity's words and none of the words
that turn it into something else ("Extension rate", "Load at break"). Words are compared without
accents and case; Chinese and Japanese ones are looked for inside the cell.
"""

import re
import unicodedata
from functools import lru_cache

LONGEST_NAME = 200
QUANTITIES = ("time", "displacement", "force")


# A file repeats its names: specimens side by side, or stacked by the thousand.
remembered = lru_cache(maxsize=4096)


def word_set(words: str) -> set[str]:
    """Return the words of a string as a set."""
    return set(words.split())


# Without accents, as plain() leaves them.
WORDS = {
    "time": word_set(
        "time zeit prufzeit testzeit laufzeit messzeit temps tiempo tempo czas godzina tid tijd"
        " aika cas ido zaman sure elapsed время"
    ),
    "displacement": word_set(
        "extension extn ext crosshead displacement disp displ position pos traverse stroke travel"
        " lvdt elongation course weg standardweg traversenweg verfahrweg maschinenweg kolbenweg"
        " verschiebung langenanderung durchbiegung deplacement allongement fleche desplazamiento"
        " alargamiento elongacion extensao deslocamento alongamento spostamento corsa allungamento"
        " estensione przemieszczenie wydluzenie droga ugiecie prodlouzeni posunuti posuv"
        " elmozdulas megnyulas uzama deplasman forskjutning forlangning verplaatsing verlenging"
        " deflection stretch verlangerung separation перемещение удлинение прогиб ход"
    ),
    "force": word_set(
        "load force kraft standardkraft prufkraft zugkraft druckkraft last belastung charge effort"
        " carga fuerza forca forza carico sila obciazenie kracht belasting belastning zatizeni ero"
        " terheles kuvvet yuk loadcell сила нагрузка усилие"
    ),
}

ACCENTED = word_set(
    "prüfzeit prüfkraft längenänderung verlängerung déplacement extensión extensão prüfer"
    " opérateur éprouvette"
)
# Words whose letters tell a code page from cp1252, in which Windows writes otherwise.
TELLING = {
    "cp1251": word_set("время перемещение удлинение прогиб ход сила нагрузка усилие"),
    "cp1250": word_set(
        "wydłużenie obciążenie siła odkształcenie naprężenie ugięcie čas prodloužení zatížení"
        " idő erő terhelés megnyúlás elmozdulás"
    ),
    "cp850": ACCENTED,
    "mac_roman": ACCENTED,
}

# Inside the cell, longest first: 試験力 is a force although it holds 試験 (test).
PIECES = {
    "time": ("时间", "時間", "시간"),
    "displacement": ("位移", "変位", "变位", "變位", "ストローク", "行程", "伸び", "伸长", "延伸",
                     "横梁", "변위", "신장", "스트로크"),
    "force": ("载荷", "載荷", "荷重", "试验力", "試験力", "負荷", "负荷", "力值", "하중", "시험력",
              "力"),
}  # fmt: skip

# A name of one letter or two counts only where the stated unit is of its quantity.
SYMBOLS = {"time": {"t"}, "displacement": {"x", "d", "s", "u", "dl", "z"}, "force": {"f", "p"}}

# A cell with one of these is a result or another channel, whatever else it says.
OTHER_THINGS = word_set(
    "rate strain stress speed velocity geschwindigkeit vitesse velocidad max maximum min minimum"
    " maxima maximale maximal peak break bruch rupture rotura at bei yield modulus energy energie"
    " energia work arbeit count number cycle cycles cycling strength percent percentage true slope"
    " area width length thickness temperature spannung dehnung contrainte esfuerzo voltage pressure"
    " ratio average mean std sd target setpoint command limit stiffness toughness creep"
    " odksztalcenie naprezenie start end date hold preload threshold"
)
OTHER_PIECES = (
    "应变",
    "应力",
    "速度",
    "歪",
    "応力",
    "ひずみ",
    "最大",
    "強度",
    "强度",
    "率",
    "面积",
    "應變",
    "應力",
    "응력",
    "변형률",
    "최대",
)

CROSSHEAD = word_set(
    "machine crosshead traverse traversenweg standardweg stroke course actuator maschinenweg"
    " kolbenweg querhaupt"
)
ABSOLUTE = word_set("absolute absolu absolue absolut abs position pos raw absoluta")
GAUGE = word_set(
    "extensometer strain gauge gage video dic ave laser optical wegaufnehmer feindehnung"
    " extensometre extensometro le capteur sensor aufnehmer taster"
)
# Read as displacement only when the unit is a length and no better column exists.
LENGTHENING = word_set(
    "dehnung verformung deformation deformacion deformazione deformacao extensometer strain"
    " compression"
    " extensometre extensometro wegaufnehmer"
)
SECONDARY = word_set("step segment corrected compensated korrigiert secondary aux auxiliary")

UNITS = {
    "time": {
        "s": "s sec secs second seconds sek sekunde sekunden seg segundo segundos sekunda 秒 с сек",
        "ms": "ms msec msecs millisecond milliseconds 毫秒",
        "min": "min mins minute minutes minuten minutos 分",
        "hour": "h hr hrs hour hours",
    },
    "displacement": {
        "mm": "mm millimeter millimeters millimetre millimetres 毫米 мм",
        "cm": "cm centimeter centimeters centimetre centimetres",
        "m": "m meter meters metre metres м",
        "micrometer": "um µm μm micron microns micrometer micrometers",
        "inch": "in inch inches zoll",
        "foot": "ft foot feet",
    },
    "force": {
        "N": "n newton newtons 牛 牛顿 н",
        "kN": "kn kilonewton kilonewtons 千牛 кн",
        "cN": "cn centinewton",
        "daN": "dan",
        "lbf": "lbf lb lbs pound pounds",
        "kip": "kip kips klbf",
        "ozf": "ozf oz",
        "kgf": "kgf kg kp kilopond",
        "gf": "gf g pond",
    },
}
CASED_UNITS = {"mN": ("force", "mN"), "MN": ("force", "MN")}
SPELLED = {
    "gram force": "gf",
    "grams force": "gf",
    "pound force": "lbf",
    "pounds force": "lbf",
    "kilogram force": "kgf",
    "kilograms force": "kgf",
}
_UNIT_OF = {
    word: (quantity, unit)
    for quantity, table in UNITS.items()
    for unit, words in table.items()
    for word in words.split()
}

OTHER_UNITS = word_set(
    "% mpa gpa kpa pa psi ksi msi mm/mm in/in n/mm n/mm² n/mm2 n/mm^2 kn/mm² n/m n/tex cn/tex"
    " g/den gf/den j mj kj nm n·m n.m v mv volt volts deg degree degrees ° °c c °f k hz mm/min"
    " mm/s in/min mm² mm2 mm^2 cycles cycle count strain mm/mm% m/m cel s-1 1/s %/min mv/v"
    " kgf/mm2 kgf/mm² kgf/cm² kgf/cm2 - none"
)
VOLTS = {"v", "mv", "volt", "volts", "mv/v", "uv", "µv"}


STROKES = str.maketrans("łøđı", "lodi")  # these do not decompose into a letter and a mark


@remembered
def plain(text: str) -> str:
    """Return the text without accents, case and punctuation, for comparing words."""
    folded = unicodedata.normalize("NFKD", text.casefold().translate(STROKES))
    bare = "".join(c for c in folded if not unicodedata.combining(c))
    return " ".join(re.split(r"[\s_\-/:.,#|*=]+", bare)).strip()


@remembered
def unit_of(text: str) -> tuple[str, str] | None:
    """Return (quantity, pint unit) of a written unit such as ``(mm)``, ``[kN]`` or ``sec``."""
    bare = text.strip().strip("\"'").strip().strip("()[]<>{}").strip().rstrip(".")
    if bare in CASED_UNITS:
        return CASED_UNITS[bare]
    folded = " ".join(bare.casefold().replace("-", " ").split())
    bare = SPELLED.get(folded, bare)
    return _UNIT_OF.get(bare.casefold())


@remembered
def is_unit(text: str) -> bool:
    """Tell whether the cell is a unit of any kind, those of stress and strain included."""
    bare = text.strip().strip("\"'").strip().strip("()[]<>").strip()
    return unit_of(text) is not None or bare.casefold() in OTHER_UNITS


@remembered
def split_unit(cell: str) -> tuple[str, str | None]:
    """Split a header cell into name and written unit: ``Load [kN]`` gives (Load, kN)."""
    text = cell.strip().strip("\"'").strip()
    if len(text) > LONGEST_NAME:
        return text, None
    for bracket in reversed(list(re.finditer(r"[(\[<{]\s*([^()\[\]<>{}]*?)\s*[)\]>}]", text))):
        if is_unit(bracket[1]):
            return (text[: bracket.start()] + text[bracket.end() :]).strip(), bracket[1]
    glued = re.fullmatch(r"(.*?\w)\s*(?:[_/,|:]| in | )\s*([^\s_/,|]+)", text)
    if glued and is_unit(glued[2]) and quantity_of(glued[1]) and not glued[2].isdigit():
        return glued[1], glued[2]
    return text, None


@remembered
def unknown_unit(name: str) -> str | None:
    """Return what stands in brackets at the end where only a unit makes sense, or None.

    ``Load (tonnes)`` must not pass for a load without a unit; ``Displacement (Strain 1)`` may.
    """
    bracket = re.search(r"[(\[]\s*([^()\[\]\s\d]{1,12})\s*[)\]]$", name)
    if bracket is None or plain(bracket[1]) in GAUGE | CROSSHEAD | ABSOLUTE | OTHER_THINGS:
        return None
    return None if quantity_of(bracket[1]) else bracket[1]


@remembered
def quantity_of(name: str) -> str | None:
    """Return which quantity a header name means, or None."""
    if len(name) > LONGEST_NAME:
        return None
    bare = plain(re.sub(r"[(\[<].*?[)\]>]", " ", name))
    tokens = {re.sub(r"\d+$", "", token) for token in bare.split()}
    if tokens & OTHER_THINGS or any(plain(piece) in bare for piece in OTHER_PIECES):
        return None
    for quantity in ("time", "force", "displacement"):
        if tokens & WORDS[quantity] or any(plain(piece) in bare for piece in PIECES[quantity]):
            return quantity
    return None


def symbol_of(name: str, unit: str | None) -> str | None:
    """Return which quantity a lone symbol means whose stated unit agrees: ``F [N]``, ``s [mm]``."""
    known = unit_of(unit) if unit else None
    if known is None or plain(name) not in SYMBOLS[known[0]]:
        return None
    return known[0]


def lengthens(name: str) -> bool:
    """Tell whether the name could be a length change, given that its unit is a length."""
    return bool(set(plain(name).split()) & LENGTHENING)


@remembered
def rank(name: str) -> int:
    """Return how far a channel is from the crosshead's own: the lowest is taken.

    The crosshead moves the tine, so its travel comes before an extensometer's, a travel that
    starts at zero before an absolute position, and a first channel before a corrected one.
    """
    tokens = {re.sub(r"\d+$", "", token) for token in plain(re.sub(r"[()\[\]]", " ", name)).split()}
    return (
        4 * bool(tokens & GAUGE)
        + 2 * bool(tokens & ABSOLUTE)
        + bool(tokens & SECONDARY)
        - bool(tokens & CROSSHEAD)
    )
