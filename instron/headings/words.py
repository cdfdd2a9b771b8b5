"""The words by which testing machines name time, displacement and force, and what goes with them.

Words are compared without accents and case. This is the vocabulary only; how the words of a
heading make a meaning is in ``headings``.
"""

import re
import unicodedata
from functools import lru_cache

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
        " aika cas ido zaman sure elapsed timestamp время"
        " час timp vrijeme vreme waktu thoi χρονοσ"
    ),
    "displacement": word_set(
        "extension extn ext crosshead displacement disp displ displcment position pos traverse"
        " stroke travel lvdt elongation course weg standardweg traversenweg verfahrweg maschinenweg"
        " kolbenweg verschiebung langenanderung durchbiegung deplacement allongement fleche"
        " desplazamiento alargamiento elongacion extensao deslocamento alongamento spostamento"
        " corsa allungamento estensione przemieszczenie wydluzenie droga ugiecie prodlouzeni"
        " posunuti posuv elmozdulas megnyulas uzama deplasman forskjutning forlangning"
        " verplaatsing verlenging deflection stretch verlangerung separation depth distance"
        " dist actuator jaw carrera recorrido curso percurso flecha freccia slag stracka rorelse"
        " zdvih dilatacao degistirme cekme crossheadtravel indentation penetration eindringtiefe"
        " standardwegaufnehmer traverseposition querhauptweg hub stauchung abstand"
        " перемещение удлинение прогиб ход деформация смещение переміщення видовження encoder"
        " forlengelse vandring siirtyma predlzenie chuyen"
        " deplasare alungire pomak pomik hod forskyvning perpindahan μετατοπιση επιμηκυνση"
    ),
    "force": word_set(
        "load force kraft standardkraft prufkraft zugkraft druckkraft last belastung charge effort"
        " carga fuerza forca forza carico sila obciazenie kracht belasting belastning zatizeni ero"
        " terheles kuvvet yuk loadcell weight gewicht voima kraftsensor kraftaufnehmer"
        " kraftmessdose сила нагрузка усилие зусилля навантаження forta opterecenje gaya beban"
        " δυναμη φορτιο luc"
    ),
}
# German and its neighbours glue: Maschinenkraft, Kolbenweg, Messzeit.
ENDINGS = {"time": ("zeit", "tijd"), "displacement": ("weg",), "force": ("kraft", "kracht")}

ACCENTED = word_set(
    "prüfzeit prüfkraft längenänderung verlängerung déplacement extensión extensão prüfer"
    " opérateur éprouvette"
)
# Words whose letters tell a code page from cp1252, in which Windows writes otherwise.
TELLING = {
    "cp1251": word_set("время перемещение удлинение прогиб ход сила нагрузка усилие"),
    "cp1250": word_set(
        "wydłużenie obciążenie siła odkształcenie naprężenie ugięcie čas prodloužení zatížení"
        " idő erő terhelés megnyúlás elmozdulás síla příčníku"
    ),
    "cp850": ACCENTED,
    "mac_roman": ACCENTED,
}

# Inside the cell, longest first: 試験力 is a force although it holds 試験 (test).
PIECES = {
    "time": ("时间", "時間", "시간"),
    "displacement": ("位移", "変位", "变位", "變位", "ストローク", "行程", "伸び", "伸长", "延伸",
                     "横梁", "변위", "신장", "스트로크", "伸長", "移動量"),
    "force": ("载荷", "載荷", "荷重", "试验力", "試験力", "負荷", "负荷", "力值", "하중", "시험력",
              "力"),
}  # fmt: skip

# A name of one letter or two counts only where the stated unit is of its quantity.
SYMBOLS = {
    "time": {"t"},
    "displacement": word_set("x d s u dl δl δ z h w y ux uy uz l dx dz"),
    "force": word_set("f p fx fy fz fn ft l"),
}

# A cell with one of these is a result or another channel, whatever else it says.
OTHER_THINGS = word_set(
    "rate strain stress speed velocity geschwindigkeit vitesse velocidad max maximum min minimum"
    " maxima maximale maximal peak break bruch rupture rotura at bei yield modulus energy energie"
    " energia work arbeit count number cycle cycles cycling strength percent percentage true slope"
    " area width length thickness temperature spannung dehnung contrainte esfuerzo voltage pressure"
    " ratio average mean std sd limit stiffness toughness creep"
    " odksztalcenie naprezenie start end date hold preload prestress threshold torque moment"
    " drehmoment torsion rotation angle winkel drehwinkel torsional vorkraft maximalkraft"
    " bruchkraft hochstkraft fmax noise offset zero deriv derivative acceleration frequency"
    " amplitude geschw tensao deformacion-unitaria sforzo tension-unitaria gerilme napeti"
    " temperatur temp humidity power current index image frame diameter radius height"
    " failure ultimate fracture gain sensitivity calibration capacity"
    " gap size durchmesser breite dicke diametre epaisseur largeur diametro spessore"
)
OTHER_PIECES = ("应变", "应力", "速度", "歪", "応力", "ひずみ", "最大", "強度", "强度", "率",
                "面积", "應變", "應力", "응력", "변형률", "최대", "温度", "扭矩")  # fmt: skip

# What a control loop was told, and by how much it missed: no measurement.
SETPOINT = word_set(
    "soll sollwert demand setpoint setp sp command cmd comando consigne consigna target ziel"
    " reference ref desired commanded vorgabe fuhrungsgrosse zadana zadany"
)
SETPOINT_PIECES = (
    "目标",
    "目標",
    "设定",
    "設定",
    "指令",
    "목표",
    "설정",
    "지령",
    "задан",
    "уставк",
)
ERROR = word_set("error err fehler abweichung regelabweichung deviation residual erreur errore")
ACTUAL = word_set(
    "ist istwert actual act value measured feedback fbk measurement messwert gemessen reell reel"
    " mesure mesuree medido medida misurato aktuell wirklich response"
)

CROSSHEAD = word_set(
    "machine crosshead traverse traversenweg stroke course actuator maschinenweg"
    " kolbenweg querhaupt querhauptweg maschine piston ram corsa carrera curso standardwegaufnehmer"
    " ストローク 横梁 pricniku crossheadtravel aktuator aktuators aktor kolben"
)
ABSOLUTE = word_set("absolute absolu absolue absolut abs position pos raw absoluta jaw")
GAUGE = word_set(
    "extensometer strain gauge gage video dic ave laser optical wegaufnehmer feindehnung"
    " extensometre extensometro le capteur sensor aufnehmer taster maytec clip cod lvdt"
    " extenso makrodehnung videoextensometer crack opening camera kamera messtaster"
)
# Read as displacement only when the unit is a length and no better column exists.
LENGTHENING = word_set(
    "dehnung verformung deformation deformacion deformazione deformacao extensometer strain"
    " compression deform def extensometre extensometro wegaufnehmer maytec taster messtaster"
    " 变形 変形 변형 deformacja odksztalcenie extenso compressao compresion"
)
# The specimen's own lengthening, where the machine's travel stands beside it.
ELONGATION = word_set(
    "elongation elongacion alargamiento allongement allungamento alongamento wydluzenie megnyulas"
    " prodlouzeni uzama verlangerung langenanderung verlenging forlangning delta удлинение"
)
SECONDARY = word_set(
    "step segment corrected compensated korrigiert secondary aux auxiliary digital digitale"
    " filtered filtre gefiltert smoothed smooth nominal cycle backup"
)
# Which of several alike: axes, sides, sensors of one specimen. Never specimens of their own.
PARTS = word_set(
    "x y z xx yy zz xy left right links rechts upper lower oben unten top bottom front back vorn"
    " hinten inner outer gauche droite haut bas izquierda derecha sinistra destra north south east"
    " west lateral transverse transversal radial shear tangential normal vertical horizontal"
    " channel ch kanal canal voie cell cells sensor sensors lc kmd dms lvdt a b c d i ii iii iv"
)
# Of these, what counts the sensors of one machine.
# What says that a unit follows.
UNIT = word_set("unit units einheit einheiten unite unites unidad unidades 単位 单位 單位 단위")

CHANNELS = word_set("channel ch kanal canal voie cell cells sensor sensors lc kmd dms lvdt axis")
ACROSS = word_set("lateral transverse transversal radial shear tangential quer horizontal")
# Says nothing that would tell one column from another.
NEUTRAL = word_set(
    "the of in en em na des der du della total running test testing standard standart primary"
    " tensile compressive flexure flexural tension axial relative measured linear applied"
    " overall default sample machine specimen data channel signal from"
)
SPECIMEN = word_set("specimen sample probe probekorper eprouvette probeta provino test run versuch"
                    " essai ensayo prova trial replicate rep")  # fmt: skip

STROKES = str.maketrans("łøđı", "lodi")  # these do not decompose into a letter and a mark


@remembered
def plain(text: str) -> str:
    """Return the text without accents, case and punctuation, for comparing words."""
    folded = unicodedata.normalize("NFKD", text.casefold().translate(STROKES))
    bare = "".join(c for c in folded if not unicodedata.combining(c))
    return " ".join(re.split(r"[\s_\-/:.,#|*=]+", bare)).strip()
