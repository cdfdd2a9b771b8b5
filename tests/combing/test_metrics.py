import numpy as np
import pandas as pd
import pytest

from combing.errors import UserError
from combing.metrics import compare_curves, event_score, iso18571

X = np.linspace(0, 1, 2001)


def jams(*places, height=3.0):
    f = 1.0 - np.exp(-X / 0.05) + sum(height * np.exp(-(((X - p) / 0.02) ** 2)) for p in places)
    return pd.DataFrame({"x": X, "f": f * (X < 0.99)})


def table(*rows):
    return pd.DataFrame([{"kind": "jam", "x": x, "f": f} for x, f in rows],
                        columns=["kind", "x", "f"])  # fmt: skip


def test_a_curve_agrees_with_itself():
    found = compare_curves(jams(0.3, 0.6), jams(0.3, 0.6), iso=True)
    assert found["f_max_error"] == found["work_error"] == found["nrmse"] == 0
    assert found["event_score"] == found["iso18571"] == found["iso_phase"] == 1


def test_signs_say_which_is_larger():
    small, large = jams(0.3, height=2.0), jams(0.3, height=4.0)
    assert compare_curves(small, large)["f_max_error"] == pytest.approx(2 / 3, rel=1e-3)
    assert compare_curves(large, small)["f_max_error"] == pytest.approx(-0.4, rel=1e-3)
    assert compare_curves(large, small)["work_error"] < 0


def test_a_shift_ranks_above_missing_jams_where_mean_absolute_error_does_not():
    true, shifted, none = jams(0.3, 0.6), jams(0.33, 0.63), jams(height=0.0)
    mae = [np.abs(true["f"] - c["f"]).mean() for c in (shifted, none)]
    assert mae[0] > 0.95 * mae[1]
    by = {
        name: compare_curves(true, c, iso=True) for name, c in (("shift", shifted), ("none", none))
    }
    assert by["shift"]["event_score"] == pytest.approx(0.7, abs=0.02)
    assert by["none"]["event_score"] == 0
    assert by["shift"]["iso18571"] > by["none"]["iso18571"]


def test_event_score_pairs_peaks_optimally():
    # The first peak alone would take 0.52; only the crossed-free pairing matches both.
    one, two = table((0.50, 1.0), (0.54, 1.0)), table((0.52, 1.0), (0.60, 1.0))
    assert event_score(one, two) == pytest.approx((0.8 + 0.4) / 2)


def test_missing_and_false_peaks_cost_the_same():
    one, two = table((0.3, 2.0)), table((0.3, 2.0), (0.7, 2.0))
    assert event_score(one, two) == event_score(two, one) == pytest.approx(2 / 3)
    assert event_score(table(), table()) == 1
    assert event_score(one, table()) == 0


def test_height_counts_in_the_event_score():
    assert event_score(table((0.3, 2.0)), table((0.3, 1.0))) == pytest.approx(0.5)


def test_iso_phase_is_the_shift_over_a_fifth_of_the_record():
    a = np.exp(-(((X - 0.4) / 0.05) ** 2))
    b = np.exp(-(((X - 0.45) / 0.05) ** 2))
    assert iso18571(a[::2], b[::2])["iso_phase"] == pytest.approx(1 - 0.05 / 0.2, abs=0.01)


def test_an_empty_curve_is_refused():
    with pytest.raises(UserError, match="curve has 0 usable points"):
        compare_curves(jams(0.3), jams(0.3).iloc[:0])
