import numpy as np
import pandas as pd
import pytest

from instron import Unscalable, on_grid, repeats
from instron.repeats import simultaneous_band

X = np.linspace(0, 1, 2001)


def curve(places, height=5.0, sd=0.01, name="", D=0.08):
    f = np.sin(np.pi * X) ** 0.5 + sum(height * np.exp(-(((X - p) / sd) ** 2) / 2) for p in places)
    table = pd.DataFrame({"x": X, "f": f, "d": X * D, "F": f * 1.0})
    table.attrs = {"specimen": name, "D": D, "B": 1e-4, "l0": 0.01, "f_noise": 0.0}
    return table


def jittered(n=10, jitter=0.01, seed=0):
    rng = np.random.default_rng(seed)
    return [curve(np.array([0.25, 0.5, 0.75]) + rng.normal(0, jitter, 3), name=str(k))
            for k in range(n)]  # fmt: skip


def test_the_maximum_of_the_mean_curve_is_a_trap():
    """Three jams that only differ in place: the mean curve loses much of every peak."""
    got = repeats(jittered(n=20))
    true = curve([0.25, 0.5, 0.75])["f"].max()
    assert got.summary.loc["f_max", "mean"] == pytest.approx(true, rel=0.01)
    assert got.grid["mean"].max() < 0.88 * true
    assert got.registered["mean"].max() == pytest.approx(true, rel=0.01)


def test_statistics_of_three_known_curves():
    curves = [pd.DataFrame({"x": X, "f": k * X}) for k in (1.0, 2.0, 3.0)]
    for c in curves:
        c["d"], c["F"] = c["x"], c["f"]
    got = repeats(curves)
    np.testing.assert_allclose(got.grid["mean"], 2 * got.grid["x"], atol=2e-3)
    np.testing.assert_allclose(got.grid["sd"], got.grid["x"], atol=2e-3)
    assert got.representative == 1
    np.testing.assert_allclose(got.table["w"], [0.5, 1.0, 1.5])


def test_registration_is_refused_when_peak_counts_differ():
    got = repeats([curve([0.3, 0.6]), curve([0.3, 0.6]), curve([0.45])])
    assert got.registered is None
    assert "2, 2, 1 peaks" in got.unregistered_because
    # The hump is its own peak, so use curves that only rise.
    flat = [pd.DataFrame({"x": X, "f": k + X, "d": X, "F": X}) for k in (1.0, 2.0)]
    assert isinstance(repeats(flat).unregistered_because, str)


def test_one_curve_is_no_repeat():
    with pytest.raises(Unscalable, match="at least 2"):
        repeats([curve([0.5])])


def test_sampling_rate_does_not_matter():
    noisy = curve([0.5], sd=0.05)
    dense = pd.DataFrame({"x": np.linspace(0, 1, 50001)})
    dense["f"] = np.interp(dense["x"], noisy["x"], noisy["f"])
    x = np.linspace(0, 1, 301)
    np.testing.assert_allclose(on_grid(dense, x)[1:-1], on_grid(noisy, x)[1:-1], atol=5e-3)


def smooth_samples(n, rng):
    modes = np.sin(np.pi * np.outer(np.arange(1, 6), np.linspace(0, 1, 101)))
    return (rng.normal(size=(n, 5)) / np.arange(1, 6)) @ modes + rng.normal(size=(n, 1)) * 0.3


@pytest.mark.parametrize("n", [5, 10, 20])
def test_the_band_covers_the_whole_true_curve(n):
    """Coverage at 95 %; 400 trials have a standard error of 1.1 %."""
    rng = np.random.default_rng(n)
    covered = 0
    for _ in range(400):
        low, high = simultaneous_band(smooth_samples(n, rng), 0.95, 400, rng)
        covered += bool(np.all((low <= 0) & (high >= 0)))
    assert 0.92 <= covered / 400 <= 0.98


def test_the_interval_of_the_mean_maximum_covers():
    rng = np.random.default_rng(3)
    curves = {h: curve([0.5], height=h) for h in np.round(rng.normal(5, 0.5, 60), 3)}
    heights = list(curves)
    truth = np.mean([c["f"].max() for c in curves.values()])
    covered = 0
    for _ in range(40):
        got = repeats([curves[h] for h in rng.choice(heights, 5)], resamples=50).summary
        covered += got.loc["f_max", "low"] <= truth <= got.loc["f_max", "high"]
    assert covered >= 34


def test_same_seed_same_band():
    one, two = (repeats(jittered(4), rng=5).grid for _ in range(2))
    pd.testing.assert_frame_equal(one, two)
