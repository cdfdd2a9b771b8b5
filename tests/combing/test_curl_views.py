"""What densities of a curl hang on: sections and views of curls whose crossings are known."""

import numpy as np
import pandas as pd
import pytest

import imaging
from combing.compare.curl_views import over_sections, over_views, seen_from, strand_table


def winding(turns, radius=2e-3, height=0.1):
    """Return two hanging strands that wind about each other, (n, 3) [m]."""
    s = np.linspace(0, 1, 1200)
    phase = 2 * np.pi * turns * s + 0.3
    x, y = radius * np.cos(phase), radius * np.sin(phase)
    return [np.column_stack([sign * x, sign * y, -height * s]) for sign in (1, -1)]


def of(table, n=2):
    return table[table["N"] == n].set_index("value")["density"]


def test_strands_wound_about_each_other_cross_twice_a_turn_from_every_side():
    """With one crossing a section at most, pairs are 2 turns/height wherever the camera is."""
    found = of(over_views(winding(5), 100))
    np.testing.assert_allclose(found, 10 / 0.1, rtol=1e-3)
    assert list(found.index) == [0, 30, 60, 90, 120, 150]


def test_half_a_turn_on_the_camera_sees_the_mirror_image():
    for here, there in zip(seen_from(winding(3), 20), seen_from(winding(3), 200), strict=True):
        np.testing.assert_allclose(here, there * [-1, 1], atol=1e-15)
    along_y = seen_from(winding(3))[0]
    np.testing.assert_allclose(along_y[:, 1], -winding(3)[0][:, 2])


def test_more_sections_tell_more_pairs_apart_until_every_crossing_has_its_own():
    """Ten crossings evenly spaced: coarser cuts see one pair a section."""
    strands = seen_from(winding(5))
    found = of(over_sections(strands, imaging.crossings(strands), 1.0, (2, 5, 100)))
    np.testing.assert_allclose(found, [20, 50, 100], rtol=1e-3)


@pytest.mark.parametrize("unit", [1.0, 5e-5])
def test_densities_are_in_metres_whatever_strands_are_given_in(unit):
    strands = [line / unit for line in seen_from(winding(5))]
    found = of(over_sections(strands, imaging.crossings(strands), unit, (100,)))
    assert found[100] == pytest.approx(100, rel=1e-3)


def test_a_view_from_the_side_tells_flat_curls_from_deep_ones():
    """Two strands that cross in the plane x, z only: seen along x they are one line."""
    s = np.linspace(0, 1, 500)
    flat = [
        np.column_stack([sign * 0.01 * np.sin(9 * s + 0.4), 0 * s, -0.1 * s]) for sign in (1, -1)
    ]
    deep = [line + [0, shift, 0] for line, shift in zip(flat, (0.0, 0.03), strict=True)]
    found = of(over_views(deep, 100, (0, 90)))
    assert found[0] > 0
    assert found[90] == 0


def test_a_strand_of_many_points_keeps_its_ends_in_the_table():
    line = np.column_stack([np.linspace(0, 1, 1001), np.linspace(2, 3, 1001)])
    table = strand_table("a", "experiment", "p", [line, line[:3]])
    assert table["z"].isna().all()
    one = table[table["strand"] == 1]
    assert len(one) <= 251
    np.testing.assert_array_equal(one[["x", "y"]].to_numpy()[[0, -1]], line[[0, -1]])
    pd.testing.assert_series_equal(
        table.groupby("strand")["x"].count(), pd.Series({1: len(one), 2: 3}), check_names=False,
        check_index_type=False,
    )  # fmt: skip
