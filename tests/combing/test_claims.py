"""The paper's claims: each can hold and can fail, and its intervals are what they say."""

import numpy as np
import pandas as pd
import pytest

from combing.claims import Verdict, all_claims, judge
from combing.claims.measures import (
    exponent,
    mean,
    mean_correlation,
    rank_correlation,
    ratio_of_ends,
    ratio_of_fullness,
    share,
)
from combing.cost import cost, cost_table
from combing.figures.cost import draw_cost
from combing.tables import write_table
from sim.scene.presets import DoubleHelix

VALUES = {
    "pi1": (14, 18, 24, 36, 48), "pi2": (1, 1.5, 2, 3), "pi3": (1, 2, 4),
    "q": (2, 4, 8, 15, 25), "friction": (0.0, 0.1, 0.3), "N": (12, 13),
}  # fmt: skip


LEVELS = ("force_and_excess", "below_jams", "jump", "jump_growth", "jump_change", "behind",
          "expelled", "lead_of_pairs")  # fmt: skip


def curves(over, power=0.0, jams=0, plateaus=0, repeats=9, scatter=0.02, level=0.0, sense=0):
    rng = np.random.default_rng(0)
    values = np.repeat(VALUES[over], repeats).astype(float)
    noise = rng.standard_normal((len(LEVELS) + 3, len(values)))
    f_max = 10 * (values + (over == "friction")) ** power * np.exp(scatter * noise[0])
    columns = {name: level + scatter * one for name, one in zip(LEVELS, noise[3:], strict=True)}
    columns["w"] = 5 * f_max * (1 + values) ** level * np.exp(scatter * noise[1])
    columns["most_excess"] = sense * np.log(f_max) + 0.1 * scatter * noise[2]
    return pd.DataFrame({"set": "s", "over": over, "source": "simulation", "value": values,
                         "f_max": f_max, "jams": jams, "plateaus": plateaus,
                         "love_diverges": jams, **columns})  # fmt: skip


@pytest.mark.parametrize("name", all_claims())
def test_every_claim_is_stated_and_can_hold_and_can_fail(name):
    claim = all_claims()[name]
    assert claim.sentence.endswith(".")
    assert claim.where
    assert claim.over in {*DoubleHelix.model_fields, "N"}
    assert np.isfinite([claim.above, claim.below]).any()
    worlds = [
        curves(claim.over, power, count, count) for power in (-1.5, 0.0, 1.5) for count in (0, 1)
    ]
    worlds += [
        curves(claim.over, level=level, sense=sense)
        for level, sense in ((-1.0, -1), (0.0, 0), (0.95, 1), (1.5, 1))
    ]
    verdicts = {claim.verdict(claim.measure(world)) for world in worlds}
    if claim.by_definition:
        assert verdicts == {Verdict.DEFINITION}
    else:
        assert {Verdict.HOLDS, Verdict.FAILS} <= verdicts
    few = claim.verdict(claim.measure(curves(claim.over, repeats=1, scatter=1.0)))
    assert few in (Verdict.OPEN, Verdict.DEFINITION)


def test_a_claim_that_no_set_is_about_is_open():
    found = judge(curves("pi1", -2.0))
    about = found[found["set"] == "s"]
    over = {name.replace("_", " ") for name, one in all_claims().items() if one.over == "pi1"}
    assert set(about["claim"]) == over
    assert about.set_index("claim").loc["tighter pitch", "verdict"] == "holds"
    others = found[found["set"] != "s"]
    assert set(others["verdict"]) == {"cannot tell"}
    assert len(found) == len(all_claims())
    assert (judge(pd.DataFrame())["verdict"] == "cannot tell").all()


def test_interval_of_the_exponent_covers_the_truth_as_often_as_it_says():
    rng = np.random.default_rng(3)
    x = np.repeat([14.0, 18, 24, 36, 48], 5)
    covered = 0
    for _ in range(400):
        f = 100 * x**-1.7 * np.exp(0.2 * rng.standard_normal(len(x)))
        found = exponent(pd.DataFrame({"value": x, "f_max": f}))
        covered += found.low <= -1.7 <= found.high
    assert 0.92 <= covered / 400 <= 0.98


def test_ratio_and_share_of_known_curves():
    table = pd.DataFrame({"value": [1.0, 1, 2, 2], "f_max": [2.0, 2.2, 6.0, 6.6]})
    found = ratio_of_ends(table)
    assert found.value == pytest.approx(3)
    assert found.low < 3 < found.high
    table = pd.DataFrame({"value": [1.0] * 10 + [50.0], "jams": [0, 2, *[1] * 4, *[0] * 4, 9]})
    found = share("jams", lambda value: value < 20)(table)
    assert found.value == 0.5
    assert [found.low, found.high] == pytest.approx([0.1871, 0.8129], abs=1e-4)
    assert share("jams", lambda value: value > 90)(table) is None


def test_a_mean_of_correlations_stays_within_one():
    table = pd.DataFrame({"rho": [0.95, 0.9, 0.3, np.nan, 1.0]})
    found = mean_correlation("rho")(table)
    z = np.arctanh([0.95, 0.9, 0.3, 0.999])
    half = 3.1824 * np.std(z, ddof=1) / 2  # Student's t of 3
    expected = np.tanh([z.mean(), z.mean() - half, z.mean() + half])
    assert [found.value, found.low, found.high] == pytest.approx(expected, abs=1e-4)
    assert found.high < 1 < mean("rho")(table).high
    assert mean_correlation("none")(table) is None
    assert np.isnan(mean_correlation("rho")(table[:1]).low)


def test_mean_and_rank_correlation_of_known_curves():
    table = pd.DataFrame({"value": 1.0, "jump": [0.4, 0.5, 0.6, np.nan], "f_max": 1.0})
    found = mean("jump")(table)
    assert [found.value, found.low, found.high] == pytest.approx([0.5, 0.2516, 0.7484], abs=1e-4)
    assert mean("behind")(table) is None
    assert np.isnan(mean("jump")(table[:1]).low)
    rng = np.random.default_rng(4)
    covered = 0
    for _ in range(300):
        one, other = rng.multivariate_normal([0, 0], [[1, 0.6], [0.6, 1]], 30).T
        found = rank_correlation("a", "b")(pd.DataFrame({"a": one, "b": other}))
        covered += found.low <= 6 / np.pi * np.arcsin(0.3) <= found.high
    assert 0.91 <= covered / 300 <= 0.98
    assert rank_correlation("a", "b")(pd.DataFrame({"a": one[:4], "b": other[:4]})) is None


@pytest.mark.parametrize(("count", "low"), [(5, 0.3841), (8, 0.9298)])
def test_a_few_curves_in_perfect_order_do_not_tell_their_correlation_to_a_thousandth(count, low):
    """The interval holds the value, and narrows with the number of curves."""
    order = np.arange(count)
    found = rank_correlation("a", "b")(pd.DataFrame({"a": order, "b": -order}))
    assert found.value == found.low == pytest.approx(-1)
    assert found.high == pytest.approx(-low, abs=1e-4)


def test_friction_that_only_lifts_the_curve_keeps_its_fullness():
    table = pd.DataFrame({"value": [0.0, 0, 1, 1], "f_max": [1, 1.1, 3, 3.3]})
    table["w"] = [0.5, 0.56, 1.5, 1.63]
    assert ratio_of_fullness(table).value == pytest.approx(0.987, abs=0.005)


def test_cost_weighs_force_against_the_number_of_strokes():
    q = np.array([1.0, 5.0, 25.0])
    assert cost(q, q, 0.0) == pytest.approx([25, 5, 1])
    assert cost(q, q, 1.0) == pytest.approx(q)
    assert cost(q, q, 0.5) == pytest.approx([13, 5, 13])


def test_the_best_stroke_is_where_the_slope_of_the_cost_vanishes():
    """With f_max = a q^2 it is the cube root of (1 - gamma) q0/(2 a gamma)."""
    q = np.linspace(1, 25, 2401)
    table = cost_table(q, 0.02 * q**2)
    for gamma in (0.25, 0.5, 0.75):
        best = table.loc[table["gamma"] == gamma, "best"].iloc[0]
        assert best == pytest.approx(((1 - gamma) * 25 / (0.04 * gamma)) ** (1 / 3), abs=0.02)
    assert table.loc[table["gamma"] == 0, "best"].iloc[0] == 25
    assert table.loc[table["gamma"] == 1, "best"].iloc[0] == 1
    assert table["low"].isna().all()


def test_interval_of_the_cost_is_that_of_the_mean_force():
    rng = np.random.default_rng(1)
    q = np.repeat([2.0, 10.0, 25.0], 40)
    f = q + rng.standard_normal(len(q))
    table = cost_table(q, f).set_index(["gamma", "q"])
    for place in (2.0, 10.0, 25.0):
        own = f[q == place]
        low, high = own.mean() + np.array([-1.96, 1.96]) * own.std() / np.sqrt(40)
        row = table.loc[(1.0, place)]
        assert [row["low"], row["cost"], row["high"]] == pytest.approx(
            [low, own.mean(), high], abs=0.06
        )
        assert table.loc[(0.0, place), "high"] == pytest.approx(25 / place)


@pytest.mark.parametrize("count", [2, 5])
def test_interval_of_the_cost_of_a_few_curves_holds_the_true_cost_as_often_as_it_says(count):
    """A bootstrap of five curves would hold it in 84 %, of two in half of all cases."""
    rng = np.random.default_rng(7)
    q, held = np.repeat([2.0, 25.0], count), []
    for _ in range(400):
        table = cost_table(q, 3 * q + rng.standard_normal(len(q))).set_index(["gamma", "q"])
        row = table.loc[(0.5, 25.0)]
        held.append(row["low"] <= 0.5 * 75 + 0.5 <= row["high"])
    assert 0.92 <= np.mean(held) <= 0.98


def test_optimum_of_curves_that_differ_has_an_interval_and_of_clear_ones_none():
    """Pain alone: f_max of 1 and 1.05 with a scatter of 0.2 do not tell which stroke is best."""
    scatter = np.array([-0.2, -0.1, 0.0, 0.1, 0.2])
    q = np.repeat([2.0, 8.0], 5)
    near = cost_table(q, np.concatenate([1 + scatter, 1.05 + scatter])).set_index("gamma")
    assert near.loc[1.0, ["best", "best_low", "best_high"]].iloc[0].tolist() == [2, 2, 8]
    clear = cost_table(q, np.concatenate([1 + scatter, 9 + scatter])).set_index("gamma")
    assert clear.loc[1.0, ["best", "best_low", "best_high"]].iloc[0].tolist() == [2, 2, 2]


def test_figure_of_the_cost_draws_the_table_and_rings_the_best():
    q = np.array([2.0, 2.0, 8.0, 8.0, 25.0, 25.0])
    table = cost_table(q, q + np.array([0, 1, 0, 1, 0, 1])).assign(set="s", source="simulation")
    (panel,) = draw_cost(table, synthetic=False).axes
    rings = [one for one in panel.lines if one.get_markersize() == 8]
    for gamma, ring in zip(table["gamma"].unique(), rings, strict=True):
        own = table[table["gamma"] == gamma]
        (line,) = [one for one in panel.lines if one.get_label() == rf"$\gamma$ = {gamma:g}"]
        np.testing.assert_allclose(line.get_ydata(), own["cost"])
        assert ring.get_ydata().item() == own["cost"].min()


def test_the_command_says_the_verdict_first(tmp_path, capsys):
    from combing.cli import main

    write_table(tmp_path / "curves.csv", curves("pi1", -2.0), ["t"])
    with pytest.raises(SystemExit) as ended:
        main(["claims", str(tmp_path)])
    assert ended.value.code == 0
    said = capsys.readouterr().out
    assert "HOLDS: The tighter the pitch, the larger the force it takes to comb." in said
    assert "threshold below 0" in said
    with pytest.raises(SystemExit) as ended:
        main(["claims", str(tmp_path / "none")])
    assert ended.value.code == 2
    assert "`combing compare` writes it" in capsys.readouterr().err
