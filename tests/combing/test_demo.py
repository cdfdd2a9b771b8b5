"""The command line as a new user meets it: the demo from end to end, and what errors look like."""

import json
import os
import re
import subprocess
import sys
from pathlib import Path

import pandas as pd
import pytest

ROOT = Path(__file__).parents[2]
MEASURE = """<script>addEventListener("load", () => {
  for (const one of document.images) one.setAttribute("drawn", one.naturalWidth) })</script>"""


def combing(*arguments, cwd):
    path = os.pathsep.join(filter(None, [str(ROOT), os.environ.get("PYTHONPATH")]))
    program = [sys.executable, "-c", "from combing.cli import main; main()"]
    return subprocess.run(
        [*program, *map(str, arguments)],
        cwd=cwd,
        env=os.environ | {"PYTHONPATH": path},
        capture_output=True,
        text=True,
        timeout=900,
        check=False,
    )


@pytest.fixture(scope="module")
def demo(tmp_path_factory):
    folder = tmp_path_factory.mktemp("demo")
    return combing("demo", "-o", "out", "--quiet", cwd=folder), folder / "out"


def test_demo_ends_by_saying_where_the_report_is(demo):
    done, out = demo
    assert done.returncode == 0, done.stderr
    assert done.stdout.splitlines()[-1] == f"report: {out / 'report.html'}"
    assert done.stderr == ""


def test_demo_leaves_figures_tables_and_nothing_else(demo):
    names = {path.name for path in demo[1].iterdir()}
    figures = {"force", "link", "change_1", "interactions", "curls_1", "sensitivity_1", "errors"}
    expected = {f"{one}.{ending}" for one in figures for ending in ("png", "svg", "csv")}
    expected |= {
        "composite.png",
        "composite.svg",
        "photographs.png",
        "photographs.svg",
        "curves.csv",
        "claims.csv",
    }
    assert names == expected | {"report.html", "summary.json", "runs"}


def test_force_peak_is_near_the_truth(demo):
    errors = pd.read_csv(demo[1] / "errors.csv", comment="#")
    peaks = errors[errors["quantity"] == "f_max"]
    assert len(peaks) == 5
    # The load cell's noise is 4 mN and is not averaged out of a maximum.
    assert (peaks["error"] / peaks["truth"]).abs().max() < 0.02


def test_link_density_is_near_the_truth_before_the_tine(demo):
    errors = pd.read_csv(demo[1] / "errors.csv", comment="#")
    before = errors[errors["item"].str.endswith("before")].set_index("quantity")
    assert before.loc["λ(s), RMS", "error"] < 0.02 * before.loc["mean λ", "truth"]


def test_interactions_are_near_the_truth(demo):
    errors = pd.read_csv(demo[1] / "errors.csv", comment="#")
    pairs = errors[errors["quantity"] == "count, N = 2"]
    assert abs(pairs["error"].sum()) < 0.15 * pairs["truth"].sum()


def test_every_curve_of_the_figures_is_in_the_tables(demo):
    force = pd.read_csv(demo[1] / "force.csv", comment="#")
    assert set(force["source"]) == {"experiment", "simulation", "theory"}
    assert force.groupby("source")["f"].max().min() > 1
    link = pd.read_csv(demo[1] / "link.csv", comment="#")
    assert link["d"].nunique() >= 4
    assert {"experiment", "simulation"} <= set(link["source"])
    counted = pd.read_csv(demo[1] / "interactions.csv", comment="#")
    assert {"experiment", "simulation"} == set(counted["source"])
    strands = pd.read_csv(demo[1] / "curls_1.csv", comment="#")
    per_curl = strands.groupby(["source", "sample"])["strand"].nunique()
    assert len(per_curl) == 6
    assert per_curl.between(12, 14).all()  # a strand that is hidden for long comes in two
    elsewhere = pd.read_csv(demo[1] / "sensitivity_1.csv", comment="#")
    here = elsewhere.query("what == 'sections' and value == 20")
    both = here.merge(counted, on=["source", "sample", "N"], suffixes=("", "_counted"))
    assert both["density"].to_numpy() == pytest.approx(both["density_counted"].to_numpy(), rel=1e-5)


def test_synthetic_is_said_everywhere(demo):
    out = demo[1]
    assert json.loads((out / "summary.json").read_text(encoding="utf-8"))["synthetic"] is True
    assert "<strong>synthetic</strong>" in (out / "report.html").read_text(encoding="utf-8")
    for name in ("force", "link", "interactions", "errors"):
        assert "synthetic" in (out / f"{name}.csv").read_text(encoding="utf-8").split("\n")[0]
        assert "synthetic data" in (out / f"{name}.svg").read_text(encoding="utf-8")


def test_report_opens_in_a_browser(demo, open_page):
    page = demo[1] / "report.html"
    html = page.read_text(encoding="utf-8")
    assert not re.search(r"""(src|href)=["']?(https?:)?//""", html)
    measured = page.with_name("measured.html")
    measured.write_text(html.replace("</body>", MEASURE + "</body>"), encoding="utf-8")
    dom, log = open_page(measured)
    measured.unlink()
    widths = [int(width) for width in re.findall(r'drawn="(\d+)"', dom)]
    assert len(widths) >= 3
    assert min(widths) > 0
    assert "CONSOLE" not in log


def test_every_scene_was_simulated_once(demo):
    assert len(list((demo[1] / "runs").glob("*.nc"))) == 4


@pytest.fixture
def study(tmp_path):
    log = "time,Extension,Load\n(s),(mm),(N)\n"
    rows = "\n".join(f"{i / 10},{i / 5},{min(i, 100 - i) / 50}" for i in range(101))
    (tmp_path / "a.csv").write_text(log + rows + "\n")
    (tmp_path / "rig.toml").write_text("r = 4.25e-4\nE = 2.8e9\n")

    def write(scene="", extra=""):
        (tmp_path / "scene.toml").write_text(scene)
        text = 'title = "t"\n[[force]]\nname = "a"\nlogs = "a.csv"\nrig = "rig.toml"\n'
        (tmp_path / "study.toml").write_text(text + extra)
        return tmp_path

    return write


@pytest.mark.parametrize(
    ("scene", "extra", "message"),
    [
        ("", 'activelength = 1\n', "unknown key 'activelength'; did you mean 'active_length'?"),
        ("", 'simulation = "none.toml"\n', "there is no file"),
        ('preset = "double_helix"\nr = -1e-4\n', 'simulation = "scene.toml"\n', "-0.0001"),
        ('preset = "double_helix"\npi9 = 1\n', 'simulation = "scene.toml"\n', "pi9"),
    ],
)  # fmt: skip
def test_errors_of_the_user_are_one_line(study, scene, extra, message):
    folder = study(scene, extra)
    done = combing("compare", "study.toml", "-o", "out", cwd=folder)
    assert done.returncode == 2
    assert message in done.stderr
    assert len(done.stderr.strip().splitlines()) == 1
    assert "Traceback" not in done.stderr
    assert not (folder / "out").exists()


def test_an_empty_export_leaves_nothing_behind(study):
    folder = study()
    (folder / "a.csv").write_text("")
    done = combing("compare", "study.toml", "-o", "out", "--quiet", cwd=folder)
    assert done.returncode == 2
    assert "a.csv" in done.stderr
    assert not (folder / "out").exists()


def test_one_log_alone_makes_a_report(study):
    folder = study()
    done = combing("compare", "study.toml", "-o", "out", "--json", cwd=folder)
    assert done.returncode == 0, done.stderr
    summary = json.loads(done.stdout)
    assert summary["synthetic"] is False
    assert Path(folder / "out" / "report.html").is_file()
    assert not (folder / "out" / "runs").exists()
