"""The report page: what it says, and that a browser opens it alone and without complaint."""

import re

import numpy as np
import pandas as pd
import pytest

from combing.figures.force import draw_force
from combing.figures.style import save
from combing.report import Section, shown, write_report

# The page measures its own pictures, because --dump-dom shows the DOM and not what was drawn.
MEASURE = """<script>addEventListener("load", () => {
  for (const one of document.images) one.setAttribute("drawn", one.naturalWidth) })</script>"""


def curve(source, name, f):
    x = np.linspace(0, 1, 50)
    return pd.DataFrame(
        {"set": "P/r = 18", "source": source, "curve": name, "x": x, "f": f * x, "low": 0.9 * f * x}
    ).assign(high=lambda rows: 1.1 * rows["f"])


@pytest.fixture(scope="module")
def page(tmp_path_factory):
    folder = tmp_path_factory.mktemp("report")
    table = pd.concat(
        [curve("experiment", "mean", 2.0), curve("experiment", "representative", 2.1)]
    )
    png, _ = save(draw_force(table, synthetic=True), folder, "force", synthetic=True)
    numbers = pd.DataFrame({"quantity": ["f_max <N>"], "value": [41.53], "sd": [np.nan]})
    section = Section("Force", ["A & B"], png, "f(x).", "force.csv", [("Peaks", numbers)])
    path = folder / "report.html"
    write_report(path, "Title", [section], about="a", footer="b", synthetic=True)
    return path


def test_text_is_escaped_and_numbers_are_rounded(page):
    html = page.read_text(encoding="utf-8")
    assert "A &amp; B" in html
    assert "f_max &lt;N&gt;" in html
    assert "<td>41.5</td>" in html
    assert "<td>–</td>" in html


def test_synthetic_is_said_on_top(page):
    assert "<strong>synthetic</strong>" in page.read_text(encoding="utf-8")


def test_figures_say_synthetic_in_text_and_metadata(page):
    drawn = page.with_name("force.svg").read_text(encoding="utf-8")
    assert "experiment: synthetic data (virtual lab)" in drawn
    assert b"synthetic data" in page.with_name("force.png").read_bytes()


def test_browser_shows_the_figure_without_complaint(page, open_page):
    measured = page.with_name("measured.html")
    measured.write_text(page.read_text(encoding="utf-8").replace("</body>", MEASURE + "</body>"))
    dom, log = open_page(measured)
    assert re.findall(r'drawn="(\d+)"', dom) != []
    assert all(int(width) > 0 for width in re.findall(r'drawn="(\d+)"', dom))
    assert "CONSOLE" not in log


def test_browser_reports_a_complaint_where_there_is_one(tmp_path, open_page):
    faulty = tmp_path / "faulty.html"
    faulty.write_text("<!doctype html><script>nonsense()</script>")
    assert "CONSOLE" in open_page(faulty)[1]


def test_page_fetches_nothing(page):
    html = page.read_text(encoding="utf-8")
    assert not re.search(r"""(src|href)=["']?(https?:)?//""", html)
    assert "<script" not in html


@pytest.mark.parametrize(
    ("value", "text"),
    [(0.0, "0"), (1234.5, "1234"), (0.012345, "0.0123"), (-1.5, "−1.50"), (2e-7, "2.00e−07"),
     (1.0, "1"), (-3.0, "−3"), (24.0, "24"), (2.6667, "2.67"), (np.nan, "–"), ("tine", "tine")],
)  # fmt: skip
def test_shown_keeps_three_digits_and_whole_numbers(value, text):
    assert shown(value) == text
