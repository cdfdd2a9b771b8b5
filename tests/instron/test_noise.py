"""Noise of every colour comes out right, of a reading and of the averaged force."""

import numpy as np
import pytest

from instron import Rig, scale
from instron.scaling.noise import last_digit, of_free_end
from instron.virtual import NOISES, STROKE, combing, hump, jams, white

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
