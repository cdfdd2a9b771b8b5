"""f_max of made logs: what noise adds to a maximum is taken off, and its interval covers."""

import numpy as np
import pytest

from instron import Rig, averaged, on_grid, scale
from instron.scaling.average import profile
from instron.scaling.peak import highest
from instron.virtual import SHAPES, STROKE, combing, hump, plateau

RIG = Rig(r=4.25e-4, E=2.8e9)


def f_max(log, rig=RIG):
    found = scale(log, rig).attrs
    return found["f_max"], found["f_max_low"], found["f_max_high"]


@pytest.mark.parametrize("name", SHAPES)
@pytest.mark.parametrize(("sd", "rows", "bias"), [(0.02, 2000, 0.01), (0.06, 6000, 0.015)])
def test_bias_and_coverage(name, sd, rows, bias):
    true = f_max(combing(SHAPES[name], 100_000))[0]
    found = np.array([f_max(combing(SHAPES[name], rows, sd=sd, rng=s)) for s in range(25)])
    assert found[:, 0].mean() == pytest.approx(true, rel=bias)
    assert np.mean((found[:, 1] <= true) & (true <= found[:, 2])) >= 0.84


def test_a_plain_maximum_would_be_too_high():
    log = combing(plateau, 2000, sd=0.06, rng=0)
    true = f_max(combing(plateau, 100_000))[0]
    assert averaged(scale(log, RIG))["f"].max() > 1.02 * true
    assert f_max(log)[0] < averaged(scale(log, RIG))["f"].max()
    assert f_max(log)[1] < true < f_max(log)[2]


def test_without_noise_it_is_the_highest_average():
    curve = scale(combing(hump, 6000), RIG)
    assert curve.attrs["f_max"] == curve.attrs["f_max_low"] == curve.attrs["f_max_high"]
    assert curve.attrs["f_max"] == pytest.approx(averaged(curve)["f"].max(), rel=1e-6)
    grid = np.linspace(0, 1, 501)
    assert curve.attrs["f_max"] == pytest.approx(on_grid(curve, grid).max(), rel=1e-3)


def test_a_spike_shorter_than_the_length_does_not_count_in_full():
    log = combing(hump, 6000)
    log.loc[2000:2010, "force"] *= 2  # 0.1 mm of 1.3
    assert f_max(log)[0] < 1.1 * f_max(combing(hump, 6000))[0]


def test_the_rig_may_name_the_length():
    log = combing(SHAPES["jams"], 6000)
    long = f_max(log, Rig(r=4.25e-4, E=2.8e9, average_over=4e-3))[0]
    assert long < 0.8 * f_max(log)[0]


def test_a_coarser_sampling_is_said():
    notes = scale(combing(hump, 30), RIG).attrs["warnings"]
    assert any("coarser than the averaging length" in note for note in notes)
    assert scale(combing(hump, 30), RIG).attrs["average_over"] == pytest.approx(STROKE / 29)


def test_sampling_rate_does_not_matter():
    found = [f_max(combing(SHAPES["teeth"], rows, sd=0.01, rng=1))[0] for rows in (600, 60_000)]
    assert found[0] == pytest.approx(found[1], rel=0.02)


def test_the_average_of_a_line_is_the_line_and_work_is_kept():
    rng = np.random.default_rng(0)
    d = np.sort(rng.uniform(0, 1, 500))
    source = profile(d, 3 * d)
    at = np.linspace(0.2, 0.8, 50)
    np.testing.assert_allclose(source.mean(at, 0.1), 3 * at, rtol=0.02)
    shuffled = rng.permutation(500)
    np.testing.assert_array_equal(profile(d[shuffled], 3 * d[shuffled]).area, source.area)


def test_the_correction_is_that_of_a_flat_force():
    """Of a constant with noise the corrected maximum is right; the plain one is 2 to 3 sd high."""
    rng = np.random.default_rng(0)
    kernel = np.ones(16) / 4  # white noise averaged over 16 places, sd 1
    made = [np.convolve(rng.standard_normal(1015), kernel, "valid") for _ in range(40)]
    assert np.mean([F.max() for F in made]) > 2.2
    assert np.mean([highest(F, 1.0).F for F in made]) == pytest.approx(0, abs=0.8)
