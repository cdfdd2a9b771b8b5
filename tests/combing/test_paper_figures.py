"""The paper's figures by their numbers show the rows they are of, from closed-form tables."""

import numpy as np
import pandas as pd
import pytest

from combing.compare.comparison import Comparison
from combing.compare.curl_views import strand_table
from combing.paper.figures import write_figures

X = np.linspace(0, 1, 11)
SWEPT = {"pi1": (14.0, 18.0), "pi2": (1.0, 2.0), "q": (2.0, 4.0)}
EVERY = ["1b", "1d", "2c", "2d", "2e", "3a", "3b", "3c", "3d", "3e", "4a", "4b", "4c"]


def swept():
    """Return sets whose force is value x in the experiment, three times that in the simulation."""
    curves, facts = [], []
    for over, values in SWEPT.items():
        for source, factor in (("experiment", 1), ("simulation", 3)):
            for value in values:
                f = factor * value * X
                place = {"set": over, "over": over, "source": source, "value": value,
                         "black": values[0]}  # fmt: skip
                for curve in ("mean", "representative"):
                    curves.append(
                        pd.DataFrame(
                            {"curve": curve, "x": X, "f": f, "low": f - 1, "high": f + 1}
                        ).assign(**place)
                    )
                facts.append(place | {"f_max": factor * value})
    return Comparison(pd.concat(curves, ignore_index=True), curves=pd.DataFrame(facts),
                      synthetic=True)  # fmt: skip


def linked():
    rows = [
        pd.DataFrame({"s": 0.1 * X, "change": size * X, "sd": 0.01}).assign(
            set="a", source=source, curve="profile", d=0.05 * x, x=x
        )
        for source, size in (("experiment", 1.0), ("simulation", 2.0))
        for x in (0.2, 0.6)
    ]
    return Comparison(pd.DataFrame({"set": []}), change=pd.concat(rows, ignore_index=True))


def curled():
    line = np.column_stack([0.01 * X, 0.1 * X])
    seen = strand_table("c", "experiment", "p", [line, line + 0.01])
    run = strand_table("c", "simulation", "r", [np.insert(line, 1, 0, axis=1) * [1, 1, -1]])
    bars = pd.DataFrame(
        {"set": "c", "source": ["experiment", "experiment", "simulation", "simulation"],
         "sample": ["p", "p", "r", "r"], "N": [2, 3, 2, 3], "density": [50.0, 10.0, 70.0, 5.0],
         "low": 0.0, "high": 80.0}
    )  # fmt: skip
    return Comparison(bars, strands=pd.concat([seen, run], ignore_index=True), synthetic=True)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    out = tmp_path_factory.mktemp("paper") / "figures"
    found = {"sweep": swept(), "link": linked(), "interactions": curled()}
    sections = write_figures(found, None, out)
    assert [section.title for section in sections] == [f"Figure {one}" for one in EVERY]
    return out


@pytest.mark.parametrize("number", EVERY)
def test_every_figure_is_a_picture_a_drawing_and_a_table(folder, number):
    stem = folder / f"figure_{number}"
    assert stem.with_suffix(".png").stat().st_size > 5000
    assert "<svg" in stem.with_suffix(".svg").read_text()
    assert len(pd.read_csv(stem.with_suffix(".csv"), comment="#"))


@pytest.mark.parametrize(
    ("number", "factor"), [("2c", 1), ("3c", 3), ("2d", 1), ("3d", 3), ("4a", 1), ("4b", 3)]
)
def test_experiment_and_simulation_are_not_mixed_up(folder, number, factor):
    table = pd.read_csv(folder / f"figure_{number}.csv", comment="#")
    end = table[(table["curve"] == "mean") & (table["x"] == 1)].set_index("value")["f"]
    over = {"c": "pi1", "d": "pi2", "a": "q", "b": "q"}[number[1]]
    assert end.to_dict() == {value: factor * value for value in SWEPT[over]}


@pytest.mark.parametrize(("number", "size"), [("2e", 1.0), ("3e", 2.0)])
def test_change_of_link_density_is_of_the_right_source(folder, number, size):
    table = pd.read_csv(folder / f"figure_{number}.csv", comment="#")
    np.testing.assert_allclose(table["change"], size * table["s"] / 0.1, atol=1e-7)


@pytest.mark.parametrize(("number", "pairs"), [("1d", 50), ("3b", 70)])
def test_densities_are_of_the_right_source(folder, number, pairs):
    table = pd.read_csv(folder / f"figure_{number}.csv", comment="#").set_index("N")
    assert table.loc[2, "density"] == pairs


def test_the_cost_is_that_of_every_source(folder):
    """C = gamma f_max + (1 - gamma) 25/q."""
    table = pd.read_csv(folder / "figure_4c.csv", comment="#")
    for source, factor in (("experiment", 1), ("simulation", 3)):
        half = table[(table["source"] == source) & (table["gamma"] == 0.5)].set_index("q")["cost"]
        assert half.to_dict() == {q: 0.5 * factor * q + 0.5 * 25 / q for q in SWEPT["q"]}


def test_only_figures_of_the_experiment_say_that_it_is_synthetic(folder):
    assert "synthetic data" in (folder / "figure_2c.svg").read_text()
    assert "synthetic data" not in (folder / "figure_3c.svg").read_text()


def test_a_study_without_photographs_gives_the_figures_of_force(tmp_path):
    sections = write_figures({"sweep": swept()}, None, tmp_path)
    numbers = [section.title.removeprefix("Figure ") for section in sections]
    assert numbers == ["2c", "2d", "3c", "3d", "4a", "4b", "4c"]
