"""``combing accuracy``: orders of error, what is kept on disk, what a user is told."""

import json
import math

import numpy as np
import pandas as pd
import pytest

from combing.accuracy import points, study, teeth
from combing.accuracy.cantilever import Cantilever
from combing.accuracy.capstan import Capstan, exponent
from combing.accuracy.jam import FLOOR, WINDOW, Jam, smoothed
from combing.accuracy.measurement import Measurement
from combing.accuracy.summary import summary
from combing.bands.release import first_jam
from combing.cli import main
from combing.figures.accuracy import draw_case, draw_teeth
from combing.power_law import slope
from sim import explicit
from sim.march import timestep


@pytest.fixture
def cantilevers(tmp_path):
    """Measure a tiny study: two knobs of the cantilever, into a folder."""
    series = [
        study.vary("cantilever", Cantilever(), "elements", (4, 8, 16)),
        study.vary("cantilever", Cantilever(elements=8), "safety", (0.25, 0.5, 0.9)),
    ]
    problems = [point for each in series for point in each.points]
    results = points.measure_all(problems, tmp_path / "points", quiet=True)
    return study.table(series, results)


def test_error_of_a_cantilever_falls_with_the_square_of_its_elements(cantilevers):
    rows = cantilevers[cantilevers["knob"] == "elements"]
    assert slope(rows) == pytest.approx(-2, abs=0.05)
    assert rows["error"].iloc[-1] == pytest.approx(0, abs=2e-3)


def test_errors_without_a_power_law_have_no_slope():
    rows = pd.DataFrame({"value": [1, 2, 4, 8], "error": [1e-2, 1e-4, 1e-2, -1e-4]})
    assert math.isnan(slope(rows))
    assert slope(rows.assign(error=1 / rows["value"])) == pytest.approx(-1)


def test_the_time_step_does_not_matter_at_rest(cantilevers):
    rows = cantilevers[cantilevers["knob"] == "safety"]
    assert np.ptp(rows["quantity"]) < 1e-6 * rows["quantity"].mean()
    assert rows["steps"].iloc[0] > 3 * rows["steps"].iloc[-1]


def test_euler_leaves_the_shear_of_a_short_cantilever_out(cantilevers):
    """Shear adds 3 E I/(alpha G A L^2) = 9/4 (r/L)^2/alpha (for nu = 1/2) to Euler's deflection."""
    expected = 9 / 4 * 0.2**2 / (27 / 28)
    finest = cantilevers.iloc[2]
    assert finest["closed_form"] / finest["textbook"] - 1 == pytest.approx(expected, rel=1e-9)
    assert finest["error_textbook"] == pytest.approx(expected, rel=0.05)


def test_a_point_on_disk_is_not_measured_again(tmp_path, monkeypatch):
    problem = Cantilever(elements=4)
    first = points.measure_all([problem, problem], tmp_path, quiet=True)
    monkeypatch.setattr(Cantilever, "measure", lambda self: pytest.fail("measured again"))
    assert points.measure_all([problem], tmp_path, quiet=True) == first
    assert len(list(tmp_path.iterdir())) == 1


def test_a_damaged_point_and_one_of_another_solver_are_measured_again(tmp_path, monkeypatch):
    problem = Cantilever(elements=4)
    first = points.measure_all([problem], tmp_path, quiet=True)
    path = tmp_path / points.point_name(problem)
    path.write_text(path.read_text()[:20])
    again = points.measure_all([problem], tmp_path, quiet=True)
    assert again[problem].quantity == first[problem].quantity
    assert json.loads(path.read_text())["steps"] == first[problem].steps
    monkeypatch.setattr(points, "model_version", lambda: "another")
    points.measure_all([problem], tmp_path, quiet=True)
    assert len(list(tmp_path.iterdir())) == 2


def test_every_point_of_the_study_has_a_name_of_its_own():
    """Two knobs' series share their middle; any other two points differ."""
    problems = {point for each in study.all_series(quick=True) for point in each.points}
    assert len({points.point_name(problem) for problem in problems}) == len(problems)


def test_an_unstable_point_is_an_answer(tmp_path, monkeypatch):
    """A step 4 times too long, where shorter ones are not tried."""
    monkeypatch.setattr(timestep, "choose_step", lambda scene, limit: 4 * limit)
    monkeypatch.setattr(explicit, "SHORTEST", 1)
    problem = Cantilever(elements=4)
    found = points.measure_all([problem], tmp_path, quiet=True)[problem]
    assert found.quantity is None


def test_a_folder_that_cannot_be_written_to_is_refused_before_any_work(tmp_path, capsys):
    (tmp_path / "file").touch()
    with pytest.raises(SystemExit) as stopped:
        main(["accuracy", "--quick", "-o", str(tmp_path / "file" / "out")])
    assert stopped.value.code == 2
    message = capsys.readouterr().err
    assert "cannot be written to" in message
    assert len(message.strip().splitlines()) == 1


def test_capstan_path_is_a_wrap_between_tangents():
    strand = Capstan(wrap=math.pi / 2)
    nodes, leaving, arriving = strand.path()
    radius = np.hypot(*nodes.T)
    assert radius.min() == pytest.approx(1.004e-2)
    np.testing.assert_allclose(leaving, [0, -1], atol=1e-15)
    np.testing.assert_allclose(arriving, [-1, 0], atol=1e-15)
    length = np.linalg.norm(np.diff(nodes, axis=0), axis=1)
    np.testing.assert_allclose(length, strand.element_length, rtol=0.05)


def test_capstan_exponent_solves_its_equation():
    m, ratio = exponent(0.3), 0.004 / 1.004
    assert m * (1 + 0.3 * m * ratio) == pytest.approx(0.3 / 1.004, rel=1e-12)


def saw_tooth():
    """Return a rising force that lets go at d = 18 mm, rippled once per twelfth of a pitch."""
    d = np.linspace(0, 25e-3, 5001)
    f = np.where(d < 18e-3, 1000 * d, 8.0) * (1 + 0.2 * np.sin(2 * np.pi * d / (WINDOW / 2)))
    return d, f


def test_first_jam_of_a_saw_tooth_under_ripple():
    """The mean over a window before the top of a straight rise is half a window lower."""
    place, height = first_jam(*smoothed(*saw_tooth()), FLOOR)
    assert place == pytest.approx(18e-3, abs=WINDOW / 10)
    assert height == pytest.approx(18 - 500 * WINDOW, rel=0.02)


def test_a_force_that_never_lets_go_has_no_jam():
    d, f = saw_tooth()
    before = d < 17e-3
    assert first_jam(*smoothed(d[before], f[before]), FLOOR) == (None, None)


def made_up_teeth():
    """Return combings that agree up to d = 18 mm, then part."""
    d = np.linspace(1e-3, 40e-3, 400)
    names = {"meshes": ["a", "b", "c"], "ensemble": ["seed 1", "seed 2"]}
    problems = {name: Cantilever(elements=3 + n) for n, name in enumerate(sum(names.values(), []))}
    results = {}
    for n, problem in enumerate(problems.values()):
        f = np.where(d < 18e-3, 1000 * d, 8.0 + 0.5 * n)
        results[problem] = Measurement(18.0, place=18e-3, d=d.tolist(), f=f.tolist())
    parts = {part: {name: problems[name] for name in names[part]} for part in names}
    return study.Teeth(**parts), results


def test_runs_that_part_after_the_first_jam_are_seen_to():
    longer, results = made_up_teeth()
    apart = teeth.parting(longer, results)
    assert apart.before == pytest.approx(0, abs=1e-12)
    assert apart.after == pytest.approx(math.sqrt((0.5**2 + 1.0**2) / 2) / 8, rel=1e-6)
    band = teeth.ensemble(longer, results)
    late = band[band["d"] > 20e-3].iloc[0]
    assert late["mean"] == pytest.approx(9.75)
    assert late["high"] - late["low"] == pytest.approx(0.5)


def test_summary_and_pictures_hold_every_case(cantilevers):
    longer, results = made_up_teeth()
    peaks = teeth.peaks(longer, results)
    lines = "\n".join(summary(cantilevers, peaks, teeth.parting(longer, results)))
    assert "slope -2.0" in lines
    assert "ensemble of 2: first jam f 18.00 ± 0.00" in lines
    panels = draw_case(cantilevers, "cantilever", "error").axes
    assert len(panels) == 3
    curves = teeth.curves(longer, results)
    figure = draw_teeth(curves, teeth.ensemble(longer, results), peaks)
    assert [panel.get_title() for panel in figure.axes][1] == "2 perturbed runs"


def test_a_point_without_a_quantity_leaves_a_gap_in_the_table():
    series = [study.vary("first jam", Jam(), "safety", (0.5, 0.75, 0.95))]
    found = [Measurement(19.0, seconds=2.0), Measurement(20.0, seconds=1.0), Measurement(None)]
    table = study.table(series, dict(zip(series[0].points, found, strict=True)))
    pd.testing.assert_series_equal(
        table["error"], pd.Series([np.nan, 20 / 19 - 1, np.nan], name="error")
    )
