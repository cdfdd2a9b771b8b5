"""docs/tutorial.md, every step run as it is written, on files whose truth is known."""

import importlib.util
import json
import re
import shlex
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

TUTORIAL = Path(__file__).parents[2] / "docs" / "tutorial.md"


def _sibling(name):
    """Load a module beside this one: tests are no package."""
    spec = importlib.util.spec_from_file_location(name, Path(__file__).with_name(f"{name}.py"))
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


files = _sibling("tutorial_files")


def blocks():
    """Return (language, text) of every block of code, in order."""
    return re.findall(r"^```(\w+)\n(.*?)^```$", TUTORIAL.read_text(encoding="utf-8"), re.M | re.S)


@pytest.fixture(scope="module")
def done(tmp_path_factory, run):
    """Follow the tutorial in a folder that holds the user's files and nothing else."""
    folder = tmp_path_factory.mktemp("lab")
    files.write(folder)
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        for language, text in blocks():
            if language == "toml":
                Path("study.toml").write_text(text, encoding="utf-8")
            for line in text.splitlines() if language == "sh" else []:
                program, *arguments = shlex.split(line)
                assert program == "combing"
                assert run(*arguments) == 0, line
    return folder


def test_the_listing_names_files_that_a_user_has():
    (listing,) = [text for language, text in blocks() if language == "text"]
    written = {f"{name}.png" for name in ("before", *files.PLACES)}
    written |= {f"pi{value}_{n}.{end}" for value in files.HEIGHTS
                for n, end in enumerate(("csv", "txt", "dat"), start=1)}  # fmt: skip
    assert set(re.findall(r"\w+\.[a-z]{3}", listing)) <= written


@pytest.mark.slow
def test_figure_2c_is_that_of_the_nine_logs(done):
    plotted = pd.read_csv(done / "out" / "sweep_1.csv", comment="#")
    B = np.pi / 4 * 2.8e9 * files.METRES**4
    for value, heights in files.HEIGHTS.items():
        own = plotted[(plotted["value"] == value) & (plotted["source"] == "experiment")]
        peak = own[own["curve"] == "f_max"]
        assert peak["f"].item() == pytest.approx(1e-4 / B * np.mean(heights), rel=0.01)
        mean = own[(own["curve"] == "mean") & own["x"].between(0.03, 0.97)]
        true = 1e-4 / B * files.shape(mean["x"].to_numpy())
        near = 0.01 * true.max()
        np.testing.assert_allclose(mean["f"] / np.mean(heights), true, atol=near)
        sd = np.std(heights, ddof=1) * true
        np.testing.assert_allclose(mean["high"] - mean["f"], sd, atol=near)
    assert (done / "out" / "sweep_1.png").stat().st_size > 20_000


@pytest.mark.slow
def test_figure_2e_is_that_of_the_drawn_pair(done):
    change = pd.read_csv(done / "out" / "change_1.csv", comment="#")
    profile = change[change["curve"] == "profile"]
    for (d, own), place in zip(profile.groupby("d"), files.PLACES.values(), strict=True):
        pitch = 18 * files.METRES
        assert d == pytest.approx((place - 1) * pitch, abs=1e-4)
        ahead = own[own["s"].between((place + 1) * pitch, (files.TURNS - 0.5) * pitch)]["change"]
        assert ahead.notna().mean() > 0.9
        assert ahead.median() == pytest.approx(files.AHEAD - 1, abs=0.01)
    jumps = change[change["curve"] == "jump"]
    apart = jumps["change"] - (files.AHEAD - files.BEHIND)
    assert len(jumps) == 2
    assert (apart.abs() < 1.96 * jumps["sd"]).all()
    assert jumps["x"].tolist() == pytest.approx([0.0191 / 0.09, 0.0344 / 0.09])
    assert (done / "out" / "change_1.png").stat().st_size > 20_000


@pytest.mark.slow
def test_the_report_holds_both_figures_and_counts_what_went_in(done):
    report = (done / "out" / "report.html").read_text(encoding="utf-8")
    assert "Change of link density: P/r = 18" in report
    summary = json.loads((done / "out" / "summary.json").read_text(encoding="utf-8"))
    sweep, link = summary["sets"]
    assert (sweep["files"], sweep["specimens"]) == (9, 9)
    assert (link["photographs"], link["measured"]) == (3, 3)
    assert summary["left_out"] == []
    assert (done / "look" / "overlay.png").is_file()
