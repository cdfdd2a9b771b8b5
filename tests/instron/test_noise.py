"""Noise of every colour comes out right, of a reading and of the averaged force."""

import numpy as np
import pytest

from instron import Rig, scale
from instron.scaling.noise import last_digit, of_free_end, swings
from instron.virtual import NOISES, STROKE, combing, filtered, hump, jams, release, teeth, white

RIG = Rig(r=4.25e-4, E=2.8e9)
ROWS = 6000


def sd_of_averages(noise, rows):
    """Return what averaging over so many rows leaves, from a long record."""
    total = np.concatenate([[0], np.cumsum(noise(500_000, np.random.default_rng(99)))])
    return np.std((total[rows:] - total[:-rows]) / rows)


@pytest.mark.parametrize("name", NOISES)
@pytest.mark.parametrize("sd", [0.002, 0.02])
def test_a_cell_of_any_colour(name, sd):
    rows = round(RIG.averaging_length / STROKE * ROWS)
    left = sd * sd_of_averages(NOISES[name], rows)
    found = [
        scale(combing(jams, ROWS, sd=sd, noise=NOISES[name], rng=seed), RIG).attrs
        for seed in range(12)
    ]
    assert np.mean([one["noise"] for one in found]) == pytest.approx(sd, rel=0.07)
    assert np.mean([one["noise_averaged"] for one in found]) == pytest.approx(left, rel=0.35)


@pytest.mark.parametrize("digit", [0.2, 1.0, 4.0])
def test_quantised_noise_is_no_less_than_its_digit_allows(digit):
    """White noise of 5 mN in steps of a fifth, one and four of it: its sd, or q/sqrt(12)."""
    q = digit * 0.005
    found = scale(combing(hump, ROWS, sd=0.005, digit=q, rng=0), RIG).attrs["noise"]
    true = np.sqrt(0.005**2 + q**2 / 12) if digit < 2 else q / np.sqrt(12)
    assert found == pytest.approx(true, rel=0.15)


def test_the_last_digit_is_that_of_a_grid():
    values = np.random.default_rng(0).normal(0, 1, 1000)
    assert last_digit(0.02 * np.round(values / 0.02)) == pytest.approx(0.02)
    assert last_digit(values) == 0
    assert last_digit(np.zeros(10)) == 0


def test_a_touch_of_the_free_tine_is_no_noise():
    F = 0.01 * white(1000, np.random.default_rng(1))
    F[400:420] += 3.0
    assert of_free_end(F, 50).sd == pytest.approx(0.01, rel=0.1)


def test_few_rows_tell_nothing():
    assert of_free_end(np.zeros(10), 5) is None


def slow(n, rng):
    """Return noise whose swings are twice as long as what is averaged over."""
    return filtered(n, rng, 0.0167)


@pytest.mark.parametrize(
    ("shape", "seed"), [(jams, 37), (jams, 61), (jams, 121), (jams, 175), (release, 183)]
)
def test_slow_noise_that_is_taken_for_combing_is_in_the_intervals(shape, seed):
    found = scale(combing(shape, 1500, height=0.5, sd=0.02, noise=slow, rng=seed), RIG).attrs
    d = np.linspace(0, STROKE, 20_001)
    end = d[np.flatnonzero(0.02 * shape(d).max() < shape(d))[-1]]
    assert found["D"] > 1.1 * end
    assert found["D_low"] <= end
    assert found["f_max_high"] - found["f_max_low"] > 0.06 * found["f_max"]  # were 0.002 to 0.03


def test_force_that_goes_one_way_or_stops_is_no_swing():
    d = np.linspace(0, STROKE, 1500)
    ripple = np.sin(2 * np.pi * d / 2.5e-3)
    for F in (d / STROKE * (1 + 0.3 * ripple), teeth(d), hump(d)):
        assert swings(F, F, 32.0) is None
    swinging = hump(d) + 0.03 * ripple
    found = swings(swinging, swinging, 32.0)
    assert found is not None
    assert found[1].sd == pytest.approx(0.03 / np.sqrt(2), rel=0.15)
