import numpy as np
import pandas as pd
import pytest

from instron import events

X = np.linspace(0, 1, 5000)


def curve(peaks, noise=0.0, seed=0, x=X, base=1.0):
    """Return a curve with Gaussian peaks (place, height, sd) on a slow hump."""
    f = base * np.sin(np.pi * x) ** 0.5 + sum(
        h * np.exp(-(((x - p) / s) ** 2) / 2) for p, h, s in peaks
    )
    f = f + noise * np.random.default_rng(seed).standard_normal(len(x))
    table = pd.DataFrame({"x": x, "f": f})
    table.attrs = {"f_noise": noise, "D": 0.08, "B": 1e-4, "l0": 0.01}
    return table


def found(table):
    return table[table["kind"] != "plateau"]


def test_three_jams_are_found_where_they_are():
    got = found(events(curve([(0.2, 3, 0.01), (0.45, 4, 0.01), (0.7, 2, 0.01)])))
    np.testing.assert_allclose(got["x"], [0.2, 0.45, 0.7], atol=0.002)
    np.testing.assert_allclose(got["d"], got["x"] * 0.08)
    np.testing.assert_allclose(got["F"], got["f"])
    assert (got["kind"] == "jam").all()
    # The release is the steepest fall, one sd (widened by smoothing) behind the top.
    np.testing.assert_allclose(got["release_x"] - got["x"], 0.0112, atol=0.002)


def test_height_and_width_of_a_resolved_peak():
    got = found(events(curve([(0.5, 4, 0.04)], base=0.0))).iloc[0]
    assert got["f"] == pytest.approx(4, rel=0.01)
    assert got["width"] == pytest.approx(2.355 * 0.04, rel=0.02)


def test_pure_noise_has_no_events():
    counts = [len(found(events(curve([], noise=0.1, seed=s)))) for s in range(40)]
    # The hump itself is one peak.
    assert max(counts) <= 1


def test_recall_and_precision_at_five_times_the_noise():
    rng = np.random.default_rng(7)
    hits = missed = false = 0
    for seed in range(60):
        places = np.arange(0.1, 0.95, 0.1) + rng.uniform(-0.02, 0.02, 9)
        table = curve([(p, 0.5, 0.012) for p in places], noise=0.1, seed=seed, base=0.0)
        got = found(events(table))["x"].to_numpy()
        near = np.abs(got[:, None] - places[None]) < 0.02
        hits += near.any(axis=0).sum()
        missed += (~near.any(axis=0)).sum()
        false += (~near.any(axis=1)).sum()
    assert hits / (hits + missed) >= 0.98
    assert hits / (hits + false) >= 0.98


def test_sampling_rate_does_not_change_the_events():
    peaks = [(0.3, 2, 0.02), (0.6, 3, 0.02)]
    coarse, fine = (
        found(events(curve(peaks, noise=0.03, x=np.linspace(0, 1, n)))) for n in (700, 40000)
    )
    np.testing.assert_allclose(coarse["x"], fine["x"], atol=0.01)
    np.testing.assert_allclose(coarse["f"], fine["f"], rtol=0.03)


def test_a_plateau_is_told_from_a_peak():
    f = np.clip(5 * X, 0, 1) * (X < 0.9)
    got = events(pd.DataFrame({"x": X, "f": f}))
    plateau = got[got["kind"] == "plateau"].iloc[0]
    assert plateau["width"] == pytest.approx(0.7, abs=0.06)
    assert plateau["f"] == pytest.approx(1.0, abs=0.01)


def test_a_curve_of_few_points_is_no_error():
    assert isinstance(events(curve([], x=np.linspace(0, 1, 6))), pd.DataFrame)
