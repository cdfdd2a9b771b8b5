"""What is drawn and written is what was measured: every artist against a value computed apart.

A density doubled on its way to the figure, a band of three sd, a representative at half height look
as good as the true ones; these tests know the numbers.
"""

import json

import numpy as np
import pandas as pd
import pytest
from matplotlib import colormaps
from matplotlib.collections import PolyCollection
from matplotlib.container import BarContainer, ErrorbarContainer

from combing.compare.bench import compare
from combing.compare.curl import compare_curl, count_interactions
from combing.compare.link import compare_link
from combing.figures.change import draw_change
from combing.figures.composite import draw_composite
from combing.figures.errors import draw_errors
from combing.figures.force import draw_force
from combing.figures.interactions import draw_interactions
from combing.figures.link import draw_link
from combing.study import CurlSet, LinkSet, load_study

R, E, L0, D = 4.25e-4, 2.184e8, 0.01, 0.08
B = np.pi / 4 * E * R**4
HEIGHTS = (1.0, 2.0, 3.5)  # N; the second is nearest to both others


def shape(x):
    """Return a force that is zero at both ends and 1 at x = 1/2."""
    return np.sin(np.pi * np.clip(x, 0, 1)) ** 2


@pytest.fixture(scope="module")
def study(tmp_path_factory):
    folder = tmp_path_factory.mktemp("closed_form")
    d = np.linspace(0, 1.2 * D, 2401)
    for number, height in enumerate(HEIGHTS, start=1):
        force = height * shape(d / D)
        rows = [f"{50 * a:.5f},{1e3 * a:.6f},{b:.7f}" for a, b in zip(d, force, strict=True)]
        text = "\n".join(["Time,Extension,Load", "(s),(mm),(N)", *rows, ""])
        (folder / f"log{number}.csv").write_text(text)
    # With a threshold of nothing, D is where the force is zero: a number known beforehand.
    (folder / "rig.toml").write_text(
        f"r = {R}\nE = {E}\nzero = 'none'\nend_fraction = 1e-9\nend_sigma = 0\n"
        "pitch = 0.00765\nhelix_radius = 4.25e-4\nturns = 20\n"
    )
    text = 'title = "t"\n[[force]]\nname = "a"\nlogs = "log*.csv"\nrig = "rig.toml"\n'
    (folder / "study.toml").write_text(text)
    compare(load_study(folder / "study.toml"), folder / "out", quiet=True)
    return folder / "out"


@pytest.fixture(scope="module")
def force(study):
    return pd.read_csv(study / "force.csv", comment="#")


def per_newton():
    return L0**2 / B


def rows(force, source, curve):
    return force[(force["source"] == source) & (force["curve"] == curve)]


def test_mean_and_sd_of_repeats_are_those_of_the_closed_form(force):
    mean = rows(force, "experiment", "mean")
    true = per_newton() * shape(mean["x"])
    np.testing.assert_allclose(mean["f"], np.mean(HEIGHTS) * true, atol=0.01 * true.max())
    sd = np.std(HEIGHTS, ddof=1) * true
    np.testing.assert_allclose(mean["high"] - mean["f"], sd, atol=0.01 * true.max())
    np.testing.assert_allclose(mean["f"] - mean["low"], sd, atol=0.01 * true.max())


def test_the_representative_is_one_of_the_repeats_at_its_own_height(force):
    one = rows(force, "experiment", "representative")
    np.testing.assert_allclose(
        one["f"], HEIGHTS[1] * per_newton() * shape(one["x"]), atol=0.02 * per_newton()
    )


def test_love_is_drawn_over_the_mean_distance(force):
    """Force that holds a helix of contour length L stretched by d, from Love's formula again."""
    for ends in ("free", "blocked"):
        drawn = rows(force, "theory", ends)
        x, f = drawn["x"].to_numpy(), drawn["f"].to_numpy()
        alpha = np.arctan2(0.00765, 2 * np.pi * R)
        contour = 20 * 0.00765 / np.sin(alpha)
        a1 = np.arcsin(np.sin(alpha) + x * D / contour)
        C = B / 1.5
        kappa, tau = np.cos(alpha) ** 2 / R, np.sin(alpha) * np.cos(alpha) / R
        s, c = np.sin(a1), np.cos(a1)
        R1 = R * c / np.cos(alpha)
        if ends == "free":
            R1 = c * (C * s**2 + B * c**2) / (C * s * tau + B * c * kappa)
        F = (C * c * (s * c / R1 - tau) - B * s * (c**2 / R1 - kappa)) / R1
        near = f > 0.02 * f.max()
        np.testing.assert_allclose(f[near], (per_newton() * F)[near], rtol=0.03)


def test_table_of_peaks_holds_the_closed_form(study):
    summary = json.loads((study / "summary.json").read_text(encoding="utf-8"))
    table = pd.DataFrame(summary["tables"]["force"]["Force peak, work and distance"])
    assert len(table) == len(HEIGHTS) + 1
    each, mean = table.iloc[:-1], table.iloc[-1]
    heights = np.array(HEIGHTS) * per_newton()
    np.testing.assert_allclose(each["f_max"], heights, rtol=0.01)
    np.testing.assert_allclose(each["w"], heights / 2, rtol=0.005)
    np.testing.assert_allclose(each["D (m)"], D, rtol=0.005)
    np.testing.assert_allclose(each["x of f_max"], 0.5, atol=0.05)
    assert (each["jams and peaks"] == 1).all()
    for column in ("f_max", "w", "D (m)"):
        assert mean[column] == pytest.approx(each[column].mean(), rel=1e-9)


def band(panel):
    """Return x, low and high of a filled band."""
    (area,) = [one for one in panel.collections if isinstance(one, PolyCollection)]
    (path,) = area.get_paths()
    table = pd.DataFrame(path.vertices, columns=["x", "y"]).round(12)
    both = table.groupby("x")["y"].agg(["min", "max"])
    return both.index.to_numpy(), both["min"].to_numpy(), both["max"].to_numpy()


def line(panel, label):
    (found,) = [one for one in panel.lines if one.get_label() == label]
    return found.get_xdata(), found.get_ydata()


def test_force_figure_draws_the_table():
    x = np.linspace(0, 1, 11)
    parts = {
        ("experiment", "mean"): (x, 5 * x, 3 * x, 7.5 * x),
        ("experiment", "representative"): (x, 4 * x, np.nan, np.nan),
        ("simulation", "run"): (x, 6 * x, np.nan, np.nan),
        ("theory", "free"): (x / 2, 9 * x, np.nan, np.nan),
    }
    table = pd.concat(
        pd.DataFrame({"set": "a", "source": source, "curve": curve, "x": x, "f": f, "low": low,
                      "high": high})
        for (source, curve), (x, f, low, high) in parts.items()
    )  # fmt: skip
    (panel,) = draw_force(table, synthetic=False).axes
    at, low, high = band(panel)
    np.testing.assert_allclose(low, 3 * at)
    np.testing.assert_allclose(high, 7.5 * at)
    np.testing.assert_allclose(line(panel, "experiment, one repeat")[1], 4 * x)
    np.testing.assert_allclose(line(panel, "simulation")[1], 6 * x)
    np.testing.assert_allclose(line(panel, "single helix, free ends"), [x / 2, 9 * x])
    means = [one.get_ydata() for one in panel.lines if str(one.get_label()).startswith("_")]
    np.testing.assert_allclose(means, [5 * x])
    assert panel.get_ylim()[1] >= 7.5


def braid(turns):
    """Return two strands that cross `2 turns` times in 0.1 m."""
    s = np.linspace(0.0, 0.1, 800)
    wave = 0.002 * np.sin(2 * np.pi * turns * s / 0.1 + 0.3)
    return [np.column_stack([wave, s]), np.column_stack([-wave, s])]


@pytest.fixture(scope="module")
def curls():
    """Curls of 4, 6 and 11 turns: 8, 12 and 20 pairs in 20 sections of 0.1 m (22 crossings)."""
    found = [count_interactions(braid(turns), 1.0, 20) for turns in (4, 6, 9)]
    for number, one in enumerate(found):
        one.attrs |= {"sample": f"c{number}", "synthetic": False}
    chosen = CurlSet.model_construct(name="c", strands=None, simulations=None, truth=None)
    return compare_curl(chosen, found, {}, 20)


def test_density_is_the_count_of_crossings_over_the_length_of_the_curl(curls):
    """A section with one crossing or more is one interaction of the two strands."""
    pairs = curls.plotted[curls.plotted["N"] == 2].set_index("sample")
    for sample, turns in (("c0", 4), ("c1", 6), ("c2", 9)):
        s = (np.arange(2 * turns) + 1) / 2 - 0.3 / (2 * np.pi)
        at = 0.1 * s[(s > 0) & (s < turns)] / turns
        sections = len(np.unique(np.floor(at / 0.005)))
        assert pairs.loc[sample, "count"] == sections
        assert pairs.loc[sample, "density"] == pytest.approx(sections / 0.1, rel=0.01)


@pytest.mark.parametrize("unit", [1.0, 5e-5])
def test_density_of_a_section_is_its_count_over_its_length(unit):
    lines = [line / unit for line in braid(6)]
    found = count_interactions(lines, unit, 20)
    np.testing.assert_allclose(found["density"], found["count"] / (0.1 / 20), rtol=0.01)


def test_table_of_densities_holds_mean_and_sample_sd(curls):
    table = dict(curls.numbers)["Mean density of N-body interactions (1/m)"].set_index("N")
    densities = curls.plotted.loc[curls.plotted["N"] == 2, "density"].to_numpy()
    a, b, c = densities
    mean = (a + b + c) / 3
    spread = (((a - mean) ** 2 + (b - mean) ** 2 + (c - mean) ** 2) / 2) ** 0.5
    assert table.loc[2, "experiment"] == pytest.approx(mean)
    assert table.loc[2, "experiment, sd over curls"] == pytest.approx(spread)


def test_histogram_draws_densities_and_their_sd(curls):
    (panel,) = draw_interactions(curls.plotted, n_sec=20, synthetic=False).axes
    densities = curls.plotted.pivot(index="N", columns="sample", values="density")
    (bars,) = [one for one in panel.containers if isinstance(one, BarContainer)]
    heights = [bar.get_height() for bar in bars]
    np.testing.assert_allclose(heights, densities.sum(axis=1) / 3)
    (whiskers,) = [one for one in panel.containers if isinstance(one, ErrorbarContainer)]
    segments = np.array(whiskers.lines[2][0].get_segments())
    assert np.diff(segments[:, :, 1]).ravel() == pytest.approx(2 * np.sqrt(densities.var(axis=1)))
    middles = [bar.get_x() + bar.get_width() / 2 for bar in bars]
    np.testing.assert_allclose(middles, densities.index)
    np.testing.assert_allclose(segments[:, 0, 0], middles)
    assert panel.get_ylim()[0] == 0
    dots = [one.get_ydata() for one in panel.lines if one.get_marker() == "."]
    np.testing.assert_allclose(dots, densities.T)


def test_one_curl_alone_has_its_interval_over_sections_and_two_sources_stand_side_by_side(curls):
    one = curls.plotted[curls.plotted["sample"] == "c0"]
    both = pd.concat([one, one.assign(source="simulation")])
    (panel,) = draw_interactions(both, n_sec=20, synthetic=False).axes
    bars = [one for one in panel.containers if isinstance(one, BarContainer)]
    middles = [[bar.get_x() + bar.get_width() / 2 for bar in own] for own in bars]
    np.testing.assert_allclose(middles, [one["N"] - 0.2, one["N"] + 0.2])
    whiskers = [each for each in panel.containers if isinstance(each, ErrorbarContainer)]
    for each in whiskers:
        segments = np.array(each.lines[2][0].get_segments())
        np.testing.assert_allclose(segments[:, :, 1].T, [one["low"], one["high"]])
    sections = count_interactions(braid(4), 1.0, 20).query("N == 2")["density"]
    half = 2.0930 * sections.std(ddof=1) / 20**0.5  # Student, 19 degrees of freedom, 95 %
    pairs = one[one["N"] == 2].iloc[0]
    assert pairs["high"] - pairs["density"] == pytest.approx(half, rel=1e-4)
    assert pairs["density"] - pairs["low"] == pytest.approx(half, rel=1e-4)


def seen(link, sd, photo):
    s = np.linspace(0, 0.1, 41)
    table = pd.DataFrame({"s": s, "link": np.full(41, link), "sd": np.full(41, sd)})
    table.attrs = {"photo": photo, "resolution": 0.005, "lean": 0.1, "warnings": []}
    table.attrs |= {"synthetic": False, "total_link": 0.1 * link, "R": 4e-4, "r": 4e-4}
    none = {"jump": np.nan}
    table.attrs |= {"first": (link, sd), "jump": lambda lambda_0: none}
    return table


def test_link_figure_draws_the_band_of_one_sd_the_reference_and_the_position(tmp_path):
    chosen = LinkSet.model_construct(
        name="a", photos=[tmp_path / "p.jpg"], positions=[0.037], simulation=None, truth=None,
        before=None, photograph_simulation=False,
    )  # fmt: skip
    found = compare_link(chosen, seen(100.0, 1.0, "before"), [seen(140.0, 2.5, "p")], {})
    (row,) = dict(found.numbers)["Link density"].to_dict("records")
    assert row["λ, experiment (1/m)"] == pytest.approx(140)
    assert row["lean (°)"] == pytest.approx(np.degrees(0.1))
    figure = draw_link(found.plotted.assign(tine=0.045), synthetic=False)
    panel = figure.axes[0]
    at, low, high = band(panel)
    np.testing.assert_allclose(at, 1e3 * np.linspace(0, 0.1, 41))
    np.testing.assert_allclose(low, 137.5)
    np.testing.assert_allclose(high, 142.5)
    np.testing.assert_allclose(line(panel, "experiment ± sd")[1], 140)
    plain = [one for one in panel.lines if str(one.get_label()).startswith("_")]
    reference, tine = plain
    np.testing.assert_allclose(reference.get_ydata(), 100)
    np.testing.assert_allclose(tine.get_xdata(), 45)
    assert panel.get_title(loc="left") == "a, $d$ = 37 mm"


def change_rows(source, curve, x, s, change, sd):
    return pd.DataFrame(
        {"set": "a", "source": source, "curve": curve, "d": 0.1 * x, "x": x, "s": s,
         "change": change, "sd": sd}
    )  # fmt: skip


@pytest.mark.parametrize("scaled", [True, False])
def test_change_figure_draws_profiles_and_jumps(scaled):
    s = np.linspace(0.02, 0.1, 9)
    table = pd.concat([
        change_rows("experiment", "profile", 0.3, s, 2 * s, 0.1 * s),
        change_rows("experiment", "jump", 0.5, [np.nan], 0.9, 0.2),
        change_rows("experiment", "jump", 0.3, [np.nan], 0.8, 0.05),
        change_rows("simulation", "profile", 0.3, s, 3 * s, 0.0),
        change_rows("simulation", "jump", np.array([0.4, 0.2, 0.5]), np.nan,
                    np.array([0.4, 0.1, 0.7]), 0.0),
    ])  # fmt: skip
    if not scaled:
        table["x"] = np.nan
    left, right, below, beside = draw_change(table, synthetic=False).axes[:4]
    (profile,) = (one for one in left.lines if len(one.get_xdata()) == 9)
    np.testing.assert_allclose(profile.get_xdata(), 1e3 * s)
    np.testing.assert_allclose(profile.get_ydata(), 2 * s)
    place = 0.3 if scaled else 0.6  # of the way, or of the last place of a tine
    assert profile.get_color() == colormaps["viridis"](0.92 * place)
    for panel in (left, right):
        (level,) = [one for one in panel.lines if list(one.get_xdata()) == [0, 1]]
        assert list(level.get_ydata()) == [0, 0]
    assert (below.get_xlabel(), beside.get_xlabel()) == (
        "$s$ (mm)", "$x = d/D$" if scaled else "$d$ (mm)",
    )  # fmt: skip
    areas = [one for one in left.collections if isinstance(one, PolyCollection)]
    corners = np.concatenate([one.get_paths()[0].vertices for one in areas])
    heights = {(round(x, 6), round(y, 6)) for x, y in corners}
    for x in s:
        assert {(round(1e3 * x, 6), round(k * x, 6)) for k in (1.9, 2.1)} <= heights
    (jumps,) = [one for one in right.containers if isinstance(one, ErrorbarContainer)]
    places = np.array([0.3, 0.5]) if scaled else np.array([30.0, 50.0])
    np.testing.assert_allclose(jumps.lines[0].get_xydata(), np.transpose([places, [0.8, 0.9]]))
    ends = np.array(jumps.lines[2][0].get_segments())[:, :, 1]
    np.testing.assert_allclose(ends, [[0.75, 0.85], [0.7, 1.1]])
    drawn = [one for one in beside.lines if len(one.get_xdata()) == 3]
    np.testing.assert_allclose(drawn[0].get_xydata()[:, 1], [0.1, 0.4, 0.7])
    assert (left.get_title(loc="left"), below.get_title(loc="left")) == (
        "experiment", "simulation",
    )  # fmt: skip
    assert left.get_ylim() == below.get_ylim()
    everything = table.loc[table["curve"] == "profile", "change"]
    assert left.get_ylim()[1] > everything.quantile(0.99)
    assert left.get_ylim()[1] < 1.5 * everything.max()
    assert -0.15 < left.get_ylim()[0] <= -0.1
    assert right.get_xlim()[1] >= (1.0 if scaled else 50.0)


def test_composite_draws_the_numbers_of_each_kind_experiment_over_simulation(curls):
    x, s = np.linspace(0, 1, 11), np.linspace(0.02, 0.1, 9)
    force = pd.concat(
        pd.DataFrame({"set": "a", "source": source, "curve": curve, "x": x, "f": height * x,
                      "low": height * x - 1, "high": height * x + 1})
        for source, curve, height in (("experiment", "mean", 5), ("simulation", "run", 6),
                                      ("experiment", "representative", 4))
    )  # fmt: skip
    change = pd.concat([change_rows("experiment", "profile", 0.3, s, 2 * s, 0.0),
                        change_rows("simulation", "profile", 0.3, s, 3 * s, 0.0)])  # fmt: skip
    bodies = curls.plotted.assign(set="c")
    tables = {"force": force, "change": change, "interactions": bodies}
    axes = np.reshape(draw_composite(tables, synthetic=False).axes, (2, 3))
    heights = [[one.get_ydata() for one in panel.lines if len(one.get_xdata()) in (9, 11)]
               for panel in axes.ravel()]  # fmt: skip
    np.testing.assert_allclose(heights[0], [5 * x, 4 * x])
    np.testing.assert_allclose(heights[1], [2 * s])
    np.testing.assert_allclose(heights[3], [6 * x])
    np.testing.assert_allclose(heights[4], [3 * s])
    assert band(axes[0, 0])[2] == pytest.approx(5 * x + 1)
    (bars,) = [one for one in axes[0, 2].containers if isinstance(one, BarContainer)]
    densities = bodies.pivot(index="N", columns="sample", values="density")
    np.testing.assert_allclose([bar.get_height() for bar in bars], densities.mean(axis=1))
    assert not axes[1, 2].containers
    assert [panel.get_ylabel().split("\n")[0] for panel in axes[:, 0]] == [
        "experiment", "simulation",
    ]  # fmt: skip


def test_figure_of_errors_draws_measured_over_true():
    errors = pd.DataFrame(
        {"kind": "force", "quantity": ["f_max", "w", "f_max"], "measured": [2.0, 9.0, 5.0],
         "truth": [1.0, 9.0, 4.0]}
    )  # fmt: skip
    (panel,) = draw_errors(errors).axes
    (dots,) = [one for one in panel.lines if one.get_marker() == "o"]
    np.testing.assert_allclose(dots.get_xdata(), [1, 4])
    np.testing.assert_allclose(dots.get_ydata(), [2, 5])
