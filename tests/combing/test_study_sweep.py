"""A set of several values: what the study may say, and what is drawn of it."""

import json

import numpy as np
import pandas as pd
import pytest
from matplotlib.collections import PolyCollection
from matplotlib.container import ErrorbarContainer
from scipy import stats

from combing.compare.bench import compare
from combing.compare.sweep import compare_sweep, measure_sweep, rig_of
from combing.errors import UserError
from combing.figures.sweep import draw_sweep
from combing.study import load_study

R, E, D = 4.25e-4, 2.184e8, 0.08
PER_NEWTON = 1e-4 / (np.pi / 4 * E * R**4)
HEIGHTS = {14: (2.0, 2.6, 3.5), 24: (1.0, 1.1), 48: (0.4,)}  # N


def force(height, d):
    return height * np.sin(np.pi * np.clip(d / D, 0, 1)) ** 2


@pytest.fixture
def lab(tmp_path):
    d = np.linspace(0, 1.2 * D, 1201)
    for value, heights in HEIGHTS.items():
        for number, height in enumerate(heights, start=1):
            rows = [f"{50 * a:.5f},{1e3 * a:.6f},{b:.7f}"
                    for a, b in zip(d, force(height, d), strict=True)]  # fmt: skip
            text = "\n".join(["Time,Extension,Load", "(s),(mm),(N)", *rows, ""])
            (tmp_path / f"pi{value}_{number}.csv").write_text(text)
    (tmp_path / "rig.toml").write_text(
        f"r = {R}\nE = {E}\nzero = 'none'\nend_fraction = 1e-9\nend_sigma = 0\n"
    )

    def study(more, values="[14, 24, 48]"):
        text = f'title = "t"\n[[sweep]]\nname = "Pitch"\nover = "pi1"\nvalues = {values}\n'
        (tmp_path / "study.toml").write_text(text + more)
        return load_study(tmp_path / "study.toml")

    study.folder = tmp_path
    return study


LOGS = 'logs = "pi{value}_*.csv"\nrig = "rig.toml"\nsimulate = false\n'


def test_value_stands_for_each_value_in_the_names_of_files(lab):
    (one,) = lab(LOGS).sweep
    assert {value: len(paths) for value, paths in one.logs.items()} == {14: 3, 24: 2, 48: 1}
    assert one.logs[24][1].name == "pi24_2.csv"
    (lab.folder / "rig_14.toml").write_text(f"r = {R}\nE = {E}\n")
    (own,) = lab('logs="pi{value}_*.csv"\nrig="rig_{value}.toml"\n', "[14]").sweep
    assert own.rig[14].name == "rig_14.toml"


@pytest.mark.parametrize(
    ("more", "said"),
    [
        (LOGS.replace("{value}", "14"), "write {value} where the value stands in the names"),
        (LOGS.replace("{value}", "1*{value}"), "no file matches"),
        (LOGS.replace("pi{value}_*", "pi{value}*"), ""),
        (LOGS.replace('rig = "rig.toml"\n', ""), "rig: the logs need one"),
        ("simulate = false\n", "nothing to draw"),
        (LOGS + "representative = 20\n", "representative = 20 is not among the values"),
        (LOGS + "fixed = { pi1 = 3 }\n", "pi1 is in over and in fixed"),
        (LOGS + "fixed = { hight = 3 }\n", "no parameter 'hight'; did you mean 'height'?"),
        (LOGS + "fixed = { pi2 = 0.1 }\n", "pi2 = 0.1: Input should be greater than or equal to 1"),
        (LOGS + "sed = 3\n", "[[sweep]] 1: unknown key 'sed'; did you mean 'seeds'?"),
    ],
)  # fmt: skip
def test_a_wrong_set_gets_one_clear_line(lab, more, said):
    if not said:
        assert lab(more).sweep
        return
    with pytest.raises(UserError) as caught:
        lab(more)
    assert said in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_log_that_is_caught_for_two_values_is_refused(lab):
    (lab.folder / "pi1_1.csv").write_text("x")
    with pytest.raises(
        UserError, match=r"pi14_1\.csv is named by 'pi1\*\.csv' and by 'pi14\*\.csv"
    ):
        lab(LOGS.replace("{value}_*", "{value}*"), "[1, 14]")


def test_one_rig_for_all_takes_the_helix_from_the_parameters(lab):
    (one,) = lab(LOGS + "fixed = { height = 0.12, pi2 = 1.5 }\n").sweep
    for value in (14, 48):
        rig = rig_of(one, value)
        assert rig.pitch == pytest.approx(value * R)
        assert rig.helix_radius == pytest.approx(1.5 * R)
        assert rig.turns == pytest.approx(0.12 / (value * R))
        assert pytest.approx(E) == rig.E


@pytest.fixture
def found(lab):
    (one,) = lab(LOGS + "representative = 14\n").sweep
    return compare_sweep(one, measure_sweep(one), {})


def test_every_number_of_the_table_is_that_of_the_closed_form(found):
    plotted = found.plotted[found.plotted["source"] == "experiment"]
    for value, heights in HEIGHTS.items():
        own = plotted[plotted["value"] == value].set_index("curve")
        mean, one, peak = (own.loc[[name]] for name in ("mean", "representative", "f_max"))
        true = PER_NEWTON * force(1.0, mean["x"].to_numpy() * D)
        near = 0.02 * PER_NEWTON
        np.testing.assert_allclose(mean["f"], np.mean(heights) * true, atol=near)
        sd = np.std(heights, ddof=1) if len(heights) > 1 else np.nan
        np.testing.assert_allclose(mean["high"] - mean["f"], sd * true, atol=near)
        np.testing.assert_allclose(mean["f"] - mean["low"], sd * true, atol=near)
        middle = {14: 2.6, 24: 1.0, 48: 0.4}[value]
        np.testing.assert_allclose(one["f"], middle * true, atol=near)
        assert peak["x"].item() == value
        assert peak["f"].item() == pytest.approx(PER_NEWTON * np.mean(heights), rel=0.02)
        if len(heights) > 1:
            low, high = stats.t.interval(
                0.95, len(heights) - 1, np.mean(heights), stats.sem(heights)
            )
            both = peak[["low", "high"]].to_numpy().ravel()
            np.testing.assert_allclose(both, PER_NEWTON * np.array([low, high]), rtol=0.03)
    heights = [height for heights in HEIGHTS.values() for height in heights]
    np.testing.assert_allclose(found.curves["f_max"], PER_NEWTON * np.array(heights), rtol=0.02)
    np.testing.assert_allclose(found.curves["D (m)"], D, rtol=0.005)
    # Smooth humps: the force falls slowly, so none is a jam that is released at once.
    assert (found.curves["jams"] == 0).all()
    (table,) = (table for _, table in found.numbers)
    assert table["curves"].tolist() == [3, 2, 1]
    assert table["D (m)"].to_numpy() == pytest.approx(D, rel=0.005)


def test_the_figure_draws_the_table(found):
    left, right = draw_sweep(found.plotted, synthetic=False).axes[:2]
    table = found.plotted
    bands = [one for one in left.collections if isinstance(one, PolyCollection)]
    assert len(bands) == 3
    for value, band in zip(HEIGHTS, bands, strict=True):
        mean = table[(table["value"] == value) & (table["curve"] == "mean")]
        (line,) = [one for one in left.lines if one.get_label() == f"{value}"]
        np.testing.assert_allclose(line.get_ydata(), mean["f"])
        if len(HEIGHTS[value]) > 1:
            corners = pd.DataFrame(band.get_paths()[0].vertices, columns=["x", "y"]).round(9)
            spread = corners.groupby("x")["y"].agg(np.ptp).to_numpy()
            np.testing.assert_allclose(spread, mean["high"] - mean["low"], atol=1e-9)
    black = [one for one in left.lines if one.get_color() == "black" and len(one.get_xdata())]
    one = table[(table["value"] == 14) & (table["curve"] == "representative")]
    np.testing.assert_allclose(black[0].get_ydata(), one["f"])
    assert len(black) == 1
    dashed = [one for one in left.lines if one.is_dashed() and len(one.get_xdata())]
    love = table[table["source"] == "theory"]
    np.testing.assert_allclose(np.concatenate([one.get_ydata() for one in dashed]), love["f"])
    seen = table[table["source"] != "theory"]
    low, high = left.get_ylim()
    assert 1 < high / max(seen["f"].max(), seen["high"].max()) < 1.3  # Love's curve runs off
    assert -0.1 * high < low <= 0
    assert left.get_xlim() == (0, 1.1)
    bars = [one for one in right.containers if isinstance(one, ErrorbarContainer)]
    heights = [one.lines[0].get_ydata().item() for one in bars]
    peaks = table[table["curve"] == "f_max"]
    np.testing.assert_allclose(heights, peaks["f"])
    whiskers = [np.ptp(one.lines[2][0].get_segments()[0][:, 1]) for one in bars[:2]]
    np.testing.assert_allclose(whiskers, (peaks["high"] - peaks["low"]).iloc[:2])


def test_a_copy_under_another_value_is_refused(lab):
    text = (lab.folder / "pi14_2.csv").read_text()
    (lab.folder / "pi48_2.csv").write_text(text)
    with pytest.raises(UserError, match="would count twice"):
        compare(lab(LOGS), lab.folder / "out", quiet=True)


def test_rigs_of_another_helix_than_the_value_are_refused(lab):
    for value in (14, 24, 48):
        (lab.folder / f"rig_{value}.toml").write_text(f"r = {R}\nE = {E}\npitch = {14 * R}\n")
    with pytest.raises(UserError, match="P = 0.00595 m in rig_24.toml but P = 0.0102 m in pi1 ="):
        compare(lab(LOGS.replace("rig.toml", "rig_{value}.toml")), lab.folder / "out", quiet=True)


def test_simulations_alone_are_an_ensemble_a_value(lab):
    study = lab(
        "seeds = 2\nfixed = { turns = 3, elements_per_pitch = 6, speed = 0.5, snapshots = 2 }\n",
        "[18, 24]",
    )
    out = lab.folder / "out"
    compare(study, out, jobs=1, quiet=True)
    assert len(list((out / "runs").glob("*.nc"))) == 4
    plotted = pd.read_csv(out / "sweep_1.csv", comment="#")
    assert set(plotted["source"]) == {"simulation", "theory"}
    summary = json.loads((out / "summary.json").read_text(encoding="utf-8"))
    assert summary["sets"][0] | {"kind": "sweep", "set": "Pitch", "runs": 4} == summary["sets"][0]
    peaks = plotted[plotted["curve"] == "f_max"]
    assert (peaks["low"] < peaks["f"]).all()
    assert "draws of 2%" in (out / "report.html").read_text(encoding="utf-8")
    assert (out / "sweep_1.svg").is_file()
    verdicts = pd.read_csv(out / "claims.csv", comment="#").set_index("claim")
    assert verdicts.loc["tighter pitch", "curves"] == 4
    assert len(pd.read_csv(out / "curves.csv", comment="#")) == 4


def test_strokes_of_several_lengths_get_a_figure_of_their_cost(lab):
    lab(LOGS + "fixed = { turns = 50 }\n")
    path = lab.folder / "study.toml"
    path.write_text(path.read_text().replace('over = "pi1"', 'over = "q"'))
    out = lab.folder / "out"
    compare(load_study(path), out, quiet=True)
    cost = pd.read_csv(out / "cost.csv", comment="#")
    strokes = cost[cost["gamma"] == 0].set_index("q")["cost"]
    assert strokes.to_dict() == pytest.approx({q: 25 / q for q in HEIGHTS})
    pain = cost[cost["gamma"] == 1].set_index("q")["cost"]
    assert pain[14] == pytest.approx(PER_NEWTON * np.mean(HEIGHTS[14]), rel=0.02)
    assert "Cost of combing" in (out / "report.html").read_text(encoding="utf-8")
