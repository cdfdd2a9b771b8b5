"""The paper's study: it is one that can be read, and its virtual specimens are what they say."""

import re
import shutil

import numpy as np
import pandas as pd
import pytest

import instron
from combing.paper import make, make_paper
from combing.paper.lab import specimens_of
from combing.paper.panels import Panel, panels
from combing.study import load_study
from combing.virtual_lab.packaged import data_folder


@pytest.mark.parametrize("quick", [True, False])
def test_the_study_of_the_paper_is_a_study(tmp_path, quick):
    chosen = panels(quick)
    (tmp_path / "lab").mkdir()
    for panel in chosen:
        for name, _ in specimens_of(panel, 2) if panel.measured else ():
            (tmp_path / "lab" / f"{name}.csv").touch()
    (tmp_path / "rig.toml").write_text(make.RIG)
    for folder in ("photos", "scenes", "truth"):
        shutil.copytree(data_folder() / folder, tmp_path / "lab" / folder)
    (tmp_path / "study.toml").write_text(make.study_text(chosen, 2, quick))
    study = load_study(tmp_path / "study.toml")
    assert [one.over for one in study.sweep] == ["pi1", "pi2", "pi3", "q", "friction"]
    for one, panel in zip(study.sweep, chosen, strict=True):
        assert one.values == list(panel.values)
        if panel.measured:
            assert {len(paths) for paths in one.logs.values()} == {2}
    assert len(study.sweep[0].members()) == 10
    assert len(study.link[0].photos) == (2 if quick else 6)
    assert len(study.curl[0].photos) == len(study.curl[0].simulations) == (1 if quick else 3)
    rig = instron.load_rig(tmp_path / "rig.toml")
    rod = study.sweep[0].nominal(18).scene.rods[0]
    assert (rig.r, rig.E) == pytest.approx((rod.radius, rod.material.E), rel=1e-5)


def test_specimens_differ_and_are_drawn_again_alike():
    panel = panels(True)[0]
    first, again = dict(specimens_of(panel, 3)), dict(specimens_of(panel, 3))
    assert len(first) == 15
    frictions = [member.scene.friction.forward for member in first.values()]
    assert len(set(frictions)) == 15
    assert min(frictions) >= 0.1
    assert max(frictions) <= 0.3
    assert [one.scene for one in first.values()] == [one.scene for one in again.values()]


def test_a_small_paper_has_experiment_over_simulation_and_goes_on(tmp_path, monkeypatch):
    fixed = {"turns": 3, "elements_per_pitch": 6, "speed": 0.5, "snapshots": 2}
    small = [Panel("Pitch", "pitch", "pi1", (18, 24), fixed)]
    monkeypatch.setattr(make, "panels", lambda quick: small)
    monkeypatch.setattr(make, "photographed", lambda *_, **__: "")
    out = tmp_path / "out"
    result = make_paper(out, quick=True, jobs=1, quiet=True)
    assert result.left_out == []
    assert result.comparisons["sweep"].synthetic
    table = pd.read_csv(out / "sweep_1.csv", comment="#")
    assert {"experiment", "simulation", "theory"} == set(table["source"])
    curves = pd.read_csv(out / "curves.csv", comment="#")
    assert np.isfinite(curves["f_max"]).all()
    runs = {path: path.stat().st_mtime_ns for path in (out / "runs").glob("*.nc")}
    assert len(runs) == 4
    make_paper(out, quick=True, jobs=1, quiet=True)
    assert {path: path.stat().st_mtime_ns for path in runs} == runs
    assert {path.stem for path in (out / "figures").glob("*.csv")} == {"figure_2c", "figure_3c"}
    page = (out / "paper.html").read_text(encoding="utf-8")
    assert "Figure 2c" in page
    links = re.findall('href="([^"]+)"', page)
    assert len(links) == 6
    assert all((out / link).is_file() for link in links)
    logs = {path: path.stat().st_mtime_ns for path in (out / "lab").glob("*.csv")}
    edited = out / "study.toml"
    edited.write_text(edited.read_text().replace('"Pitch"', '"Ours"') + "# ours\n")
    make_paper(out, quick=True, jobs=1, quiet=True)
    assert edited.read_text().endswith("# ours\n")
    assert {path: path.stat().st_mtime_ns for path in logs} == logs
    assert set(pd.read_csv(out / "figures" / "figure_2c.csv", comment="#")["set"]) == {"Ours"}
