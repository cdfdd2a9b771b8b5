import numpy as np
import pandas as pd
import pytest

from instron import Rig, Unscalable, noise_of, scale, work

RIG = Rig(B=1e-4)
D, TOP = 0.08, 1.5


def combing(n=4000, noise=0.0, offset=0.0, start=0.0, seed=0, end=0.1):
    """Return a log whose force is a parabola with its peak TOP, zero from D on."""
    d = np.linspace(0, end, n)
    F = TOP * 4 * (d / D) * (1 - d / D) * (d < D)
    F = F + noise * np.random.default_rng(seed).standard_normal(n) + offset
    return pd.DataFrame({"time": d / 1e-3, "displacement": d + start, "force": F})


def exact_D(rig=RIG):
    """Where the parabola falls through the threshold: 4 x (1 - x) = end_fraction."""
    return D * (1 + np.sqrt(1 - rig.end_fraction)) / 2


def test_scaling_is_the_papers():
    curve = scale(combing(), RIG)
    assert curve.attrs["D"] == pytest.approx(exact_D(), rel=1e-4)
    np.testing.assert_allclose(curve["x"], curve["d"] / curve.attrs["D"])
    np.testing.assert_allclose(curve["f"], 0.01**2 * curve["F"] / 1e-4)
    # Averaged over a length, the top of a parabola loses (length / D)^2 / 3.
    lost = (RIG.averaging_length / D) ** 2 / 3
    assert curve.attrs["f_max"] == pytest.approx(TOP * (1 - lost), rel=1e-5)


def test_work_of_a_parabola():
    W, w = work(scale(combing(), RIG))
    x = exact_D() / D
    exact = TOP * D * 4 * (x**2 / 2 - x**3 / 3)
    assert pytest.approx(exact, rel=1e-4) == W
    assert w == pytest.approx(W * 1.0 / exact_D(), rel=1e-3)


@pytest.mark.parametrize("offset", [-3.0, 0.4, 10.4])
def test_offset_of_the_load_cell_and_start_of_the_crosshead_cancel(offset):
    plain, moved = scale(combing(), RIG), scale(combing(offset=offset, start=-0.794), RIG)
    np.testing.assert_allclose(moved[["x", "f"]], plain[["x", "f"]], atol=1e-9)


@pytest.mark.parametrize("signs", [(1, -1), (-1, 1), (-1, -1)])
def test_signs_of_machine_do_not_matter(signs):
    log = combing()
    log["displacement"] *= signs[0]
    log["force"] *= signs[1]
    np.testing.assert_allclose(scale(log, RIG)["f"], scale(combing(), RIG)["f"], atol=1e-12)


def test_drift_is_taken_off_by_its_rule():
    log = combing()
    log["force"] += np.linspace(0.1, 0.3, len(log))
    curve = scale(log, Rig(B=1e-4, zero="drift"))
    assert curve.attrs["f_max"] == pytest.approx(TOP, rel=0.02)


def test_a_returning_crosshead_is_cut_off():
    there = combing()
    back = there.iloc[::-1].assign(time=lambda t: 200 - t["time"], force=0.0)
    curve = scale(pd.concat([there, back]), RIG)
    assert len(curve) <= len(there) + 1
    assert curve.attrs["D"] == pytest.approx(exact_D(), rel=1e-4)


@pytest.mark.parametrize(("noise", "within"), [(0.0, 1e-4), (0.005, 0.03), (0.05, 0.12)])
def test_accuracy_ladder_of_D_with_noise(noise, within):
    curve = scale(combing(noise=noise), RIG)
    assert curve.attrs["D"] == pytest.approx(D, rel=within + 0.01)
    assert curve.attrs["D_low"] <= curve.attrs["D"] <= curve.attrs["D_high"]


@pytest.mark.parametrize("sigma", [0.001, 0.01, 0.1])
def test_noise_is_recovered(sigma):
    assert noise_of(combing(noise=sigma)["force"].to_numpy()) == pytest.approx(sigma, rel=0.1)


def test_noise_of_a_simulation_is_none():
    assert noise_of(combing()["force"].to_numpy()) < 1e-6 * TOP


def test_sampling_rate_does_not_matter():
    coarse, fine = (scale(combing(n=n, noise=0.01), RIG).attrs for n in (1000, 20000))
    for key, within in (("D", 0.01), ("W", 0.01), ("f_max", 0.05)):
        assert coarse[key] == pytest.approx(fine[key], rel=within)


def test_a_log_that_stops_early_says_so():
    notes = scale(combing(end=0.05), RIG).attrs["warnings"]
    assert any("stops before combing ends" in note for note in notes)
    assert any("own zero is kept" in note for note in notes)


def test_coarse_digits_are_flagged():
    log = combing()
    log["force"] = np.round(log["force"], 1)
    assert any("last digit" in note for note in scale(log, RIG).attrs["warnings"])
    assert not any("last digit" in note for note in scale(combing(), RIG).attrs["warnings"])


def test_compliance_shortens_the_displacement():
    curve = scale(combing(), Rig(B=1e-4, compliance=1e-3))
    stretched = combing()["displacement"].to_numpy() - 1e-3 * curve["F"].to_numpy()
    np.testing.assert_allclose(curve["d"], stretched - stretched[0], atol=1e-12)


def test_a_still_crosshead_and_a_forceless_log_are_refused():
    log = combing()
    with pytest.raises(Unscalable, match="does not move"):
        scale(log.assign(displacement=1.0), RIG)
    with pytest.raises(Unscalable, match="does not stand out"):
        scale(log.assign(force=0.0), RIG)
