"""A TIFF of several pages: each page as it was written, or one line that names it."""

import json

import numpy as np
import pandas as pd
import pytest
import tifffile
from drawn.strands import render
from PIL import Image

from imaging import Unmeasurable, read_photo
from imaging.correct import beside
from imaging.photo.pages import pages_of

RNG = np.random.default_rng(4)
GREY = RNG.integers(0, 256, (4, 40, 50), np.uint8)
COLOUR = RNG.integers(0, 256, (4, 40, 50, 3), np.uint8)


def _deep(pixels: np.ndarray) -> np.ndarray:
    return pixels.astype(np.uint16) * 257 - (pixels > 0)


KINDS = {
    "grey": (GREY, {"photometric": "minisblack"}),
    "deep grey": (_deep(GREY), {"photometric": "minisblack"}),
    "colour": (COLOUR, {"photometric": "rgb"}),
    "deep colour": (_deep(COLOUR), {"photometric": "rgb"}),
    "planes": (_deep(COLOUR), {"photometric": "rgb", "planarconfig": "separate"}),
    "deflated": (_deep(GREY), {"photometric": "minisblack", "compression": "zlib"}),
    "BigTIFF": (_deep(GREY), {"photometric": "minisblack", "bigtiff": True}),
    "ImageJ": (_deep(GREY), {"imagej": True, "metadata": {"axes": "TYX"}}),
    "OME": (GREY, {"ome": True, "metadata": {"axes": "TYX"}}),
    "one header": (GREY, {"photometric": "minisblack", "volumetric": True, "metadata": None}),
}


@pytest.mark.parametrize("kind", KINDS)
def test_each_page_is_read_as_it_was_written(tmp_path, kind):
    pixels, options = KINDS[kind]
    path = tmp_path / "stack.tif"
    stored = np.moveaxis(pixels, -1, 1) if kind == "planes" else pixels
    tifffile.imwrite(path, stored, **options)
    assert pages_of(path) == (1, 2, 3, 4)
    for number, page in enumerate(pixels, 1):
        photo = read_photo(path, page=number)
        wanted = page if page.ndim == 3 else np.repeat(page[..., None], 3, axis=2)
        np.testing.assert_array_equal(photo.pixels, wanted)
        assert photo.source == f"{path}, page {number}"
        assert photo.pixels.dtype == pixels.dtype
    with pytest.raises(Unmeasurable, match=r"holds 4 pictures, one a page; .*`combing photo`"):
        read_photo(path)
    with pytest.raises(Unmeasurable, match="page 5: no such photograph; its pages are 1, 2, 3, 4"):
        read_photo(path, page=5)


def test_lzw_of_sixteen_bits(tmp_path):
    path = tmp_path / "stack.tif"
    frames = [Image.fromarray(page) for page in _deep(GREY)]
    frames[0].save(path, save_all=True, append_images=frames[1:], compression="tiff_lzw")
    for number, page in enumerate(_deep(GREY), 1):
        np.testing.assert_array_equal(read_photo(path, page=number).pixels[..., 0], page)


def test_pages_of_unlike_kinds_and_smaller_copies(tmp_path):
    path = tmp_path / "mixed.tif"
    with tifffile.TiffWriter(path) as tiff:
        tiff.write(COLOUR[0], photometric="rgb", metadata=None)
        tiff.write(COLOUR[0, ::2, ::2], photometric="rgb", subfiletype=1, metadata=None)
        tiff.write(_deep(GREY[1, :30]), photometric="miniswhite", metadata=None)
    assert pages_of(path) == (1, 3)
    np.testing.assert_array_equal(read_photo(path, page=1).pixels, COLOUR[0])
    third = read_photo(path, page=3).pixels[..., 0]
    np.testing.assert_array_equal(third, 65535 - _deep(GREY[1, :30]))
    with pytest.raises(Unmeasurable, match="page 2: no such photograph; its pages are 1, 3"):
        read_photo(path, page=2)


def test_a_photograph_with_its_thumbnail_is_one(tmp_path):
    path = tmp_path / "a.tif"
    with tifffile.TiffWriter(path) as tiff:
        tiff.write(COLOUR[0, ::2, ::2], photometric="rgb", subfiletype=1, metadata=None)
        tiff.write(COLOUR[0], photometric="rgb", metadata=None)
    np.testing.assert_array_equal(read_photo(path).pixels, COLOUR[0])


def test_channels_are_no_photographs(tmp_path):
    path = tmp_path / "a.tif"
    about = {"axes": "CYX", "mode": "composite"}
    tifffile.imwrite(path, GREY[:3], imagej=True, metadata=about)
    with pytest.raises(Unmeasurable, match="channels of one picture; save it as RGB"):
        read_photo(path)


@pytest.mark.parametrize("suffix", ["gif", "webp", "png"])
def test_other_formats_of_several_pictures_are_refused(tmp_path, suffix):
    frames = [Image.fromarray(page) for page in COLOUR]
    frames[0].save(tmp_path / f"a.{suffix}", save_all=True, append_images=frames[1:])
    for page in (None, 2):
        with pytest.raises(Unmeasurable, match="holds 4 pictures; export .* a TIFF of several"):
            read_photo(tmp_path / f"a.{suffix}", page=page)


def test_only_a_tiff_has_pages(tmp_path):
    Image.fromarray(COLOUR[0]).save(tmp_path / "a.png")
    with pytest.raises(Unmeasurable, match="page 2: only a TIFF has pages; this is PNG"):
        read_photo(tmp_path / "a.png", page=2)


def test_previews_of_camera_raw_are_no_pages(tmp_path):
    tifffile.imwrite(tmp_path / "a.nef", GREY, photometric="minisblack")
    assert pages_of(tmp_path / "a.nef") == (1,)
    with pytest.raises(Unmeasurable, match="page 2: only a TIFF has pages; this is camera RAW"):
        read_photo(tmp_path / "a.nef", page=2)


def test_a_second_page_that_is_cut_off_is_no_silent_loss(tmp_path):
    path = tmp_path / "a.tif"
    tifffile.imwrite(path, GREY[:2], photometric="minisblack")
    with tifffile.TiffFile(path) as tiff:
        second = tiff.pages[1].offset
    path.write_bytes(path.read_bytes()[:second])
    assert pages_of(path) == (1, 2)
    with pytest.raises(Unmeasurable, match="page 2: cannot be read as a picture"):
        read_photo(path, page=2)


def test_corrections_of_a_page_are_its_own(tmp_path):
    (tmp_path / "stack.corrections.json").write_text("{}")
    assert beside(tmp_path / "stack.tif") == tmp_path / "stack.corrections.json"
    assert beside(tmp_path / "stack.tif, page 3") is None
    own = tmp_path / "stack.tif, page 3.corrections.json"
    own.write_text("{}")
    assert beside(tmp_path / "stack.tif, page 3") == own


def _scene(seed: int) -> np.ndarray:
    y = np.linspace(15, 145, 200)
    lines = [np.stack([60 + 25 * np.sin(y / 30 + np.pi * i), y], axis=1) for i in range(2)]
    heights = [np.full(200, 20.0 * i) for i in range(2)]
    return render(
        lines, heights, [(0.85, 0.1, 0.2), (0.1, 0.3, 0.8)], 4, (160, 120), rng=seed
    ).pixels


@pytest.fixture
def stack(tmp_path):
    """Three pages, the second black."""
    path = tmp_path / "stack.tif"
    tifffile.imwrite(
        path, np.stack([_scene(1), np.zeros((160, 120, 3), np.uint8), _scene(3)]), photometric="rgb"
    )
    return path


def test_command_measures_each_page(stack, tmp_path, capsys, run):
    out = tmp_path / "out"
    assert run("photo", stack, "-o", out, "--quiet") == 0
    told = capsys.readouterr().out
    assert "stack.tif, page 1: 2 strands" in told
    assert f"stack.tif, page 2: REFUSED, {stack}, page 2: " in told
    assert "2 measured, 1 refused" in told
    assert {p.name for p in out.iterdir() if p.is_dir()} == {"stack-page-1", "stack-page-3"}
    strands = pd.read_csv(out / "strands.csv")
    assert set(strands["photo"]) == {"stack-page-1.tif", "stack-page-3.tif"}
    rows = json.loads((out / "summary.json").read_text())
    assert [(row["photo"], row["page"]) for row in rows] == [("stack.tif", n) for n in (1, 2, 3)]
    alone = tmp_path / "third.png"
    Image.fromarray(_scene(3)).save(alone)
    assert run("photo", alone, "-o", tmp_path / "alone", "--quiet") == 0
    single = pd.read_csv(tmp_path / "alone" / "strands.csv").drop(columns="photo")
    third = strands[strands["photo"] == "stack-page-3.tif"].drop(columns="photo")
    pd.testing.assert_frame_equal(third.reset_index(drop=True), single)
    capsys.readouterr()
    assert run("photo", stack, "-o", out, "--quiet") == 0
    assert "(2 of them before" in capsys.readouterr().out


def test_a_stack_that_is_cut_reports_the_page(stack, tmp_path, capsys, run):
    with tifffile.TiffFile(stack) as tiff:
        last = tiff.pages[2].offset
    stack.write_bytes(stack.read_bytes()[:last])
    assert run("photo", stack, "-o", tmp_path / "out", "--quiet") == 0
    told = capsys.readouterr().out
    assert "stack.tif, page 1: 2 strands" in told
    assert "page 3: cannot be read as a picture" in told


def test_corrections_of_a_whole_stack_are_refused(stack, tmp_path, capsys, run):
    stack.with_name("stack.tif.corrections.json").write_text("{}")
    assert run("photo", stack, "-o", tmp_path / "out", "--quiet") != 0
    assert "'stack.tif, page 1.corrections.json'" in capsys.readouterr().out


@pytest.mark.parametrize("command", ["helix", "edit"])
def test_commands_of_one_photograph_say_how_to_choose(stack, tmp_path, capsys, command, run):
    assert run(command, stack, "-o", tmp_path / "out", "--quiet") != 0
    assert "holds 3 pictures, one a page; export the one" in capsys.readouterr().err
