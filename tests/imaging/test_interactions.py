"""Drawings whose interactions can be counted by eye, and what must not change them."""

import numpy as np
import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.stats import poisson

from imaging import Unmeasurable, crossings, densities, events, interactions


def counts(found: pd.DataFrame) -> dict[tuple[int, int], int]:
    """Non-zero counts by (section, N)."""
    seen = found[found["count"] > 0]
    return dict(zip(zip(seen["section"], seen["N"], strict=True), seen["count"], strict=True))


# Strands run down the picture from y = 0 to y = 40; four sections of 10.
#   section 1: 1 x 2      section 2: 1 x 2, 3 x 4      section 3: 2 x 3, 3 x 4 -> one of three
#   section 4: nothing
# columns at y = 0, 10, 20, 30, 40, each swap in the middle of a section
PLAITED = [
    np.array([[0, 0], [0, 3], [1, 7], [1, 13], [0, 17], [0, 40]], float),
    np.array([[1, 0], [1, 3], [0, 7], [0, 13], [1, 17], [1, 21], [2, 24], [2, 40]], float),
    np.array([[2, 0], [2, 13], [3, 17], [3, 21], [1.4, 24], [1.4, 40]], float),
    np.array([[3, 0], [3, 13], [2, 17], [2, 21], [2.6, 24], [2.6, 40]], float),
]


def test_plait_is_counted_as_drawn():
    found = interactions(PLAITED, n_sec=4)
    assert counts(found) == {(1, 2): 1, (2, 2): 2, (3, 3): 1}
    assert found.attrs["n_sec"] == 4
    assert found.attrs["length"] == pytest.approx(40, rel=0.01)
    np.testing.assert_allclose(found["density"], found["count"] / 10, rtol=0.01)


def test_every_section_and_size_has_a_row():
    found = interactions(PLAITED, n_sec=4)
    assert len(found) == 4 * 3
    assert found["section"].tolist() == sorted(found["section"])


def test_crossing_twice_in_a_section_is_one_interaction():
    straight = np.array([[0, 0], [0, 10]], float)
    wavy = np.array([[-1, 0], [1, 4], [-1, 8], [-1, 10]], float)
    assert counts(interactions([straight, wavy], 1)) == {(1, 2): 1}
    assert counts(interactions([straight, wavy], 2)) == {(1, 2): 1, (2, 2): 1}


def test_a_strand_crossing_itself_is_no_interaction():
    loop = np.array([[0, 0], [4, 4], [4, 2], [0, 6], [0, 10]], float)
    aside = np.array([[9, 0], [9, 10]], float)
    table = crossings([loop, aside])
    assert table["kind"].tolist() == ["self"]
    assert counts(interactions([loop, aside], 5)) == {}


def test_separate_pairs_and_one_chain_differ():
    a = np.array([[0, 0], [1, 10]], float)
    b = np.array([[1, 0], [0, 10]], float)
    apart = [a, b, a + [5, 0], b + [5, 0]]
    assert counts(interactions(apart, 1)) == {(1, 2): 2}
    bridge = np.array([[-1, 4], [7, 6]], float)
    assert counts(interactions([*apart, bridge], 1, axis=np.array([0, 1.0]))) == {(1, 5): 1}


def _random_curl(seed: int, count: int = 6) -> list[np.ndarray]:
    rng = np.random.default_rng(seed)
    y = np.linspace(0, 100, 60)
    waves = rng.normal(size=(count, 3, 1)) * np.sin(
        np.outer([1, 2, 3], y) * 2 * np.pi / 100 + rng.uniform(0, 6, (count, 3, 1))
    )
    return [np.stack([5 * wave.sum(axis=0), y], axis=1) for wave in waves]


@settings(max_examples=20, deadline=None)
@given(
    seed=st.integers(0, 50),
    turn=st.floats(0, 6.28),
    size=st.floats(1e-4, 1e3),
    shift=st.floats(-1e3, 1e3),
)
def test_rotation_scale_and_place_do_not_matter(seed, turn, size, shift):
    strands = _random_curl(seed)
    c, s = np.cos(turn), np.sin(turn)
    moved = [size * (line @ np.array([[c, s], [-s, c]]) + shift) for line in strands]
    before, after = interactions(strands, 7), interactions(moved, 7)
    # A crossing on the border between two sections may fall to either side of it by rounding.
    assert (before["count"] != after["count"]).sum() <= 0
    np.testing.assert_allclose(after["density"] * size, before["density"], rtol=1e-6)
    pd.testing.assert_series_equal(
        events(strands, 0.5)["count"], events(moved, 0.5 * size)["count"]
    )


@settings(max_examples=20, deadline=None)
@given(seed=st.integers(0, 50), order=st.permutations(range(6)))
def test_order_of_the_strands_does_not_matter(seed, order):
    strands = _random_curl(seed)
    shuffled = [strands[i] for i in order]
    pd.testing.assert_series_equal(
        interactions(strands, 9)["count"], interactions(shuffled, 9)["count"]
    )
    assert len(crossings(strands)) == len(crossings(shuffled))


def test_direction_of_a_strand_does_not_change_the_crossings():
    strands = _random_curl(3)
    turned = [line[::-1] if i % 2 else line for i, line in enumerate(strands)]
    np.testing.assert_allclose(
        np.sort(crossings(strands)["x"]), np.sort(crossings(turned)["x"]), atol=1e-9
    )


def test_bin_free_events_merge_when_overlaps_touch():
    # Two right-angled crossings on strand 1, 10 apart: rhombi of half-length r touch at r = 5.
    strands = [
        np.array([[0, 0], [30, 0]], float),
        np.array([[10, -9], [10, 9]], float),
        np.array([[20, -9], [20, 9]], float),
    ]
    assert events(strands, 4.9).set_index("N")["count"].to_dict() == {2: 2, 3: 0}
    assert events(strands, 5.1).set_index("N")["count"].to_dict() == {2: 0, 3: 1}


def test_poisson_interval_is_exact():
    found = interactions(PLAITED, n_sec=4)
    row = densities(found).set_index("N").loc[2]
    length = found.attrs["length"]
    assert row["count"] == 3
    assert poisson.sf(2, row["low"] * length) == pytest.approx(0.025, rel=1e-6)
    assert poisson.cdf(3, row["high"] * length) == pytest.approx(0.025, rel=1e-6)
    assert densities(found)["low"].iloc[-1] == 0


@pytest.mark.parametrize(("strands", "n_sec"), [(PLAITED[:1], 20), ([], 20), (PLAITED, 0)])
def test_too_few_strands_or_sections_are_refused(strands, n_sec):
    with pytest.raises(Unmeasurable):
        interactions(strands, n_sec)
