"""Friction and factor from logs: against closed forms, and against simulated labs."""

import json
import sys

import numpy as np
import pandas as pd
import pytest
from click.testing import CliRunner
from scipy import stats

import instron
import sim
from combing.cli import combing
from combing.errors import UserError
from combing.fit.emulator import needs_sklearn, train
from combing.fit.plan import from_unit, load_fit
from combing.fit.posterior import CELLS, WHOLE, Measured, Posterior, posterior
from combing.fit.summaries import FORCE, LEVEL, SHAPE, Shot, of_curve

FRICTION, FACTOR = (0.0, 0.4), (0.05, 0.5)
NAMES = ("level", "shape", "other")
SD = np.array([0.05, 0.08, 0.02])
FIT = """\
logs = "lab_*.csv"
rig = "rig.toml"
friction = [0.0, 0.4]
factor = [0.04, 0.4]
points = 12
[fixed]
pi1 = 24
turns = 3
elements_per_pitch = 6
speed = 0.8
snapshots = 2
"""


@pytest.fixture(scope="module")
def linear():
    """Return an emulator of summaries that are straight over the unit square, and their means."""
    pytest.importorskip("sklearn")

    def mean(unit):
        log = np.log(FACTOR[0]) + unit[:, 1] * np.log(FACTOR[1] / FACTOR[0])
        return np.column_stack([unit[:, 0] + log, 0.5 * unit[:, 0], 1 + 0 * unit[:, 0]])

    rng = np.random.default_rng(3)
    unit = stats.qmc.LatinHypercube(2, rng=np.random.default_rng(0)).random(60)
    values = [at + SD * rng.standard_normal((4, 3)) for at in mean(unit)]
    return train(unit, values, NAMES, ["level"], tuple(np.log(FACTOR))), mean


def lab(values, specimens=3.0, error=0.0):
    return Measured(np.asarray(values), np.full(3, error), np.full(3, specimens))


def test_the_emulator_is_the_mean_and_the_scatter_of_its_members(linear):
    emulator, mean = linear
    unit = np.random.default_rng(5).random((50, 2))
    found, doubt = emulator.mean(unit)
    sd = np.sqrt(doubt[:, [0, 1, 2], [0, 1, 2]])
    assert np.abs(found - mean(unit)).max() < 0.6 * SD.max()
    assert np.mean(np.abs(found - mean(unit)) < 2 * sd) > 0.9
    assert np.sqrt(emulator.scatter(unit)[:, 0, 0]).mean() == pytest.approx(SD[0], rel=0.15)
    assert np.sqrt(emulator.scatter(unit)[:, 1, 1]).mean() == pytest.approx(SD[1], rel=0.15)


def test_the_posterior_of_straight_summaries_is_the_normal_one(linear):
    # level = u + log factor, shape = u/2: u = 2 shape, and log factor = level - u.
    emulator, mean = linear
    at = np.array([[0.5, 0.5]])
    found = posterior(emulator, lab(mean(at)[0], 10.0), FRICTION, FACTOR)
    friction, factor = found.axes
    middle = found.mass.sum(axis=1) @ friction
    sd = np.sqrt(found.mass.sum(axis=1) @ (friction - middle) ** 2)
    assert middle == pytest.approx(0.2, abs=0.4 * 2 * 0.08 / np.sqrt(10))
    assert sd == pytest.approx(0.4 * 2 * 0.08 / np.sqrt(10), rel=0.25)
    log = found.mass.sum(axis=0) @ np.log(factor)
    spread = np.sqrt(found.mass.sum(axis=0) @ (np.log(factor) - log) ** 2)
    assert spread == pytest.approx(np.hypot(2 * 0.08, 0.05) / np.sqrt(10), rel=0.25)
    assert found.correlation() == pytest.approx(-0.16 / np.hypot(0.16, 0.05), abs=0.05)
    ridge = found.ridge()  # log factor falls as u grows
    slope = np.polyfit(ridge[:, 0] / 0.4, np.log(ridge[:, 1]), 1)[0]
    assert slope == pytest.approx(-1, abs=0.1)


def test_twice_the_force_is_twice_the_factor(linear):
    emulator, mean = linear
    values = mean(np.array([[0.4, 0.3]]))[0]
    one = posterior(emulator, lab(values), FRICTION, FACTOR).intervals()
    two = posterior(emulator, lab(values + [np.log(2), 0, 0]), FRICTION, FACTOR).intervals()
    assert two[1].value / one[1].value == pytest.approx(2, rel=0.01)
    assert two[0].value == pytest.approx(one[0].value, abs=1e-3)


@pytest.mark.slow
def test_regions_hold_what_labs_were_drawn_with_as_often_as_they_say(linear):
    emulator, mean = linear
    rng = np.random.default_rng(11)
    held, ranks = 0, []
    for _ in range(150):
        unit = rng.random((1, 2))
        drawn = rng.multivariate_normal(mean(unit)[0], np.diag(SD**2) / 3)
        found = posterior(emulator, lab(drawn), FRICTION, FACTOR)
        (true,) = from_unit(unit, FRICTION, FACTOR)
        held += found.holds(*true)
        ranks.append(found.rank(*true))
    assert stats.binomtest(held, 150, 0.95).pvalue > 0.01
    for one in np.array(ranks).T:
        assert stats.kstest(one, "uniform").pvalue > 0.01


def test_data_that_say_nothing_leave_what_was_possible(linear):
    emulator, mean = linear
    values = mean(np.array([[0.5, 0.5]]))[0]
    found = posterior(emulator, lab(values, error=50.0), FRICTION, FACTOR)
    assert found.share == pytest.approx(0.95, abs=0.01)
    friction, factor = found.intervals()
    assert not any(
        [friction.bounded_below, friction.bounded_above, factor.bounded_below, factor.bounded_above]
    )
    assert (friction.low, friction.high) == pytest.approx((0.01, 0.39), abs=1e-3)
    assert factor.value == pytest.approx(np.sqrt(0.05 * 0.5), rel=0.01)
    # The level alone: a ridge from side to side, on which neither is bounded.
    level = posterior(emulator, lab(values), FRICTION, FACTOR, only=[0])
    assert not any([level.intervals()[0].bounded_below, level.intervals()[0].bounded_above])
    assert level.correlation() < -0.95


def test_a_sharp_posterior_is_drawn_in_upon():
    mass = np.full((CELLS, CELLS), 1 / CELLS**2)
    window = ((0.25, 0.5), (0.5, 0.6))
    found = Posterior(mass, FRICTION, FACTOR, window)
    assert found.axes[0][[0, -1]] == pytest.approx([0.1, 0.2], abs=2e-3)
    assert found.share == pytest.approx(0.95 * 0.025, rel=0.01)
    assert not found.holds(0.3, 0.17)
    assert found.rank(0.3, 0.01) == pytest.approx((1.0, 0.0))
    draws = found.draws(500, np.random.default_rng(0))
    assert (draws.min(axis=0) >= [0.25, 0.5]).all()
    assert (draws.max(axis=0) <= [0.5, 0.6]).all()
    whole = Posterior(mass, FRICTION, FACTOR, WHOLE)
    assert whole.rank(0.1, FACTOR[1])[0] == pytest.approx(0.25)


def curve(scale=1.0, width=0.04, stretch=1.0):
    """Return a scaled log of two jams."""
    d = np.linspace(0, 0.06 * stretch, 3000)
    jams = [np.clip((d - a) / (b - a), 0, 1) * (d < b) for a, b in ((0, 0.02), (0.021, width))]
    F = scale * (0.5 * jams[0] + 0.8 * jams[1])
    log = pd.DataFrame({"time": d, "displacement": d, "force": F})
    return instron.scale(log, instron.Rig(r=4.25e-4, E=2e8, zero="none"))


def test_summaries_are_of_the_force_in_newtons_and_of_its_shape():
    one, stronger = of_curve(curve()), of_curve(curve(3.0))
    for name in LEVEL:
        assert stronger[name] - one[name] == pytest.approx(np.log(3))
    for name in SHAPE:
        assert stronger[name] == pytest.approx(one[name], abs=1e-9)
    assert tuple(one) == FORCE
    assert np.exp(one["log D"]) == pytest.approx(0.04, rel=1e-3)
    # A ramp to 0.5 over 20 mm and one to 0.8 over 19: 12.6 mJ; two jams make three ways.
    assert np.exp(one["log mean force"]) == pytest.approx(0.0126 / 0.04, rel=0.01)
    assert np.exp(one["log spacing of jams"]) == pytest.approx(0.04 / 3, rel=1e-3)
    assert one["share of part 1"] == pytest.approx(0.1 / 0.315, rel=0.02)


def test_summaries_do_not_depend_on_the_rigs_young_modulus():
    log = curve()[["d", "F"]].rename(columns={"d": "displacement", "F": "force"})
    log.attrs = {}
    found = [
        of_curve(instron.scale(log, instron.Rig(r=4.25e-4, E=E, zero="none"))) for E in (1e8, 3e9)
    ]
    assert list(found[0].values()) == pytest.approx(list(found[1].values()))


def test_a_photograph_is_looked_at_where_it_shows_link():
    s = np.linspace(0, 0.04, 81)
    seen = pd.DataFrame({"s": s, "link": -130.0, "sd": 2.0})
    seen.loc[(s > 0.02) & (s < 0.03), "link"] = np.nan
    seen["sides"] = s < 0.012  # averaged otherwise
    seen.attrs["resolution"] = 0.004
    shot = Shot("one", 0.01, pitch=0.008, length=0.04, seen=seen)
    assert len(shot.names) == 2  # 24 mm is not resolved, 8 mm averaged otherwise
    assert shot.values == pytest.approx([130 * 0.008] * 2)
    assert shot.sd == pytest.approx([0.016] * 2)
    run = sim.simulate(sim.double_helix(pi1=24, turns=4, elements_per_pitch=6, speed=2.0))
    pitch = 24 * 4.25e-4
    before = Shot("before", 0.0, pitch=pitch, length=4 * pitch)
    assert dict(before.of(run))[before.names[1]] == pytest.approx(1, abs=0.15)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ("points = 3", "points: input should be greater than or equal to 12"),
        ("friction = [0.4, 0.1]", "friction: expected [lowest, highest], not [0.4, 0.1]"),
        ("friction = [-0.1, 0.1]", "friction: -0.1 is below 0"),
        ("factor = [0.0, 0.1]", "factor: 0 is not above 0"),
        ("logs = 'none_*.csv'", "no file matches"),
        ("[fixed]\nfriction = 0.2", "fixed: friction is what is fitted; give its range instead"),
        ("[fixed]\npi_1 = 2", "double_helix has no parameter 'pi_1'; did you mean 'pi1'?"),
        ("pionts = 20", "unknown key 'pionts'; did you mean 'points'?"),
        ("seeds = 1", "seeds: input should be greater than or equal to 2"),
    ],
)
def test_a_wrong_fit_file_gets_one_clear_line(tmp_path, change, said):
    (tmp_path / "rig.toml").write_text("r = 4.25e-4\nE = 2.8e9\n")
    (tmp_path / "lab_1.csv").write_text("")
    key = change.split()[0]
    rest = [line for line in FIT.partition("[fixed]")[0].splitlines() if line.split()[0] != key]
    (tmp_path / "fit.toml").write_text("\n".join([*rest, change]))
    with pytest.raises(UserError) as caught:
        load_fit(tmp_path / "fit.toml")
    assert said in str(caught.value)
    assert "\n" not in str(caught.value)


def test_without_scikit_learn_there_is_one_clear_line(monkeypatch):
    monkeypatch.setitem(sys.modules, "sklearn.gaussian_process", None)
    monkeypatch.setitem(sys.modules, "sklearn", None)
    with pytest.raises(UserError, match=r'needs scikit-learn: pip install "combing\[fit\]"'):
        needs_sklearn()


@pytest.mark.slow
def test_a_simulated_lab_is_found_again_and_nothing_is_simulated_twice(tmp_path, monkeypatch):
    pytest.importorskip("sklearn")
    (tmp_path / "rig.toml").write_text("r = 4.25e-4\nE = 2.8e9\n")
    (tmp_path / "fit.toml").write_text(FIT.replace("points = 12", "points = 16"))
    true = (0.25, 0.1)
    scene = {"pi1": 24, "turns": 3, "elements_per_pitch": 6, "speed": 0.8, "snapshots": 2}
    for seed in (101, 102):
        run = sim.simulate(
            sim.double_helix(**scene, friction=true[0], E=true[1] * 2.8e9, seed=seed,
                             imperfection=0.02)
        )  # fmt: skip
        instron.write_bluehill(tmp_path / f"lab_{seed}.csv", run.force_log())
    ask = ["fit", str(tmp_path / "fit.toml"), "-o", str(tmp_path / "out")]
    dry = CliRunner().invoke(combing, [*ask, "--dry-run"])
    assert "32 runs to simulate" in dry.output
    done = CliRunner().invoke(combing, [*ask, "--json"], catch_exceptions=False)
    found = json.loads(done.stdout)
    for name, value in zip(("friction", "factor"), true, strict=True):
        # Two specimens and 32 rough runs: within twice the half-width of its interval.
        low, high = found[name]["low"], found[name]["high"]
        assert low - (high - low) / 2 < value < high + (high - low) / 2
    files = {"fit.json", "fit.png", "fit.svg", "posterior.csv", "ridge.csv", "curve.csv"}
    assert files <= {path.name for path in (tmp_path / "out").iterdir()}
    monkeypatch.setattr(sim, "simulate", None)
    again = CliRunner().invoke(combing, [*ask, "--json"], catch_exceptions=False)
    assert json.loads(again.stdout) == found
