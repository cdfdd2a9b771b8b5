"""`combing edit` as a user meets it: a page in a browser, real clicks, a file that is applied."""

import json
import time
from pathlib import Path

import cv2
import numpy as np
import pytest
from browser import WAIT
from drawn.waves import off, photographed, waves

import imaging
from imaging import Corrections
from imaging.correct.schema import Delete
from imaging.trace.centreline import resample


@pytest.fixture(scope="module")
def photo(tmp_path_factory) -> Path:
    path = tmp_path_factory.mktemp("photos") / "waves.png"
    cv2.imwrite(str(path), photographed().pixels[..., ::-1])
    return path


@pytest.fixture
def page(photo, chromium, capsys, run):
    """Open the page of the waves anew."""
    said = photo.with_name("waves.png.corrections.json")
    said.unlink(missing_ok=True)
    assert run("edit", photo) == 0
    assert "3 strands" in capsys.readouterr().out
    chromium.open(photo.with_name("waves.png.edit.html"))
    chromium.complaints.clear()
    yield chromium
    assert chromium.complaints == []


def state(page):
    return json.loads(page.value("JSON.stringify(state)"))


def shown(page) -> list[np.ndarray]:
    """Lines of the page's strands, points a pixel apart."""
    return [resample(np.array(one["line"])) for one in state(page)["strands"]]


def free_place(page, which: int) -> list[float]:
    """Where a strand of the page lies farthest from all crossings and its ends."""
    return page.value(
        f"(() => {{ const {{ line }} = state.strands[{which}], all = length(line);"
        "const far = (s) => Math.min(s, all - s, ...state.crossings.map((c) => "
        "distance(c.at, pointAt(line, s))));"
        "const places = Array.from({ length: 200 }, (_, i) => (i * all) / 200);"
        "return pointAt(line, places.sort((a, b) => far(b) - far(a))[0]); })()"
    )


def saved(page, photo) -> imaging.Measured:
    """Save, put the file beside the photograph, and measure that."""
    page.value("delete window.showSaveFilePicker")
    name = "waves.png.corrections.json"
    for old in page.downloads.glob("waves*"):
        old.unlink()
    page.press("save")
    page.wait(f"$('hint').textContent.includes('{name}')")
    until = time.monotonic() + WAIT
    while not (page.downloads / name).exists() and time.monotonic() < until:
        time.sleep(0.03)
    (page.downloads / name).replace(photo.with_name(name))
    return imaging.measure(imaging.read_photo(photo))


def test_click_a_strand_and_delete_it(page, photo):
    page.click(*free_place(page, 1))
    page.press("do-delete")
    assert len(state(page)["strands"]) == 2
    found = saved(page, photo)
    assert len(found.strands) == 2
    assert found.hand.tally() == {"applied": 1}
    pairs = zip(found.strands, shown(page), strict=True)
    assert all(off(strand.line, line).max() < 1 for strand, line in pairs)


def test_undo_and_redo(page):
    before = state(page)
    for which, key in ((0, "x"), (0, "s")):
        page.click(*free_place(page, which))
        page.key(key)
    after = state(page)
    assert [len(s["strands"]) for s in (before, after)] == [3, 3]
    page.key("z", control=True)
    page.press("undo")
    assert state(page) == before
    page.press("redo")
    page.key("y", control=True)
    assert state(page) == after


def test_split_and_join(page, photo):
    x, y = free_place(page, 2)
    page.click(x, y)
    page.press("do-split")
    assert len(state(page)["strands"]) == 4
    page.click(x, y - 14)
    page.press("do-join")
    page.click(x, y + 14)
    now = state(page)
    assert len(now["strands"]) == 3
    assert now["outcomes"] == ["applied", "applied"]
    found = saved(page, photo)
    assert found.hand.tally() == {"applied": 2}
    assert all(min(off(s.line, w).mean() for w in waves()) < 0.5 for s in found.strands)


def test_draw_a_strand_that_snaps_to_its_ridge(page, photo):
    page.click(*free_place(page, 0))
    page.key("x")
    gone = max(waves(), key=lambda wave: min(off(wave, line).mean() for line in shown(page)))
    page.press("mode-draw")
    for point in (gone[2] + [1.5, 0], gone[150] - [1.5, 0], gone[-3] + [1.5, 0]):
        page.click(*point)
    assert len(page.value("drawn()")) > 6  # not the three points of the hand
    page.key("Enter")
    assert off(shown(page)[-1], gone).mean() < 1.5
    found = saved(page, photo)
    assert sorted(found.hand.by) == ["", "", "drawn"]
    assert off(found.strands[found.hand.by.index("drawn")].line, gone).mean() < 0.5


def test_shift_draws_straight(page):
    page.key("d")
    page.click(30, 30)
    page.click(200, 220, shift=True)
    assert len(page.value("drawn()")) == 2
    page.key("Backspace")
    page.click(200, 220)
    assert len(page.value("drawn()")) > 2
    page.key("Escape")
    assert state(page)["outcomes"] == []


def test_swap_who_is_on_top_and_say_unknown(page, photo):
    first, second = state(page)["crossings"][:2]
    page.click(*first["at"])
    page.press("do-swap")
    page.click(*second["at"])
    page.key("u")
    now = state(page)["crossings"]
    assert now[0]["over"] == sum(first["on"]) - first["over"]
    assert now[1]["over"] is None
    found = saved(page, photo)
    said = found.crossings[found.crossings["over_by"] == "hand"]
    assert len(said) == 2
    for one in now[:2]:
        row = said.iloc[np.hypot(*(said[["x", "y"]] - one["at"]).to_numpy(float).T).argmin()]
        over = None if np.isnan(row["confidence"]) else row["over"] - 1
        assert over == one["over"]


def test_exchange_at_a_crossing(page, photo):
    page.click(*state(page)["crossings"][1]["at"])
    page.key("e")
    assert state(page)["outcomes"] == ["applied"]
    found = saved(page, photo)
    assert found.hand.by.count("exchanged") == 2
    pairs = zip(found.strands, shown(page), strict=True)
    assert all(off(strand.line, line).max() < 4 for strand, line in pairs)


def test_name_ground_colours_and_the_number(page, photo):
    page.press("mode-ground")
    page.click(8, 250)
    page.key("c")
    page.click(*free_place(page, 0))
    page.wait("said.colours.length === 1 && said.ground.length === 1")
    page.value("$('strands').value = 1, $('strands').dispatchEvent(new Event('change'))")
    found = saved(page, photo)
    assert len(found.strands) == 1
    assert [one.outcome for one in found.hand.outcomes] == ["applied", "already so"]


def test_a_page_goes_on_from_what_was_said(page, photo, capsys, run):
    page.click(*free_place(page, 1))
    page.key("x")
    before = state(page)
    saved(page, photo)
    assert run("edit", photo) == 0
    assert "corrections of waves.png.corrections.json" in capsys.readouterr().out
    page.open(photo.with_name("waves.png.edit.html"))
    assert state(page) == before
    page.click(*free_place(page, 0))
    page.key("x")
    assert len(state(page)["strands"]) == 1


def test_load_says_what_is_wrong_with_a_file(page):
    for text, told in (("{", "not JSON"), ("{}", "not corrections"), (
        '{"format": "combing corrections", "version": 1, "photograph": '
        '{"name": "a", "width": 3, "height": 4}}', "3 x 4")):  # fmt: skip
        page.value(f"load({json.dumps(text)}, 'a.json'), 1")
        assert told in page.value("$('hint').textContent")
    said = Corrections(steps=[Delete(line=[(1, 1), (2, 2)])]).model_dump_json(by_alias=True)
    page.value(f"load({json.dumps(said)}, 'a.json'), 1")
    assert state(page)["outcomes"] == ["already so"]


def test_moving_and_zooming_keep_clicks_where_they_point(page):
    x, y = free_place(page, 2)
    page.wheel(x, y, -120)
    page.wheel(x, y, -120)
    page.drag((400, 500), (470, 450))
    assert page.value("box.w") < 240
    page.click(x, y)
    assert page.value("chosen.strand === state.strands[2]")
    page.size(500, 800)
    page.click(x, y)
    assert page.value("chosen.strand === state.strands[2]")


def test_a_page_fetches_nothing(page):
    assert all(url.startswith(("file:", "data:", "blob:")) for url in page.requests)


def test_a_folder_is_linked_page_to_page(photo, tmp_path, capsys, run):
    folder = tmp_path / "session"
    folder.mkdir()
    for name in ("frame_2.png", "frame_10.png"):
        (folder / name).write_bytes(photo.read_bytes())
    cv2.imwrite(str(folder / "black.png"), np.zeros((60, 60, 3), np.uint8))
    (folder / "cut.png").write_bytes(photo.read_bytes()[:300])
    assert run("edit", folder, "-o", tmp_path / "pages", "--quiet") == 0
    told = capsys.readouterr().out
    assert "black.png: not measured" in told
    assert "cut.png: REFUSED" in told
    text = (tmp_path / "pages" / "frame_2.png.edit.html").read_text()
    assert 'href="frame_10.png.edit.html"' in text
    assert 'href="black.png.edit.html"' in text
    assert "cut.png" not in text


def test_wrong_requests_end_in_one_line(photo, tmp_path, capsys, run):
    wrong = photo.with_name("waves.png.corrections.json")
    wrong.write_text("{")
    assert run("edit", photo) == 2
    assert "not JSON" in capsys.readouterr().err
    wrong.unlink()
    assert run("edit", tmp_path / "none.png") == 2
    assert "no such file" in capsys.readouterr().err
