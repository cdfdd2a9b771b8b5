"""Photographs as a user names them, and a study in which one of them cannot be measured."""

from pathlib import Path

import cv2
import numpy as np
import pandas as pd
import pytest
from drawn.strands import render

from combing.compare.bench import compare
from combing.compare.link import compare_link
from combing.errors import UserError
from combing.photographs import Refused, find_photographs, measured_only, tried
from combing.study import LinkSet, load_study
from imaging import Unmeasurable


@pytest.fixture
def folder(tmp_path) -> Path:
    for name in ("frame_2.png", "frame_10.PNG", "frame_1.jpg", "notes.txt", "._frame_3.png"):
        (tmp_path / name).write_bytes(b"x")
    (tmp_path / "inner").mkdir()
    return tmp_path


def names(paths: list[Path]) -> list[str]:
    return [path.name for path in paths]


def test_a_folder_stands_for_its_photographs_in_the_order_of_their_numbers(folder):
    found = find_photographs([str(folder)])
    assert names(found) == ["frame_1.jpg", "frame_2.png", "frame_10.PNG"]


@pytest.mark.parametrize(
    ("pattern", "expected"),
    [
        ("frame_*.png", ["frame_2.png"]),
        ("frame_?.*", ["frame_1.jpg", "frame_2.png"]),
        ("frame_%d.jpg", ["frame_1.jpg"]),
        ("frame_%02d.PNG", ["frame_10.PNG"]),
        ("*", ["frame_1.jpg", "frame_2.png", "frame_10.PNG", "inner", "notes.txt"]),
    ],
)
def test_patterns_and_sequences(folder, pattern, expected):
    assert names(find_photographs([str(folder / pattern)])) == expected


def test_a_photograph_that_is_named_twice_is_measured_once(folder):
    again = [str(folder / "frame_2.png"), str(folder / "frame_*.png")]
    assert names(find_photographs(again)) == ["frame_2.png"]


def _refusing(path: Path) -> None:
    raise Unmeasurable(f"{path}: too dark")


def test_what_cannot_be_measured_is_refused_and_what_is_our_fault_is_not_hidden():
    assert tried(_refusing, Path("a.jpg")) == Refused(Path("a.jpg"), "a.jpg: too dark")
    with pytest.raises(ZeroDivisionError):
        tried(lambda path: 1 / 0, Path("a.jpg"))


def test_a_set_without_any_measurement_is_an_error():
    with pytest.raises(UserError, match="none of the photographs could be measured: c, a: left"):
        measured_only("c", [Refused(Path("a.jpg"), "too dark")])
    assert measured_only("c", []) == ([], [], [])


def test_a_refused_photograph_takes_its_tine_position_with_it():
    seen = pd.DataFrame({"s": [0.0, 0.01], "link": [90.0, 110.0], "sd": [1.0, 1.0]})
    seen.attrs = {"photo": "b", "lean": 0.0, "resolution": 0.01, "warnings": [], "synthetic": False}
    none = {"jump": np.nan}
    seen.attrs |= {"first": (100.0, 1.0), "jump": lambda lambda_0: none}
    chosen = LinkSet.model_construct(
        name="comb", photos=[Path("a.jpg"), Path("b.jpg")], positions=[0.01, 0.02],
        simulation=None, truth=None, before=Path("rest.jpg"), photograph_simulation=False,
    )  # fmt: skip
    rest, dark = (Refused(Path(f"{name}.jpg"), "too dark") for name in ("rest", "a"))
    found = compare_link(chosen, rest, [dark, seen], {})
    assert found.plotted["d"].unique() == [0.02]
    assert found.notes == [
        "comb, a: left out, too dark",
        "comb, rest: no reference, too dark",
    ]


def test_one_bad_photograph_does_not_stop_a_study(tmp_path):
    y = np.linspace(15, 225, 300)
    lines = [np.stack([100 + 40 * np.sin(y / 40 + 2.1 * i), y], axis=1) for i in range(3)]
    heights = [np.full(300, 20.0 * i) for i in range(3)]
    colours = [(0.85, 0.1, 0.2), (0.1, 0.6, 0.25), (0.1, 0.3, 0.8)]
    for number in (1, 2):
        drawn = render(lines, heights, colours, 4, (240, 200), rng=number).pixels
        cv2.imwrite(str(tmp_path / f"curl_{number}.png"), drawn[..., ::-1])
    (tmp_path / "curl_3.png").write_bytes((tmp_path / "curl_1.png").read_bytes()[:3000])
    (tmp_path / "study.toml").write_text(
        'title = "curls"\n[[curl]]\nname = "three"\nphotos = "curl_*.png"\npixel_size = 1e-4\n'
    )
    result = compare(load_study(tmp_path / "study.toml"), tmp_path / "out", quiet=True)
    found = result.comparisons["interactions"]
    assert sorted(found.plotted["sample"].unique()) == ["curl_1", "curl_2"]
    (note,) = found.notes
    assert note.startswith("three, curl_3: left out, ")
    assert "cannot be read as a picture" in note
    assert "curl_3: left out" in (tmp_path / "out" / "report.html").read_text()
