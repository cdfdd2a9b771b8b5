"""Numbers of instron that a small slip would change without a picture looking wrong."""

import numpy as np
import pandas as pd
import pytest
from scipy import stats

from instron import events, repeats

X = np.linspace(0, 1, 2001)


def triangle(top, place=0.4):
    f = top * np.clip(1 - np.abs(X - place) / 0.4, 0, None)
    table = pd.DataFrame({"x": X, "f": f, "d": 0.08 * X, "F": f})
    table.attrs = {"D": 0.08, "B": 1e-4, "l0": 0.01, "f_noise": 0.0, "specimen": "s"}
    return table


@pytest.mark.parametrize("level", [0.95, 0.8])
def test_interval_of_the_mean_is_students_with_one_degree_less_than_repeats(level):
    tops = [2.0, 3.0, 3.5, 5.0]
    row = repeats([triangle(top) for top in tops], level=level).summary.loc["w"]
    areas = np.array([0.4 * top for top in tops])
    low, high = stats.t.interval(level, len(tops) - 1, areas.mean(), stats.sem(areas))
    assert [row["low"], row["high"]] == pytest.approx([low, high], rel=1e-3)
    assert row["sd"] == pytest.approx(areas.std(ddof=1), rel=1e-3)


def step(left):
    """Return a curve that rises to 10, falls to `left` over a width of 0.1, and stays there."""
    f = np.interp(X, [0, 0.3, 0.4, 0.9, 1.0], [0, 10, left, left, left + 0.5])
    table = pd.DataFrame({"x": X, "f": f})
    table.attrs = {"D": 0.08, "B": 1e-4, "l0": 0.01, "f_noise": 0.0}
    return table


@pytest.mark.parametrize(("left", "kind"), [(7.4, "peak"), (7.15, "peak"), (6.85, "jam")])
def test_a_jam_loses_three_tenths_of_its_force(left, kind):
    found = events(step(left))
    (first,) = found[(found["kind"] != "plateau") & (found["x"] < 0.5)]["kind"]
    assert first == kind


@pytest.mark.parametrize(("slope", "flat"), [(0.13, True), (0.17, False)])
def test_a_plateau_rises_by_less_than_0_15_f_max_over_d(slope, flat):
    f = np.interp(X, [0, 0.3, 0.9, 1.0], [0, 1 - 0.6 * slope, 1, 0])
    table = pd.DataFrame({"x": X, "f": f})
    table.attrs = {"D": 0.08, "B": 1e-4, "l0": 0.01, "f_noise": 0.0}
    assert ("plateau" in set(events(table)["kind"])) == flat
