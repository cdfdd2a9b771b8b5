"""The report's first sentences: by how much, where, and in which direction."""

import numpy as np
import pandas as pd

from combing.compare.comparison import Comparison
from combing.compare.first_page import closing_section, found_section


def force(f_max):
    x = np.linspace(0, 1, 11)
    curves = {"experiment": 2 * x, "simulation": 2 * x + np.isclose(x, 0.7) * 1.5}
    plotted = pd.concat(
        pd.DataFrame({"set": "P", "source": one, "curve": "mean", "x": x, "f": f})
        for one, f in curves.items()
    )
    peaks = pd.DataFrame({
        "set": "P", "f_max": [2.0, 2.4, 2.2, f_max],
        "curve": ["experiment, a", "experiment, b", "experiment, mean of 2", "simulation"],
    })  # fmt: skip
    apart = pd.DataFrame({"set": "P", "experiment": ["a", "mean"], "f_max_error": [0.5, 0.25],
                          "work_error": -0.1, "nrmse": 0.08})  # fmt: skip
    tables = [("Force peak, work and distance", peaks), ("Simulation against every repeat", apart)]
    return {"force": Comparison(plotted, tables)}


def test_the_force_is_said_with_its_sign_and_place():
    ((said,),) = (one.text for one in found_section(force(3.0)))
    assert "highest force is 25% above the experiment's, outside its range of 2 to 2.4" in said
    assert "the work is 10% below" in said
    assert "8% of the range (r.m.s.), most at x = 0.70, by 1.5" in said
    assert "within its range" in found_section(force(2.2))[0].text[0]


def test_a_sweep_says_how_the_force_goes_and_how_far_apart_they_are():
    def rows(source, peaks):
        values = [36.0, 14.0, 24.0][: len(peaks)]
        return pd.DataFrame({"set": "pitch", "source": source, "pi1": values,
                             "f_max": peaks})  # fmt: skip

    def said(*parts):
        table = pd.concat(parts, ignore_index=True)
        found = Comparison(table, [("Force peak over pi1", table)])
        return found_section({"sweep": found})[0].text

    alone = said(rows("simulation", [5.0, 40.0, 15.0]))
    assert alone == [
        "pitch, simulation: the highest force is 40 at pi1 = 14 and 5 at pi1 = 36, falling between "
        "the 3 values."
    ]
    *_, apart = said(rows("simulation", [5.0, 40.0, 15.0]), rows("experiment", [4.0, 50.0, 15.0]))
    assert "20% below to 25% above the experiment's, farthest from it at pi1 = 36" in apart
    *_, apart = said(rows("simulation", [5.0, 40.0, 15.0]), rows("experiment", [4.0]))
    assert "farthest from it at pi1 = 36" in apart
    assert "up and down" in said(rows("simulation", [50.0, 40.0, 15.0]))[0]


def test_pairs_agree_or_do_not():
    def curls(simulated):
        row = {"set": "12 hairs", "N": 2, "experiment": 100.0, "experiment, sd over curls": 6.0}
        row |= {"simulation": simulated, "simulation, sd over curls": 8.0}
        table = pd.DataFrame([row])
        numbers = [("Mean density of N-body interactions (1/m)", table)]
        return found_section({"interactions": Comparison(table, numbers)})[0].text[0]

    assert "they agree within the scatter" in curls(109.0)
    assert "they differ by more than the scatter" in curls(111.0)


def test_link_names_the_worst_place_of_the_tine():
    table = pd.DataFrame({"set": "a", "d (m)": [0.01, 0.03], "λ, experiment (1/m)": [100.0, -100.0],
                          "RMS difference (1/m)": [5.0, 20.0]})  # fmt: skip
    said = found_section({"link": Comparison(table, [("Link density", table)])})[0].text[0]
    assert "differ by 5% to 20% of λ" in said
    assert "d = 30 mm" in said


def test_methods_name_what_was_done_and_how():
    section = closing_section({"interactions": Comparison(pd.DataFrame())}, 15, "abc")
    assert "one of 15 equal sections" in section.text[0]
    assert "solver abc" in section.text[0]
    assert "Force logs" not in section.text[0]
    assert "arXiv:2103.05211" in section.quote


def test_nothing_beside_anything_has_no_first_page():
    assert found_section({"sweep": Comparison(pd.DataFrame())}) == []
