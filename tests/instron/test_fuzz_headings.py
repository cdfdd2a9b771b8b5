"""Random headings: every column is understood, or the file is asked about."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

STEADY, SEARCH = settings.get_profile("steady"), settings.get_profile("search")
SI = {"s": 1, "sec": 1, "ms": 1e-3, "min": 60, "mm": 1e-3, "cm": 1e-2, "m": 1, "in": 0.0254,
      "N": 1, "kN": 1e3, "mN": 1e-3, "lbf": 4.4482216152605, "kgf": 9.80665,
      "gram-force": 9.80665e-3, "秒": 1, "毫米": 1e-3, "牛": 1}  # fmt: skip

UNITS = {"time": ["s", "sec", "min"], "displacement": ["mm", "cm", "in"],
         "force": ["N", "kN", "mN", "lbf", "kgf"]}  # fmt: skip
WORDS = {
    "time": ["Time", "Zeit", "Temps", "Total Time", "Running Time", "Tiempo"],
    "displacement": ["Extension", "Weg", "Crosshead", "Desplaz.", "Distance", "Axial Displacement"],
    "force": ["Load", "Kraft", "Force", "Axial Force", "Carico", "Standard force"],
}
PLACES = ["{0} ({1})", "{0} [{1}]", "{0}_{1}", "{0}/{1}", "{0}..{1}.", "{0} in {1}", "{1} {0}",
          "{0} - {1}", "{0}, {1}"]  # fmt: skip
FACTORS = [("", 1), ("x10^3 ", 1e3), ("10^-3 ", 1e-3), ("x 100 ", 100), ("1/10 ", 0.1)]
UNREAD = ["% of 50 ", "5 ", "10E3 ", "?? "]


@st.composite
def headings(draw):
    """Return names of columns, what each of them is in SI (None: to be left), or a question."""
    columns, asked = [], False
    for quantity in draw(st.permutations(list(WORDS))):
        unit = draw(st.sampled_from([u for u in UNITS[quantity] if u != "min"]))
        place = draw(st.sampled_from(PLACES))
        factor, scale = draw(st.sampled_from(FACTORS if place[4:5] in "([" else FACTORS[:1]))
        if quantity == "force" and place[4:5] in "([" and draw(st.integers(0, 9)) == 0:
            factor, asked = draw(st.sampled_from(UNREAD)), True
        name = place.format(draw(st.sampled_from(WORDS[quantity])), factor + unit)
        columns.append((name, quantity, SI[unit] * scale))
        if draw(st.integers(0, 4)) == 0:
            word, *_ = WORDS[quantity]
            role = draw(st.sampled_from(["setpoint", "Soll", "Demand", "error"]))
            at = draw(st.integers(0, len(columns)))
            columns.insert(at, (f"{word} {role} ({unit})", None, 0))
    if draw(st.integers(0, 9)) == 0:
        columns += [("Force X (N)", None, 0), ("Force Y (N)", None, 0)]
    return columns, asked


def check_headings(drawn, seed, attempt):
    """Every column that is taken has its own numbers and scale, or the file is asked about."""
    columns, asked = drawn
    rng = np.random.default_rng(seed)
    values = np.round(np.cumsum(rng.uniform(0.01, 1, (12, len(columns))), axis=0), 4)
    text = "\t".join(name for name, *_ in columns) + "\n"
    text += "".join("\t".join(map(str, row)) + "\n" for row in values)
    logs = attempt(text.encode())
    if logs is None:
        assert asked or "Force X" in text, text.splitlines()[0]
        return
    assert not asked, text.splitlines()[0]
    for k, (_, quantity, scale) in enumerate(columns):
        if quantity:
            np.testing.assert_allclose(logs[0][quantity], values[:, k] * scale, rtol=1e-12)


@settings(STEADY, max_examples=250)
@given(drawn=headings(), seed=st.integers(0, 2**32))
def test_random_headings_are_understood_or_asked_about(drawn, seed, attempt):
    check_headings(drawn, seed, attempt)


@pytest.mark.slow
@settings(SEARCH, max_examples=3000)
@given(drawn=headings(), seed=st.integers(0, 2**32))
def test_many_random_headings(drawn, seed, attempt):
    check_headings(drawn, seed, attempt)
